//! Continuous dynamics of the reference vehicle, and its integration.
//!
//! (1)-(2) of the paper with what the detector does not know of: steering fault, disturbances, road
//! bank, an actuator with dead time, lag and rate limit, tyres that saturate.
//!
//! # Conventions
//! - As the detector's: ISO 8855 axes, SI units, angles at the road wheel.
//! - Internal state `[v_x, v_y, r, delta_w]`, delta_w being the actuator's angle before the fault.

use steerguard_detector::{StateVector, Vehicle, rk4};

/// Step of the Runge-Kutta integration, s.
pub const INTERNAL_STEP_S: f64 = 1e-3;

/// Longest dead time of the actuator, internal steps.
pub const MAX_DEAD_TIME_STEPS: usize = 1500;

/// Below this speed, m/s, slip angles are taken at this speed: 1/v_x has no meaning at standstill.
pub const SLIP_SPEED_FLOOR_M_PER_S: f64 = 0.5;

const GRAVITY_M_PER_S2: f64 = 9.81;

/// Internal state `[v_x, v_y, r, delta_w]` in m/s, m/s, rad/s, rad.
pub type PlantState = [f64; 4];

/// What acts on the vehicle, constant over an internal step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Excitation {
    /// Drive torque at the wheels, N m.
    pub t_eng: f64,
    /// Road-wheel angle that the actuator is to reach, after its dead time, rad.
    pub delta: f64,
    /// Steering fault, added to the actuator's angle, rad.
    pub fault: f64,
    /// Lateral disturbance force at the centre of gravity, N.
    pub side_force: f64,
    /// Disturbance yaw moment, N m.
    pub yaw_moment: f64,
}

/// Vehicle, tyres, road and actuator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dynamics {
    /// Vehicle data.
    pub vehicle: Vehicle,
    /// Whether friction limits the axle forces; otherwise tyres are linear.
    pub friction_limited: bool,
    /// Friction coefficient.
    pub friction: f64,
    /// Time constant of the steering actuator's first-order lag, s; below an internal step there is
    /// none.
    pub actuator_lag_s: f64,
    /// Fastest turn of the road wheel by the actuator, rad/s; 0 for no limit.
    pub actuator_rate_limit: f64,
    /// Road bank, rad, positive where gravity pulls to the left.
    pub bank_rad: f64,
}

impl Dynamics {
    /// The state one internal step later.
    pub fn step(&self, mut state: PlantState, excitation: &Excitation) -> PlantState {
        let limit = self.actuator_rate_limit;
        let limited = |rate: f64| if limit > 0.0 { rate.max(-limit).min(limit) } else { rate };
        let lag_s = self.actuator_lag_s;
        let lags = lag_s >= INTERNAL_STEP_S;
        if !lags && limit <= 0.0 {
            state[3] = excitation.delta;
        }
        // Without lag the angle moves evenly, to arrive with the step if the limit lets it.
        let even = limited((excitation.delta - state[3]) / INTERNAL_STEP_S);
        let wheel_rate =
            |delta_w| if lags { limited((excitation.delta - delta_w) / lag_s) } else { even };
        let bank_m_per_s2 = GRAVITY_M_PER_S2 * libm::sin(self.bank_rad);
        let derivative = |x: PlantState| {
            let [v_x, v_y, r] = self.derivative(x, excitation, bank_m_per_s2);
            [v_x, v_y, r, wheel_rate(x[3])]
        };
        rk4(derivative, state, INTERNAL_STEP_S)
    }

    /// `d[v_x, v_y, r]/dt` on a road whose bank accelerates the vehicle sideways by `bank_m_per_s2`.
    // Inlined: between the stages of rk4 the state stays in registers, a quarter of the time saved.
    #[inline(always)]
    fn derivative(
        &self,
        [v_x, v_y, r, delta_w]: PlantState,
        e: &Excitation,
        bank_m_per_s2: f64,
    ) -> StateVector {
        let vehicle = &self.vehicle;
        let at_speed = [v_x.max(SLIP_SPEED_FLOOR_M_PER_S), v_y, r].into();
        let forces = self.saturate(vehicle.axle_forces(at_speed, delta_w + e.fault));
        let [v_x_dot, v_y_dot, r_dot] =
            vehicle.derivative_under([v_x, v_y, r].into(), e.t_eng, forces);
        [
            v_x_dot,
            v_y_dot + e.side_force / vehicle.mass_kg + bank_m_per_s2,
            r_dot + e.yaw_moment / vehicle.yaw_inertia_kg_m2,
        ]
    }

    /// Axle forces limited by friction: `mu F_z tanh(F / (mu F_z))` at the static axle load F_z.
    fn saturate(&self, [front, rear]: [f64; 2]) -> [f64; 2] {
        if !self.friction_limited {
            return [front, rear];
        }
        let v = &self.vehicle;
        let load_per_distance =
            v.mass_kg * GRAVITY_M_PER_S2 / (v.front_axle_distance_m + v.rear_axle_distance_m);
        let limited = |force: f64, other_axle_distance_m: f64| {
            let limit = self.friction * load_per_distance * other_axle_distance_m;
            limit * libm::tanh(force / limit)
        };
        [limited(front, v.rear_axle_distance_m), limited(rear, v.front_axle_distance_m)]
    }
}

/// Dead time of the actuator in internal steps: the commanded angles of the last ones, in a ring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeadTime {
    /// Commanded angles, rad; the first `steps` entries are in use.
    pub angles: [f64; MAX_DEAD_TIME_STEPS],
    /// Place of the oldest angle.
    pub oldest: usize,
    /// Dead time, internal steps.
    pub steps: usize,
}

