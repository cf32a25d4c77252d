//! The worst drives that a search finds, as scenarios that `simulate` replays.
//!
//! # Conventions
//! A scenario gives the plant's FMU all that the drive's vehicle, steering and sensors differ in from the
//! design's, and the courses value by value: the replay is the drive, to the last bit.

use std::collections::BTreeMap;

use steerguard_designer::Spec;
use steerguard_designer::worst::drive::{Drive, Worst};
use steerguard_designer::worst::{FamilyWorst, Objective};
use steerguard_world::Tyres;

use crate::drive::scenario::{PlantParameter, Scenario, SensorNoise, Signal};

/// The scenario of `drive`, with the noise and the gusts of `spec`.
pub fn scenario(drive: &Drive, spec: &Spec) -> Scenario {
    let courses = &drive.courses;
    let signal = |values: &[f64]| Signal::of_values(values.to_vec(), courses.period_s);
    let [v_x_std_m_per_s, r_std_rad_per_s] = spec.noise.white_std();
    let gust = spec.uncertainty.gust();
    Scenario {
        duration_s: courses.steering_rad.len() as f64 * courses.period_s,
        initial_speeds_m_per_s: vec![drive.start.v_x_m_per_s],
        initial_lateral_speed_m_per_s: drive.start.v_y_m_per_s,
        initial_yaw_rate_rad_per_s: drive.start.r_rad_per_s,
        side_wind_lever_arm_m: gust.acting_ahead_m,
        wind_coefficient_n_s2_per_m2: gust.coefficient_n_s2_per_m2,
        steering_angle_rad: signal(&courses.steering_rad),
        side_wind_m_per_s2: Signal::default(),
        wind_m_per_s: signal(&courses.wind_m_per_s),
        road_bank_deg: signal(&courses.bank_deg),
        steering_fault_deg: Signal::default(),
        speed_m_per_s: Some(signal(&courses.speed_m_per_s)),
        sensor_noise: SensorNoise { v_x_std_m_per_s, r_std_rad_per_s, seed: drive.noise_seed },
        plant: plant(drive),
        ..Scenario::default()
    }
}

/// Parameters of the plant's FMU.
fn plant(drive: &Drive) -> BTreeMap<String, PlantParameter> {
    let Drive { vehicle, tyres, steering, .. } = drive;
    let mut parameters: BTreeMap<String, PlantParameter> = [
        ("vehicle.M_v", vehicle.mass_kg),
        ("vehicle.I_e", vehicle.effective_longitudinal_inertia_kg_m),
        ("vehicle.I_z", vehicle.yaw_inertia_kg_m2),
        ("vehicle.C_f", vehicle.front_cornering_stiffness_n_per_rad),
        ("vehicle.C_r", vehicle.rear_cornering_stiffness_n_per_rad),
        ("vehicle.h", vehicle.centre_of_gravity_height_m),
        ("actuator.lag", steering.actuator.lag_s),
        ("actuator.delay", steering.actuator.delay_s),
        ("steering.ratio", steering.ratio),
        ("steering.offset", steering.offset_rad),
        ("sensor.v_x_scale", drive.v_x_scale),
        ("sensor.r_bias", drive.yaw_rate_bias_rad_per_s),
    ]
    .map(|(name, value)| (name.to_owned(), PlantParameter::Number(value)))
    .into();
    if let Tyres::Saturating { friction } = *tyres {
        parameters.insert("tyre.friction_limited".into(), PlantParameter::Flag(true));
        parameters.insert("tyre.friction".into(), PlantParameter::Number(friction));
    }
    parameters
}

/// The scenario file of a family's worst drive by `objective`; none where it has none.
///
/// # Errors
/// None that a drive can cause.
pub fn file(
    found: &FamilyWorst,
    objective: Objective,
    spec: &Spec,
) -> Result<Option<String>, toml::ser::Error> {
    let Some((drive, worst)) = &found.worst else { return Ok(None) };
    let Worst { ratio, time_s, .. } = *worst;
    let name = found.family.name();
    let head = match objective {
        Objective::Residual => format!(
            "# The worst fault-free drive found of family \"{name}\": J/J_th {ratio:.6} at {time_s:.2} s.\n\n"
        ),
        Objective::Second => format!(
            "# The worst fault-free drive for the second test found of family \"{name}\": statistic over \
             threshold {ratio:.6} at {time_s:.2} s, with the detector's parameter threshold_factor at a number that it \
             stays below.\n\n"
        ),
    };
    Ok(Some(head + &scenario(drive, spec).to_toml()?))
}
