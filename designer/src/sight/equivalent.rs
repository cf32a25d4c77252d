//! What no method can tell from a steering fault: method 12.
//!
//! Straight and steady, a road wheel that is off by
//!
//! ```text
//! f = K g sin b + F [(l_r + l_w) / (2 C_f L) - (l_f - l_w) / (2 C_r L)],
//! K = M (l_r C_r - l_f C_f) / (2 C_f C_r L),  L = l_f + l_r
//! ```
//!
//! goes unseen on a road banked by b with a side force F on it, which acts l_w ahead of the centre of
//! gravity: every slip angle, and so every measurement, is that of a healthy vehicle without them.
//!
//! # Conventions
//! f is the actual less the commanded angle, left positive; the bank's left side is raised and F points
//! to the right where they are positive.

use steerguard_detector::{Configuration, Vehicle};

/// The road-wheel angle in rad that goes unseen on a road whose bank pulls to the right by
/// `bank_m_per_s2`, under the side force `force_n` to the right that acts `ahead_m` ahead of the centre
/// of gravity. The lateral drag of the sideslip is left out.
pub fn equivalent_angle_rad(
    vehicle: &Vehicle,
    bank_m_per_s2: f64,
    force_n: f64,
    ahead_m: f64,
) -> f64 {
    let (l_f, l_r) = (vehicle.front_axle_distance_m, vehicle.rear_axle_distance_m);
    let wheelbase = l_f + l_r;
    let front = 2.0 * vehicle.front_cornering_stiffness_n_per_rad * wheelbase;
    let rear = 2.0 * vehicle.rear_cornering_stiffness_n_per_rad * wheelbase;
    let of_bank = vehicle.mass_kg * bank_m_per_s2 * (l_r / front - l_f / rear);
    of_bank + force_n * ((l_r + ahead_m) / front - (l_f - ahead_m) / rear)
}

/// F: the angle in rad that bank and gust at their bounds look like together, at the speed of the design
/// range where it is largest.
pub fn bank_and_wind_rad(configuration: &Configuration) -> f64 {
    let vehicle = &configuration.model.vehicle;
    let uncertainty = &configuration.deviations.uncertainty;
    let gust = uncertainty.gust;
    // The force of a gust grows with the speed.
    let force_n = gust.side_force(configuration.model.range.v_x.max);
    equivalent_angle_rad(vehicle, uncertainty.bank_m_per_s2, 0.0, 0.0).abs()
        + equivalent_angle_rad(vehicle, 0.0, force_n, gust.acting_ahead_m).abs()
}
