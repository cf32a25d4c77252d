//! What the detector does at the edges: range, invalid input, start, debounce.

#![allow(clippy::unwrap_used)]

mod common;

use common::{configuration, u, y};
use proptest::prelude::*;
use steerguard_detector::{
    Configuration, Detector, Initialisation, Input, Monitor, Output, State, StateError,
};

const NAN: f64 = f64::NAN;
const CRUISE: Input = u(78.75, 0.0);

fn detector() -> Detector {
    Detector::new(&configuration()).unwrap()
}

/// The detector after `samples` of straight driving at 15 m/s, in step with the vehicle.
fn settled(samples: u32) -> Detector {
    let mut detector = detector();
    for _ in 0..samples {
        detector.sample(y(15.0, 0.0), CRUISE);
    }
    detector
}

#[test]
fn straight_driving_leaves_no_residual() {
    let detector = settled(1000);
    let output = *detector.output();
    assert_eq!(output.monitor, Monitor::Monitoring);
    assert!(output.j_rms < 1e-12 && !output.alarm, "{output:?}");
    assert!((output.j_th - 1e-3).abs() < 1e-8);
}

#[test]
fn a_step_in_yaw_rate_raises_the_alarm_and_is_remembered() {
    let mut detector = settled(500);
    let output = *detector.sample(y(15.0, 0.1), CRUISE);
    assert!(output.alarm && output.j_rms >= output.j_th);
    assert_eq!(output.first_alarm, Some(500));
    for _ in 0..500 {
        detector.sample(y(15.0, 0.0), CRUISE);
    }
    assert!(!detector.output().alarm);
    assert_eq!(detector.output().first_alarm, Some(500));
}

#[test]
fn debounce_counts_consecutive_samples() {
    let mut detector = settled(500);
    detector.set_debounce_samples(3).unwrap();
    let alarms: Vec<bool> = (0..4).map(|_| detector.sample(y(15.0, 0.1), CRUISE).alarm).collect();
    assert_eq!(alarms, [false, false, true, true]);
}

#[test]
fn the_threshold_factor_scales_the_whole_threshold() {
    let (mut one, mut two) = (detector(), detector());
    two.set_threshold_factor(2.0).unwrap();
    assert_eq!(two.output().j_th, 2.0 * one.output().j_th, "before the first sample too");
    for _ in 0..100 {
        let single = one.sample(y(15.0, 0.0), CRUISE).j_th;
        assert_eq!(two.sample(y(15.0, 0.0), CRUISE).j_th, 2.0 * single);
    }
}

#[test]
fn the_threshold_factor_leaves_the_results_of_samples_as_they_were() {
    let mut detector = settled(3);
    let before = *detector.output();
    detector.set_threshold_factor(3.0).unwrap();
    assert_eq!(*detector.output(), before);
}

#[test]
fn parameters_out_of_range_are_refused_and_change_nothing() {
    let mut detector = settled(3);
    let before = detector;
    for factor in [0.0, -1.0, NAN, f64::INFINITY] {
        assert_eq!(detector.set_threshold_factor(factor).unwrap_err().field, "threshold factor");
    }
    assert_eq!(detector.set_debounce_samples(0).unwrap_err().field, "debounce");
    let given = Initialisation::Given([0.0, NAN, 0.0]);
    assert_eq!(detector.set_initialisation(given).unwrap_err().field, "z_0");
    assert_eq!(detector, before);
}

#[test]
fn a_detector_goes_on_from_a_state_as_it_was() {
    let mut first = settled(70);
    first.sample(y(15.0, 0.1), u(60.0, 0.01));
    let mut second = detector();
    second.set_state(first.state()).unwrap();
    for k in 0..100 {
        let (y, u) = (y(15.0, 0.01 * f64::from(k % 7)), u(70.0, 0.001 * f64::from(k % 5)));
        assert_eq!(first.sample(y, u), second.sample(y, u));
    }
    assert_eq!(first, second);
}

