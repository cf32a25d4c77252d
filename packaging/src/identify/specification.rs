//! The specification that `identify` writes: what was told as it stood, what the drives show with how it
//! came about, and its interval in `[uncertainty]`.
//!
//! # Conventions
//! Intervals are two standard errors and the misfit, rounded away from zero. Delays add only
//! (`uncertainty.actuator_delay_s` is what comes on top), so the shortest stands in `[actuator]`.

use steerguard_identification::{Estimate, Identified, Lateral, Origin, Parameter, Scale, Told};
use toml_edit::{DocumentMut, Item, TableLike, TomlError, table, value};

/// Cornering stiffnesses are not known better than this, percent: tyres differ by as much from day to day.
const TYRES_PERCENT: f64 = 5.0;
/// Effective longitudinal inertia over mass where it is not told, m: a wheel's radius.
const WHEEL_RADIUS_M: f64 = 0.3;

/// The text of the specification: the `known` one, completed.
///
/// # Errors
/// [`TomlError`] where `known` is no TOML.
pub fn text(
    known: &str,
    told: &Told,
    identified: &Identified,
    drives: &[String],
) -> Result<String, TomlError> {
    let mut document: DocumentMut = known.parse()?;
    for name in ["vehicle", "sensors", "actuator", "uncertainty"] {
        entry(&mut document, name); // In this order, where they are new.
    }
    let guess = format!(
        "{WHEEL_RADIUS_M} m of wheel radius times the mass: a guess, which only a torque uses"
    );
    put_if_absent(
        &mut document,
        "vehicle",
        "effective_longitudinal_inertia_kg_m",
        rounded(WHEEL_RADIUS_M * told.chassis.mass_kg, 4),
        &guess,
    );
    for estimate in &identified.estimates {
        put_estimate(&mut document, identified, estimate);
    }
    let [slowest, fastest] = identified.speeds_m_per_s;
    let head = format!(
        "# From {}: {:.0} s of {:.0} s compared, {slowest:.1} to {fastest:.1} m/s.\n\
         # A value's comment says how it came about; [uncertainty] holds two standard errors and the misfit.\n\
         # Mass and tyres of other days are not in the drives: widen their intervals for them.\n\n",
        drives.join(", "),
        identified.compared_s,
        identified.driven_s,
    );
    Ok(head + &document.to_string())
}

/// Writes an estimate, unless it was told, and its interval.
fn put_estimate(document: &mut DocumentMut, identified: &Identified, estimate: &Estimate) {
    let Some((table, key)) = place(estimate.parameter) else { return };
    let no_lag = estimate.parameter == Parameter::Lag && estimate.origin == Origin::Assumed;
    if estimate.origin == Origin::Told || no_lag {
        return;
    }
    let about = about(identified, estimate);
    let interval = estimate.interval();
    let percent = round_up(100.0 * interval, 0.1);
    let both = |percent: f64| [-percent, percent];
    match estimate.parameter {
        Parameter::Delay | Parameter::Lag => {
            let least_s = (1e3 * (estimate.value - interval)).floor().max(0.0) / 1e3;
            let most_s = (1e3 * (estimate.value + interval)).ceil() / 1e3;
            let name = estimate.parameter.name();
            put(
                document,
                table,
                key,
                least_s,
                &format!("{about}; the shortest {name} of the interval"),
            );
            let key = if estimate.parameter == Parameter::Lag {
                "actuator_lag_s"
            } else {
                "actuator_delay_s"
            };
            put(
                document,
                "uncertainty",
                key,
                rounded((most_s - least_s).max(0.0), 3),
                "what may come on top",
            );
        }
        Parameter::SteeringRatio => {
            put(document, table, key, rounded(estimate.value, 5), &about);
            put_pair(document, "steering_ratio_percent", both(percent));
        }
        Parameter::SteeringOffset | Parameter::YawRateBias => {
            let step = 0.001;
            let degrees = (estimate.value.to_degrees() / step).round() * step;
            put(document, table, key, rounded(degrees, 4), &about);
            put(document, "uncertainty", key, round_up(interval.to_degrees(), step), "either way");
        }
        Parameter::FrontStiffness | Parameter::RearStiffness => {
            put(document, table, key, rounded(estimate.value, 4), &about);
            let key = key.replace("_n_per_rad", "_percent");
            put_pair(document, &key, both(percent.max(TYRES_PERCENT)));
        }
        Parameter::YawInertia => {
            put(document, table, key, rounded(estimate.value, 4), &about);
            put_pair(document, "yaw_inertia_percent", both(percent));
        }
        Parameter::Height => put(document, table, key, rounded(estimate.value, 3), &about),
        Parameter::LateralBias | Parameter::LateralScale | Parameter::LateralDelay => {}
    }
}

