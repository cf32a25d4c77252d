//! Frequency ranges, and their ends enclosed in rational numbers.

use crate::exact::{Rational, approximate, exact, whole};
use crate::refusal::Refusal;

/// How far the upper end may be from the Nyquist frequency to be it, relative.
const ROUNDING: f64 = 1e-12;

/// pi lies between these.
pub fn pi() -> [Rational; 2] {
    let digits = whole(3_141_592_653_589_793_238);
    let unit = whole(1_000_000_000_000_000_000);
    [&digits / &unit, (&digits + whole(1)) / &unit]
}

/// A frequency range in radians a sample.
#[derive(Clone, Debug, PartialEq)]
pub enum Band {
    /// `|w| <= theta`.
    Low(Theta),
    /// `|w| >= theta`.
    High(Theta),
    /// All.
    Full,
}

/// `theta = 2 pi f T_s`: f T_s, exactly.
#[derive(Clone, Debug, PartialEq)]
pub struct Theta {
    cycles_per_sample: Rational,
}

impl Band {
    /// The range that `band_hz` stands for.
    pub fn new(band_hz: [f64; 2], sampling_period_s: f64) -> Result<Self, Refusal> {
        let [from, to] = band_hz.map(|hz| exact(hz) * exact(sampling_period_s));
        // Rounding of the Nyquist frequency.
        let [half_below, half_above] =
            [whole(1) - exact(ROUNDING), whole(1) + exact(ROUNDING)].map(|x| x / whole(2));
        let from_zero = from == whole(0);
        let to_nyquist = to >= half_below;
        let ordered = whole(0) <= from && from < to && from < half_below && to <= half_above;
        if !ordered || !(from_zero || to_nyquist) {
            return Err(Refusal::Band { band_hz });
        }
        Ok(match (from_zero, to_nyquist) {
            (true, true) => Self::Full,
            (true, false) => Self::Low(Theta { cycles_per_sample: to }),
            _ => Self::High(Theta { cycles_per_sample: from }),
        })
    }
}

impl Theta {
    /// Numbers that `2 cos(theta)` lies between.
    pub fn two_cos(&self) -> [Rational; 2] {
        let two = whole(2);
        // Of theta in [0, pi] the cosine falls.
        let [below, above] = pi().map(|pi| &two * pi * &self.cycles_per_sample);
        [&two * cosine(&above, 23), &two * cosine(&below, 24)]
    }

    /// The nearest f64.
    pub fn approximate(&self) -> f64 {
        2.0 * std::f64::consts::PI * approximate(&self.cycles_per_sample)
    }
}

/// `1 - x^2/2! + x^4/4! - ...` up to the power `2 last`: at most cos(x) for odd `last`, at least
/// for even, whatever x.
fn cosine(x: &Rational, last: i64) -> Rational {
    let mut term = whole(1);
    let mut sum = whole(1);
    for k in 1..=last {
        term = -term * x * x / whole(2 * k * (2 * k - 1));
        sum += &term;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cosine_is_enclosed() {
        for (hz, period) in [(1.5, 0.01), (0.001, 0.001), (49.0, 0.01), (25.0, 0.01)] {
            let Ok(Band::Low(theta)) = Band::new([0.0, hz], period) else { panic!() };
            let [below, above] = theta.two_cos();
            assert!(below < above);
            assert!(approximate(&(&above - &below)) < 1e-16);
            let expected = 2.0 * theta.approximate().cos();
            assert!((approximate(&below) - expected).abs() < 1e-15);
        }
    }

    #[test]
    fn bands_are_low_high_or_full() {
        assert!(matches!(Band::new([0.0, 1.5], 0.01), Ok(Band::Low(_))));
        assert!(matches!(Band::new([1.5, 50.0], 0.01), Ok(Band::High(_))));
        assert!(matches!(Band::new([0.0, 0.5 / 0.03], 0.03), Ok(Band::Full)));
        for band in [[1.0, 2.0], [2.0, 2.0], [-1.0, 2.0], [3.0, 2.0]] {
            assert!(matches!(Band::new(band, 0.01), Err(Refusal::Band { .. })));
        }
    }
}
