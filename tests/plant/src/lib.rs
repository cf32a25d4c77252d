//! Reference vehicle plant as an FMI 2.0 Co-Simulation model, on the detector's FMI layer.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

pub mod dynamics;
mod model;
pub mod noise;
pub mod variables;

pub use model::PlantModel;
pub use variables::PlantVariable;
