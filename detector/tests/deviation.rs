//! Deviations from the model: what is taken out of the residual, and what raises the threshold.

#![allow(clippy::unwrap_used)]

mod common;

use common::{u, y};
use proptest::prelude::*;
use steerguard_detector::{
    Actuator, ActuatorState, Configuration, Detector, Deviations, Evaluation, Gust, Input, Monitor,
    Output, StateVector, TsModel, Uncertainty, Vehicle,
};
use steerguard_test_support::integration::rk4;

const NOMINAL: Vehicle = Vehicle::PAPER;
const T_S: f64 = TsModel::PAPER.sampling_period_s;
const LEVEL: f64 = 1e-5;

fn configuration(deviations: Deviations) -> Configuration {
    let configuration = common::configuration();
    Configuration {
        evaluation: Evaluation {
            weights: [0.1, 1.0],
            threshold: LEVEL,
            start_up_amplitude: 0.0,
            ..configuration.evaluation
        },
        deviations,
        ..configuration
    }
}

/// A weave of 0.3 Hz at about `v_x`.
fn weave(v_x: f64, k: u32, amplitude: f64) -> Input {
    let t = f64::from(k) * T_S;
    u(NOMINAL.cruise_torque(v_x), amplitude * (std::f64::consts::TAU * 0.3 * t).sin())
}

/// The outputs of a detector that watches `step` from straight ahead at `v_x` for ten seconds.
fn watch(
    deviations: Deviations,
    v_x: f64,
    amplitude: f64,
    step: impl Fn(StateVector, Input) -> StateVector,
) -> Vec<Output> {
    let mut detector = Detector::new(&configuration(deviations)).unwrap();
    let mut x = [v_x, 0.0, 0.0];
    (0..1000)
        .map(|k| {
            let u = weave(v_x, k, amplitude);
            let output = *detector.sample(y(x[0], x[2]), u);
            x = step(x, u);
            output
        })
        .collect()
}

/// Continuous time: ten Runge-Kutta steps a sample.
fn continuous(vehicle: &Vehicle, x: StateVector, u: Input) -> StateVector {
    (0..10).fold(x, |x, _| rk4(|x| vehicle.derivative(x.into(), u), x, T_S / 10.0))
}

/// Euler's step with a further slope: what the model (7) is for another vehicle.
fn euler(vehicle: &Vehicle, x: StateVector, u: Input, further: StateVector) -> StateVector {
    let slope = vehicle.derivative(x.into(), u);
    [0, 1, 2].map(|i| x[i] + T_S * (slope[i] + further[i]))
}

fn largest_j(outputs: &[Output]) -> f64 {
    outputs.iter().map(|output| output.j_rms).fold(0.0, f64::max)
}

#[test]
fn the_correction_takes_out_most_of_eulers_remainder() {
    let corrected = Deviations { euler_correction: true, ..Deviations::NONE };
    for (v_x, amplitude, at_most) in [(6.0, 0.1, 0.15), (15.0, 0.04, 0.08), (29.0, 0.02, 0.08)] {
        let step = |x, u| continuous(&NOMINAL, x, u);
        let plain = largest_j(&watch(Deviations::NONE, v_x, amplitude, step));
        let left = largest_j(&watch(corrected, v_x, amplitude, step));
        assert!(left < at_most * plain, "{left} of {plain} at {v_x} m/s");
    }
}

#[test]
fn what_is_known_raises_no_threshold() {
    let outputs = watch(Deviations::NONE, 15.0, 0.04, |x, u| euler(&NOMINAL, x, u, [0.0; 3]));
    assert!(outputs.iter().all(|output| output.j_th == LEVEL && output.detectability == 0.0));
}

