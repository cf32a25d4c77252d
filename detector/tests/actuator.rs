//! The actuator against its definition, and its place in the detector.

#![allow(clippy::unwrap_used)]

mod common;

use common::{configuration, u, y};
use proptest::prelude::*;
use steerguard_detector::{
    Actuator, ActuatorState, Detector, Input, MAX_DELAY_SAMPLES, Measurement, Monitor,
};
use steerguard_test_support::integration::rk4;

const PERIOD_S: f64 = 0.01;
/// Steps of the simulation to a sample: dead times are whole numbers of them.
const STEPS: usize = 500;
const STEP_S: f64 = PERIOD_S / STEPS as f64;
const SLOW: Actuator = Actuator {
    lag_s: 0.05,
    delay_s: 0.037,
    rate_limit_rad_per_s: Some(0.4),
    angle_limit_rad: None,
};

/// The averages over the samples of `commands`.
fn averages(actuator: &Actuator, period_s: f64, commands: &[f64]) -> Vec<f64> {
    let mut state = ActuatorState::START;
    commands.iter().map(|&command| state.sample(actuator, period_s, command)).collect()
}

/// The same by integration in small steps: `delay` of them dead, then `dx/dt = (u - x) / lag` with
/// the speed limited.
fn simulated(actuator: &Actuator, delay: usize, commands: &[f64]) -> Vec<f64> {
    let limit = actuator.rate_limit_rad_per_s.unwrap_or(f64::INFINITY);
    let mut x = commands[0];
    let mut step = |n: usize| {
        let u = commands[n.saturating_sub(delay) / STEPS];
        let before = x;
        if actuator.lag_s > 0.0 {
            let rate = |[x]: [f64; 1]| [((u - x) / actuator.lag_s).clamp(-limit, limit)];
            [x] = rk4(rate, [x], STEP_S);
        } else {
            x += (u - x).clamp(-limit * STEP_S, limit * STEP_S);
        }
        // Without lag and limit the angle jumps.
        if actuator.lag_s > 0.0 || limit.is_finite() { 0.5 * (before + x) } else { x }
    };
    let samples = 0..commands.len();
    samples.map(|k| (0..STEPS).map(|i| step(k * STEPS + i)).sum::<f64>() / STEPS as f64).collect()
}

fn commands() -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(-0.1..0.1, 1..40)
}

fn lag_s() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), 0.3 * PERIOD_S..20.0 * PERIOD_S]
}

fn rate_limit() -> impl Strategy<Value = Option<f64>> {
    prop::option::of(0.05..5.0)
}

proptest! {
    #[test]
    fn the_average_is_that_of_a_simulation_in_small_steps(
        commands in commands(),
        lag_s in lag_s(),
        delay in prop_oneof![Just(0), 1..10 * STEPS],
        rate_limit_rad_per_s in rate_limit(),
    ) {
        let actuator = Actuator { lag_s, delay_s: delay as f64 * STEP_S, rate_limit_rad_per_s, angle_limit_rad: None };
        let found = averages(&actuator, PERIOD_S, &commands);
        for (k, (x, expected)) in found.iter().zip(simulated(&actuator, delay, &commands)).enumerate() {
            prop_assert!((x - expected).abs() < 2e-6, "sample {k}: {x}, simulated {expected}");
        }
    }

    /// For a held command the solution is exact: halving the samples changes nothing.
    #[test]
    fn samples_of_half_the_length_have_the_same_averages(
        commands in commands(),
        lag_s in lag_s(),
        delay_s in 0.0..0.1_f64,
        rate_limit_rad_per_s in rate_limit(),
    ) {
        let actuator = Actuator { lag_s, delay_s, rate_limit_rad_per_s, angle_limit_rad: None };
        let twice: Vec<f64> = commands.iter().flat_map(|&command| [command, command]).collect();
        let halves = averages(&actuator, 0.5 * PERIOD_S, &twice);
        let whole = averages(&actuator, PERIOD_S, &commands);
        for (x, halves) in whole.iter().zip(halves.chunks(2)) {
            prop_assert!((x - 0.5 * (halves[0] + halves[1])).abs() < 1e-12);
        }
    }

    #[test]
    fn no_actuator_leaves_every_bit(commands in prop::collection::vec(any::<f64>(), 1..10)) {
        for (x, command) in averages(&Actuator::NONE, PERIOD_S, &commands).iter().zip(&commands) {
            prop_assert_eq!(x.to_bits(), command.to_bits());
        }
    }

    /// Extreme numbers too leave the angle between the commands.
    #[test]
    fn the_angle_stays_between_the_commands(
        commands in prop::collection::vec(-1e9..1e9_f64, 1..30),
        lag_s in prop_oneof![Just(0.0), Just(1e-300), 1e-9..1e9_f64],
        delay_s in 0.0..=256.0 * PERIOD_S,
        rate_limit_rad_per_s in prop::option::of(prop_oneof![1e-300..1.0_f64, 1.0..1e300_f64]),
    ) {
        let actuator = Actuator { lag_s, delay_s, rate_limit_rad_per_s, angle_limit_rad: None };
        let (min, max) = commands.iter().fold((f64::MAX, f64::MIN), |(a, b), &u| (a.min(u), b.max(u)));
        let slack = 1e-9 * (1.0 + lag_s / PERIOD_S) * (max - min) + 1e-9 * max.abs();
        for x in averages(&actuator, PERIOD_S, &commands) {
            prop_assert!(min - slack <= x && x <= max + slack, "{x}");
        }
    }
}

