//! What is known before: a specification of which only mass and axle distances have to be there.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use steerguard_designer::document::{self, Allowed, Mistake, Mistakes};
use steerguard_designer::spec::ActuatorTable;
use steerguard_identification::{Chassis, Parameter, Told};

/// The tables of a specification that say something of the vehicle. The others are read once the whole
/// specification is there.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
struct Known {
    vehicle: Vehicle,
    sensors: Sensors,
    actuator: Actuator,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Vehicle {
    mass_kg: Option<f64>,
    yaw_inertia_kg_m2: Option<f64>,
    effective_longitudinal_inertia_kg_m: Option<f64>,
    front_axle_distance_m: Option<f64>,
    rear_axle_distance_m: Option<f64>,
    front_cornering_stiffness_n_per_rad: Option<f64>,
    rear_cornering_stiffness_n_per_rad: Option<f64>,
    longitudinal_drag_n_m_s2_per_m2: Option<f64>,
    lateral_drag_n_s2_per_m2: Option<f64>,
    centre_of_gravity_height_m: Option<f64>,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Sensors {
    steering_ratio: Option<f64>,
    steering_offset_deg: Option<f64>,
    yaw_rate_bias_deg_per_s: Option<f64>,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Actuator {
    lag_s: Option<f64>,
    delay_s: Option<f64>,
    rate_limit_rad_per_s: Option<f64>,
    angle_limit_deg: Option<f64>,
}

/// Reads what is known from the TOML text of a specification.
///
/// # Errors
/// [`Mistakes`]: what is missing, unknown or not possible.
pub fn told(text: &str) -> Result<Told, Mistakes> {
    let known = document::read(text, find_mistakes)?;
    let Known { vehicle, sensors, actuator } = known;
    let values = [
        (Parameter::SteeringRatio, sensors.steering_ratio),
        (Parameter::SteeringOffset, sensors.steering_offset_deg.map(f64::to_radians)),
        (Parameter::YawRateBias, sensors.yaw_rate_bias_deg_per_s.map(f64::to_radians)),
        (Parameter::Delay, actuator.delay_s),
        (Parameter::Lag, actuator.lag_s),
        (Parameter::FrontStiffness, vehicle.front_cornering_stiffness_n_per_rad),
        (Parameter::RearStiffness, vehicle.rear_cornering_stiffness_n_per_rad),
        (Parameter::YawInertia, vehicle.yaw_inertia_kg_m2),
        (Parameter::Height, vehicle.centre_of_gravity_height_m),
    ];
    // Missing ones were found to be mistakes.
    let chassis = Chassis {
        mass_kg: vehicle.mass_kg.unwrap_or_default(),
        front_axle_distance_m: vehicle.front_axle_distance_m.unwrap_or_default(),
        rear_axle_distance_m: vehicle.rear_axle_distance_m.unwrap_or_default(),
    };
    let told = values.into_iter().filter_map(|(parameter, value)| Some((parameter, value?)));
    Ok(Told { chassis, values: told.collect::<BTreeMap<_, _>>() })
}

fn find_mistakes(known: &Known, mistakes: &mut Mistakes) {
    let Known { vehicle, sensors, actuator } = known;
    for (key, value) in [
        ("mass_kg", vehicle.mass_kg),
        ("front_axle_distance_m", vehicle.front_axle_distance_m),
        ("rear_axle_distance_m", vehicle.rear_axle_distance_m),
    ] {
        let key = format!("vehicle.{key}");
        mistakes.unless(value.is_some(), || {
            Mistake::missing(&key)
                .help("drives do not show it: weigh the axles, measure the wheelbase")
        });
    }
    for (key, value, allowed) in [
        ("vehicle.mass_kg", vehicle.mass_kg, Allowed::POSITIVE),
        ("vehicle.front_axle_distance_m", vehicle.front_axle_distance_m, Allowed::POSITIVE),
        ("vehicle.rear_axle_distance_m", vehicle.rear_axle_distance_m, Allowed::POSITIVE),
        ("vehicle.yaw_inertia_kg_m2", vehicle.yaw_inertia_kg_m2, Allowed::POSITIVE),
        (
            "vehicle.front_cornering_stiffness_n_per_rad",
            vehicle.front_cornering_stiffness_n_per_rad,
            Allowed::POSITIVE,
        ),
        (
            "vehicle.rear_cornering_stiffness_n_per_rad",
            vehicle.rear_cornering_stiffness_n_per_rad,
            Allowed::POSITIVE,
        ),
        (
            "vehicle.centre_of_gravity_height_m",
            vehicle.centre_of_gravity_height_m,
            Allowed::between(0.0, 3.0),
        ),
        ("sensors.steering_ratio", sensors.steering_ratio, Allowed::between(0.1, 100.0)),
        ("sensors.steering_offset_deg", sensors.steering_offset_deg, Allowed::between(-10.0, 10.0)),
        (
            "sensors.yaw_rate_bias_deg_per_s",
            sensors.yaw_rate_bias_deg_per_s,
            Allowed::between(-10.0, 10.0),
        ),
        (
            "actuator.delay_s",
            actuator.delay_s,
            Allowed::between(0.0, ActuatorTable::LARGEST_DELAY_S),
        ),
        ("actuator.lag_s", actuator.lag_s, Allowed::between(0.0, ActuatorTable::LARGEST_LAG_S)),
    ] {
        if let Some(value) = value {
            mistakes.number(key, value, allowed);
        }
    }
}
