//! The simulated world as an FMU model.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

mod model;
pub mod variables;

pub use model::PlantModel;
pub use variables::PlantVariable;
