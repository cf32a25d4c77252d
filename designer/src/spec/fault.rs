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
        /// Largest fault up to which the alarm must come and stay, degrees at the road wheel; default
        /// 20. It caps what a fault may do to the estimate: [`Fault::estimate_cap`].
        #[serde(default = "twenty_degrees")]
        largest_deg: f64,
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

/// No road wheel turns further.
const LARGEST_DEG: f64 = 90.0;
/// Smallest angle of interest, and torques, N m.
const LEAST_DEG: f64 = 1e-3;
const LEAST_N_M: f64 = 0.01;
const LARGEST_N_M: f64 = 1e6;

fn half_a_degree() -> f64 {
    0.5
}

fn twenty_degrees() -> f64 {
    20.0
}

/// What the largest fault may make of e_2, in units of the range of v_y to its nearer end: e_2 rises
/// no faster than the residual that reports the fault, so that a quarter of its rise is left for the
/// alarm before v_y^ can leave the range.
const RANGES_OF_V_Y: f64 = 4.0;

impl Fault {
    /// Cap on e_2 = v_y - v_y^ after a step of the fault, m/s per rad, for lateral speeds within
    /// `v_y_m_per_s`: 0.3 m/s per degree with the defaults. A torque fault has none: it acts along v_x.
    pub fn estimate_cap(&self, v_y_m_per_s: [f64; 2]) -> Option<f64> {
        let [right, left] = v_y_m_per_s;
        match self {
            Self::Torque { .. } => None,
            Self::Steering { largest_deg, .. } => {
                Some(RANGES_OF_V_Y * f64::min(left, -right) / largest_deg.to_radians())
            }
        }
    }

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
        let (key, smallest, allowed) = match self {
            Self::Steering { smallest_deg, .. } => {
                ("smallest_deg", *smallest_deg, Allowed::between(LEAST_DEG, LARGEST_DEG))
            }
            Self::Torque { smallest_n_m, .. } => {
                ("smallest_n_m", *smallest_n_m, Allowed::between(LEAST_N_M, LARGEST_N_M))
            }
        };
        mistakes.number(&format!("{at}.{key}"), smallest, allowed);
        if let Self::Steering { smallest_deg, largest_deg, .. } = self
            && mistakes.sound(&format!("{at}.smallest_deg"))
        {
            let allowed = Allowed::between(*smallest_deg, LARGEST_DEG);
            mistakes.number(&format!("{at}.largest_deg"), *largest_deg, allowed);
        }
        if let Some(nyquist_hz) = nyquist_hz {
            check_band(at, self.band_hz(), nyquist_hz, mistakes);
        }
    }
}

impl Default for Fault {
    /// A steering fault of half a degree.
    fn default() -> Self {
        Self::Steering {
            smallest_deg: half_a_degree(),
            largest_deg: twenty_degrees(),
            band_hz: low_band(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 0.3 m/s per degree with the defaults: method 5.
    #[test]
    fn a_larger_fault_may_do_less_to_the_estimate() {
        let cap = |largest_deg, v_y| {
            let fault = Fault::Steering { smallest_deg: 0.5, largest_deg, band_hz: low_band() };
            fault.estimate_cap(v_y).map(|cap| cap * 1f64.to_radians())
        };
        let near = |cap: Option<f64>, expected: f64| {
            assert!(cap.is_some_and(|cap| (cap - expected).abs() < 1e-15), "{cap:?} {expected}");
        };
        near(cap(20.0, [-1.5, 1.5]), 0.3);
        near(cap(40.0, [-1.5, 1.5]), 0.15);
        // The nearer end counts.
        near(cap(20.0, [-0.5, 1.5]), 0.1);
        let torque = Fault::Torque { smallest_n_m: 100.0, band_hz: low_band() };
        assert_eq!(torque.estimate_cap([-1.5, 1.5]), None);
    }
}
