//! `[operating_range]`: where the detector works.

use serde::{Deserialize, Serialize};
use steerguard_detector::{Interval, OperatingRange};

use crate::document::{Mistake, Mistakes};

/// `[operating_range]`: the design range S_x as [min, max]; the detector disarms outside it and arms
/// inside it shrunk by the hysteresis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OperatingRangeTable {
    /// Longitudinal speed; default [5, 30].
    pub v_x_m_per_s: [f64; 2],
    /// Lateral speed, true and estimated; default [-1.5, 1.5].
    pub v_y_m_per_s: [f64; 2],
    /// Yaw rate; default [-0.55, 0.55].
    pub r_rad_per_s: [f64; 2],
    /// Arming hysteresis of v_x; default 0.5.
    pub v_x_hysteresis_m_per_s: f64,
    /// Arming hysteresis of the estimated v_y; default 0.25.
    pub v_y_hysteresis_m_per_s: f64,
    /// Arming hysteresis of r; default 0.05.
    pub r_hysteresis_rad_per_s: f64,
}

impl Default for OperatingRangeTable {
    fn default() -> Self {
        Self {
            v_x_m_per_s: [5.0, 30.0],
            v_y_m_per_s: [-4.0, 4.0],
            r_rad_per_s: [-1.2, 1.2],
            v_x_hysteresis_m_per_s: 0.5,
            v_y_hysteresis_m_per_s: 0.5,
            r_hysteresis_rad_per_s: 0.1,
        }
    }
}

impl OperatingRangeTable {
    /// S_x.
    pub fn range(&self) -> OperatingRange {
        let interval = |[min, max]: [f64; 2]| Interval::new(min, max);
        OperatingRange {
            v_x: interval(self.v_x_m_per_s),
            v_y: interval(self.v_y_m_per_s),
            r: interval(self.r_rad_per_s),
        }
    }

    /// Arming hysteresis of [v_x, v_y, r].
    pub fn hysteresis(&self) -> [f64; 3] {
        [self.v_x_hysteresis_m_per_s, self.v_y_hysteresis_m_per_s, self.r_hysteresis_rad_per_s]
    }

    /// Finds what is not possible by itself.
    pub(super) fn check(&self, mistakes: &mut Mistakes) {
        for (name, unit, interval, hysteresis) in [
            ("v_x", "m_per_s", self.v_x_m_per_s, self.v_x_hysteresis_m_per_s),
            ("v_y", "m_per_s", self.v_y_m_per_s, self.v_y_hysteresis_m_per_s),
            ("r", "rad_per_s", self.r_rad_per_s, self.r_hysteresis_rad_per_s),
        ] {
            let key = format!("operating_range.{name}_{unit}");
            let [min, max] = interval;
            let allowed = "two finite numbers, min < max";
            let ordered = min.is_finite() && max.is_finite() && min < max;
            mistakes.unless(ordered, || Mistake::value(&key, interval, allowed));
            if name == "v_x" {
                mistakes.unless(min > 0.0, || {
                    Mistake::value(&key, interval, "min > 0").help("the model holds 1/v_x")
                });
            } else {
                let around_zero = min < 0.0 && max > 0.0;
                mistakes.unless(around_zero, || Mistake::value(&key, interval, "min < 0 < max"));
            }
            if mistakes.sound(&key) {
                let half = (max - min) / 2.0;
                let hysteresis_key = format!("operating_range.{name}_hysteresis_{unit}");
                mistakes.unless((0.0..half).contains(&hysteresis), || {
                    let allowed = format!("from 0 to below half the range's width, {half}");
                    Mistake::value(&hysteresis_key, hysteresis, allowed).because_of(&key)
                });
            }
        }
    }
}