#[test]
fn a_state_that_none_can_have_had_is_refused() {
    let mut detector = settled(70);
    let before = detector;
    for spoil in [
        |s: &mut State| s.z[1] = NAN,
        |s: &mut State| s.rms.next = 40,
        |s: &mut State| s.rms.ring[39] = f64::INFINITY,
        |s: &mut State| s.start_up.samples = 41,
        |s: &mut State| s.start_up.sum = NAN,
        |s: &mut State| s.responses.uncertainties[6][2] = NAN,
        |s: &mut State| s.responses.fault_rms.newer = NAN,
        |s: &mut State| s.actuator.oldest = 1,
        |s: &mut State| s.slowest_actuator.command = Some(NAN),
        |s: &mut State| s.output.residual.r_rad_per_s = NAN,
        |s: &mut State| s.output.j_th = 0.0,
    ] {
        let mut state = *detector.state();
        spoil(&mut state);
        assert_eq!(detector.set_state(&state), Err(StateError));
        assert_eq!(detector, before);
    }
}

#[test]
fn the_first_residual_is_zero_from_the_measurement_and_not_from_a_given_start() {
    let first = *detector().sample(y(15.0, 0.2), CRUISE);
    assert_eq!(first.residual, y(0.0, 0.0));

    let mut given = detector();
    given.set_initialisation(Initialisation::Given([0.0; 3])).unwrap();
    let first = *given.sample(y(15.0, 0.2), CRUISE);
    assert_eq!(first.residual, y(15.0, 0.2));
}

#[test]
fn arming_has_hysteresis_at_each_end_of_each_measured_range() {
    // (outside S_x, inside S_x but short of the armed range, armed)
    for (outside, edge, armed) in [
        (y(4.9, 0.0), y(5.4, 0.0), y(5.6, 0.0)),
        (y(30.1, 0.0), y(29.6, 0.0), y(29.4, 0.0)),
        (y(15.0, -0.56), y(15.0, -0.52), y(15.0, -0.49)),
        (y(15.0, 0.56), y(15.0, 0.52), y(15.0, 0.49)),
    ] {
        let mut detector = detector();
        let mut monitor = |y| detector.sample(y, CRUISE).monitor;
        assert_eq!(monitor(edge), Monitor::OutOfRange, "must not arm at {edge:?}");
        assert_eq!(monitor(armed), Monitor::Monitoring, "must arm at {armed:?}");
        assert_eq!(monitor(edge), Monitor::Monitoring, "must stay armed at {edge:?}");
        assert_eq!(monitor(outside), Monitor::OutOfRange, "must disarm at {outside:?}");
        assert_eq!(monitor(edge), Monitor::OutOfRange, "must not re-arm at {edge:?}");
        assert_eq!(monitor(armed), Monitor::Monitoring, "must re-arm at {armed:?}");
    }
}

#[test]
fn leaving_the_range_withholds_the_alarm_and_forgets_the_window() {
    let mut detector = settled(500);
    assert!(detector.sample(y(15.0, 0.1), CRUISE).alarm);
    let out = *detector.sample(y(31.0, 0.1), CRUISE);
    assert_eq!(
        out,
        Output {
            j_th: 1e-3,
            monitor: Monitor::OutOfRange,
            first_alarm: Some(500),
            ..Output::default()
        }
    );
    let back = *detector.sample(y(15.0, 0.1), CRUISE);
    assert!(back.j_rms == 0.0 && back.j_th > 10e-3, "starts anew, start-up term included");
}

#[test]
fn an_estimate_outside_its_range_disarms_until_it_has_come_back() {
    let mut detector = settled(500);
    // A commanded angle that the measured yaw rate does not follow drives the estimate out.
    let mut left = None;
    for k in 0..2000 {
        let output = *detector.sample(y(15.0, 0.0), u(78.75, 0.3));
        if output.monitor == Monitor::OutOfRange {
            assert!(output.v_y_hat.abs() > 1.5 && !output.alarm);
            left = Some(k);
            break;
        }
    }
    assert!(left.is_some());
    let mut back = 0.0_f64;
    for _ in 0..2000 {
        back = detector.output().v_y_hat;
        if detector.sample(y(15.0, 0.0), CRUISE).monitor == Monitor::Monitoring {
            break;
        }
    }
    assert!(back.abs() <= 1.25, "re-armed at an estimate of {back} m/s");
    assert_eq!(detector.output().monitor, Monitor::Monitoring);
}

