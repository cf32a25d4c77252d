//! Co-simulation of a detector FMU with a plant FMU.
//!
//! # Conventions
//! - Jacobi master: at communication point `t_k = k h` both FMUs get their inputs, then both step
//!   over h. The detector is given what the plant measures at t_k and the u_k that acts on the plant
//!   from then on, so what it puts out after the step belongs to sample k, time t_k.
//! - The plant takes the vehicle that the detector was designed for: every `vehicle.*`, by name, and
//!   every `design.actuator.*` as `actuator.*`.

use serde::{Serialize, Serializer};
use steerguard_detector::{Actuator, Gust, Vehicle};
use steerguard_world::{Steering, bank_m_per_s2, speed_control_n_m};

use steerguard_designer::document::Mistakes;

use crate::drive::exchange::{self, Inputs, NotFinite, Results, finite};
use crate::drive::scenario::{PlantParameter, Scenario, SensorNoise};
use crate::drive::wheel::Wheel;
use crate::importer::{CallError, Fmu, ImportError, Instance, Type};

/// Why a co-simulation ended early.
#[derive(Debug, thiserror::Error)]
pub enum CosimulationError {
    /// An FMU lacks a variable, or has none where it is looked for.
    #[error(transparent)]
    Import(#[from] ImportError),
    /// An FMU refused a call or failed.
    #[error(transparent)]
    Call(#[from] CallError),
    /// An FMU gave what is no number.
    #[error(transparent)]
    NotFinite(#[from] NotFinite),
    /// The scenario does not fit the communication step.
    #[error(transparent)]
    Scenario(#[from] Mistakes),
    /// Neither scenario nor detector says how long a communication step is.
    #[error("the detector proposes no communication step and the scenario gives none")]
    NoStep,
}

/// Sample k of a run: the columns of its CSV file, named as the FMU variables.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Sample {
    /// t_k, s.
    pub time: f64,
    /// Measured longitudinal speed, m/s.
    pub v_x: f64,
    /// Measured yaw rate, rad/s.
    pub r: f64,
    /// Drive torque, N m.
    #[serde(rename = "u.T_eng")]
    pub drive_torque: f64,
    /// Commanded road-wheel angle, rad.
    #[serde(rename = "u.delta")]
    pub steering_angle: f64,
    /// Angle added by the faulty actuator, rad.
    pub fault: f64,
    /// Side force, N.
    #[serde(rename = "disturbance.side_force")]
    pub side_force: f64,
    /// Yaw moment, N m.
    #[serde(rename = "disturbance.yaw_moment")]
    pub yaw_moment: f64,
    /// Lateral speed, m/s.
    #[serde(rename = "true.v_y")]
    pub lateral_speed: f64,
    /// Residual of the longitudinal speed, m/s.
    #[serde(rename = "residual.v_x")]
    pub residual_v_x: f64,
    /// Residual of the yaw rate, rad/s.
    #[serde(rename = "residual.r")]
    pub residual_r: f64,
    /// Windowed RMS of the weighted residual.
    #[serde(rename = "J_rms")]
    pub j_rms: f64,
    /// Threshold.
    #[serde(rename = "J_th")]
    pub j_th: f64,
    /// Estimated lateral speed, m/s.
    pub v_y_hat: f64,
    /// Whether a fault is detected; 0 or 1 in the file.
    #[serde(serialize_with = "as_digit")]
    pub alarm: bool,
    /// Whether the smallest fault of interest could be seen; 0 or 1 in the file.
    #[serde(serialize_with = "as_digit")]
    pub excited: bool,
    /// Item of the enumeration `DetectorState`.
    pub state: i32,
    /// Item of the enumeration `DetectorStateCause`.
    pub state_cause: i32,
    /// Item of the enumeration `DetectorAlarmCause`.
    pub alarm_cause: i32,
    /// Statistic of the second test over its threshold.
    pub second_ratio: f64,
    /// The fault that the second test has found, rad; 0 for none.
    pub fault_estimate: f64,
    /// Its largest error, rad.
    pub fault_estimate_bound: f64,
}

/// 0 or 1.
pub(crate) fn as_digit<S: Serializer>(value: &bool, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_u8(u8::from(*value))
}

/// One run of a scenario.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// v_x(0), m/s.
    pub initial_speed_m_per_s: f64,
    /// Communication step, s.
    pub step_s: f64,
    /// Samples 0, 1, ... before the end of the run.
    pub samples: Vec<Sample>,
}

/// Drives both FMUs through the run of `scenario` with the given initial speed.
///
/// # Errors
/// [`CosimulationError`] at the first call that an FMU refuses.
pub fn run(
    detector: &Fmu,
    plant: &Fmu,
    scenario: &Scenario,
    initial_speed_m_per_s: f64,
) -> Result<Run, CosimulationError> {
    let step_s = scenario
        .communication_step_s
        .or(detector.step_size_s())
        .ok_or(CosimulationError::NoStep)?;
    let steps = scenario.steps(step_s)?;
    let mut rig = Rig::new(detector, plant)?;
    let of_detector = vehicle(&rig.detector, detector)?;
    let mass_kg = of_detector.mass_kg;
    let cruise_torque_n_m = of_detector.cruise_torque(initial_speed_m_per_s);
    let initial_state = [
        initial_speed_m_per_s,
        scenario.initial_lateral_speed_m_per_s,
        scenario.initial_yaw_rate_rad_per_s,
    ];
    rig.plant.set_real(plant.reals(["initial.v_x", "initial.v_y", "initial.r"])?, initial_state)?;
    if let Some(actuator) = scenario.actuator {
        rig.set_actuator(plant, &actuator.actuator())?;
    }
    let noise = &scenario.sensor_noise;
    if [noise.v_x_std_m_per_s, noise.r_std_rad_per_s] != [0.0, 0.0] {
        rig.set_noise(plant, noise, detector.step_size_s().unwrap_or(step_s))?;
    }
    for (name, value) in &scenario.plant {
        match *value {
            PlantParameter::Number(x) => rig.plant.set_real(plant.reals([name])?, [x])?,
            PlantParameter::Flag(flag) => {
                let parameter = plant.variable(name, Type::Boolean)?;
                rig.plant.set_boolean([parameter], [i32::from(flag)])?;
            }
        }
    }

    let course = match &scenario.manoeuvre {
        Some(table) => Some(table.course(&vehicle(&rig.plant, plant)?, initial_speed_m_per_s)),
        None => None,
    };
    let command_rad = |time_s| match &course {
        Some(course) => course.steering_rad(time_s),
        None => scenario.steering_angle_rad.at(time_s, initial_speed_m_per_s),
    };
    let faulty = match &scenario.fault {
        Some(table) => {
            let steering = Steering::of(rig.actuator(plant)?);
            let wheel = Wheel::new(command_rad, &steering, step_s, steps);
            Some((table.fault(), wheel))
        }
        None => None,
    };
    let [mass_of_plant_kg] = rig.plant.get_real(plant.reals(["vehicle.M_v"])?)?;
    let excitation = |time_s, v_x, true_v_x| {
        let v = initial_speed_m_per_s;
        let side_wind = mass_kg * scenario.side_wind_m_per_s2.at(time_s, v);
        let wind = Gust {
            speed_m_per_s: scenario.wind_m_per_s.at(time_s, v),
            coefficient_n_s2_per_m2: scenario.wind_coefficient_n_s2_per_m2,
            acting_ahead_m: scenario.side_wind_lever_arm_m,
        };
        let of_air = side_wind + wind.side_force(true_v_x);
        let bank_rad = scenario.road_bank_deg.at(time_s, v).to_radians();
        Excitation {
            drive_torque: match (&course, &scenario.speed_m_per_s) {
                (Some(course), _) => course.drive_torque_n_m(time_s, v_x),
                (None, Some(speed)) => {
                    let [now, next] = [time_s, time_s + step_s].map(|t| speed.at(t, v));
                    speed_control_n_m(&of_detector, now, (next - now) / step_s, v_x)
                }
                (None, None) => cruise_torque_n_m + scenario.drive_torque_n_m.at(time_s, v),
            },
            steering_angle: command_rad(time_s),
            fault: match &faulty {
                Some((fault, wheel)) => wheel.fault_rad(fault.as_ref(), time_s),
                None => scenario.steering_fault_rad(time_s, v),
            },
            side_force: of_air + mass_of_plant_kg * bank_m_per_s2(bank_rad),
            yaw_moment: of_air * scenario.side_wind_lever_arm_m,
        }
    };
    let v_x = initial_speed_m_per_s;
    rig.initialise(scenario.duration_s, &excitation(0.0, v_x, v_x))?;
    let samples = (0..steps)
        .map(|k| {
            let time_s = f64::from(k) * step_s;
            rig.step(time_s, step_s, |seen| excitation(time_s, seen.v_x, seen.true_v_x))
        })
        .collect::<Result<_, _>>()?;
    rig.terminate()?;
    Ok(Run { initial_speed_m_per_s, step_s, samples })
}

/// The vehicle data of an `instance` of `fmu`, detector or plant.
///
/// # Errors
/// [`CosimulationError`] if a parameter is missing.
pub fn vehicle(instance: &Instance, fmu: &Fmu) -> Result<Vehicle, CosimulationError> {
    let [
        mass_kg,
        yaw_inertia_kg_m2,
        effective_longitudinal_inertia_kg_m,
        front_axle_distance_m,
        rear_axle_distance_m,
        front_cornering_stiffness_n_per_rad,
        rear_cornering_stiffness_n_per_rad,
        longitudinal_drag_n_m_s2_per_m2,
        lateral_drag_n_s2_per_m2,
        centre_of_gravity_height_m,
    ] = instance.get_real(fmu.reals([
        "vehicle.M_v",
        "vehicle.I_z",
        "vehicle.I_e",
        "vehicle.l_f",
        "vehicle.l_r",
        "vehicle.C_f",
        "vehicle.C_r",
        "vehicle.C_x",
        "vehicle.C_y",
        "vehicle.h",
    ])?)?;
    Ok(Vehicle {
        mass_kg,
        yaw_inertia_kg_m2,
        effective_longitudinal_inertia_kg_m,
        front_axle_distance_m,
        rear_axle_distance_m,
        front_cornering_stiffness_n_per_rad,
        rear_cornering_stiffness_n_per_rad,
        longitudinal_drag_n_m_s2_per_m2,
        lateral_drag_n_s2_per_m2,
        centre_of_gravity_height_m,
    })
}

/// What the plant shows at a communication point, m/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Measured longitudinal speed.
    pub v_x: f64,
    /// Longitudinal speed.
    pub true_v_x: f64,
}

/// What acts from a communication point to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Excitation {
    /// Drive torque, N m.
    pub drive_torque: f64,
    /// Commanded road-wheel angle, rad.
    pub steering_angle: f64,
    /// Angle added by the faulty actuator, rad.
    pub fault: f64,
    /// Side force, N.
    pub side_force: f64,
    /// Yaw moment, N m.
    pub yaw_moment: f64,
}

