//! The steering-fault detector as an FMU model, and the numbers that are baked into its library.
//!
//! # Conventions
//! - `doStep` runs the detector on its own grid; its outputs are those of the last sample run.
//! - Before the first sample the residual is zero and `state` is Starting.
//! - Which numbers a design consists of, and their bytes, is the business of [`BakedDesign`] alone.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]

mod design;
mod model;
mod state;

pub use design::{BakedDesign, DesignError};
pub use model::DetectorModel;
pub use state::{alarm_cause, fault_hypothesis, state, state_cause};
