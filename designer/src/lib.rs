//! From vehicle data and a specification to a steering-fault detector with its proof.
//!
//! [`Spec`] (TOML) -> [`design()`] -> [`Design`] (`design.json`) ->
//! [`Design::configuration`], which the detector runs.
//!
//! # Conventions
//! - Those of [`steerguard_detector`]: axes, SI units, state, measurement, input, rules' order.
//! - Numbers in brackets are equations of Wang et al., IFAC CESCIT 2021,
//!   doi 10.1016/j.ifacol.2021.10.033; "corrected" and METHOD.md refer to `designer/METHOD.md`.
//! - beta is the smallest gain from fault to residual over the fault's band, gamma the largest from
//!   disturbance to residual over the disturbance's.

#![forbid(unsafe_code)]

pub mod band;
pub mod calibration;
pub mod certificate;
pub mod certified;
pub mod channel;
mod design;
mod design_file;
pub mod frequency;
pub mod gains;
pub mod gap;
pub mod guaranteed;
pub mod gust;
mod infeasible;
pub mod lmi;
pub mod operating_point;
pub mod spec;
mod spec_error;
pub mod start_up;
pub mod synthesis;
pub mod theorem4;
pub mod threshold;
pub mod worth;

pub use certified::{APosteriori, BandCertificate, CertifiedFigures, GainCertificate};
pub use design::{DesignError, Step, design};
pub use design_file::{
    AttenuationRecord, Certificate, Design, DesignFileError, DesignStatus, EvaluationDesign,
    FORMAT, FaultFigures, FrozenRecord, LargestBeta, Performance, Rows3, Rule, StartUpRecord,
    SynthesisRecord,
};
pub use guaranteed::{Guaranteed, InputBound, PeakCertificate};
pub use infeasible::Obstacle;
pub use spec::Spec;
pub use spec_error::SpecError;
