//! What the detector does at the edges: range, invalid input, start, debounce.

#![allow(clippy::unwrap_used)]

mod common;

use common::{configuration, u, y};
use proptest::prelude::*;
use steerguard_detector::{
    AlarmCause, Configuration, Detector, Initialisation, Input, Monitor, Output, Signal, State,
    StateCause, StateError, Zero,
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
        |s: &mut State| s.responses.along[2][4][2] = NAN,
        |s: &mut State| s.responses.common[6][2] = NAN,
        |s: &mut State| s.motions[1].v_y_m_per_s = NAN,
        |s: &mut State| s.output.alarm_cause = AlarmCause::Range,
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
fn leaving_the_range_keeps_the_alarm_and_forgets_the_window() {
    let mut detector = settled(500);
    assert!(detector.sample(y(15.0, 0.1), CRUISE).alarm);
    let out = *detector.sample(y(31.0, 0.1), CRUISE);
    assert_eq!(
        out,
        Output {
            j_th: 1e-3,
            alarm: true,
            alarm_cause: AlarmCause::Residual,
            monitor: Monitor::OutOfRange,
            state_cause: StateCause::Signal(Signal::Speed),
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
            assert!(output.v_y_hat.abs() > 1.5);
            assert_eq!(output.state_cause, StateCause::LateralSpeed);
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
    for bad in [NAN, f64::INFINITY, f64::NEG_INFINITY, 1.000_001e6, -1e300] {
        for (place, signal) in Signal::ALL.into_iter().enumerate() {
            let mut detector = settled(500);
            let before = *detector.sample(y(15.0, 0.1), CRUISE);
            let mut values = [15.0, 0.1, 78.75, 0.0];
            values[place] = bad;
            let [v_x, r, t_eng, delta] = values;
            let held = *detector.sample(y(v_x, r), u(t_eng, delta));
            let state_cause = StateCause::Signal(signal);
            assert_eq!(held, Output { monitor: Monitor::InvalidInput, state_cause, ..before });
            let after = *detector.sample(y(15.0, 0.0), CRUISE);
            assert_eq!((after.residual, after.monitor), (y(0.0, 0.0), Monitor::Monitoring));
            assert!(after.j_th > 10e-3, "start-up term restarts");
        }
    }
}

#[test]
fn an_estimate_that_runs_away_is_dropped() {
    // A lateral speed that feeds on itself, which the residual does not hold.
    let mut unstable = configuration();
    for n in &mut unstable.gains.n {
        n[1][1] = 1.5;
    }
    let mut detector = Detector::new(&unstable).unwrap();
    let mut dropped = false;
    for _ in 0..400 {
        let output = *detector.sample(y(15.0, 0.0), u(78.75, -0.3));
        assert!(output.v_y_hat.is_finite() && output.j_rms.is_finite(), "{output:?}");
        dropped |= output.monitor == Monitor::OutOfRange && output.v_y_hat == 0.0;
    }
    assert!(dropped);
    let state = detector.state();
    assert!(state.z.iter().chain(&state.rms.ring).all(|x| x.is_finite()), "{:?}", state.z);
}

#[test]
fn values_at_the_limits_are_valid() {
    let mut detector = detector();
    let limit = Signal::limit;
    let y = y(limit(Signal::Speed), -limit(Signal::YawRate));
    let u = u(limit(Signal::DriveTorque), -limit(Signal::SteeringAngle));
    assert_eq!(detector.sample(y, u).monitor, Monitor::OutOfRange);
}

/// Straight ahead at 15 m/s, a fault for two seconds, and again straight ahead.
fn alarms(hold_s: f64, during: impl Fn(u32) -> (f64, f64)) -> Vec<Output> {
    let mut detector = settled(500);
    detector.set_alarm_hold_s(hold_s).unwrap();
    (0..800)
        .map(|k| {
            let (v_x, r) = if k < 200 { during(k) } else { (15.0, 0.0) };
            *detector.sample(y(v_x, r), CRUISE)
        })
        .collect()
}

#[test]
fn an_alarm_stays_until_j_has_been_low_for_its_hold() {
    for hold_s in [0.0, 0.5, 1.0, 3.0] {
        let outputs = alarms(hold_s, |_| (15.0, 0.1));
        let stands = outputs.iter().filter(|x| x.alarm).count();
        let first_low = outputs.iter().skip(200).position(|x| x.j_rms < 0.8 * x.j_th).unwrap();
        assert!(outputs[..200].iter().all(|x| x.alarm), "uninterrupted");
        let over = 200 + first_low + ((hold_s / 0.01) as usize).max(1) - 1;
        assert_eq!(stands, over, "hold of {hold_s} s");
        assert!(outputs[stands..].iter().all(|x| !x.alarm));
    }
}

#[test]
fn neither_range_nor_invalid_input_ends_an_alarm() {
    for lost in [(31.0, 0.0), (15.0, 0.6), (NAN, 0.0), (15.0, 21.0)] {
        let outputs = alarms(0.5, |k| if k < 10 { (15.0, 0.1) } else { lost });
        let stands = outputs.iter().filter(|x| x.alarm).count();
        assert!(outputs[..stands].iter().all(|x| x.alarm));
        // The hold counts from the return on.
        assert_eq!(stands, 200 + 50 - 1, "{lost:?}");
    }
}

#[test]
fn a_yaw_rate_that_leaves_the_range_against_the_command_is_an_alarm() {
    for debounce in [1, 20] {
        let mut detector = settled(500);
        detector.set_debounce_samples(debounce).unwrap();
        for k in 1..=200 {
            let output = *detector.sample(y(15.0, 0.7), CRUISE);
            assert_eq!(output.monitor, Monitor::OutOfRange);
            assert_eq!(output.state_cause, StateCause::Signal(Signal::YawRate));
            assert_eq!(output.alarm, k >= debounce, "sample {k}");
            assert_eq!(output.alarm_cause == AlarmCause::Range, output.alarm);
        }
    }
}

#[test]
fn a_yaw_rate_that_leaves_the_range_as_commanded_is_none() {
    let mut detector = settled(500);
    // The range alone is asked.
    detector.set_threshold_factor(100.0).unwrap();
    let vehicle = steerguard_detector::Vehicle::PAPER;
    let mut x = steerguard_detector::VehicleState { v_x_m_per_s: 15.0, ..Default::default() };
    let mut left = false;
    for k in 0..400 {
        let u = u(78.75, 0.15 * f64::from(k.min(100)) / 100.0);
        let output = *detector.sample(x.measured(), u);
        assert!(!output.alarm, "{output:?}");
        left |= output.monitor == Monitor::OutOfRange;
        let slope = vehicle.derivative(x, u);
        let next = [0, 1, 2].map(|i| x.vector()[i] + 0.01 * slope[i]);
        x = next.into();
    }
    assert!(left);
}

#[test]
fn a_detector_that_is_off_gives_no_alarm_and_starts_clean() {
    let mut detector = settled(500);
    assert!(detector.sample(y(15.0, 0.1), CRUISE).alarm);
    detector.set_enabled(false);
    for _ in 0..100 {
        let output = *detector.sample(y(15.0, 0.3), CRUISE);
        let expected = Output {
            j_th: 1e-3,
            monitor: Monitor::Disabled,
            state_cause: StateCause::NotEnabled,
            first_alarm: Some(500),
            ..Output::default()
        };
        assert_eq!(output, expected);
    }
    detector.set_enabled(true);
    let back = *detector.sample(y(15.0, 0.0), CRUISE);
    assert!(back.j_rms == 0.0 && back.monitor == Monitor::Monitoring && !back.alarm);
}

/// The paper's detector with data that are stale after 0.2 s.
fn with_staleness() -> Detector {
    let staleness = steerguard_detector::Staleness {
        after_s: 0.2,
        v_x_jump_m_per_s: 0.3,
        r_jump_rad_per_s: 0.2,
    };
    Detector::new(&Configuration { staleness, ..configuration() }).unwrap()
}

#[test]
fn measurements_that_do_not_change_are_stale_and_the_observer_goes_on() {
    let mut detector = with_staleness();
    let monitors: Vec<Monitor> =
        (0..40).map(|_| detector.sample(y(15.0, 0.0), CRUISE).monitor).collect();
    assert!(monitors[..21].iter().all(|&x| x == Monitor::Monitoring));
    assert!(monitors[21..].iter().all(|&x| x == Monitor::StaleInput));
    assert_eq!(detector.output().state_cause, StateCause::Unchanged);
    // A small step is the same drive.
    let before = *detector.output();
    let output = *detector.sample(y(15.0, 1e-5), CRUISE);
    assert_eq!(output.monitor, Monitor::Monitoring);
    assert!(output.j_th <= before.j_th && output.j_rms > 0.0, "no start: {output:?}");
    // A fault that begins there is seen at once.
    let mut detector = with_staleness();
    for _ in 0..500 {
        detector.sample(y(15.0, 0.0), CRUISE);
    }
    assert!(detector.sample(y(15.0, 0.1), CRUISE).alarm);
}

#[test]
fn stale_measurements_that_return_with_a_jump_start_the_observer_anew() {
    let mut detector = with_staleness();
    for _ in 0..100 {
        detector.sample(y(15.0, 0.0), CRUISE);
    }
    let output = *detector.sample(y(14.0, 0.3), CRUISE);
    assert!(!output.alarm && output.j_rms == 0.0 && output.j_th > 10e-3, "{output:?}");
}

#[test]
fn what_the_sensors_show_at_zero_is_subtracted() {
    let zero = Zero { steering_offset_rad: 0.01, yaw_rate_bias_rad_per_s: -0.02 };
    let mut shown = Detector::new(&Configuration { zero, ..configuration() }).unwrap();
    let mut true_values = detector();
    for k in 0..200 {
        let delta = 0.001 * f64::from(k % 7);
        let r = 0.01 * f64::from(k % 5);
        // The same sums, in the same order, as the detector makes.
        let expected =
            *true_values.sample(y(15.0, (r - 0.02) + 0.02), u(78.75, (delta + 0.01) - 0.01));
        assert_eq!(*shown.sample(y(15.0, r - 0.02), u(78.75, delta + 0.01)), expected);
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
    // Their products with factors and times must be numbers too.
    reject(|c| c.evaluation.threshold = 1e101, "threshold");
    reject(|c| c.model.sampling_period_s = 1e101, "sampling period");
    reject(|c| c.evaluation.start_up_decay = 1.0, "start-up decay");
    reject(|c| c.actuator.lag_s = -0.1, "actuator lag");
    reject(|c| c.actuator.lag_s = NAN, "actuator lag");
    reject(|c| c.actuator.delay_s = -0.01, "actuator delay");
    reject(|c| c.actuator.delay_s = 2.58, "actuator delay");
    reject(|c| c.actuator.delay_s = NAN, "actuator delay");
    reject(|c| c.actuator.rate_limit_rad_per_s = Some(0.0), "actuator rate limit");
    reject(|c| c.actuator.rate_limit_rad_per_s = Some(f64::INFINITY), "actuator rate limit");
}

/// Numbers of a design that no designer writes, each in its range.
#[test]
fn no_design_makes_an_output_that_is_not_finite() {
    let spoilt: [fn(&mut Configuration); 4] = [
        // J overflows.
        |c| c.evaluation.weights = [1e300; 2],
        // J_th overflows.
        |c| {
            c.evaluation.uncertainty_share = 1e300;
            c.deviations.uncertainty.bank_m_per_s2 = 1e20;
        },
        // What the smallest fault would make does, and J_th is a number.
        |c| c.deviations.smallest_fault = [0.0, 1e300, 1e300],
        // The residual is 0 times infinity.
        |c| c.gains.e = [[1e308; 2]; 3],
    ];
    for spoil in spoilt {
        let mut configuration = configuration();
        spoil(&mut configuration);
        let mut detector = Detector::new(&configuration).unwrap();
        let mut lost = 0;
        for k in 0..100 {
            let output = *detector.sample(y(15.0, 0.1 * f64::from(k % 3)), u(100.0, 0.02));
            let [v_x, r] = output.residual.vector();
            let Output { v_y_hat, j_rms, j_th, detectability, second_ratio, .. } = output;
            let ratio = j_rms / j_th;
            let numbers = [v_x, r, v_y_hat, j_rms, j_th, ratio, detectability, second_ratio];
            assert!(numbers.iter().all(|x| x.is_finite()), "sample {k}: {output:?}");
            lost += u32::from(output.monitor == Monitor::OutOfRange);
            // What is told can be restored.
            let state = *detector.state();
            detector.set_state(&state).unwrap();
        }
        assert!(lost > 0, "nothing overflows");
    }
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
            prop_assert!(output.alarm == (output.alarm_cause != AlarmCause::None));
        }
    }
}
