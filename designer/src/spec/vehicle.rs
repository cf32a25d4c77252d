//! `[vehicle]`: vehicle data.

use serde::{Deserialize, Serialize};
use steerguard_detector::Vehicle;

use crate::document::{Allowed, Mistakes};

/// The keys of `[vehicle]`: documented at [`Vehicle`].
#[derive(Serialize, Deserialize)]
#[serde(remote = "Vehicle", default = "default_vehicle", deny_unknown_fields)]
#[allow(missing_docs)]
pub(super) struct VehicleTable {
    mass_kg: f64,
    yaw_inertia_kg_m2: f64,
    effective_longitudinal_inertia_kg_m: f64,
    front_axle_distance_m: f64,
    rear_axle_distance_m: f64,
    front_cornering_stiffness_n_per_rad: f64,
    rear_cornering_stiffness_n_per_rad: f64,
    longitudinal_drag_n_m_s2_per_m2: f64,
    lateral_drag_n_s2_per_m2: f64,
    centre_of_gravity_height_m: f64,
}

/// The vehicle of Table 1, with the height of a passenger car's centre of gravity.
pub(super) fn default_vehicle() -> Vehicle {
    Vehicle { centre_of_gravity_height_m: 0.55, ..Vehicle::PAPER }
}

/// Finds what is not possible by itself.
pub(super) fn check(vehicle: &Vehicle, mistakes: &mut Mistakes) {
    for (key, value) in [
        ("mass_kg", vehicle.mass_kg),
        ("yaw_inertia_kg_m2", vehicle.yaw_inertia_kg_m2),
        ("effective_longitudinal_inertia_kg_m", vehicle.effective_longitudinal_inertia_kg_m),
        ("front_axle_distance_m", vehicle.front_axle_distance_m),
        ("rear_axle_distance_m", vehicle.rear_axle_distance_m),
        ("front_cornering_stiffness_n_per_rad", vehicle.front_cornering_stiffness_n_per_rad),
        ("rear_cornering_stiffness_n_per_rad", vehicle.rear_cornering_stiffness_n_per_rad),
    ] {
        mistakes.number(&format!("vehicle.{key}"), value, Allowed::POSITIVE);
    }
    for (key, value) in [
        ("longitudinal_drag_n_m_s2_per_m2", vehicle.longitudinal_drag_n_m_s2_per_m2),
        ("lateral_drag_n_s2_per_m2", vehicle.lateral_drag_n_s2_per_m2),
    ] {
        mistakes.number(&format!("vehicle.{key}"), value, Allowed::NOT_NEGATIVE);
    }
    let height_m = Allowed::between(0.0, 3.0);
    let key = "vehicle.centre_of_gravity_height_m";
    mistakes.number(key, vehicle.centre_of_gravity_height_m, height_m);
}
