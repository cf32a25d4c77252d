//! The plant on the FMI layer.
//!
//! # Conventions
//! - A sample is an internal step: from `start time + k ms` to the next millisecond, with the inputs
//!   valid at its beginning. Outputs are those at its end.
//! - Until the end of Initialization Mode outputs are those that the parameters and inputs set so far
//!   give.
//! - Inputs that are not finite or beyond their limits are refused by the step, and so is a motion that
//!   no vehicle has: what was there before stays, and no output is ever NaN or infinite.

use steerguard_detector::{Actuator, LARGEST_ESTIMATE, StateVector, Vehicle, VehicleState};
use steerguard_fmu_core::{Archive, Log, Model, Status};
use steerguard_model_description::plant::{INFO, PlantVariable};
use steerguard_model_description::{Kind, ModelInfo, RealKind, Role, Value, Variable, VariableSet};
use steerguard_world::{
    Excitation, MAX_DEAD_TIME_STEPS, Readings, STEP_S, Sensor, Sensors, State, Steering,
    TrueVehicle, Tyres, World,
};

/// Inputs and parameters: everything that an importer sets. Limits of 0 are none.
#[derive(Clone, Copy, Debug)]
struct Settings {
    inputs: Inputs,
    vehicle: Vehicle,
    friction_limited: bool,
    friction: f64,
    actuator_lag_s: f64,
    actuator_delay_s: f64,
    actuator_rate_limit_rad_per_s: f64,
    actuator_angle_limit_rad: f64,
    steering_ratio: f64,
    steering_offset_rad: f64,
    bank_rad: f64,
    /// Of v_x and r.
    sensors: [Sensor; 2],
    sensor_period_s: f64,
    sensors_held: bool,
    seed: i32,
    /// v_x, v_y, r at the start.
    initial: StateVector,
}

#[derive(Clone, Copy, Debug)]
struct Inputs {
    drive_torque_n_m: f64,
    steering_rad: f64,
    fault_rad: f64,
    side_force_n: f64,
    yaw_moment_n_m: f64,
}

impl Settings {
    /// Place of a Real input or parameter; `None` for all other variables.
    fn real(&mut self, variable: PlantVariable) -> Option<&mut f64> {
        use PlantVariable as V;
        let Self { vehicle, inputs, initial: [v_x, v_y, r], sensors, .. } = self;
        let [speed_sensor, yaw_rate_sensor] = sensors;
        Some(match variable {
            V::DriveTorque => &mut inputs.drive_torque_n_m,
            V::SteeringAngle => &mut inputs.steering_rad,
            V::Fault => &mut inputs.fault_rad,
            V::SideForce => &mut inputs.side_force_n,
            V::YawMoment => &mut inputs.yaw_moment_n_m,

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
            V::CentreOfGravityHeight => &mut vehicle.centre_of_gravity_height_m,

            V::Friction => &mut self.friction,
            V::ActuatorLag => &mut self.actuator_lag_s,
            V::ActuatorDelay => &mut self.actuator_delay_s,
            V::ActuatorRateLimit => &mut self.actuator_rate_limit_rad_per_s,
            V::ActuatorAngleLimit => &mut self.actuator_angle_limit_rad,
            V::SteeringRatio => &mut self.steering_ratio,
            V::SteeringOffset => &mut self.steering_offset_rad,
            V::Bank => &mut self.bank_rad,
            V::BiasSpeedX => &mut speed_sensor.bias,
            V::BiasYawRate => &mut yaw_rate_sensor.bias,
            V::ScaleSpeedX => &mut speed_sensor.scale,
            V::ScaleYawRate => &mut yaw_rate_sensor.scale,
            V::ResolutionSpeedX => &mut speed_sensor.resolution,
            V::ResolutionYawRate => &mut yaw_rate_sensor.resolution,
            V::NoiseSpeedX => &mut speed_sensor.noise_std,
            V::NoiseYawRate => &mut yaw_rate_sensor.noise_std,
            V::NoisePeriod => &mut self.sensor_period_s,

            V::SpeedX
            | V::YawRate
            | V::TrueSpeedX
            | V::TrueSpeedY
            | V::TrueYawRate
            | V::WheelAngle
            | V::FrictionLimited
            | V::SensorsHeld
            | V::NoiseSeed => return None,
        })
    }

    /// The first input that a step refuses, and its value.
    fn refused_input(&self) -> Option<(&'static Variable, f64)> {
        let Inputs { drive_torque_n_m, steering_rad, fault_rad, side_force_n, yaw_moment_n_m } =
            self.inputs;
        let values = [drive_torque_n_m, steering_rad, fault_rad, side_force_n, yaw_moment_n_m];
        // Inputs are the first variables of the table.
        let mut inputs = PlantVariable::TABLE.iter().zip(values);
        inputs.find(|(row, value)| !row.kind.admits(Value::Real(*value)))
    }

