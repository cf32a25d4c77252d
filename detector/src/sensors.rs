//! What is known of the signals themselves: their zeros, their limits, and when one has died.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::{Input, Measurement};

/// What the sensors show where there is nothing: it is subtracted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize), serde(deny_unknown_fields))]
pub struct Zero {
    /// Commanded angle at which the road wheel stands straight, rad.
    pub steering_offset_rad: f64,
    /// Yaw rate shown at standstill, rad/s.
    pub yaw_rate_bias_rad_per_s: f64,
}

/// When measurements that no longer change are stale.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize), serde(deny_unknown_fields))]
pub struct Staleness {
    /// Speed and yaw rate both the same, bit for bit, for longer than this are stale, s; 0 for never.
    pub after_s: f64,
    /// A change of the speed by more than this in a sample, m/s, no vehicle makes: the observer starts
    /// anew where stale data return with it.
    pub v_x_jump_m_per_s: f64,
    /// Likewise of the yaw rate, rad/s.
    pub r_jump_rad_per_s: f64,
}

/// A change of a measured signal that no vehicle makes in a sample, in the signal's unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jump {
    /// Magnitude of the change.
    pub change: f64,
    /// The most that a vehicle and the sensor's noise allow.
    pub most: f64,
}

impl Staleness {
    /// Nothing is ever stale.
    pub const NEVER: Self = Self { after_s: 0.0, v_x_jump_m_per_s: 0.0, r_jump_rad_per_s: 0.0 };

    /// The jumps of `[v_x, r]` from one measurement to the next; none where a vehicle may get there.
    pub fn jumps(&self, from: Measurement, to: Measurement) -> [Option<Jump>; 2] {
        let jump = |from: f64, to: f64, most: f64| {
            let change = (from - to).max(to - from);
            (change > most).then_some(Jump { change, most })
        };
        [
            jump(from.v_x_m_per_s, to.v_x_m_per_s, self.v_x_jump_m_per_s),
            jump(from.r_rad_per_s, to.r_rad_per_s, self.r_jump_rad_per_s),
        ]
    }
}

/// The signals that a detector is told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signal {
    /// v_x.
    Speed,
    /// r.
    YawRate,
    /// T_eng.
    DriveTorque,
    /// delta.
    SteeringAngle,
}

impl Signal {
    /// In the order `[v_x, r, T_eng, delta]`.
    pub const ALL: [Self; 4] = [Self::Speed, Self::YawRate, Self::DriveTorque, Self::SteeringAngle];

    /// Largest magnitude that is valid, m/s, rad/s, N m, rad: no road vehicle goes beyond.
    pub const fn limit(self) -> f64 {
        match self {
            Self::Speed => 150.0,
            Self::YawRate => 20.0,
            Self::DriveTorque => 1e6,
            Self::SteeringAngle => 1.6,
        }
    }

    /// Whether a value is valid; NaN lies in no interval.
    pub(crate) fn admits(self, value: f64) -> bool {
        -self.limit() <= value && value <= self.limit()
    }

    /// The first that is not finite or beyond its limit.
    pub(crate) fn invalid(y: Measurement, u: Input) -> Option<Self> {
        let values = [y.v_x_m_per_s, y.r_rad_per_s, u.t_eng_n_m, u.delta_rad];
        let mut signals = Self::ALL.into_iter().zip(values);
        signals.find(|(signal, value)| !signal.admits(*value)).map(|(signal, _)| signal)
    }
}
