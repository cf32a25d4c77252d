//! Channels of a specification: faults, disturbances and sensor noise.

use serde::{Deserialize, Serialize};
use steerguard_detector::Vehicle;

/// Standard acceleration of gravity, m/s^2.
pub(super) const GRAVITY: f64 = 9.80665;

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

pub(super) fn half_a_degree() -> f64 {
    0.5
}

pub(super) fn low_band() -> [f64; 2] {
    [0.0, 1.5]
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
}

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

pub(super) fn quarter_of_a_metre() -> f64 {
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
            Self::Bank { .. } => [0.0, -GRAVITY.to_radians(), 0.0],
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
}

/// `[noise]`: sensor noise. Bounds count like those of disturbances, in the norm of their band;
/// standard deviations of white noise give the RMS of the residual.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Noise {
    /// Of the speed.
    pub v_x: SpeedNoise,
    /// Of the yaw rate.
    pub r: YawRateNoise,
}

/// `[noise.v_x]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SpeedNoise {
    /// Standard deviation of a sample, white; default 0.02.
    pub white_std_m_per_s: f64,
    /// Largest magnitude; default none.
    pub bound_m_per_s: Option<f64>,
    /// Frequency range of what is bounded; default all.
    pub band_hz: Option<[f64; 2]>,
}

/// `[noise.r]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct YawRateNoise {
    /// Standard deviation of a sample, white; default 0.002.
    pub white_std_rad_per_s: f64,
    /// Largest magnitude; default none.
    pub bound_rad_per_s: Option<f64>,
    /// Frequency range of what is bounded; default all.
    pub band_hz: Option<[f64; 2]>,
}

impl Default for SpeedNoise {
    fn default() -> Self {
        Self { white_std_m_per_s: 0.02, bound_m_per_s: None, band_hz: None }
    }
}

impl Default for YawRateNoise {
    fn default() -> Self {
        Self { white_std_rad_per_s: 0.002, bound_rad_per_s: None, band_hz: None }
    }
}

impl Noise {
    /// Standard deviations of [v_x, r], m/s and rad/s.
    pub fn white_std(&self) -> [f64; 2] {
        [self.v_x.white_std_m_per_s, self.r.white_std_rad_per_s]
    }

    /// Largest magnitudes of [v_x, r], m/s and rad/s.
    pub fn bounds(&self) -> [Option<f64>; 2] {
        [self.v_x.bound_m_per_s, self.r.bound_rad_per_s]
    }

    /// Frequency ranges of [v_x, r], Hz; none for all frequencies.
    pub fn bands_hz(&self) -> [Option<[f64; 2]>; 2] {
        [self.v_x.band_hz, self.r.band_hz]
    }
}
