//! What is baked: that the section `detector` says what specification, constants, model and gains say.

use std::f64::consts::PI;

use crate::agreement::{ROUNDING, near, same, within};
use crate::read::{
    Actuator, ActuatorOfSpec, Design, Detector, Estimator, Fault, Spec, Staleness, Uncertainty,
    UncertaintyOfSpec,
};
use crate::refusal::Refusal;

/// Standard acceleration of gravity, m/s^2.
const GRAVITY_M_PER_S2: f64 = 9.80665;
/// Density of air that designs of this format are made with, kg/m^3.
const AIR_DENSITY_KG_PER_M3: f64 = 1.2;
/// Window of the RMS where none is stated, s, and the most samples that it holds.
const WINDOW_S: f64 = 0.4;
const LARGEST_WINDOW: f64 = 256.0;
/// Friction from which on tyres are taken to have no end.
const LARGEST_FRICTION: f64 = 10.0;
/// Sensors with noise that show the same for longer than this are stale, s.
const STALE_AFTER_S: f64 = 0.2;
/// No vehicle accelerates faster, m/s^2 and rad/s^2, and no difference of readings is more standard
/// deviations.
const LARGEST_ACCELERATIONS: [f64; 2] = [20.0, 20.0];
const NOISE_OF_A_STEP: f64 = 8.5;
/// The second test assumes at least this noise, m/s and rad/s.
const LEAST_NOISE: [f64; 2] = [0.002, 0.0002];

/// Checks every number of `detector` but the threshold and its share.
///
/// # Errors
/// [`Refusal::Disagreement`]: the first that another place of the file contradicts.
pub fn check(design: &Design) -> Result<(), Refusal> {
    let Design { spec, constants, .. } = design;
    same("constants.gravity_m_per_s2", &constants.gravity_m_per_s2, &GRAVITY_M_PER_S2)?;
    let air = constants.air_density_kg_per_m3;
    same("constants.air_density_kg_per_m3", &air, &AIR_DENSITY_KG_PER_M3)?;

    let Detector {
        model,
        hysteresis,
        gains,
        evaluation: e,
        deviations,
        actuator,
        zero,
        staleness,
        estimator,
    } = &design.detector;
    same("detector.model.vehicle", &model.vehicle, &spec.vehicle)?;
    same("detector.model.sampling_period_s", &model.sampling_period_s, &spec.sampling.period_s)?;
    let range = &spec.operating_range;
    for (key, interval, specified) in [
        ("v_x", model.range.v_x, range.v_x_m_per_s),
        ("v_y", model.range.v_y, range.v_y_m_per_s),
        ("r", model.range.r, range.r_rad_per_s),
    ] {
        same(&format!("detector.model.range.{key}"), &interval.ends(), &specified)?;
    }
    let specified =
        [range.v_x_hysteresis_m_per_s, range.v_y_hysteresis_m_per_s, range.r_hysteresis_rad_per_s];
    same("detector.hysteresis", hysteresis, &specified)?;

    for (i, rule) in design.vertices.iter().enumerate() {
        same(&format!("detector.gains.n[{i}]"), &gains.n[i], &rule.n)?;
        same(&format!("detector.gains.l[{i}]"), &gains.l[i], &rule.l)?;
    }

    let in_samples = |window_s: f64| (window_s / spec.sampling.period_s).round();
    let window = spec.evaluation.window_samples.unwrap_or_else(|| {
        in_samples(spec.evaluation.window_s.unwrap_or(WINDOW_S)).clamp(1.0, LARGEST_WINDOW)
    });
    same("detector.evaluation.window", &e.window, &window)?;
    let hold_s = spec.evaluation.alarm_hold_s;
    same("detector.evaluation.alarm_hold_s", &e.alarm_hold_s, &hold_s)?;
    same("detector.evaluation.weights", &e.weights, &spec.evaluation.weights)?;
    let debounce = spec.evaluation.debounce_samples;
    same("detector.evaluation.debounce_samples", &e.debounce_samples, &debounce)?;

    let euler_correction = spec.sampling.euler_correction;
    let key = "detector.deviations.euler_correction";
    same(key, &deviations.euler_correction, &euler_correction)?;
    uncertainty(&deviations.uncertainty, &spec.uncertainty, air)?;
    let (size, column) = match spec.fault[0] {
        Fault::Steering { smallest_deg, .. } => (smallest_deg * PI / 180.0, 1),
        Fault::Torque { smallest_n_m, .. } => (smallest_n_m, 0),
    };
    for (row, stored) in deviations.smallest_fault.into_iter().enumerate() {
        let key = format!("detector.deviations.smallest_fault[{row}]");
        near(&key, stored, design.b[row][column] * size)?;
    }
    actuator_is(actuator, &spec.actuator)?;
    let rad = |deg: f64| deg * PI / 180.0;
    let of = |key: &str| format!("detector.zero.{key}");
    let offset = rad(spec.sensors.steering_offset_deg);
    near(&of("steering_offset_rad"), zero.steering_offset_rad, offset)?;
    let bias = rad(spec.sensors.yaw_rate_bias_deg_per_s);
    near(&of("yaw_rate_bias_rad_per_s"), zero.yaw_rate_bias_rad_per_s, bias)?;
    staleness_is(staleness, spec)?;
    if let Some(Estimator { noise, .. }) = estimator {
        let stds = [spec.noise.v_x.white_std_m_per_s, spec.noise.r.white_std_rad_per_s];
        let assumed = [0, 1].map(|k: usize| stds[k].max(LEAST_NOISE[k]));
        same("detector.estimator.noise", noise, &assumed)?;
    }
    Ok(())
}

