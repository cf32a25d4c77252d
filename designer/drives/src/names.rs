//! What the names of columns say: units in them, and signals by their usual names.

use crate::signal::Signal;
use crate::unit::Unit;

/// The name of a column, taken apart.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Named {
    /// Its words without the unit, in small letters, joined by `_`.
    pub base: String,
    /// The unit in it.
    pub unit: Option<Unit>,
}

/// Takes a name apart: `v [km/h]`, `r (deg/s)`, `speed_km_h`, `yawRateDeg`. `signal` is what a unit without
/// brackets has to fit: `t_ms` is a time in ms, `v_m_s` no time in s.
pub(crate) fn taken_apart(name: &str, signal: Signal) -> Named {
    if let Some((before, inside)) = bracketed(name) {
        return Named { base: words(before).join("_"), unit: Unit::parse(inside) };
    }
    let words = words(name);
    for length in (1..words.len().min(4)).rev() {
        let (base, unit) = words.split_at(words.len() - length);
        let unit = Unit::parse(&unit.join("_"));
        if let Some(unit) = unit.filter(|unit| unit.quantity == signal.quantity()) {
            return Named { base: base.join("_"), unit: Some(unit) };
        }
    }
    Named { base: words.join("_"), unit: None }
}

/// Text before brackets at the end, and in them.
fn bracketed(name: &str) -> Option<(&str, &str)> {
    let name = name.trim();
    let open = match name.chars().last()? {
        ']' => '[',
        ')' => '(',
        _ => return None,
    };
    let at = name.rfind(open)?;
    Some((&name[..at], &name[at + 1..name.len() - 1]))
}

/// Words of a name in small letters; a capital after a small letter begins one.
fn words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut after_small = false;
    for c in name.chars() {
        if !c.is_alphanumeric() || c.is_uppercase() && after_small {
            words.push(String::new());
        }
        if let Some(word) = words.last_mut()
            && c.is_alphanumeric()
        {
            word.extend(c.to_lowercase());
        }
        after_small = c.is_lowercase();
    }
    words.retain(|word| !word.is_empty());
    words
}

/// The signal's name among the variables of the detector's FMU, which are in SI: results of this project
/// have them as columns.
pub(crate) fn in_fmu(signal: Signal) -> Option<&'static str> {
    match signal {
        Signal::Speed => Some("v_x"),
        Signal::YawRate => Some("r"),
        Signal::Steering => Some("u.delta"),
        Signal::DriveTorque => Some("u.T_eng"),
        Signal::Time | Signal::LateralAcceleration => None,
    }
}

/// Whether columns of this name are usually the signal.
pub(crate) fn is_usual(base: &str, signal: Signal) -> bool {
    let names: &[&str] = match signal {
        Signal::Time => &[
            "time",
            "t",
            "timestamp",
            "time_stamp",
            "timestamps",
            "elapsed",
            "zeit",
            "datetime",
            "date_time",
        ],
        Signal::Speed => &[
            "speed",
            "v",
            "vx",
            "v_x",
            "velocity",
            "vehicle_speed",
            "car_speed",
            "vel",
            "vel_x",
            "velocity_x",
            "speed_x",
            "longitudinal_speed",
            "longitudinal_velocity",
            "v_veh",
        ],
        Signal::YawRate => &[
            "yaw_rate",
            "yawrate",
            "r",
            "yaw_velocity",
            "psi_dot",
            "psid",
            "psip",
            "gyro_z",
            "gyr_z",
            "omega_z",
            "w_z",
            "wz",
            "angular_velocity_z",
        ],
        Signal::Steering => &[
            "steering",
            "steering_angle",
            "steering_wheel",
            "steering_wheel_angle",
            "steer",
            "steer_angle",
            "hand_wheel",
            "handwheel",
            "hand_wheel_angle",
            "handwheel_angle",
            "hw",
            "swa",
            "delta",
            "u_delta",
            "road_wheel_angle",
            "road_wheel",
            "steerangle",
        ],
        Signal::LateralAcceleration => &[
            "lateral_acceleration",
            "lateral_acc",
            "lateral_accel",
            "lat_acc",
            "lat_accel",
            "ay",
            "a_y",
            "acc_y",
            "accel_y",
            "acceleration_y",
        ],
        Signal::DriveTorque => {
            &["drive_torque", "wheel_torque", "t_eng", "u_t_eng", "drivetorque", "torque"]
        }
    };
    names.contains(&base)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_found_in_names() {
        for (name, signal, base, unit) in [
            ("v [km/h]", Signal::Speed, "v", Some("km/h")),
            ("r (deg/s)", Signal::YawRate, "r", Some("deg/s")),
            ("speed_km_h", Signal::Speed, "speed", Some("km/h")),
            ("v_m_per_s", Signal::Speed, "v", Some("m/s")),
            ("yawRateDegS", Signal::YawRate, "yaw_rate", Some("deg/s")),
            ("steering_wheel_deg", Signal::Steering, "steering_wheel", Some("deg")),
            ("time_ms", Signal::Time, "time", Some("ms")),
            ("v_m_s", Signal::Time, "v_m", Some("s")),
            ("s", Signal::Time, "s", None),
            ("u.delta", Signal::Steering, "u_delta", None),
            ("speed", Signal::Speed, "speed", None),
            ("speed [rpm]", Signal::Speed, "speed", None),
        ] {
            let named = taken_apart(name, signal);
            assert_eq!(named.base, base, "{name}");
            assert_eq!(named.unit.map(|unit| unit.symbol), unit, "{name}");
        }
    }
}