/// An instance of either FMU, connected.
pub struct Rig {
    /// The detector.
    pub detector: Instance,
    /// The plant; its parameters may be set before [`Rig::initialise`].
    pub plant: Instance,
    ports: Ports,
}

/// Value references of what is exchanged and recorded.
struct Ports {
    plant_inputs: [u32; 5],
    plant_outputs: [u32; 4],
    detector: exchange::Ports,
}

/// What is read of the plant.
const PLANT_OUTPUTS: [&str; 4] = ["v_x", "r", "true.v_y", "true.v_x"];

impl Ports {
    fn find(detector: &Fmu, plant: &Fmu) -> Result<Self, ImportError> {
        Ok(Self {
            plant_inputs: plant.reals([
                "u.T_eng",
                "u.delta",
                "fault",
                "disturbance.side_force",
                "disturbance.yaw_moment",
            ])?,
            plant_outputs: plant.reals(PLANT_OUTPUTS)?,
            detector: exchange::Ports::find(detector)?,
        })
    }
}

/// The plant's parameters of the steering actuator; a limit of 0 is none.
const ACTUATOR: [&str; 4] =
    ["actuator.lag", "actuator.delay", "actuator.rate_limit", "actuator.angle_limit"];

/// What the plant calls the detector's constant `name`, where the plant has it as a parameter.
pub fn name_in_plant(name: &str) -> Option<&str> {
    let of_plant = name.strip_prefix("design.").unwrap_or(name);
    let shared = ["vehicle.", "actuator."];
    shared.iter().any(|prefix| of_plant.starts_with(prefix)).then_some(of_plant)
}

