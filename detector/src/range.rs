//! The set S_x (4) on which a design holds.

use crate::VehicleState;

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

/// A closed interval `[min, max]`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize), serde(deny_unknown_fields))]
pub struct Interval {
    /// Lower end.
    pub min: f64,
    /// Upper end.
    pub max: f64,
}

impl Interval {
    /// The interval `[min, max]`.
    pub const fn new(min: f64, max: f64) -> Self {
        Self { min, max }
    }

    /// Whether `value` lies inside; NaN lies in no interval.
    pub fn contains(&self, value: f64) -> bool {
        self.min <= value && value <= self.max
    }

    /// The interval with both ends moved inwards by `margin`.
    pub fn shrunk(&self, margin: f64) -> Self {
        Self::new(self.min + margin, self.max - margin)
    }

    /// Largest magnitude in the interval.
    pub fn magnitude(&self) -> f64 {
        (-self.min).max(self.max)
    }
}

/// The compact set S_x (4): the range of the state for which the gains are designed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize), serde(deny_unknown_fields))]
pub struct OperatingRange {
    /// Longitudinal speed, m/s; its minimum is positive, since 1/v_x is a premise variable.
    pub v_x: Interval,
    /// Lateral speed, m/s.
    pub v_y: Interval,
    /// Yaw rate, rad/s.
    pub r: Interval,
}

impl OperatingRange {
    /// Whether the state lies in S_x.
    pub fn contains(&self, x: VehicleState) -> bool {
        self.v_x.contains(x.v_x_m_per_s)
            && self.v_y.contains(x.v_y_m_per_s)
            && self.r.contains(x.r_rad_per_s)
    }

    /// S_x with every interval shrunk by `margins` = [v_x, v_y, r].
    pub fn shrunk(&self, [v_x, v_y, r]: [f64; 3]) -> Self {
        Self { v_x: self.v_x.shrunk(v_x), v_y: self.v_y.shrunk(v_y), r: self.r.shrunk(r) }
    }
}
