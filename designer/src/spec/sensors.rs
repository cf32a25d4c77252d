//! `[sensors]`: what the sensors show of what there is.

use serde::{Deserialize, Serialize};
use steerguard_detector::Zero;

use crate::document::{Allowed, Mistakes};

/// `[sensors]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SensorsTable {
    /// Angle of the hand wheel over that of the road wheel, for recorded drives; default 1, which is the
    /// road wheel's own angle.
    pub steering_ratio: f64,
    /// Commanded angle, at the road wheel, at which the vehicle drives straight ahead: subtracted; default
    /// 0.
    pub steering_offset_deg: f64,
    /// Yaw rate shown at standstill: subtracted; default 0.
    pub yaw_rate_bias_deg_per_s: f64,
}

impl Default for SensorsTable {
    fn default() -> Self {
        Self { steering_ratio: 1.0, steering_offset_deg: 0.0, yaw_rate_bias_deg_per_s: 0.0 }
    }
}

impl SensorsTable {
    /// What is subtracted.
    pub fn zero(&self) -> Zero {
        Zero {
            steering_offset_rad: self.steering_offset_deg.to_radians(),
            yaw_rate_bias_rad_per_s: self.yaw_rate_bias_deg_per_s.to_radians(),
        }
    }

    /// Finds what is not possible.
    pub(super) fn check(&self, mistakes: &mut Mistakes) {
        for (key, value, allowed) in [
            ("steering_ratio", self.steering_ratio, Allowed::between(0.1, 100.0)),
            ("steering_offset_deg", self.steering_offset_deg, Allowed::between(-10.0, 10.0)),
            (
                "yaw_rate_bias_deg_per_s",
                self.yaw_rate_bias_deg_per_s,
                Allowed::between(-10.0, 10.0),
            ),
        ] {
            mistakes.number(&format!("sensors.{key}"), value, allowed);
        }
    }
}
