//! The simulated world as an FMU model.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

mod model;

pub use model::PlantModel;
