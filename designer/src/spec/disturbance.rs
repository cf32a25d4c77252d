//! `[[disturbance]]`: what acts on the vehicle besides its inputs.

use serde::{Deserialize, Serialize};
use steerguard_detector::Vehicle;
use steerguard_world::GRAVITY_M_PER_S2;

use super::band::{check_band, low_band};
use crate::document::{Allowed, Mistake, Mistakes};

/// `[[disturbance]]`: an unknown input, by its kind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Disturbance {
    /// A lateral specific force that acts ahead of the centre of gravity.
    SideWind {
        /// Name in reports.
        name: String,
        /// Distance of its line of action ahead of the centre of gravity; default 0.25.
        #[serde(default = "quarter_of_a_metre")]
        acting_ahead_m: f64,
        /// Largest lateral specific force.
        bound_m_per_s2: f64,
        /// Frequency range; default [0, 1.5].
        #[serde(default = "low_band")]
        band_hz: [f64; 2],
    },
    /// Road bank, positive with the left side raised (ISO 8855 roll).
    Bank {
        /// Name in reports.
        name: String,
        /// Largest bank angle.
        bound_deg: f64,
        /// Frequency range; default [0, 1.5].
        #[serde(default = "low_band")]
        band_hz: [f64; 2],
    },
    /// A moment about the vertical axis.
    YawMoment {
        /// Name in reports.
        name: String,
        /// Largest moment.
        bound_n_m: f64,
        /// Frequency range; default [0, 1.5].
        #[serde(default = "low_band")]
        band_hz: [f64; 2],
    },
    /// Any other: `x' = ... + direction d`.
    Direction {
        /// Name in reports.
        name: String,
        /// Change of [v_x, v_y, r] in m/s^2, m/s^2, rad/s^2 per unit of d.
        direction: [f64; 3],
        /// Largest |d|.
        bound: f64,
        /// Frequency range; default [0, 1.5].
        #[serde(default = "low_band")]
        band_hz: [f64; 2],
    },
}

fn quarter_of_a_metre() -> f64 {
    0.25
}

impl Disturbance {
    /// Name in reports.
    pub fn name(&self) -> &str {
        match self {
            Self::SideWind { name, .. }
            | Self::Bank { name, .. }
            | Self::YawMoment { name, .. }
            | Self::Direction { name, .. } => name,
        }
    }

    /// Change of [v_x, v_y, r] in m/s^2, m/s^2, rad/s^2 per unit of the disturbance.
    pub fn direction(&self, vehicle: &Vehicle) -> [f64; 3] {
        match self {
            Self::SideWind { acting_ahead_m, .. } => {
                [0.0, 1.0, vehicle.mass_kg * acting_ahead_m / vehicle.yaw_inertia_kg_m2]
            }
            Self::Bank { .. } => [0.0, -GRAVITY_M_PER_S2.to_radians(), 0.0],
            Self::YawMoment { .. } => [0.0, 0.0, 1.0 / vehicle.yaw_inertia_kg_m2],
            Self::Direction { direction, .. } => *direction,
        }
    }

    /// Largest magnitude, in its unit.
    pub fn bound(&self) -> f64 {
        match self {
            Self::SideWind { bound_m_per_s2, .. } => *bound_m_per_s2,
            Self::Bank { bound_deg, .. } => *bound_deg,
            Self::YawMoment { bound_n_m, .. } => *bound_n_m,
            Self::Direction { bound, .. } => *bound,
        }
    }

    /// The same, to be changed.
    pub(crate) fn bound_mut(&mut self) -> &mut f64 {
        match self {
            Self::SideWind { bound_m_per_s2, .. } => bound_m_per_s2,
            Self::Bank { bound_deg, .. } => bound_deg,
            Self::YawMoment { bound_n_m, .. } => bound_n_m,
            Self::Direction { bound, .. } => bound,
        }
    }

    /// Key of its largest magnitude.
    pub(crate) fn bound_key(&self) -> &'static str {
        match self {
            Self::SideWind { .. } => "bound_m_per_s2",
            Self::Bank { .. } => "bound_deg",
            Self::YawMoment { .. } => "bound_n_m",
            Self::Direction { .. } => "bound",
        }
    }

    /// Unit of the disturbance.
    pub fn unit(&self) -> &'static str {
        match self {
            Self::SideWind { .. } => "m/s^2",
            Self::Bank { .. } => "deg",
            Self::YawMoment { .. } => "N m",
            Self::Direction { .. } => "1",
        }
    }

    /// Frequency range, Hz.
    pub fn band_hz(&self) -> [f64; 2] {
        match self {
            Self::SideWind { band_hz, .. }
            | Self::Bank { band_hz, .. }
            | Self::YawMoment { band_hz, .. }
            | Self::Direction { band_hz, .. } => *band_hz,
        }
    }

    /// Finds what is not possible of the disturbance called `at`; of its band where the Nyquist
    /// frequency is known.
    pub(super) fn check(&self, at: &str, nyquist_hz: Option<f64>, mistakes: &mut Mistakes) {
        let (key, bound, most) = match self {
            Self::SideWind { bound_m_per_s2, acting_ahead_m, .. } => {
                let key = format!("{at}.acting_ahead_m");
                mistakes.number(&key, *acting_ahead_m, Allowed::FINITE);
                ("bound_m_per_s2", *bound_m_per_s2, 100.0)
            }
            Self::Bank { bound_deg, .. } => ("bound_deg", *bound_deg, 45.0),
            Self::YawMoment { bound_n_m, .. } => ("bound_n_m", *bound_n_m, 1e6),
            Self::Direction { bound, direction, .. } => {
                let proper =
                    direction.iter().all(|x| x.is_finite()) && direction.iter().any(|&x| x != 0.0);
                mistakes.unless(proper, || {
                    let allowed = "finite numbers, not all zero";
                    Mistake::value(format!("{at}.direction"), direction, allowed)
                });
                ("bound", *bound, 1e6)
            }
        };
        mistakes.number(&format!("{at}.{key}"), bound, Allowed::above_up_to(0.0, most));
        if let Some(nyquist_hz) = nyquist_hz {
            check_band(at, self.band_hz(), nyquist_hz, mistakes);
        }
    }
}

impl Default for Disturbance {
    /// The paper's side wind.
    fn default() -> Self {
        Self::SideWind {
            name: "side wind".into(),
            acting_ahead_m: quarter_of_a_metre(),
            bound_m_per_s2: 0.1,
            band_hz: low_band(),
        }
    }
}