impl Rig {
    /// Instantiates both; the plant gets the detector's vehicle and actuator.
    ///
    /// # Errors
    /// [`CosimulationError`] if a variable is missing or an FMU refuses.
    pub fn new(detector_fmu: &Fmu, plant_fmu: &Fmu) -> Result<Self, CosimulationError> {
        let ports = Ports::find(detector_fmu, plant_fmu)?;
        let detector = detector_fmu.instantiate("detector")?;
        let mut plant = plant_fmu.instantiate("plant")?;
        for name in detector_fmu.names() {
            let Some(of_plant) = name_in_plant(name) else { continue };
            let value = detector.get_real(detector_fmu.reals([name])?)?;
            plant.set_real(plant_fmu.reals([of_plant])?, value)?;
        }
        Ok(Self { detector, plant, ports })
    }

    /// Gives the plant another actuator than the design's.
    ///
    /// # Errors
    /// [`CosimulationError`] if a parameter is missing or refused.
    pub fn set_actuator(
        &mut self,
        plant_fmu: &Fmu,
        actuator: &Actuator,
    ) -> Result<(), CosimulationError> {
        let Actuator { lag_s, delay_s, rate_limit_rad_per_s, angle_limit_rad } = *actuator;
        Ok(self.plant.set_real(
            plant_fmu.reals(ACTUATOR)?,
            [lag_s, delay_s, rate_limit_rad_per_s.unwrap_or(0.0), angle_limit_rad.unwrap_or(0.0)],
        )?)
    }

