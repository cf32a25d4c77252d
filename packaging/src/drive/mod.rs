//! Drives through packaged FMUs: scenarios, their co-simulation, and what was detected.

pub mod cosimulation;
pub mod detection;
pub mod exchange;
pub(crate) mod figure;
pub mod kinds;
pub mod plot;
pub mod scenario;
pub mod simulation;
pub mod wheel;
