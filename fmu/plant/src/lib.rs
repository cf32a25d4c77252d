//! The simulated world as an FMI 2.0 Co-Simulation model, on the detector's FMI layer.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

mod model;
pub mod variables;

pub use model::PlantModel;
pub use variables::PlantVariable;
