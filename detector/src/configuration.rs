//! Everything the detector is told: plain numbers, checked once before it runs.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::algebra::all_finite;
use crate::{
    Actuator, Deviations, Estimator, Evaluation, Gains, Interval, MAX_DELAY_SAMPLES, MAX_WINDOW,
    Staleness, TsModel, Zero,
};

/// A detector's numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize), serde(deny_unknown_fields))]
pub struct Configuration {
    /// Vehicle, sampling period and design range S_x.
    pub model: TsModel,
    /// Hysteresis of arming for [v_x, v_y, r] in m/s, m/s, rad/s: the detector disarms outside S_x
    /// and arms inside S_x shrunk by these; not negative.
    pub hysteresis: [f64; 3],
    /// Observer gains.
    pub gains: Gains,
    /// Residual evaluation.
    pub evaluation: Evaluation,
    /// Where the vehicle may depart from the model.
    pub deviations: Deviations,
    /// Between the commanded angle and the road wheel.
    pub actuator: Actuator,
    /// What the sensors show where there is nothing.
    pub zero: Zero,
    /// When measurements are stale.
    pub staleness: Staleness,
    /// The second test; none for the residual alone.
    pub estimator: Option<Estimator>,
}

/// Why a configuration cannot run: the first field that is not finite or out of its range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ConfigurationError {
    /// Name of the field.
    pub field: &'static str,
}

impl core::fmt::Display for ConfigurationError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "detector configuration: `{}` is not finite or out of range", self.field)
    }
}

impl core::error::Error for ConfigurationError {}

