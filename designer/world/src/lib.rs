//! The one simulated world: every vehicle that is driven in a computer is driven here.
//!
//! What a detector does not know of is in it: steering faults, tyres that saturate, axle loads that
//! shift, an actuator with dead time, lag and limits, bank, gusts, sensors that err. Calibration, the
//! plant FMU, reference files, co-simulation and campaigns share it, so that a threshold is judged in
//! the world that it was set in.
//!
//! # Conventions
//! - As the detector's: ISO 8855 axes, SI units, angles at the road wheel, left positive.
//! - A bank is positive with the left side raised: gravity then pulls to the right.
//! - Nothing here keeps a random generator: random numbers are functions of seed, stream and number.
//! - Sine, exponential and the like are those of `libm`: the same bits on every machine.
//! - The world is left-right symmetric: mirrored inputs give the mirrored drive, to the last bit.
//! - No allocation, and no panic whatever the numbers.
#![no_std]
#![forbid(unsafe_code)]

mod course;
mod fault;
mod integration;
mod random;
mod road;
mod sensor;
mod steering;
mod tyre;
mod vehicle;
mod wind;

pub use course::{Course, Manoeuvre, Plan, speed_control_n_m, steady_angle};
pub use fault::{Fault, FaultKind};
pub use random::Stream;
pub use road::bank_m_per_s2;
pub use sensor::{Readings, Sensor, Sensors, held_sample};
pub use steering::{MAX_DEAD_TIME_STEPS, Steering, SteeringState};
pub use tyre::Tyres;
pub use vehicle::TrueVehicle;
pub use wind::{CALM_S, GUST_S, Gusts, Wind};

use integration::Dynamics;
pub use steerguard_detector::GRAVITY_M_PER_S2;
use steerguard_detector::{StateVector, VehicleState};

/// Longest step that the vehicle is integrated by, s.
pub const STEP_S: f64 = 1e-3;

/// What is constant in a drive: vehicle, steering and road.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct World {
    /// The vehicle on its tyres.
    pub vehicle: TrueVehicle,
    /// What turns the road wheel.
    pub steering: Steering,
    /// Road bank, rad, positive with the left side raised.
    pub bank_rad: f64,
}

impl World {
    /// `vehicle` with `steering` on a flat road.
    pub const fn of(vehicle: TrueVehicle, steering: Steering) -> Self {
        Self { vehicle, steering, bank_rad: 0.0 }
    }
}

/// What acts on the vehicle, constant over a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Excitation {
    /// Drive torque at the wheels, N m.
    pub drive_torque_n_m: f64,
    /// Commanded road-wheel angle, rad.
    pub command_rad: f64,
    /// Steering fault: added to the actuator's angle, rad.
    pub fault_rad: f64,
    /// What else adds to `d[v_x, v_y, r]/dt`, m/s^2, m/s^2, rad/s^2.
    pub push: StateVector,
}

/// Where a drive stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// The vehicle.
    pub motion: VehicleState,
    /// The steering.
    pub steering: SteeringState,
}

impl State {
    /// The beginning of a drive in `world` by steps of `step_s`: the steering has settled at
    /// `command_rad`.
    pub fn new(world: &World, step_s: f64, motion: VehicleState, command_rad: f64) -> Self {
        Self { motion, steering: SteeringState::new(&world.steering, step_s, command_rad) }
    }

    /// Goes on by a step of `step_s`, at most [`STEP_S`].
    pub fn step(&mut self, world: &World, excitation: &Excitation, step_s: f64) {
        let Excitation { drive_torque_n_m, command_rad, fault_rad, push } = *excitation;
        let angles = self.steering.step(&world.steering, step_s, command_rad);
        let bank_m_per_s2 = bank_m_per_s2(world.bank_rad);
        let [p_x, p_y, p_r] = push;
        let push = [p_x, p_y + bank_m_per_s2, p_r];
        let held = Held { vehicle: &world.vehicle, drive_torque_n_m, fault_rad, push };
        self.motion = integration::rk4(&held, self.motion.vector(), angles, step_s).into();
    }
}

/// A vehicle under what is constant in a step; the steering's angle is its input.
struct Held<'a> {
    vehicle: &'a TrueVehicle,
    drive_torque_n_m: f64,
    fault_rad: f64,
    push: StateVector,
}

impl Dynamics<3> for Held<'_> {
    #[inline(always)]
    fn derivative(&self, x: StateVector, angle_rad: f64) -> StateVector {
        let Self { vehicle, drive_torque_n_m, fault_rad, push } = *self;
        vehicle.derivative(x.into(), drive_torque_n_m, angle_rad + fault_rad, push)
    }
}