#[test]
fn the_threshold_rises_with_the_manoeuvre_and_sinks_after_it() {
    let uncertainty = Uncertainty { front_cornering_stiffness: 0.1, ..Uncertainty::NONE };
    let deviations = Deviations { uncertainty, ..Deviations::NONE };
    let mut detector = Detector::new(&configuration(deviations)).unwrap();
    let mut x = [15.0, 0.0, 0.0];
    let mut j_th = Vec::new();
    for k in 0..3000 {
        let Input { t_eng_n_m, delta_rad } = weave(15.0, k, 0.04);
        let u = u(t_eng_n_m, if k < 1000 { delta_rad } else { 0.0 });
        j_th.push(detector.sample(y(x[0], x[2]), u).j_th);
        x = euler(&NOMINAL, x, u, [0.0; 3]);
    }
    assert_eq!(j_th[0], LEVEL);
    assert!(j_th[500] > 10.0 * LEVEL);
    assert!(j_th[2999] < 1.01 * LEVEL, "{}", j_th[2999]);
}

#[test]
fn detectability_is_the_j_of_the_smallest_fault_over_the_threshold() {
    let fault_rad = 0.5_f64.to_radians();
    let deviations = Deviations {
        smallest_fault: TsModel::PAPER.b().map(|row| row[1] * fault_rad),
        ..Deviations::NONE
    };
    let faulty = |x, commanded: Input| {
        euler(&NOMINAL, x, u(commanded.t_eng_n_m, commanded.delta_rad + fault_rad), [0.0; 3])
    };
    let outputs = watch(deviations, 15.0, 0.0, faulty);
    let Output { j_rms, j_th, detectability, .. } = outputs[300];
    assert!(detectability > 1.0, "excited");
    // First order in the error: the turn that the fault makes changes the premise.
    assert!((detectability * j_th / j_rms - 1.0).abs() < 0.02, "{detectability} {j_rms} {j_th}");
    assert_eq!(outputs[0].detectability, 0.0);
}

#[test]
fn an_actuator_slower_than_modelled_stays_below_the_threshold() {
    let lag = |lag_s| Actuator { lag_s, ..Actuator::NONE };
    let uncertainty = Uncertainty { actuator_lag_s: 0.1, ..Uncertainty::NONE };
    let deviations = Deviations { uncertainty, ..Deviations::NONE };
    for lag_s in [0.03, 0.06, 0.1] {
        let mut detector = Detector::new(&configuration(deviations)).unwrap();
        let mut wheel = ActuatorState::START;
        let mut x = [15.0, 0.0, 0.0];
        let mut largest: f64 = 0.0;
        for k in 0..1000 {
            let Input { t_eng_n_m, delta_rad: command } = weave(15.0, k, 0.04);
            let output = *detector.sample(y(x[0], x[2]), u(t_eng_n_m, command));
            let delta = wheel.sample(&lag(lag_s), T_S, command);
            x = euler(&NOMINAL, x, u(t_eng_n_m, delta), [0.0; 3]);
            largest = largest.max(output.j_rms / output.j_th);
        }
        assert!((0.2..1.02).contains(&largest), "{largest} of the threshold with {lag_s} s");
    }
}

/// Sums of the magnitudes of what [`Vehicle::derivative`] adds up: its rounding, and that of its
/// arguments, is a few units in the last place of these.
fn magnitudes([v_x, v_y, r]: StateVector, u: Input) -> StateVector {
    let v = &NOMINAL;
    let (l_f, l_r) = (v.front_axle_distance_m, v.rear_axle_distance_m);
    let (v_y, r) = (v_y.abs(), r.abs());
    let front =
        2.0 * v.front_cornering_stiffness_n_per_rad * (u.delta_rad.abs() + (v_y + l_f * r) / v_x);
    let rear = 2.0 * v.rear_cornering_stiffness_n_per_rad * (v_y + l_r * r) / v_x;
    let torque = u.t_eng_n_m.abs() + v.cruise_torque(v_x);
    let drag = v.lateral_drag_n_s2_per_m2 * v_y * v_y;
    [
        torque / v.effective_longitudinal_inertia_kg_m + v_y * r,
        (front + rear + drag) / v.mass_kg + v_x * r,
        (l_f * front + l_r * rear) / v.yaw_inertia_kg_m2,
    ]
}

