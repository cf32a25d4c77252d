//! A detector driven in the simulated [world](steerguard_world): the loop of calibration and of the
//! verdict on sight.
//!
//! # Conventions
//! Inputs and forces on the body are held from sample to sample, disturbances and faults for an integration step; of a
//! specification with an actuator the steering is its command. The sensors' white noise is that of the
//! specification.

use steerguard_detector::{Detector, Input, Measurement, StateVector, VehicleState};
use steerguard_world::{
    Course, Excitation, STEP_S, Sensor, Sensors, State, Steering, TrueVehicle, World,
};

use crate::spec::{Noise, Spec};

/// What a drive takes place in, and how its sensors err.
pub struct Surroundings {
    /// Vehicle, steering and road.
    pub world: World,
    /// Relative error of the speed shown.
    pub v_x_scale: f64,
    /// Yaw rate shown at standstill.
    pub yaw_rate_bias_rad_per_s: f64,
}

impl Surroundings {
    /// The vehicle as specified, on linear tyres, on a flat road in still air.
    pub fn specified(spec: &Spec) -> Self {
        let zero = spec.sensors.zero();
        Self {
            world: World::of(
                TrueVehicle::linear(spec.vehicle),
                Steering {
                    offset_rad: zero.steering_offset_rad,
                    ..Steering::of(spec.actuator.actuator())
                },
            ),
            v_x_scale: 0.0,
            yaw_rate_bias_rad_per_s: zero.yaw_rate_bias_rad_per_s,
        }
    }

    /// Sensors that err so, with the white noise of the given seed.
    pub fn sensors(&self, noise: &Noise, period_s: f64, seed: u64) -> Sensors {
        let [v_x_std, r_std] = noise.white_std();
        let sensors = [
            Sensor { noise_std: v_x_std, scale: self.v_x_scale, ..Sensor::default() },
            Sensor { noise_std: r_std, bias: self.yaw_rate_bias_rad_per_s, ..Sensor::default() },
        ];
        Sensors { sensors, period_s, held: false, seed }
    }
}

/// Steering and speed of a drive, as functions of time in s.
pub trait Driving {
    /// Commanded road-wheel angle, rad.
    fn steering_rad(&self, t: f64) -> f64;

    /// Drive torque at the wheels at the measured speed `v_x` in m/s, N m.
    fn drive_torque_n_m(&self, t: f64, v_x: f64) -> f64;
}

impl Driving for Course {
    fn steering_rad(&self, t: f64) -> f64 {
        self.steering_rad(t)
    }

    fn drive_torque_n_m(&self, t: f64, v_x: f64) -> f64 {
        self.drive_torque_n_m(t, v_x)
    }
}

/// What acts in a drive beside its course, as functions of time in s.
pub trait Acting {
    /// Side force in N and yaw moment in N m at speed `v_x` in m/s, held for a sample.
    fn on_body(&self, _t: f64, _v_x: f64) -> [f64; 2] {
        [0.0; 2]
    }

    /// Added to the readings `[v_x, r]`, m/s and rad/s.
    fn on_measurement(&self, _t: f64) -> [f64; 2] {
        [0.0; 2]
    }

    /// Added to the state's derivative.
    fn on_vehicle(&self, _t: f64) -> StateVector {
        [0.0; 3]
    }

    /// Steering fault, rad.
    fn fault_rad(&self, _t: f64) -> f64 {
        0.0
    }
}

/// A drive to simulate.
pub struct Simulation<D> {
    /// Where it takes place.
    pub surroundings: Surroundings,
    /// Its sensors.
    pub sensors: Sensors,
    /// Its course.
    pub course: D,
    /// State of the vehicle at its start.
    pub start: VehicleState,
    /// Sampling period, s.
    pub period_s: f64,
    /// Its length in samples.
    pub samples: u64,
}

impl<D: Driving> Simulation<D> {
    /// Drives `detector`, with what is `acting`; `sampled` sees each sample once the detector has had it.
    pub fn run(
        &self,
        detector: &mut Detector,
        acting: &impl Acting,
        mut sampled: impl FnMut(&Sampled<'_>),
    ) {
        let Self { surroundings, sensors, course, period_s, .. } = self;
        let world = &surroundings.world;
        let steps = (period_s / STEP_S).ceil().max(1.0);
        let step_s = period_s / steps;
        let mut state = State::new(world, step_s, self.start, course.steering_rad(0.0));
        for k in 0..self.samples {
            let t = k as f64 * period_s;
            let [v_x, r] = sensors.readings(k, state.motion.measured().vector());
            let [on_v_x, on_r] = acting.on_measurement(t);
            let measured = Measurement { v_x_m_per_s: v_x + on_v_x, r_rad_per_s: r + on_r };
            let u = Input {
                t_eng_n_m: course.drive_torque_n_m(t, measured.v_x_m_per_s),
                delta_rad: course.steering_rad(t),
            };
            detector.sample(measured, u);
            sampled(&Sampled { number: k, detector, state: &state, input: u });
            let [side_force_n, yaw_moment_n_m] = acting.on_body(t, state.motion.v_x_m_per_s);
            let on_body = world.vehicle.push(side_force_n, yaw_moment_n_m);
            for inner in 0..steps as u32 {
                let t = t + f64::from(inner) * step_s;
                let excitation = Excitation {
                    drive_torque_n_m: u.t_eng_n_m,
                    command_rad: u.delta_rad,
                    fault_rad: acting.fault_rad(t),
                    push: plus(on_body, acting.on_vehicle(t)),
                };
                state.step(world, &excitation, step_s);
            }
        }
    }
}

/// A sample of a drive.
pub struct Sampled<'a> {
    /// Its number.
    pub number: u64,
    /// The detector after it.
    pub detector: &'a Detector,
    /// Where the drive stands at its time.
    pub state: &'a State,
    /// The input from then on.
    pub input: Input,
}

/// Sum of two changes of the state.
pub fn plus(a: StateVector, b: StateVector) -> StateVector {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}
