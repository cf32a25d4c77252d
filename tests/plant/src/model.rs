//! The plant on the FMI layer.
//!
//! # Conventions
//! - A sample is an internal step: from `start time + k ms` to the next millisecond, with the inputs
//!   valid at its beginning. Outputs are those at its end.
//! - The noise value of time t is number `floor(t / noise.sample_period)` since the start.

use steerguard_detector::Vehicle;
use steerguard_fmu_core::{Archive, Log, Model, Status};
use steerguard_model_description::{ModelInfo, Value, VariableSet};

use crate::dynamics::{
    DeadTime, Dynamics, Excitation, INTERNAL_STEP_S, MAX_DEAD_TIME_STEPS, PlantState,
};
use crate::noise::standard_normal;
use crate::variables::{INFO, PlantVariable};

/// Inputs and parameters: everything that an importer sets.
#[derive(Clone, Copy, Debug)]
struct Settings {
    dynamics: Dynamics,
    dead_time_s: f64,
    noise_v_x: f64,
    noise_r: f64,
    noise_period_s: f64,
    noise_seed: i32,
    /// v_x, v_y, r at the start.
    initial: [f64; 3],
    excitation: Excitation,
}

impl Settings {
    /// Place of a Real input or parameter; `None` for all other variables.
    fn real(&mut self, variable: PlantVariable) -> Option<&mut f64> {
        use PlantVariable as V;
        let Self { dynamics, excitation, initial: [v_x, v_y, r], .. } = self;
        let vehicle = &mut dynamics.vehicle;
        Some(match variable {
            V::DriveTorque => &mut excitation.t_eng,
            V::SteeringAngle => &mut excitation.delta,
            V::Fault => &mut excitation.fault,
            V::SideForce => &mut excitation.side_force,
            V::YawMoment => &mut excitation.yaw_moment,

            V::InitialSpeedX => v_x,
            V::InitialSpeedY => v_y,
            V::InitialYawRate => r,

            V::Mass => &mut vehicle.mass_kg,
            V::YawInertia => &mut vehicle.yaw_inertia_kg_m2,
            V::LongitudinalInertia => &mut vehicle.effective_longitudinal_inertia_kg_m,
            V::FrontAxleDistance => &mut vehicle.front_axle_distance_m,
            V::RearAxleDistance => &mut vehicle.rear_axle_distance_m,
            V::FrontStiffness => &mut vehicle.front_cornering_stiffness_n_per_rad,
            V::RearStiffness => &mut vehicle.rear_cornering_stiffness_n_per_rad,
            V::LongitudinalDrag => &mut vehicle.longitudinal_drag_n_m_s2_per_m2,
            V::LateralDrag => &mut vehicle.lateral_drag_n_s2_per_m2,

            V::Friction => &mut dynamics.friction,
            V::ActuatorLag => &mut dynamics.actuator_lag_s,
            V::ActuatorRateLimit => &mut dynamics.actuator_rate_limit,
            V::ActuatorDelay => &mut self.dead_time_s,
            V::Bank => &mut dynamics.bank_rad,
            V::NoiseSpeedX => &mut self.noise_v_x,
            V::NoiseYawRate => &mut self.noise_r,
            V::NoisePeriod => &mut self.noise_period_s,

            V::SpeedX
            | V::YawRate
            | V::TrueSpeedX
            | V::TrueSpeedY
            | V::TrueYawRate
            | V::WheelAngle
            | V::FrictionLimited
            | V::NoiseSeed => return None,
        })
    }

    fn inputs_are_finite(&self) -> bool {
        let e = &self.excitation;
        [e.t_eng, e.delta, e.fault, e.side_force, e.yaw_moment].iter().all(|x| x.is_finite())
    }
}

/// Reference vehicle.
#[derive(Clone, Debug)]
pub struct PlantModel {
    settings: Settings,
    dead_time: DeadTime,
    state: PlantState,
    step: u64,
}

impl PlantModel {
    /// What the sensor noise on a channel now is.
    fn noise(&self, channel: u32, standard_deviation: f64) -> f64 {
        let time_s = self.step as f64 * INTERNAL_STEP_S;
        // The slack keeps a time of n periods at number n whatever its last bit.
        let sample = libm::floor(time_s / self.settings.noise_period_s + 1e-6) as u64;
        standard_deviation * standard_normal(self.settings.noise_seed, sample, channel)
    }
}