proptest! {
    /// Against a difference quotient of fourth order. Its truncation is estimated from twice the step;
    /// each of its slopes is rounded some twenty times, and the step is where the two are alike.
    #[test]
    fn the_jacobian_gives_the_slope_of_the_derivative(
        v_x in 5.0..30.0, v_y in -1.5..1.5, r in -0.55..0.55,
        t_eng in -2000.0..2000.0, delta in -0.3..0.3,
    ) {
        let (x, u) = ([v_x, v_y, r], u(t_eng, delta));
        let at = |h| NOMINAL.derivative(rk4(|x| NOMINAL.derivative(x.into(), u), x, h).into(), u);
        let quotient = |h: f64| {
            let near = [at(h), at(-h)];
            let far = [at(2.0 * h), at(-2.0 * h)];
            [0, 1, 2].map(|i| {
                (8.0 * (near[0][i] - near[1][i]) - (far[0][i] - far[1][i])) / (12.0 * h)
            })
        };
        let h = 3e-5;
        let (fine, coarse) = (quotient(h), quotient(2.0 * h));
        let rounding = magnitudes(x, u).map(|sum| 20.0 * f64::EPSILON * sum / h);
        let slope = NOMINAL.derivative(x.into(), u);
        let second = NOMINAL.jacobian(x.into()).map(|row| {
            row.iter().zip(slope).map(|(by, slope)| by * slope).sum::<f64>()
        });
        for (i, value) in second.into_iter().enumerate() {
            let tolerance = (fine[i] - coarse[i]).abs() + rounding[i];
            prop_assert!((value - fine[i]).abs() <= tolerance, "{i}: {value} {} {tolerance}", fine[i]);
        }
    }

    /// The bound holds to first order in the uncertainties; a tenth is what the second order takes here.
    #[test]
    fn no_vehicle_within_the_bounds_exceeds_the_threshold(
        v_x in 6.0..29.0, a_y in 0.5..3.0,
        mass in -1.0..=1.0, yaw_inertia in -1.0..=1.0, front in -1.0..=1.0, rear in -1.0..=1.0,
        bank in -1.0..=1.0, gust in -1.0..=1.0,
    ) {
        let uncertainty = Uncertainty {
            mass: 0.05,
            yaw_inertia: 0.05,
            front_cornering_stiffness: 0.05,
            rear_cornering_stiffness: 0.05,
            bank_m_per_s2: 0.3,
            gust: Gust { speed_m_per_s: 5.0, coefficient_n_s2_per_m2: 2.64, acting_ahead_m: 0.25 },
            ..Uncertainty::NONE
        };
        let vehicle = Vehicle {
            mass_kg: NOMINAL.mass_kg / (1.0 + 0.05 * mass),
            effective_longitudinal_inertia_kg_m:
                NOMINAL.effective_longitudinal_inertia_kg_m / (1.0 + 0.05 * mass),
            yaw_inertia_kg_m2: NOMINAL.yaw_inertia_kg_m2 / (1.0 + 0.05 * yaw_inertia),
            front_cornering_stiffness_n_per_rad:
                NOMINAL.front_cornering_stiffness_n_per_rad * (1.0 + 0.05 * front),
            rear_cornering_stiffness_n_per_rad:
                NOMINAL.rear_cornering_stiffness_n_per_rad * (1.0 + 0.05 * rear),
            ..NOMINAL
        };
        let amplitude = a_y * (2.62 / (v_x * v_x) + 0.0017);
        let step = |x: StateVector, u| {
            let force = gust * uncertainty.gust.side_force(x[0]);
            let (m, i_z) = (vehicle.mass_kg, vehicle.yaw_inertia_kg_m2);
            let push = [0.0, 0.3 * bank + force / m, 0.25 * force / i_z];
            euler(&vehicle, x, u, push)
        };
        let deviations = Deviations { uncertainty, ..Deviations::NONE };
        for output in watch(deviations, v_x, amplitude, step) {
            prop_assume!(output.monitor == Monitor::Monitoring);
            prop_assert!(output.j_rms <= 1.1 * output.j_th, "{output:?}");
        }
    }
}