impl Configuration {
    /// Checks every number.
    ///
    /// # Errors
    /// [`ConfigurationError`] with the name of the first field out of its documented range.
    pub fn check(&self) -> Result<(), ConfigurationError> {
        let v = &self.model.vehicle;
        let range = &self.model.range;
        let e = &self.evaluation;
        let g = &self.gains;
        let d = &self.deviations.uncertainty;
        let a = &self.actuator;
        let slowest = d.slowest(a);
        let delay = |a: &Actuator| {
            let samples = a.delay_s / self.model.sampling_period_s;
            (0.0..(MAX_DELAY_SAMPLES + 1) as f64).contains(&samples)
        };
        let armed = range.shrunk(self.hysteresis);
        let second = |holds: fn(&Estimator) -> bool| self.estimator.as_ref().is_none_or(holds);
        let proper = |i: Interval| i.min < i.max && i.min.is_finite() && i.max.is_finite();

        for (field, holds) in [
            ("mass", positive(v.mass_kg)),
            ("yaw inertia", positive(v.yaw_inertia_kg_m2)),
            ("effective longitudinal inertia", positive(v.effective_longitudinal_inertia_kg_m)),
            ("front axle distance", positive(v.front_axle_distance_m)),
            ("rear axle distance", positive(v.rear_axle_distance_m)),
            ("front cornering stiffness", positive(v.front_cornering_stiffness_n_per_rad)),
            ("rear cornering stiffness", positive(v.rear_cornering_stiffness_n_per_rad)),
            ("centre-of-gravity height", not_negative(v.centre_of_gravity_height_m)),
            ("longitudinal drag", not_negative(v.longitudinal_drag_n_m_s2_per_m2)),
            ("lateral drag", not_negative(v.lateral_drag_n_s2_per_m2)),
            ("sampling period", measurable(self.model.sampling_period_s)),
            ("v_x range", proper(range.v_x) && range.v_x.min > 0.0),
            ("v_y range", proper(range.v_y) && range.v_y.contains(0.0)),
            ("r range", proper(range.r)),
            ("hysteresis", self.hysteresis.iter().all(|&x| not_negative(x))),
            ("v_x hysteresis", proper(armed.v_x)),
            ("v_y hysteresis", proper(armed.v_y) && armed.v_y.contains(0.0)),
            ("r hysteresis", proper(armed.r)),
            ("N", all_finite(g.n.as_flattened().as_flattened())),
            ("L", all_finite(g.l.as_flattened().as_flattened())),
            ("M", all_finite(g.m.as_flattened())),
            ("E", all_finite(g.e.as_flattened())),
            ("window", (1..=MAX_WINDOW).contains(&e.window)),
            ("weights", e.weights.iter().all(|&x| not_negative(x))),
            ("threshold", measurable(e.threshold)),
            ("uncertainty share", not_negative(e.uncertainty_share)),
            ("start-up amplitude", not_negative(e.start_up_amplitude)),
            ("start-up decay", not_negative(e.start_up_decay) && e.start_up_decay < 1.0),
            ("debounce", e.debounce_samples >= 1),
            ("alarm hold", not_negative(e.alarm_hold_s)),
            ("uncertainty of the mass", not_negative(d.mass)),
            ("uncertainty of the yaw inertia", not_negative(d.yaw_inertia)),
            ("uncertainty of the front stiffness", not_negative(d.front_cornering_stiffness)),
            ("uncertainty of the rear stiffness", not_negative(d.rear_cornering_stiffness)),
            ("friction", d.friction.is_none_or(positive)),
            ("uncertainty of the load transfer", not_negative(d.load_transfer)),
            ("bank", not_negative(d.bank_m_per_s2)),
            ("gust speed", not_negative(d.gust.speed_m_per_s)),
            ("gust coefficient", not_negative(d.gust.coefficient_n_s2_per_m2)),
            ("gust lever", d.gust.acting_ahead_m.is_finite()),
            ("smallest fault", all_finite(&self.deviations.smallest_fault)),
            ("actuator lag", not_negative(a.lag_s)),
            ("actuator delay", delay(a)),
            ("actuator rate limit", a.rate_limit_rad_per_s.is_none_or(positive)),
            ("uncertainty of the actuator's lag", not_negative(d.actuator_lag_s)),
            ("uncertainty of the actuator's delay", not_negative(d.actuator_delay_s)),
            ("slowest actuator's delay", delay(&slowest)),
            ("actuator angle limit", a.angle_limit_rad.is_none_or(positive)),
            ("uncertainty of the steering ratio", not_negative(d.steering_ratio)),
            ("uncertainty of the steering offset", not_negative(d.steering_offset_rad)),
            ("uncertainty of the yaw-rate bias", not_negative(d.yaw_rate_bias_rad_per_s)),
            ("uncertainty of the speed's scale", not_negative(d.v_x_scale)),
            ("steering offset", self.zero.steering_offset_rad.is_finite()),
            ("yaw-rate bias", self.zero.yaw_rate_bias_rad_per_s.is_finite()),
            ("time until data are stale", not_negative(self.staleness.after_s)),
            ("jump of the speed", not_negative(self.staleness.v_x_jump_m_per_s)),
            ("jump of the yaw rate", not_negative(self.staleness.r_jump_rad_per_s)),
            ("estimator's threshold", second(|x| positive(x.threshold))),
            ("estimator's factor", second(|x| positive(x.estimate_factor))),
            ("estimator's noise", second(|x| x.noise.iter().all(|&x| positive(x)))),
        ] {
            if !holds {
                return Err(ConfigurationError { field });
            }
        }
        Ok(())
    }
}

// Not inlined: asked often and seldom run, copies of them would be a tenth of the FMU's code.

/// Whether `x` is positive and finite.
#[inline(never)]
pub(crate) fn positive(x: f64) -> bool {
    x > 0.0 && x.is_finite()
}

/// The least threshold, sampling period and factor on a threshold; the largest is its reciprocal.
pub const LEAST: f64 = 1e-100;

/// Whether `x` is positive, and so far from what an f64 holds that products with times and factors are
/// finite and positive too.
#[inline(never)]
pub(crate) fn measurable(x: f64) -> bool {
    (LEAST..=1.0 / LEAST).contains(&x)
}

/// Whether `x` is finite and not negative.
#[inline(never)]
pub(crate) fn not_negative(x: f64) -> bool {
    x >= 0.0 && x.is_finite()
}