    /// The input `variable`, or 0 where a step would refuse it.
    fn admitted(&self, variable: PlantVariable) -> f64 {
        let value = { *self }.real(variable).map_or(0.0, |value| *value);
        let row = PlantVariable::TABLE.get(variable as usize);
        if row.is_some_and(|row| row.kind.admits(Value::Real(value))) { value } else { 0.0 }
    }

    fn world(&self) -> World {
        let limit = |limit: f64| (limit > 0.0).then_some(limit);
        World {
            vehicle: TrueVehicle {
                data: self.vehicle,
                tyres: if self.friction_limited {
                    Tyres::Saturating { friction: self.friction }
                } else {
                    Tyres::Linear
                },
            },
            steering: Steering {
                actuator: Actuator {
                    lag_s: self.actuator_lag_s,
                    delay_s: self.actuator_delay_s,
                    rate_limit_rad_per_s: limit(self.actuator_rate_limit_rad_per_s),
                    angle_limit_rad: limit(self.actuator_angle_limit_rad),
                },
                ratio: self.steering_ratio,
                offset_rad: self.steering_offset_rad,
            },
            bank_rad: self.bank_rad,
        }
    }

    fn sensors(&self) -> Sensors {
        Sensors {
            sensors: self.sensors,
            period_s: self.sensor_period_s,
            held: self.sensors_held,
            seed: self.seed.cast_unsigned().into(),
        }
    }
}

/// Reference vehicle.
#[derive(Clone, Debug)]
pub struct PlantModel {
    settings: Settings,
    /// Whether Initialization Mode is over.
    started: bool,
    state: State,
    readings: Readings,
    step: u64,
}

impl PlantModel {
    /// `[v_x, v_y, r]` now.
    fn motion(&self) -> StateVector {
        if self.started { self.state.motion.vector() } else { self.settings.initial }
    }

    /// What the sensors show of `[v_x, r]` now.
    fn measured(&self) -> [f64; 2] {
        let [v_x, _, r] = self.motion();
        self.readings.at(&self.settings.sensors(), self.time_s(), [v_x, r])
    }

    /// Angle of the road wheel now, fault included, rad.
    fn wheel_angle_rad(&self) -> f64 {
        let settings = &self.settings;
        let actuator_rad = if self.started {
            self.state.steering.angle_rad
        } else {
            let command_rad = settings.admitted(PlantVariable::SteeringAngle);
            settings.world().steering.settled_rad(command_rad)
        };
        actuator_rad + settings.admitted(PlantVariable::Fault)
    }

    /// Time since the start, s.
    fn time_s(&self) -> f64 {
        self.step as f64 * STEP_S
    }

    fn sample_sensors(&mut self) {
        let (time_s, truth) = (self.time_s(), self.state.motion.measured());
        self.readings.sample(&self.settings.sensors(), time_s, truth.vector());
    }
}

/// Whether a state is far from what an f64 holds, and a number at all.
fn plausible(state: &State) -> bool {
    let [v_x, v_y, r] = state.motion.vector();
    let numbers = [v_x, v_y, r, state.steering.angle_rad];
    numbers.iter().all(|x| -LARGEST_ESTIMATE < *x && *x < LARGEST_ESTIMATE)
}

impl Model for PlantModel {
    type Variable = PlantVariable;
    const INFO: ModelInfo = INFO;

