//! Seeded sensor noise: a value for each (seed, sample, channel), computed alone.
//!
//! # Conventions
//! Counter-based, so that a run reproduces from its seed whatever is read, saved or restored between.

/// A standard normal deviate for a sample of a channel.
pub fn standard_normal(seed: i32, sample: u64, channel: u32) -> f64 {
    let key = u64::from(seed.cast_unsigned()) | u64::from(channel) << 32;
    let counter = mix(mix(key).wrapping_add(sample));
    let radius = unit_interval(counter);
    let angle = unit_interval(mix(counter));
    // Box-Muller.
    libm::sqrt(-2.0 * libm::log(radius)) * libm::cos(core::f64::consts::TAU * angle)
}

/// The finaliser of SplitMix64 (Steele, Lea and Flood, 2014) after one step of its counter.
fn mix(x: u64) -> u64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ x >> 31
}

/// The upper 53 bits as a number in (0, 1].
fn unit_interval(bits: u64) -> f64 {
    ((bits >> 11) + 1) as f64 / (1_u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_are_those_of_the_normal_distribution() {
        for (seed, channel) in [(1, 0), (1, 1), (-7, 0)] {
            let samples = 200_000;
            let (mut mean, mut square, mut lag) = (0.0, 0.0, 0.0);
            for k in 0..samples {
                let x = standard_normal(seed, k, channel);
                mean += x;
                square += x * x;
                lag += x * standard_normal(seed, k + 1, channel);
            }
            let n = samples as f64;
            // Five standard errors of each estimate.
            assert!((mean / n).abs() < 5.0 / n.sqrt());
            assert!((square / n - 1.0).abs() < 5.0 * (2.0 / n).sqrt());
            assert!((lag / n).abs() < 5.0 / n.sqrt());
        }
    }

    #[test]
    fn seeds_and_channels_differ() {
        assert_ne!(standard_normal(1, 0, 0), standard_normal(2, 0, 0));
        assert_ne!(standard_normal(1, 0, 0), standard_normal(1, 0, 1));
    }
}