/// Table and key of a parameter that a specification has.
fn place(parameter: Parameter) -> Option<(&'static str, &'static str)> {
    Some(match parameter {
        Parameter::SteeringRatio => ("sensors", "steering_ratio"),
        Parameter::SteeringOffset => ("sensors", "steering_offset_deg"),
        Parameter::YawRateBias => ("sensors", "yaw_rate_bias_deg_per_s"),
        Parameter::Delay => ("actuator", "delay_s"),
        Parameter::Lag => ("actuator", "lag_s"),
        Parameter::FrontStiffness => ("vehicle", "front_cornering_stiffness_n_per_rad"),
        Parameter::RearStiffness => ("vehicle", "rear_cornering_stiffness_n_per_rad"),
        Parameter::YawInertia => ("vehicle", "yaw_inertia_kg_m2"),
        Parameter::Height => ("vehicle", "centre_of_gravity_height_m"),
        Parameter::LateralBias | Parameter::LateralScale | Parameter::LateralDelay => return None,
    })
}

/// `vehicle.yaw_inertia_kg_m2`, and the like; none for what a specification does not have.
pub fn key(parameter: Parameter) -> Option<String> {
    place(parameter).map(|(table, key)| format!("{table}.{key}"))
}

/// How a value came about.
fn about(identified: &Identified, estimate: &Estimate) -> String {
    let error = in_words(estimate.parameter.scale(), estimate.standard_error);
    match (estimate.origin, estimate.parameter) {
        (Origin::Identified, _) => format!("fitted, standard error {error}"),
        (Origin::Pair, _) => format!(
            "fitted as a pair of offset and bias, which these drives do not part: standard error {error}"
        ),
        (Origin::Told, _) => "told".to_owned(),
        (Origin::Assumed, Parameter::YawInertia) => match identified.lateral_acceleration {
            Lateral::Unexplained { .. } => {
                "M l_f l_r, a guess: lateral acceleration shows the body's roll".to_owned()
            }
            _ => "M l_f l_r, a guess: lateral acceleration, not logged, would show it".to_owned(),
        },
        (Origin::Assumed, Parameter::Height) => {
            "of a passenger car: the drives do not show it".to_owned()
        }
        (Origin::Assumed, _) => "assumed".to_owned(),
    }
}

/// A standard error or an interval for people.
pub fn in_words(scale: Scale, error: f64) -> String {
    match scale {
        Scale::Relative | Scale::Share if error > 10.0 => "beyond 1000 %".to_owned(),
        Scale::Relative | Scale::Share => format!("{:.1} %", 100.0 * error),
        Scale::Degrees => format!("{:.3} deg", error.to_degrees()),
        Scale::DegreesPerSecond => format!("{:.3} deg/s", error.to_degrees()),
        Scale::Seconds => format!("{:.1} ms", 1e3 * error),
        Scale::Metres => format!("{error:.2} m"),
        Scale::MetresPerSecondSquared => format!("{error:.3} m/s^2"),
    }
}

/// `value` to so many significant `digits`.
fn rounded(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits - 1).parse().unwrap_or(value)
}

/// The next multiple of `step`.
fn round_up(value: f64, step: f64) -> f64 {
    rounded((value / step - 1e-9).ceil() * step, 6)
}

fn entry<'a>(document: &'a mut DocumentMut, name: &str) -> Option<&'a mut dyn TableLike> {
    document.entry(name).or_insert_with(table).as_table_like_mut()
}

fn put(document: &mut DocumentMut, table: &str, key: &str, number: f64, comment: &str) {
    set(document, table, key, value(number), comment);
}

fn put_if_absent(document: &mut DocumentMut, table: &str, key: &str, number: f64, comment: &str) {
    if entry(document, table).is_some_and(|table| !table.contains_key(key)) {
        put(document, table, key, number, comment);
    }
}

fn put_pair(document: &mut DocumentMut, key: &str, pair: [f64; 2]) {
    let pair: toml_edit::Array = pair.into_iter().collect();
    set(document, "uncertainty", key, value(pair), "");
}

fn set(document: &mut DocumentMut, table: &str, key: &str, mut item: Item, comment: &str) {
    if let (Some(value), false) = (item.as_value_mut(), comment.is_empty()) {
        value.decor_mut().set_suffix(format!(" # {comment}"));
    }
    if let Some(table) = entry(document, table) {
        table.insert(key, item);
    }
}