    /// The steering actuator that the plant simulates.
    ///
    /// # Errors
    /// [`CosimulationError`] if a parameter is missing.
    pub fn actuator(&self, plant_fmu: &Fmu) -> Result<Actuator, CosimulationError> {
        let [lag_s, delay_s, rate, angle] = self.plant.get_real(plant_fmu.reals(ACTUATOR)?)?;
        let limit = |limit: f64| (limit > 0.0).then_some(limit);
        Ok(Actuator {
            lag_s,
            delay_s,
            rate_limit_rad_per_s: limit(rate),
            angle_limit_rad: limit(angle),
        })
    }

    /// Gives the plant's sensors white noise, a new value each `period_s`.
    ///
    /// # Errors
    /// [`CosimulationError`] if a parameter is missing or refused.
    pub fn set_noise(
        &mut self,
        plant_fmu: &Fmu,
        noise: &SensorNoise,
        period_s: f64,
    ) -> Result<(), CosimulationError> {
        self.plant.set_real(
            plant_fmu.reals(["noise.v_x", "noise.r", "noise.sample_period"])?,
            [noise.v_x_std_m_per_s, noise.r_std_rad_per_s, period_s],
        )?;
        let seed = plant_fmu.variable("noise.seed", Type::Integer)?;
        Ok(self.plant.set_integer([seed], [noise.seed])?)
    }