#[test]
fn invalid_input_holds_the_last_results_and_restarts_the_observer() {
    for bad in [NAN, f64::INFINITY, f64::NEG_INFINITY, 1e9, -1e300] {
        for place in 0..4 {
            let mut detector = settled(500);
            let before = *detector.sample(y(15.0, 0.1), CRUISE);
            let mut values = [15.0, 0.1, 78.75, 0.0];
            values[place] = bad;
            let [v_x, r, t_eng, delta] = values;
            let held = *detector.sample(y(v_x, r), u(t_eng, delta));
            assert_eq!(held, Output { monitor: Monitor::InvalidInput, ..before });
            let after = *detector.sample(y(15.0, 0.0), CRUISE);
            assert_eq!((after.residual, after.monitor), (y(0.0, 0.0), Monitor::Monitoring));
            assert!(after.j_th > 10e-3, "start-up term restarts");
        }
    }
}

#[test]
fn an_estimate_that_runs_away_is_dropped() {
    for delta in [-5e7, 4e8] {
        let mut detector = settled(500);
        let mut dropped = false;
        for _ in 0..200 {
            let output = *detector.sample(y(15.0, 0.0), u(78.75, delta));
            assert!(output.v_y_hat.is_finite() && output.j_rms.is_finite(), "{output:?}");
            dropped |= output.monitor == Monitor::OutOfRange && output.v_y_hat == 0.0;
        }
        assert!(dropped);
        let state = detector.state();
        assert!(state.z.iter().chain(&state.rms.ring).all(|x| x.is_finite()), "{:?}", state.z);
    }
}

#[test]
fn a_configuration_out_of_range_is_refused_by_field() {
    let reject = |spoil: fn(&mut Configuration), field: &str| {
        let mut configuration = configuration();
        spoil(&mut configuration);
        let error = Detector::new(&configuration).unwrap_err();
        assert_eq!(error.field, field);
        assert!(error.to_string().contains(field));
    };
    reject(|c| c.model.vehicle.mass_kg = 0.0, "mass");
    reject(|c| c.model.sampling_period_s = NAN, "sampling period");
    reject(|c| c.model.range.v_x.min = 0.0, "v_x range");
    reject(|c| c.hysteresis[0] = 13.0, "v_x hysteresis");
    reject(|c| c.gains.n[3][2][2] = NAN, "N");
    reject(|c| c.gains.e[0][1] = f64::INFINITY, "E");
    reject(|c| c.evaluation.window = 0, "window");
    reject(|c| c.evaluation.window = 257, "window");
    reject(|c| c.evaluation.threshold = 0.0, "threshold");
    reject(|c| c.evaluation.start_up_decay = 1.0, "start-up decay");
    reject(|c| c.actuator.lag_s = -0.1, "actuator lag");
    reject(|c| c.actuator.lag_s = NAN, "actuator lag");
    reject(|c| c.actuator.delay_s = -0.01, "actuator delay");
    reject(|c| c.actuator.delay_s = 2.58, "actuator delay");
    reject(|c| c.actuator.delay_s = NAN, "actuator delay");
    reject(|c| c.actuator.rate_limit_rad_per_s = Some(0.0), "actuator rate limit");
    reject(|c| c.actuator.rate_limit_rad_per_s = Some(f64::INFINITY), "actuator rate limit");
}

proptest! {
    /// Whatever comes in, what goes out is a number.
    #[test]
    fn no_input_makes_an_output_that_is_not_finite(
        samples in prop::collection::vec(
            (
                prop_oneof![4 => 4.0..31.0, 1 => any::<f64>()],
                prop_oneof![4 => -0.6..0.6, 1 => any::<f64>()],
                prop_oneof![4 => -1e4..1e4, 1 => -1e9..1e9, 1 => any::<f64>()],
                prop_oneof![4 => -1.0..1.0, 1 => -1e9..1e9, 1 => any::<f64>()],
            ),
            1..300,
        ),
    ) {
        let mut detector = detector();
        for (v_x, r, t_eng, delta) in samples {
            let output = detector.sample(y(v_x, r), u(t_eng, delta));
            let [v_x, r] = output.residual.vector();
            let numbers = [v_x, r, output.v_y_hat, output.j_rms, output.j_th];
            prop_assert!(numbers.iter().all(|x| x.is_finite()), "{output:?}");
            prop_assert!(output.j_th > 0.0);
            prop_assert!(!output.alarm || output.monitor != Monitor::OutOfRange);
        }
    }
}
