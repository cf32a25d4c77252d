//! `[sampling]`: when the detector runs.

use serde::{Deserialize, Serialize};

use crate::document::{Allowed, Mistakes};

/// `[sampling]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Sampling {
    /// T_s; default 0.01.
    pub period_s: f64,
    /// Whether the detector takes out of the residual what Euler's steps leave out; default true.
    pub euler_correction: bool,
}

impl Default for Sampling {
    fn default() -> Self {
        Self { period_s: 0.01, euler_correction: true }
    }
}

impl Sampling {
    /// Highest frequency that samples can show, Hz.
    pub fn nyquist_hz(self) -> f64 {
        0.5 / self.period_s
    }

    /// Finds what is not possible by itself.
    pub(super) fn check(self, mistakes: &mut Mistakes) {
        mistakes.number("sampling.period_s", self.period_s, Allowed::between(1e-4, 0.1));
    }
}
