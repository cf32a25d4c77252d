//! Wind across the road: gusts of 1-cosine shape, one after the other.

use core::f64::consts::TAU;

use steerguard_detector::Gust;

/// Length of a gust, shortest and longest, s.
pub const GUST_S: [f64; 2] = [0.5, 3.0];
/// Time before the first gust and between two, shortest and longest, s.
pub const CALM_S: [f64; 2] = [1.0, 5.0];

/// When gusts blow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gusts {
    /// Fastest wind across the road in a gust, m/s, positive to the left.
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

/// Gusts, and what they do to the vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wind {
    /// When they blow, and how fast.
    pub gusts: Gusts,
    /// How they act; its speed is not used.
    pub action: Gust,
}

impl Wind {
    /// Side force in N and yaw moment in N m at time `t` and speed `v_x` in m/s.
    pub fn side_force_and_yaw_moment(&self, t: f64, v_x: f64) -> [f64; 2] {
        let speed_m_per_s = self.gusts.wind_m_per_s(t);
        let force = Gust { speed_m_per_s, ..self.action }.side_force(v_x);
        [force, force * self.action.acting_ahead_m]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GUSTS: Gusts = Gusts { speed_m_per_s: 10.0, start_s: 2.0, duration_s: 1.0, pause_s: 3.0 };

    #[test]
    fn gusts_rise_and_fall_once_in_their_length() {
        for (t, expected) in
            [(1.0, 0.0), (2.0, 0.0), (2.25, 5.0), (2.5, 10.0), (3.0, 0.0), (5.0, 0.0), (6.5, 10.0)]
        {
            assert!((GUSTS.wind_m_per_s(t) - expected).abs() < 1e-12, "at {t} s");
        }
        assert_eq!(Gusts::NONE.wind_m_per_s(1e9), 0.0);
    }

    #[test]
    fn a_passenger_car_at_30_m_per_s_is_pushed_by_800_n() {
        let action =
            Gust { speed_m_per_s: 0.0, coefficient_n_s2_per_m2: 2.64, acting_ahead_m: 0.25 };
        // 1.2/2 x 2.2 x 2 x 10 x sqrt(30^2 + 10^2), 0.25 m ahead.
        let wind = Wind { gusts: GUSTS, action };
        let [force, moment] = wind.side_force_and_yaw_moment(2.5, 30.0);
        assert!((force - 834.8).abs() < 0.1 && (moment - 0.25 * force).abs() < 1e-12);
    }
}