impl DeadTime {
    /// A dead time of `duration_s`, rounded to internal steps, during which `angle` acts.
    pub fn new(duration_s: f64, angle: f64) -> Self {
        let steps = libm::round(duration_s / INTERNAL_STEP_S) as usize;
        Self {
            angles: [angle; MAX_DEAD_TIME_STEPS],
            oldest: 0,
            steps: steps.min(MAX_DEAD_TIME_STEPS),
        }
    }

    /// Takes the angle of this step and gives the one that acts in it.
    pub fn pass(&mut self, angle: f64) -> f64 {
        let ring = self.angles.get_mut(..self.steps).unwrap_or_default();
        let Some(place) = ring.get_mut(self.oldest) else {
            return angle;
        };
        self.oldest = if self.oldest + 1 < self.steps { self.oldest + 1 } else { 0 };
        core::mem::replace(place, angle)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LINEAR: Dynamics = Dynamics {
        vehicle: Vehicle::PAPER,
        friction_limited: false,
        friction: 0.3,
        actuator_lag_s: 0.0,
        actuator_rate_limit: 0.0,
        bank_rad: 0.0,
    };

    fn run(dynamics: &Dynamics, excitation: &Excitation, steps: u32) -> PlantState {
        (0..steps).fold([15.0, 0.0, 0.0, 0.0], |x, _| dynamics.step(x, excitation))
    }

    #[test]
    fn a_fault_acts_as_the_same_commanded_angle() {
        let cruise = Vehicle::PAPER.cruise_torque(15.0);
        let commanded = Excitation { t_eng: cruise, delta: 0.01, ..Excitation::default() };
        let faulty = Excitation { t_eng: cruise, fault: 0.01, ..Excitation::default() };
        assert_eq!(run(&LINEAR, &commanded, 5000)[..3], run(&LINEAR, &faulty, 5000)[..3]);
    }

    #[test]
    fn steady_cornering_has_the_bicycle_models_yaw_rate() {
        // r = v delta / (l + K v^2), K = M (l_r C_r - l_f C_f) / (2 l C_f C_r): Rajamani (2012), 3.
        let v = Vehicle::PAPER;
        let (l_f, l_r) = (v.front_axle_distance_m, v.rear_axle_distance_m);
        let (c_f, c_r) =
            (v.front_cornering_stiffness_n_per_rad, v.rear_cornering_stiffness_n_per_rad);
        let l = l_f + l_r;
        let gradient = v.mass_kg * (l_r * c_r - l_f * c_f) / (2.0 * l * c_f * c_r);
        let excitation =
            Excitation { t_eng: v.cruise_torque(15.0), delta: 0.01, ..Excitation::default() };
        let [v_x, _, r, _] = run(&LINEAR, &excitation, 5000);
        let expected = v_x * 0.01 / (l + gradient * v_x * v_x);
        assert!((r / expected - 1.0).abs() < 1e-3, "{r} rad/s instead of {expected}");
    }

    #[test]
    fn saturation_vanishes_at_small_slip_and_bounds_large() {
        let slick = Dynamics { friction_limited: true, ..LINEAR };
        let [front, rear] = slick.saturate([10.0, -10.0]);
        assert!((front - 10.0).abs() < 1e-3 && (rear + 10.0).abs() < 1e-3);
        let [front, rear] = slick.saturate([1e6, -1e6]);
        let weight = Vehicle::PAPER.mass_kg * GRAVITY_M_PER_S2;
        assert!((front - rear - 0.3 * weight).abs() < 1e-6 * weight);
    }

    #[test]
    fn actuator_lag_is_first_order() {
        let lagging = Dynamics { actuator_lag_s: 0.1, ..LINEAR };
        let excitation = Excitation { delta: 0.02, ..Excitation::default() };
        let [_, _, _, delta_w] = run(&lagging, &excitation, 100);
        assert!((delta_w - 0.02 * (1.0 - (-1.0_f64).exp())).abs() < 1e-10);
    }

    #[test]
    fn a_limited_actuator_ramps_then_lags() {
        let excitation = Excitation { delta: 0.05, ..Excitation::default() };
        let angle = |actuator_lag_s, steps| {
            let limited = Dynamics { actuator_lag_s, actuator_rate_limit: 0.2, ..LINEAR };
            run(&limited, &excitation, steps)[3]
        };
        assert!((angle(0.0, 100) - 0.02).abs() < 1e-12);
        assert!((angle(0.0, 250) - 0.05).abs() < 1e-12);
        assert!((angle(0.0, 1000) - 0.05).abs() < 1e-12);
        // Behind by more than 0.1 s x 0.2 rad/s for 0.15 s, then by that times exp(-t / 0.1 s).
        assert!((angle(0.1, 150) - 0.03).abs() < 1e-12);
        assert!((angle(0.1, 250) - (0.05 - 0.02 * (-1.0_f64).exp())).abs() < 1e-10);
    }

    #[test]
    fn the_shortest_lags_are_stable() {
        for actuator_lag_s in [1e-9, 1e-4, 9e-4, 1e-3] {
            let excitation = Excitation { delta: 0.02, ..Excitation::default() };
            let [.., delta_w] = run(&Dynamics { actuator_lag_s, ..LINEAR }, &excitation, 20);
            assert!((delta_w - 0.02).abs() < 1e-9, "{actuator_lag_s}: {delta_w}");
        }
    }

    #[test]
    fn dead_time_delays_by_its_duration() {
        for steps in [0_u16, 1, 7, 1500] {
            let mut dead_time = DeadTime::new(f64::from(steps) * INTERNAL_STEP_S, -1.0);
            for k in 0..3600 {
                let expected = if k < steps { -1.0 } else { f64::from(k - steps) };
                assert_eq!(dead_time.pass(f64::from(k)), expected);
            }
        }
    }
}
