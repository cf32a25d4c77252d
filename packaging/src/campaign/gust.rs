//! Gusts across the road, as the drives have them.

use steerguard_detector::Gust;
use steerguard_world::Gusts;

use super::drive::Drive;

/// Side force in N and yaw moment in N m at time `t` and speed `v_x`, of a vehicle on which `gust`
/// says how gusts act.
pub fn side_force_and_yaw_moment(drive: &Drive, gust: Gust, t: f64, v_x: f64) -> [f64; 2] {
    let gusts = Gusts {
        speed_m_per_s: drive.gust_m_per_s,
        duration_s: drive.gust_duration_s,
        start_s: drive.gust_start_s,
        pause_s: drive.gust_pause_s,
    };
    let force = Gust { speed_m_per_s: gusts.wind_m_per_s(t), ..gust }.side_force(v_x);
    [force, force * gust.acting_ahead_m]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::campaign::settings::tests::{PAPER, SETTINGS};

    #[test]
    fn a_passenger_car_at_30_m_per_s_is_pushed_by_800_n() {
        let drive = Drive {
            gust_m_per_s: 10.0,
            gust_start_s: 2.0,
            gust_duration_s: 1.0,
            gust_pause_s: 3.0,
            ..Drive::draw(&SETTINGS, &PAPER, 0)
        };
        // 1.2/2 x 2.2 x 2 x 10 x sqrt(30^2 + 10^2), 0.25 m ahead.
        let [force, moment] = side_force_and_yaw_moment(&drive, PAPER.gust, 2.5, 30.0);
        assert!((force - 834.8).abs() < 0.1 && (moment - 0.25 * force).abs() < 1e-12);
    }
}