    /// Initialises both for a run of `stop_time_s`; `excitation` is that of time 0.
    ///
    /// # Errors
    /// [`CosimulationError::Call`], [`CosimulationError::NotFinite`].
    pub fn initialise(
        &mut self,
        stop_time_s: f64,
        excitation: &Excitation,
    ) -> Result<(), CosimulationError> {
        self.plant.setup_experiment(stop_time_s)?;
        self.plant.enter_initialization_mode()?;
        self.excite_plant(excitation)?;
        self.plant.exit_initialization_mode()?;

        self.detector.setup_experiment(stop_time_s)?;
        self.detector.enter_initialization_mode()?;
        let [v_x, r, ..] = self.measure(0.0)?;
        self.excite_detector([v_x, r], excitation)?;
        self.detector.exit_initialization_mode()?;
        Ok(())
    }

    /// One communication step from `time_s` on; `excite` is told what the plant shows.
    ///
    /// # Errors
    /// [`CosimulationError::Call`], [`CosimulationError::NotFinite`].
    pub fn step(
        &mut self,
        time_s: f64,
        step_s: f64,
        excite: impl FnOnce(Seen) -> Excitation,
    ) -> Result<Sample, CosimulationError> {
        let [v_x, r, lateral_speed, true_v_x] = self.measure(time_s)?;
        let excitation = excite(Seen { v_x, true_v_x });
        self.excite_detector([v_x, r], &excitation)?;
        self.excite_plant(&excitation)?;
        self.detector.do_step(time_s, step_s)?;
        self.plant.do_step(time_s, step_s)?;

        let results = self.ports.detector.hear(&self.detector)?;
        results.finite(time_s)?;
        let Results {
            residual_v_x,
            residual_r,
            j_rms,
            j_th,
            v_y_hat,
            second_ratio,
            fault_estimate,
            fault_estimate_bound,
            alarm,
            excited,
            state,
            state_cause,
            alarm_cause,
        } = results;
        let Excitation { drive_torque, steering_angle, fault, side_force, yaw_moment } = excitation;
        Ok(Sample {
            time: time_s,
            v_x,
            r,
            drive_torque,
            steering_angle,
            fault,
            side_force,
            yaw_moment,
            lateral_speed,
            residual_v_x,
            residual_r,
            j_rms,
            j_th,
            v_y_hat,
            alarm,
            excited,
            state,
            state_cause,
            alarm_cause,
            second_ratio,
            fault_estimate,
            fault_estimate_bound,
        })
    }

    /// Terminates both.
    ///
    /// # Errors
    /// [`CosimulationError::Call`].
    pub fn terminate(&mut self) -> Result<(), CosimulationError> {
        self.detector.terminate()?;
        Ok(self.plant.terminate()?)
    }

    fn measure(&self, time_s: f64) -> Result<[f64; 4], CosimulationError> {
        let values = self.plant.get_real(self.ports.plant_outputs)?;
        finite("plant", PLANT_OUTPUTS, values, time_s)?;
        Ok(values)
    }

    fn excite_detector(
        &mut self,
        [v_x, r]: [f64; 2],
        excitation: &Excitation,
    ) -> Result<(), CallError> {
        let Excitation { drive_torque, steering_angle, .. } = *excitation;
        let inputs = Inputs { v_x, r, drive_torque, steering_angle };
        self.ports.detector.tell(&mut self.detector, &inputs)
    }

    fn excite_plant(&mut self, excitation: &Excitation) -> Result<(), CallError> {
        let Excitation { drive_torque, steering_angle, fault, side_force, yaw_moment } =
            *excitation;
        self.plant.set_real(
            self.ports.plant_inputs,
            [drive_torque, steering_angle, fault, side_force, yaw_moment],
        )
    }
}