fn actuator_is(stored: &Actuator, specified: &ActuatorOfSpec) -> Result<(), Refusal> {
    let of = |key: &str| format!("detector.actuator.{key}");
    same(&of("lag_s"), &stored.lag_s, &specified.lag_s)?;
    same(&of("delay_s"), &stored.delay_s, &specified.delay_s)?;
    let rate = "rate_limit_rad_per_s";
    same(&of(rate), &stored.rate_limit_rad_per_s, &specified.rate_limit_rad_per_s)?;
    let key = of("angle_limit_rad");
    match (stored.angle_limit_rad, specified.angle_limit_deg) {
        (Some(stored), Some(deg)) => near(&key, stored, deg * PI / 180.0),
        (stored, specified) => same(&key, &stored.is_some(), &specified.is_some()),
    }
}

/// Times and jumps follow from period and noise.
fn staleness_is(stored: &Staleness, spec: &Spec) -> Result<(), Refusal> {
    let period_s = spec.sampling.period_s;
    let stds = [spec.noise.v_x.white_std_m_per_s, spec.noise.r.white_std_rad_per_s];
    let noisy = stds.iter().any(|std| *std > 0.0);
    let after_s = if noisy { STALE_AFTER_S.max(2.0 * period_s) } else { 0.0 };
    same("detector.staleness.after_s", &stored.after_s, &after_s)?;
    let [v_x, r] =
        [0, 1].map(|k: usize| LARGEST_ACCELERATIONS[k] * period_s + NOISE_OF_A_STEP * stds[k]);
    near("detector.staleness.v_x_jump_m_per_s", stored.v_x_jump_m_per_s, v_x)?;
    near("detector.staleness.r_jump_rad_per_s", stored.r_jump_rad_per_s, r)
}

/// The bounds of what is uncertain are those of the specification.
fn uncertainty(
    stored: &Uncertainty,
    specified: &UncertaintyOfSpec,
    air_density_kg_per_m3: f64,
) -> Result<(), Refusal> {
    let Uncertainty {
        mass,
        yaw_inertia,
        front_cornering_stiffness,
        rear_cornering_stiffness,
        bank_m_per_s2,
        gust,
        actuator_lag_s,
        actuator_delay_s,
        friction,
        load_transfer,
        steering_ratio,
        steering_offset_rad,
        yaw_rate_bias_rad_per_s,
        v_x_scale,
    } = stored;
    let of = |key: &str| format!("detector.deviations.uncertainty.{key}");
    let largest = |percent: [f64; 2], deviation: fn(f64) -> f64| {
        let [low, high] = percent.map(|percent| deviation(percent).abs());
        low.max(high)
    };
    // M / M' - 1 of a true mass M', C' / C - 1 of a true stiffness C'.
    let of_inertia = |percent: f64| percent / (100.0 + percent);
    let of_stiffness = |percent: f64| percent / 100.0;
    for (key, stored, percent, deviation) in [
        ("mass", mass, specified.mass_percent, of_inertia as fn(f64) -> f64),
        ("yaw_inertia", yaw_inertia, specified.yaw_inertia_percent, of_inertia),
        ("steering_ratio", steering_ratio, specified.steering_ratio_percent, of_inertia),
        (
            "front_cornering_stiffness",
            front_cornering_stiffness,
            specified.front_cornering_stiffness_percent,
            of_stiffness,
        ),
        (
            "rear_cornering_stiffness",
            rear_cornering_stiffness,
            specified.rear_cornering_stiffness_percent,
            of_stiffness,
        ),
    ] {
        // Differences of numbers near one.
        within(&of(key), *stored, largest(percent, deviation), ROUNDING)?;
    }
    let bank = GRAVITY_M_PER_S2 * (specified.bank_deg * PI / 180.0).sin();
    near(&of("bank_m_per_s2"), *bank_m_per_s2, bank)?;
    same(&of("gust.speed_m_per_s"), &gust.speed_m_per_s, &specified.gust_m_per_s)?;
    let coefficient =
        air_density_kg_per_m3 / 2.0 * specified.frontal_area_m2 * specified.side_force_per_rad;
    near(&of("gust.coefficient_n_s2_per_m2"), gust.coefficient_n_s2_per_m2, coefficient)?;
    same(&of("gust.acting_ahead_m"), &gust.acting_ahead_m, &specified.gust_acting_ahead_m)?;
    same(&of("actuator_lag_s"), actuator_lag_s, &specified.actuator_lag_s)?;
    same(&of("actuator_delay_s"), actuator_delay_s, &specified.actuator_delay_s)?;
    let [smallest, _] = specified.friction;
    let ends = (smallest < LARGEST_FRICTION).then_some(smallest);
    same(&of("friction"), friction, &ends)?;
    let rad = |deg: f64| deg * PI / 180.0;
    for (key, stored, expected) in [
        ("load_transfer", load_transfer, specified.load_transfer_percent / 100.0),
        ("steering_offset_rad", steering_offset_rad, rad(specified.steering_offset_deg)),
        (
            "yaw_rate_bias_rad_per_s",
            yaw_rate_bias_rad_per_s,
            rad(specified.yaw_rate_bias_deg_per_s),
        ),
        ("v_x_scale", v_x_scale, specified.v_x_scale_percent / 100.0),
    ] {
        near(&of(key), *stored, expected)?;
    }
    Ok(())
}
