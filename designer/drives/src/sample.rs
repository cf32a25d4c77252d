//! Samples of a drive on a grid.

/// One sample of a drive in SI, ISO 8855 axes (left positive).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Time of the file, s.
    pub time_s: f64,
    /// Longitudinal speed, m/s.
    pub speed_m_per_s: f64,
    /// Yaw rate, rad/s.
    pub yaw_rate_rad_per_s: f64,
    /// As the steering sensor shows it, in rad: at the hand wheel or the road wheel. Ratio and offset are
    /// not applied here; a table to the road wheel is.
    pub steering_rad: f64,
    /// Lateral acceleration, m/s^2, where the file has it at this time.
    pub lateral_acceleration_m_per_s2: Option<f64>,
    /// Drive torque at the wheels, N m, where the file has it at this time.
    pub drive_torque_n_m: Option<f64>,
}

/// Samples on a grid of one period, without a gap.
#[derive(Clone, Debug, PartialEq)]
pub struct Piece {
    /// Time of the first sample, s.
    pub start_s: f64,
    /// Time from a sample to the next, s.
    pub period_s: f64,
    /// The samples, at least one.
    pub samples: Vec<Sample>,
}
