//! What a design is busy with, for whoever waits for it.

use std::fmt;

/// What the design is busy with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// The largest beta for the given gamma.
    LargestBeta,
    /// The smallest gamma near that beta: the gains.
    SmallestGamma,
    /// The inequalities for the stored gains.
    Check,
    /// The search for multipliers: how many syntheses of how many are done.
    Search {
        /// Syntheses done.
        done: usize,
        /// All syntheses.
        of: usize,
    },
    /// The gains' refinement.
    Refine,
    /// The gains' certificate.
    Certify,
    /// The bound on the start-up residual.
    StartUp,
    /// The bound on J under disturbances and noise.
    Guarantee,
    /// Fault-free drives: how many of how many are done.
    Calibration {
        /// Drives done.
        done: usize,
        /// All drives.
        of: usize,
    },
    /// The worst drives for the second test.
    Worst,
    /// Drives with faults.
    Sight,
}

impl fmt::Display for Step {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::LargestBeta => write!(f, "maximising beta"),
            Self::SmallestGamma => write!(f, "minimising gamma"),
            Self::Check => write!(f, "checking the inequalities"),
            Self::Search { done, of } => write!(f, "searching multipliers: {done} of {of}"),
            Self::Refine => write!(f, "refining the gains"),
            Self::Certify => write!(f, "certifying the gains"),
            Self::StartUp => write!(f, "bounding the start-up"),
            Self::Guarantee => write!(f, "bounding the residual under disturbances and noise"),
            Self::Worst => write!(f, "searching the worst drives for the second test"),
            Self::Sight => write!(f, "driving the design with faults"),
            Self::Calibration { done, of } => write!(f, "calibrating: drive {done} of {of}"),
        }
    }
}