impl Model for PlantModel {
    type Variable = PlantVariable;
    const INFO: ModelInfo = INFO;

    fn new(_payload: &[u8]) -> Result<Self, &'static str> {
        let vehicle = Vehicle::PAPER;
        let v_x = 15.0;
        Ok(Self {
            settings: Settings {
                dynamics: Dynamics {
                    vehicle,
                    friction_limited: false,
                    friction: 0.9,
                    actuator_lag_s: 0.0,
                    actuator_rate_limit: 0.0,
                    bank_rad: 0.0,
                },
                dead_time_s: 0.0,
                noise_v_x: 0.0,
                noise_r: 0.0,
                noise_period_s: 0.01,
                noise_seed: 1,
                initial: [v_x, 0.0, 0.0],
                excitation: Excitation {
                    t_eng: vehicle.cruise_torque(v_x),
                    ..Excitation::default()
                },
            },
            dead_time: DeadTime::new(0.0, 0.0),
            state: [v_x, 0.0, 0.0, 0.0],
            step: 0,
        })
    }

    fn sample_period_s(&self) -> f64 {
        INTERNAL_STEP_S
    }

    fn get(&self, variable: PlantVariable) -> Value<'_> {
        use PlantVariable as V;
        let mut settings = self.settings;
        if let Some(value) = settings.real(variable) {
            return Value::Real(*value);
        }
        let [v_x, v_y, r, delta_w] = self.state;
        Value::Real(match variable {
            V::SpeedX => v_x + self.noise(0, settings.noise_v_x),
            V::YawRate => r + self.noise(1, settings.noise_r),
            V::TrueSpeedX => v_x,
            V::TrueSpeedY => v_y,
            V::TrueYawRate => r,
            V::FrictionLimited => return Value::Boolean(settings.dynamics.friction_limited),
            V::NoiseSeed => return Value::Integer(settings.noise_seed),
            // WheelAngle is all that is left: Settings::real has answered the rest.
            _ => delta_w + settings.excitation.fault,
        })
    }

    fn set(&mut self, variable: PlantVariable, value: Value<'_>) {
        let settings = &mut self.settings;
        match value {
            Value::Real(value) => {
                if let Some(place) = settings.real(variable) {
                    *place = value;
                }
            }
            Value::Boolean(value) => settings.dynamics.friction_limited = value,
            Value::Integer(value) => settings.noise_seed = value,
            Value::String(_) => {}
        }
    }

    fn initialise(&mut self, _start_time_s: f64) -> Result<(), &'static str> {
        let settings = &self.settings;
        if !settings.inputs_are_finite() {
            return Err("an input is not finite");
        }
        let delta = settings.excitation.delta;
        let [v_x, v_y, r] = settings.initial;
        self.dead_time = DeadTime::new(settings.dead_time_s, delta);
        self.state = [v_x, v_y, r, delta];
        self.step = 0;
        Ok(())
    }

    fn sample(&mut self, log: &Log<'_>) -> Status {
        let settings = &self.settings;
        if !settings.inputs_are_finite() {
            log.error(|text| {
                text.str("an input is not finite: the vehicle cannot go on");
            });
            return Status::Error;
        }
        let delta = self.dead_time.pass(settings.excitation.delta);
        let excitation = Excitation { delta, ..settings.excitation };
        self.state = settings.dynamics.step(self.state, &excitation);
        self.step += 1;
        Status::Ok
    }

    fn archive(&mut self, archive: &mut Archive<'_>) {
        for &variable in PlantVariable::ALL {
            if let Some(value) = self.settings.real(variable) {
                archive.real(value);
            }
        }
        archive.flag(&mut self.settings.dynamics.friction_limited);
        let mut seed = self.settings.noise_seed.cast_unsigned();
        archive.u32(&mut seed);
        self.settings.noise_seed = seed.cast_signed();

        let DeadTime { angles, oldest, steps } = &mut self.dead_time;
        archive.size(steps);
        archive.size(oldest);
        archive.require(*steps <= MAX_DEAD_TIME_STEPS && *oldest < (*steps).max(1));
        for angle in angles.iter_mut().take(*steps) {
            archive.finite(angle);
        }
        for value in &mut self.state {
            archive.finite(value);
        }
        archive.u64(&mut self.step);
    }
}
