//! From vehicle data and a specification to a steering-fault detector with its proof.
//!
//! [`Spec`] (TOML) -> [`design()`] -> [`Design`] (`design.json`) ->
//! [`Design::configuration`], which the detector runs.
//!
//! # Conventions
//! - Those of [`steerguard_detector`]: axes, SI units, state, measurement, input, rules' order.
//! - Numbers in brackets are equations of Wang et al., IFAC CESCIT 2021,
//!   doi 10.1016/j.ifacol.2021.10.033; "corrected" and "method N" refer to `docs/method`.
//! - beta is the smallest gain from fault to residual over the fault's band, gamma the largest from
//!   disturbance to residual over the disturbance's.

#![forbid(unsafe_code)]

pub mod analysis;
mod design;
pub mod document;
pub mod lmi;
pub mod problem;
mod progress;
pub mod search;
pub mod sight;
mod simulation;
pub mod spec;
pub mod synthesis;
pub mod threshold;
pub mod worst;

pub use analysis::certified::{APosteriori, BandCertificate, CertifiedFigures, GainCertificate};
pub use design::file::{
    AttenuationRecord, Certificate, Constants, Design, DesignFileError, DesignStatus, FORMAT,
    FaultFigures, FrozenRecord, LargestBeta, Performance, Rule, StartUpRecord, SynthesisRecord,
    ThresholdRecord,
};
pub use design::{DesignError, design, design_with_drives};
pub use progress::Step;
pub use spec::Spec;
pub use synthesis::obstacle::Obstacle;
pub use threshold::guaranteed::{Guaranteed, InputBound, PeakCertificate};
