//! Vehicle data from recorded drives: output error of the single-track model on yaw rate and, where it
//! is logged and the model explains it, lateral acceleration (method 10).
//!
//! # Conventions
//! SI, ISO 8855 axes. Mass and axle distances are told; anything else may be. What the drives do not
//! show is refused by name.

mod course;
mod drives;
mod error;
mod fit;
mod identified;
mod identify;
mod misfit;
mod model;
mod parameter;
mod problem;

pub use error::IdentificationError;
pub use identified::{Estimate, Identified, Lateral, Origin, Refused, Told, Trace};
pub use identify::{STEPS, identify};
pub use model::Chassis;
pub use parameter::{Parameter, Scale};
