//! `[actuator]`: the steering actuator.

use serde::{Deserialize, Serialize};
use steerguard_detector::Actuator;

use crate::document::{Allowed, Mistakes};

/// `[actuator]`: what lies between the steering angle that the detector is told and the road wheel. The
/// default is nothing: the angle is a measured one, or the actuator is too fast to matter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct ActuatorTable {
    /// Time constant of a first-order lag; default 0.
    pub lag_s: f64,
    /// Dead time; default 0.
    pub delay_s: f64,
    /// Fastest turn of the road wheel; default none.
    pub rate_limit_rad_per_s: Option<f64>,
    /// Largest angle of the road wheel to either side, its end stops; default none.
    pub angle_limit_deg: Option<f64>,
}

impl ActuatorTable {
    /// Slowest lag, s.
    pub const LARGEST_LAG_S: f64 = 5.0;
    /// Longest dead time, s; the detector's memory may be shorter.
    pub const LARGEST_DELAY_S: f64 = 0.5;
    /// Slowest and fastest rate limit, rad/s.
    pub const RATE_LIMITS_RAD_PER_S: [f64; 2] = [1e-3, 100.0];

    /// The detector's actuator.
    pub fn actuator(self) -> Actuator {
        let Self { lag_s, delay_s, rate_limit_rad_per_s, angle_limit_deg } = self;
        let angle_limit_rad = angle_limit_deg.map(f64::to_radians);
        Actuator { lag_s, delay_s, rate_limit_rad_per_s, angle_limit_rad }
    }

    /// Finds what is not possible, for a dead time of at most `largest_delay_s`.
    pub fn check(self, largest_delay_s: f64, mistakes: &mut Mistakes) {
        let lag_s = Allowed::between(0.0, Self::LARGEST_LAG_S);
        mistakes.number("actuator.lag_s", self.lag_s, lag_s);
        mistakes.number("actuator.delay_s", self.delay_s, Allowed::between(0.0, largest_delay_s));
        if let Some(limit) = self.rate_limit_rad_per_s {
            let [slowest, fastest] = Self::RATE_LIMITS_RAD_PER_S;
            let allowed = Allowed::between(slowest, fastest);
            mistakes.number("actuator.rate_limit_rad_per_s", limit, allowed);
        }
        if let Some(limit) = self.angle_limit_deg {
            mistakes.number("actuator.angle_limit_deg", limit, Allowed::between(1.0, 90.0));
        }
    }
}
