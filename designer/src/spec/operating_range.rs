//! `[operating_range]`: where the detector works.

use serde::{Deserialize, Serialize};
use steerguard_detector::{Interval, OperatingRange};

use crate::document::{Mistake, Mistakes};

/// `[operating_range]`: the design range S_x as [min, max]; the detector disarms outside it and arms
/// inside it shrunk by the hysteresis.
///
/// Each hysteresis has a default for wide ranges, and in a narrow one [`DEFAULT_SHARE`] of its width.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "Stated")]
pub struct OperatingRangeTable {
    /// Longitudinal speed; default [5, 30].
    pub v_x_m_per_s: [f64; 2],
    /// Lateral speed, true and estimated; default [-4, 4].
    pub v_y_m_per_s: [f64; 2],
    /// Yaw rate; default [-1.2, 1.2].
    pub r_rad_per_s: [f64; 2],
    /// Arming hysteresis of v_x; default 0.5, or the share.
    pub v_x_hysteresis_m_per_s: f64,
    /// Arming hysteresis of the estimated v_y; default 0.5, or the share.
    pub v_y_hysteresis_m_per_s: f64,
    /// Arming hysteresis of r; default 0.1, or the share.
    pub r_hysteresis_rad_per_s: f64,
}

/// Largest share of a range's width that a hysteresis has which is not stated: no range is too narrow for
/// a key that nobody wrote.
const DEFAULT_SHARE: f64 = 1.0 / 12.0;

/// The table as it is written.
#[derive(Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Stated {
    v_x_m_per_s: [f64; 2],
    v_y_m_per_s: [f64; 2],
    r_rad_per_s: [f64; 2],
    v_x_hysteresis_m_per_s: Option<f64>,
    v_y_hysteresis_m_per_s: Option<f64>,
    r_hysteresis_rad_per_s: Option<f64>,
}

impl Default for Stated {
    fn default() -> Self {
        let OperatingRangeTable { v_x_m_per_s, v_y_m_per_s, r_rad_per_s, .. } =
            OperatingRangeTable::DEFAULT;
        Self {
            v_x_m_per_s,
            v_y_m_per_s,
            r_rad_per_s,
            v_x_hysteresis_m_per_s: None,
            v_y_hysteresis_m_per_s: None,
            r_hysteresis_rad_per_s: None,
        }
    }
}

impl From<Stated> for OperatingRangeTable {
    fn from(stated: Stated) -> Self {
        let or_share = |stated: Option<f64>, wide: f64, [min, max]: [f64; 2]| {
            stated.unwrap_or_else(|| wide.min(DEFAULT_SHARE * (max - min)))
        };
        let Stated { v_x_m_per_s, v_y_m_per_s, r_rad_per_s, .. } = stated;
        let wide = Self::DEFAULT;
        Self {
            v_x_m_per_s,
            v_y_m_per_s,
            r_rad_per_s,
            v_x_hysteresis_m_per_s: or_share(
                stated.v_x_hysteresis_m_per_s,
                wide.v_x_hysteresis_m_per_s,
                v_x_m_per_s,
            ),
            v_y_hysteresis_m_per_s: or_share(
                stated.v_y_hysteresis_m_per_s,
                wide.v_y_hysteresis_m_per_s,
                v_y_m_per_s,
            ),
            r_hysteresis_rad_per_s: or_share(
                stated.r_hysteresis_rad_per_s,
                wide.r_hysteresis_rad_per_s,
                r_rad_per_s,
            ),
        }
    }
}

impl Default for OperatingRangeTable {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl OperatingRangeTable {
    /// What tyres on a dry road allow, nearly.
    pub const DEFAULT: Self = Self {
        v_x_m_per_s: [5.0, 30.0],
        v_y_m_per_s: [-4.0, 4.0],
        r_rad_per_s: [-1.2, 1.2],
        v_x_hysteresis_m_per_s: 0.5,
        v_y_hysteresis_m_per_s: 0.5,
        r_hysteresis_rad_per_s: 0.1,
    };

    /// The paper's.
    pub const PAPER: Self = Self {
        v_x_m_per_s: [5.0, 30.0],
        v_y_m_per_s: [-1.5, 1.5],
        r_rad_per_s: [-0.55, 0.55],
        v_x_hysteresis_m_per_s: 0.5,
        v_y_hysteresis_m_per_s: 0.25,
        r_hysteresis_rad_per_s: 0.05,
    };

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