#[test]
fn the_longest_dead_time_is_held_to_its_last_part() {
    let delay_s = MAX_DELAY_SAMPLES as f64 * PERIOD_S;
    let step: Vec<f64> = (0..400).map(|k| f64::from(u8::from(k >= 100))).collect();
    let found = averages(&Actuator { delay_s, ..Actuator::NONE }, PERIOD_S, &step);
    let first = found.iter().position(|&x| x > 0.5);
    assert_eq!(first, Some(100 + MAX_DELAY_SAMPLES));
}

/// A drive in a turn that leaves the range and returns, and loses a signal now and then.
fn drive(k: u32) -> (Measurement, Input) {
    let t = f64::from(k);
    let v_x = if (200..300).contains(&k) { 4.0 } else { 15.0 };
    (y(v_x, 0.1 * (0.05 * t).sin()), u(78.75, 0.05 * (0.05 * t).cos()))
}

#[test]
fn the_observer_is_given_the_angle_at_the_wheel() {
    let commanded = configuration();
    let mut actuator = ActuatorState::START;
    let mut measured = Detector::new(&commanded).unwrap();
    let mut commanded =
        Detector::new(&steerguard_detector::Configuration { actuator: SLOW, ..commanded }).unwrap();
    for k in 0..600 {
        let (y, Input { t_eng_n_m, delta_rad: command }) = drive(k);
        let delta = actuator.sample(&SLOW, PERIOD_S, command);
        let expected = *measured.sample(y, u(t_eng_n_m, delta));
        assert_eq!(*commanded.sample(y, u(t_eng_n_m, command)), expected, "sample {k}");
    }
    assert_eq!(commanded.output().monitor, Monitor::Monitoring);
}

#[test]
fn an_invalid_command_leaves_the_last_one_standing() {
    let configuration = steerguard_detector::Configuration { actuator: SLOW, ..configuration() };
    for bad in [f64::NAN, f64::INFINITY, -1e9] {
        let [mut lost, mut held] = [0; 2].map(|_| Detector::new(&configuration).unwrap());
        // Before the first command there is none to hold: the actuator settles at the first.
        lost.sample(y(15.0, 0.0), u(78.75, bad));
        let mut last = 0.0;
        for k in 0..600 {
            let (y, Input { t_eng_n_m, delta_rad: command }) = drive(k);
            let gap = k % 50 > 45;
            last = if gap { last } else { command };
            let monitor = lost.sample(y, u(t_eng_n_m, if gap { bad } else { command })).monitor;
            assert_eq!(monitor == Monitor::InvalidInput, gap);
            held.sample(y, u(t_eng_n_m, last));
            assert_eq!(lost.state().actuator, held.state().actuator, "sample {k}");
        }
    }
}

#[test]
fn a_lost_measurement_loses_no_command() {
    let configuration = steerguard_detector::Configuration { actuator: SLOW, ..configuration() };
    let [mut lost, mut seen] = [0; 2].map(|_| Detector::new(&configuration).unwrap());
    for k in 0..600 {
        let (y, u) = drive(k);
        lost.sample(if k % 50 > 45 { Measurement { v_x_m_per_s: f64::NAN, ..y } } else { y }, u);
        seen.sample(y, u);
        assert_eq!(lost.state().actuator, seen.state().actuator, "sample {k}");
    }
}
