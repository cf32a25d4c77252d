//! What loads the axles of a vehicle, and what friction leaves of their forces (method 6).

/// What loads the axles at a sample, beside the static loads and the forces that steering asks for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Loading {
    /// Longitudinal acceleration as measured, m/s^2.
    pub a_x_m_per_s2: f64,
    /// That which the drive torque asks for, m/s^2.
    pub asked_m_per_s2: f64,
    /// Axle loads, front and rear, at the measured acceleration over those at rest.
    pub factors: [f64; 2],
    /// Lateral forces of the axles, front and rear, that bank and gust ask for at their bounds, N.
    pub aside_n: [f64; 2],
}

impl Loading {
    /// Of the measured acceleration what the drive torque asks for, m/s^2: nothing of what a fault does to
    /// the speed is in it.
    pub(crate) fn driven_m_per_s2(&self) -> f64 {
        let Self { a_x_m_per_s2: a_x, asked_m_per_s2: asked, .. } = *self;
        if asked > 0.0 { a_x.min(asked).max(0.0) } else { a_x.max(asked).min(0.0) }
    }
}

/// `1 - tanh(x) / x`, the share of a linear tyre's force that is missing where it asks for x times what
/// friction holds; from above, by a continued fraction: by at most 0.7 % of the force for |x| below 3.
pub(crate) fn deficit(x: f64) -> f64 {
    let square = x * x;
    let fraction = square / (3.0 + square / (5.0 + square / 7.0));
    fraction / (1.0 + fraction)
}

/// `d(x deficit(x)) / dx`, the share that is missing of a linear tyre's slope: the derivative of that fraction.
pub(crate) fn slope_deficit(x: f64) -> f64 {
    let square = x * x;
    let denominator = 105.0 + square * (45.0 + square);
    let numerator = 2.0 * square * (3675.0 + square * (210.0 + 10.0 * square));
    deficit(x) + numerator / (denominator * denominator)
}
