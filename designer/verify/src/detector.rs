//! What is baked: that the section `detector` says what specification, constants, model and gains say.

use std::f64::consts::PI;

use crate::agreement::{ROUNDING, near, same, within};
use crate::read::{Design, Detector, Fault, Uncertainty, UncertaintyOfSpec};
use crate::refusal::Refusal;

/// Standard acceleration of gravity, m/s^2.
const GRAVITY_M_PER_S2: f64 = 9.80665;
/// Density of air that designs of this format are made with, kg/m^3.
const AIR_DENSITY_KG_PER_M3: f64 = 1.2;

/// Checks every number of `detector` but the threshold and its share.
///
/// # Errors
/// [`Refusal::Disagreement`]: the first that another place of the file contradicts.
pub fn check(design: &Design) -> Result<(), Refusal> {
    let Design { spec, constants, .. } = design;
    same("constants.gravity_m_per_s2", &constants.gravity_m_per_s2, &GRAVITY_M_PER_S2)?;
    let air = constants.air_density_kg_per_m3;
    same("constants.air_density_kg_per_m3", &air, &AIR_DENSITY_KG_PER_M3)?;

    let Detector { model, hysteresis, gains, evaluation: e, deviations, actuator } =
        &design.detector;
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

    same("detector.evaluation.window", &e.window, &spec.evaluation.window_samples)?;
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
    same("detector.actuator", actuator, &spec.actuator)
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
    same(&of("actuator_delay_s"), actuator_delay_s, &specified.actuator_delay_s)
}
