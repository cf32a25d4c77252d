//! Random numbers by counter: each is a function of seed, stream and number alone.
//!
//! # Conventions
//! - SplitMix64 (Steele, Lea and Flood, 2014) from a place that seed and stream give, so that a number
//!   needs none before it, and a new one changes none that is there.
//! - Uniform numbers take `+ - * /` only; normal ones the logarithm and cosine of `libm`.

/// A stream of random numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stream(u64);

impl Stream {
    /// Stream `stream` of `seed`.
    pub const fn new(seed: u64, stream: u64) -> Self {
        Self(mix(mix(seed).wrapping_add(stream)))
    }

    /// 64 random bits.
    pub const fn bits(self, number: u64) -> u64 {
        mix(self.0.wrapping_add(number.wrapping_mul(GOLDEN)))
    }

    /// Uniform in `[0, 1)`.
    pub fn unit(self, number: u64) -> f64 {
        (self.bits(number) >> 11) as f64 * RESOLUTION
    }

    /// Uniform in `[min, max]`.
    pub fn uniform(self, number: u64, [min, max]: [f64; 2]) -> f64 {
        // Rounding may lead past the end.
        (min + (max - min) * self.unit(number)).min(max)
    }

    /// Uniform in `[-bound, bound]`.
    pub fn within(self, number: u64, bound: f64) -> f64 {
        self.uniform(number, [-bound, bound])
    }

    /// 1 or -1, equally likely.
    pub fn sign(self, number: u64) -> f64 {
        if self.bits(number) >> 63 == 0 { 1.0 } else { -1.0 }
    }

    /// One of `choices`, equally likely; `None` of none.
    pub fn choose<T: Copy>(self, number: u64, choices: &[T]) -> Option<T> {
        let place = (u128::from(self.bits(number)) * choices.len() as u128) >> 64;
        choices.get(place as usize).copied()
    }

    /// Standard normal, by Box and Muller (1958).
    pub fn normal(self, number: u64) -> f64 {
        let bits = self.bits(number);
        let radius = ((bits >> 11) + 1) as f64 * RESOLUTION; // in (0, 1]
        let turns = (mix(bits) >> 11) as f64 * RESOLUTION;
        libm::sqrt(-2.0 * libm::log(radius)) * libm::cos(core::f64::consts::TAU * turns)
    }
}

/// Distance of the numbers in [0, 1).
const RESOLUTION: f64 = 1.0 / (1_u64 << 53) as f64;

/// 2^64 over the golden ratio, odd.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// A step of SplitMix64's counter, and its finaliser.
const fn mix(x: u64) -> u64 {
    let x = x.wrapping_add(GOLDEN);
    let x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ x >> 31
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_those_of_splitmix64() {
        // The first three of seed 1234567: Vigna's reference implementation.
        let expected = [6457827717110365317, 3203168211198807973, 9817491932198370423];
        for (number, expected) in (0..).zip(expected) {
            assert_eq!(Stream(1234567).bits(number), expected);
        }
    }

    #[test]
    fn numbers_depend_on_seed_stream_and_number_alone() {
        let bits = Stream::new(7, 3).bits(5);
        assert_eq!(Stream::new(7, 3).bits(5), bits);
        for other in
            [Stream::new(7, 3).bits(6), Stream::new(7, 4).bits(5), Stream::new(8, 3).bits(5)]
        {
            assert_ne!(other, bits);
        }
    }

    #[test]
    fn normal_numbers_have_the_moments_of_their_distribution() {
        for (seed, stream) in [(1, 0), (1, 1), (u64::MAX, 0)] {
            let numbers = Stream::new(seed, stream);
            let n = 200_000_u32;
            let mean_of =
                |f: &dyn Fn(u64) -> f64| (0..u64::from(n)).map(f).sum::<f64>() / f64::from(n);
            // Five standard errors of each estimate: of x 1, x^2 2, x^3 15, x^4 96, of x y 1.
            let within = |mean: f64, expected: f64, variance: f64| {
                let error = libm::sqrt(variance / f64::from(n));
                assert!((mean - expected).abs() < 5.0 * error, "{mean} for {expected}");
            };
            within(mean_of(&|k| numbers.normal(k)), 0.0, 1.0);
            within(mean_of(&|k| libm::pow(numbers.normal(k), 2.0)), 1.0, 2.0);
            within(mean_of(&|k| libm::pow(numbers.normal(k), 3.0)), 0.0, 15.0);
            within(mean_of(&|k| libm::pow(numbers.normal(k), 4.0)), 3.0, 96.0);
            within(mean_of(&|k| numbers.normal(k) * numbers.normal(k + 1)), 0.0, 1.0);
            let other = Stream::new(seed, stream + 1);
            within(mean_of(&|k| numbers.normal(k) * other.normal(k)), 0.0, 1.0);
        }
    }

    #[test]
    fn uniform_numbers_fill_their_interval() {
        let n = 10_000_u32;
        let numbers = |index: u32| Stream::new(1, index.into());
        let uniform = || (0..n).map(|index| numbers(index).uniform(1, [2.0, 6.0]));
        assert!(uniform().all(|x| (2.0..=6.0).contains(&x)));
        // Five standard errors.
        let mean = uniform().sum::<f64>() / f64::from(n);
        assert!((mean - 4.0).abs() < 5.0 * 4.0 / libm::sqrt(12.0 * f64::from(n)), "{mean}");
        let ones = (0..n).filter(|&index| numbers(index).sign(5) > 0.0).count() as f64;
        assert!((ones / f64::from(n) - 0.5).abs() < 5.0 * 0.5 / libm::sqrt(f64::from(n)));
    }

    #[test]
    fn choices_are_equally_likely() {
        let mut counts = [0_u32; 7];
        for index in 0..7000 {
            let choice = Stream::new(1, index).choose(48, &[0_usize, 1, 2, 3, 4, 5, 6]).unwrap();
            counts[choice] += 1;
        }
        // Five standard errors of a count: sqrt(7000 x 6/49) = 29.
        assert!(counts.iter().all(|&count| count.abs_diff(1000) < 147), "{counts:?}");
        assert_eq!(Stream::new(1, 0).choose::<u8>(0, &[]), None);
    }
}
