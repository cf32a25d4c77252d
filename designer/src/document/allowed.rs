//! What a number may be.

use std::fmt;

/// A range of finite numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Allowed {
    min: f64,
    max: f64,
    with_min: bool,
    with_max: bool,
}

impl Allowed {
    /// Above 0.
    pub const POSITIVE: Self = Self::inside(0.0, f64::INFINITY);
    /// 0 or above.
    pub const NOT_NEGATIVE: Self = Self::between(0.0, f64::INFINITY);
    /// Any.
    pub const FINITE: Self = Self::inside(f64::NEG_INFINITY, f64::INFINITY);

    /// From `min` to `max`, ends included.
    pub const fn between(min: f64, max: f64) -> Self {
        Self { min, max, with_min: true, with_max: true }
    }

    /// Above `min`, up to `max`.
    pub const fn above_up_to(min: f64, max: f64) -> Self {
        Self { min, max, with_min: false, with_max: true }
    }

    /// From `min` to `max`, ends excluded.
    pub const fn inside(min: f64, max: f64) -> Self {
        Self { min, max, with_min: false, with_max: false }
    }

    /// Whether `value` is finite and in the range.
    pub fn holds(self, value: f64) -> bool {
        let Self { min, max, with_min, with_max } = self;
        let above = min < value || with_min && value == min;
        let below = value < max || with_max && value == max;
        value.is_finite() && above && below
    }
}

impl fmt::Display for Allowed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { min, max, with_min, with_max } = *self;
        match (min.is_finite(), max.is_finite()) {
            (true, true) if with_min => write!(f, "from {min} to {max}"),
            (true, true) if with_max => write!(f, "above {min}, up to {max}"),
            (true, true) => write!(f, "between {min} and {max}"),
            (true, false) if with_min => write!(f, "a finite number >= {min}"),
            (true, false) => write!(f, "a finite number > {min}"),
            _ => write!(f, "a finite number"),
        }
    }
}
