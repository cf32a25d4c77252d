//! The car of the paper as the subject of a campaign.

use steerguard::campaign::settings::Subject;
use steerguard_detector::{Actuator, Gust, Interval, Vehicle, Zero};

pub const SUBJECT: Subject = Subject {
    vehicle: Vehicle::PAPER,
    actuator: Actuator::NONE,
    zero: Zero { steering_offset_rad: 0.0, yaw_rate_bias_rad_per_s: 0.0 },
    period_s: 0.01,
    armed_v_x: Interval::new(5.5, 29.5),
    lateral_acceleration_m_per_s2: 3.0,
    steering_rate_rad_per_s: 0.3,
    smallest_fault_deg: 0.5,
    gust: Gust { speed_m_per_s: 10.0, coefficient_n_s2_per_m2: 2.64, acting_ahead_m: 0.25 },
};
