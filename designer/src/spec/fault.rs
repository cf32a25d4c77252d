//! `[[fault]]`: the faults of interest.

use serde::{Deserialize, Serialize};

use super::band::{check_band, low_band};
use crate::document::{Allowed, Mistakes};

/// `[[fault]]`: an additive fault of an actuator.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "channel", rename_all = "lowercase", deny_unknown_fields)]
pub enum Fault {
    /// Error of the road-wheel angle.
    Steering {
        /// Smallest fault of interest, degrees at the road wheel; default 0.5.
        #[serde(default = "half_a_degree")]
        smallest_deg: f64,
        /// Frequency range; default [0, 1.5].
        #[serde(default = "low_band")]
        band_hz: [f64; 2],
    },
    /// Error of the drive torque at the wheels.
    Torque {
        /// Smallest fault of interest, N m at the wheels.
        smallest_n_m: f64,
        /// Frequency range; default [0, 1.5].
        #[serde(default = "low_band")]
        band_hz: [f64; 2],
    },
}

fn half_a_degree() -> f64 {
    0.5
}

impl Fault {
    /// Column of B, in the order of the input [T_eng, delta].
    pub fn column(&self) -> usize {
        match self {
            Self::Torque { .. } => 0,
            Self::Steering { .. } => 1,
        }
    }

    /// Smallest fault of interest in rad or N m.
    pub fn smallest(&self) -> f64 {
        match self {
            Self::Steering { smallest_deg, .. } => smallest_deg.to_radians(),
            Self::Torque { smallest_n_m, .. } => *smallest_n_m,
        }
    }

    /// Frequency range, Hz.
    pub fn band_hz(&self) -> [f64; 2] {
        match self {
            Self::Steering { band_hz, .. } | Self::Torque { band_hz, .. } => *band_hz,
        }
    }

    /// Finds what is not possible of the fault called `at`; of its band where the Nyquist frequency
    /// is known.
    pub(super) fn check(&self, at: &str, nyquist_hz: Option<f64>, mistakes: &mut Mistakes) {
        let (key, smallest) = match self {
            Self::Steering { smallest_deg, .. } => ("smallest_deg", *smallest_deg),
            Self::Torque { smallest_n_m, .. } => ("smallest_n_m", *smallest_n_m),
        };
        mistakes.number(&format!("{at}.{key}"), smallest, Allowed::POSITIVE);
        if let Some(nyquist_hz) = nyquist_hz {
            check_band(at, self.band_hz(), nyquist_hz, mistakes);
        }
    }
}

impl Default for Fault {
    /// A steering fault of half a degree.
    fn default() -> Self {
        Self::Steering { smallest_deg: half_a_degree(), band_hz: low_band() }
    }
}
