//! Reference vehicle plant as an FMU model.
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