    fn new(_payload: &[u8]) -> Result<Self, &'static str> {
        let vehicle = Vehicle::PAPER;
        let initial = [15.0, 0.0, 0.0];
        let [v_x, ..] = initial;
        let settings = Settings {
            inputs: Inputs {
                drive_torque_n_m: vehicle.cruise_torque(v_x),
                steering_rad: 0.0,
                fault_rad: 0.0,
                side_force_n: 0.0,
                yaw_moment_n_m: 0.0,
            },
            vehicle,
            friction_limited: false,
            friction: 0.9,
            actuator_lag_s: 0.0,
            actuator_delay_s: 0.0,
            actuator_rate_limit_rad_per_s: 0.0,
            actuator_angle_limit_rad: 0.0,
            steering_ratio: 1.0,
            steering_offset_rad: 0.0,
            bank_rad: 0.0,
            sensors: [Sensor::default(); 2],
            sensor_period_s: 0.01,
            sensors_held: false,
            seed: 1,
            initial,
        };
        Ok(Self {
            settings,
            started: false,
            state: State::new(&settings.world(), STEP_S, initial.into(), 0.0),
            readings: Readings::default(),
            step: 0,
        })
    }

    fn sample_period_s(&self) -> f64 {
        STEP_S
    }

    fn get(&self, variable: PlantVariable) -> Value<'_> {
        use PlantVariable as V;
        let mut settings = self.settings;
        if let Some(value) = settings.real(variable) {
            return Value::Real(*value);
        }
        let [v_x, v_y, r] = self.motion();
        Value::Real(match variable {
            V::SpeedX => self.measured()[0],
            V::YawRate => self.measured()[1],
            V::TrueSpeedX => v_x,
            V::TrueSpeedY => v_y,
            V::TrueYawRate => r,
            V::FrictionLimited => return Value::Boolean(settings.friction_limited),
            V::SensorsHeld => return Value::Boolean(settings.sensors_held),
            V::NoiseSeed => return Value::Integer(settings.seed),
            // WheelAngle is all that is left: Settings::real has answered the rest.
            _ => self.wheel_angle_rad(),
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
            Value::Boolean(value) if variable == PlantVariable::SensorsHeld => {
                settings.sensors_held = value;
            }
            Value::Boolean(value) => settings.friction_limited = value,
            Value::Integer(value) => settings.seed = value,
            Value::String(_) => {}
        }
    }

    fn initialise(&mut self, _start_time_s: f64) -> Result<(), &'static str> {
        let settings = &self.settings;
        let command_rad = settings.admitted(PlantVariable::SteeringAngle);
        self.state = State::new(&settings.world(), STEP_S, settings.initial.into(), command_rad);
        self.readings = Readings::default();
        self.step = 0;
        self.started = true;
        self.sample_sensors();
        Ok(())
    }

    fn sample(&mut self, log: &Log<'_>) -> Status {
        let settings = &self.settings;
        if let Some((row, value)) = settings.refused_input() {
            log.error(|text| {
                text.str("the vehicle cannot go on: input \"")
                    .str(row.name)
                    .str("\" is ")
                    .real(value);
                if let Kind::Real(RealKind { unit, min: Some(min), max: Some(max), .. }) = row.kind
                {
                    text.str(" ").str(unit.name).str(", allowed is ").real(min);
                    text.str(" to ").real(max);
                }
            });
            return Status::Error;
        }
        let world = settings.world();
        let Inputs { drive_torque_n_m, steering_rad, fault_rad, side_force_n, yaw_moment_n_m } =
            settings.inputs;
        let excitation = Excitation {
            drive_torque_n_m,
            command_rad: steering_rad,
            fault_rad,
            push: world.vehicle.push(side_force_n, yaw_moment_n_m),
        };
        let (motion, angle_rad) = (self.state.motion, self.state.steering.angle_rad);
        self.state.step(&world, &excitation, STEP_S);
        if !plausible(&self.state) {
            self.state.motion = motion;
            self.state.steering.angle_rad = angle_rad;
            let [v_x, v_y, r] = motion.vector();
            log.error(|text| {
                text.str("the motion leaves the finite numbers after v_x = ").real(v_x);
                text.str(" m/s, v_y = ").real(v_y).str(" m/s, r = ").real(r).str(" rad/s: ");
                text.str("vehicle.* and inputs are too far from those of a vehicle");
            });
            return Status::Error;
        }
        // A restored state may say anything.
        self.step = self.step.wrapping_add(1);
        self.sample_sensors();
        Status::Ok
    }

    fn archive(&mut self, archive: &mut Archive<'_>) {
        for &variable in PlantVariable::ALL {
            if let Some(value) = self.settings.real(variable) {
                archive.real(value);
                // Inputs may be anything: the step refuses them.
                let row = PlantVariable::TABLE.get(variable as usize);
                archive.require(row.is_some_and(|row| {
                    row.role == Role::INPUT || row.kind.admits(Value::Real(*value))
                }));
            }
        }
        archive.flag(&mut self.settings.friction_limited);
        archive.flag(&mut self.settings.sensors_held);
        let mut seed = self.settings.seed.cast_unsigned();
        archive.u32(&mut seed);
        self.settings.seed = seed.cast_signed();

        archive.flag(&mut self.started);
        let VehicleState { v_x_m_per_s, v_y_m_per_s, r_rad_per_s } = &mut self.state.motion;
        for value in [v_x_m_per_s, v_y_m_per_s, r_rad_per_s] {
            archive.real(value);
        }
        archive.real(&mut self.state.steering.angle_rad);
        archive.require(plausible(&self.state));
        let steering = &mut self.state.steering;
        archive.size(&mut steering.dead_time_steps);
        archive.size(&mut steering.oldest);
        archive.require(
            steering.dead_time_steps <= MAX_DEAD_TIME_STEPS
                && steering.oldest < steering.dead_time_steps.max(1),
        );
        for command in steering.commands_rad.iter_mut().take(steering.dead_time_steps) {
            archive.finite(command);
        }
        archive.optional(&mut self.readings.number, Archive::u64);
        for value in &mut self.readings.values {
            archive.finite(value);
        }
        archive.u64(&mut self.step);
    }
}
