//! Gusts across the road: 1-cosine, one after the other.
//!
//! # Conventions
//! Sine and cosine are those of `libm`: the same on every machine.

use std::f64::consts::TAU;

/// When gusts blow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gusts {
    /// Fastest wind across the road in a gust, m/s; its sign is the direction.
    pub speed_m_per_s: f64,
    /// Length of a gust, s.
    pub duration_s: f64,
    /// When the first one begins, s.
    pub start_s: f64,
    /// Time between two, s.
    pub pause_s: f64,
}

impl Gusts {
    /// Still air.
    pub const NONE: Self =
        Self { speed_m_per_s: 0.0, duration_s: 0.0, start_s: f64::INFINITY, pause_s: 0.0 };

    /// Wind across the road at time `t`, m/s.
    pub fn wind_m_per_s(&self, t: f64) -> f64 {
        let since_s = t - self.start_s;
        if since_s < 0.0 {
            return 0.0;
        }
        let gust_s = libm::fmod(since_s, self.duration_s + self.pause_s);
        if gust_s >= self.duration_s {
            return 0.0;
        }
        0.5 * self.speed_m_per_s * (1.0 - libm::cos(TAU * gust_s / self.duration_s))
    }
}

#[cfg(test)]
mod tests {
    use super::Gusts;

    #[test]
    fn gusts_rise_and_fall_once_in_their_length() {
        let gusts = Gusts { speed_m_per_s: 10.0, start_s: 2.0, duration_s: 1.0, pause_s: 3.0 };
        for (t, expected) in
            [(1.0, 0.0), (2.0, 0.0), (2.25, 5.0), (2.5, 10.0), (3.0, 0.0), (5.0, 0.0), (6.5, 10.0)]
        {
            assert!((gusts.wind_m_per_s(t) - expected).abs() < 1e-12, "at {t} s");
        }
    }
}
