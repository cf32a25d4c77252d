//! `[estimator]`: the second test.

use serde::{Deserialize, Serialize};

/// `[estimator]`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct EstimatorTable {
    /// Whether a Kalman filter that is told all of `[uncertainty]` looks for the fault beside the residual;
    /// default false. Of `evaluation.threshold = "adaptive"` alone: the other kinds are told no uncertainty.
    pub enabled: bool,
}
