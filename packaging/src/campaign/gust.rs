//! Gusts across the road: 1-cosine, one after the other.
//!
//! # Conventions
//! The side force is `rho/2 A c_S w sqrt(v^2 + w^2)`: the side-force derivative c_S times the sine of
//! the angle of attack. It acts ahead of the centre of gravity, as in METHOD.md 7.

use std::f64::consts::TAU;

use super::drive::Drive;

/// Density of air, kg/m^3.
const AIR_KG_PER_M3: f64 = 1.2;
/// Frontal area of a passenger car, m^2.
const FRONTAL_AREA_M2: f64 = 2.2;
/// Side-force derivative of a passenger car on its frontal area, 1/rad.
const SIDE_FORCE_PER_RAD: f64 = 2.0;
/// Distance of the line of action ahead of the centre of gravity, m.
const ACTING_AHEAD_M: f64 = 0.25;

/// Speed of the wind across the road at time `t`, m/s.
fn wind_m_per_s(drive: &Drive, t: f64) -> f64 {
    let since_s = t - drive.gust_start_s;
    if since_s < 0.0 {
        return 0.0;
    }
    let gust_s = libm::fmod(since_s, drive.gust_duration_s + drive.gust_pause_s);
    if gust_s >= drive.gust_duration_s {
        return 0.0;
    }
    0.5 * drive.gust_m_per_s * (1.0 - libm::cos(TAU * gust_s / drive.gust_duration_s))
}

/// Side force in N and yaw moment in N m at time `t` and speed `v_x`.
pub fn side_force_and_yaw_moment(drive: &Drive, t: f64, v_x: f64) -> [f64; 2] {
    let wind = wind_m_per_s(drive, t);
    let pressure = 0.5 * AIR_KG_PER_M3 * FRONTAL_AREA_M2 * SIDE_FORCE_PER_RAD;
    let force = pressure * wind * libm::sqrt(v_x * v_x + wind * wind);
    [force, force * ACTING_AHEAD_M]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::campaign::settings::tests::{PAPER, SETTINGS};

    #[test]
    fn gusts_rise_and_fall_once_in_their_length() {
        let drive = Drive {
            gust_m_per_s: 10.0,
            gust_start_s: 2.0,
            gust_duration_s: 1.0,
            gust_pause_s: 3.0,
            ..Drive::draw(&SETTINGS, &PAPER, 0)
        };
        for (t, expected) in
            [(1.0, 0.0), (2.0, 0.0), (2.25, 5.0), (2.5, 10.0), (3.0, 0.0), (5.0, 0.0), (6.5, 10.0)]
        {
            assert!((wind_m_per_s(&drive, t) - expected).abs() < 1e-12, "at {t} s");
        }
        // 1.2/2 x 2.2 x 2 x 10 x sqrt(30^2 + 10^2), 0.25 m ahead.
        let [force, moment] = side_force_and_yaw_moment(&drive, 2.5, 30.0);
        assert!((force - 834.8).abs() < 0.1 && (moment - 0.25 * force).abs() < 1e-12);
    }
}
