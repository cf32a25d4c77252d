//! What the road does to a vehicle on it.

use steerguard_detector::GRAVITY_M_PER_S2;

/// Acceleration to the left on a road banked by `bank_rad`, left side raised, m/s^2.
pub fn bank_m_per_s2(bank_rad: f64) -> f64 {
    -GRAVITY_M_PER_S2 * libm::sin(bank_rad)
}
