//! What raises, holds and ends an alarm, and what a sample leaves for the next.

#![allow(clippy::unwrap_used)]

mod common;

use common::{configuration, u, y};
use steerguard_detector::{
    AlarmCause, Configuration, Detector, Estimator, FaultEstimate, FaultHypothesis, Initialisation,
    Input, Monitor, Output, RELEASE, Staleness,
};

const CRUISE: Input = u(78.75, 0.0);

fn detector() -> Detector {
    Detector::new(&configuration()).unwrap()
}

/// With data that are stale after 0.2 s.
fn with_staleness() -> Detector {
    let staleness = Staleness { after_s: 0.2, v_x_jump_m_per_s: 0.3, r_jump_rad_per_s: 0.2 };
    Detector::new(&Configuration { staleness, ..configuration() }).unwrap()
}

/// Whether the observer has started anew at the last sample.
fn started(output: &Output) -> bool {
    output.j_rms == 0.0 && output.j_th > 10e-3
}

#[test]
fn a_state_can_be_restored_at_any_speed() {
    for v_x in [0.0, -3.0, 4.0, 31.0, 150.0] {
        for drives_before in [0, 100] {
            let mut detector = detector();
            for _ in 0..drives_before {
                detector.sample(y(15.0, 0.1), u(78.75, 0.05));
            }
            for _ in 0..3 {
                detector.sample(y(v_x, 0.2), u(78.75, 0.05));
                let state = *detector.state();
                detector.set_state(&state).unwrap();
            }
        }
    }
}

#[test]
fn nothing_is_unchanged_at_the_first_sample() {
    // What is kept of a last sample is zero before there was one.
    let mut detector = detector();
    detector.sample(y(0.0, 0.0), CRUISE);
    assert_eq!(detector.state().unchanged, 0);
    detector.sample(y(0.0, 0.0), CRUISE);
    assert_eq!(detector.state().unchanged, 1);
}

/// The output where measurements move on by less than a jump, after 40 samples that did not change.
fn returning(steers_at: Option<u32>) -> Output {
    let mut detector = with_staleness();
    detector.sample(y(15.1, 0.0), CRUISE);
    for k in 0..40 {
        let steers = steers_at.is_some_and(|at| k >= at);
        detector.sample(y(15.0, 0.0), if steers { u(78.75, 1e-4) } else { CRUISE });
    }
    assert_eq!(detector.output().monitor, Monitor::StaleInput);
    *detector.sample(y(15.0, 1e-5), CRUISE)
}

#[test]
fn measurements_that_left_steering_unanswered_start_the_observer_anew() {
    // A single change of the command counts from there on.
    assert!(started(&returning(Some(10))));
    assert!(!started(&returning(Some(30))), "not yet for as long as makes them stale");
    assert!(!started(&returning(None)));
}

#[test]
fn a_given_start_is_that_of_the_first_sample_alone() {
    let mut detector = detector();
    detector.set_initialisation(Initialisation::Given([0.0; 3])).unwrap();
    assert_eq!(detector.sample(y(15.0, 0.2), CRUISE).residual, y(15.0, 0.2));
    detector.sample(y(f64::NAN, 0.2), CRUISE);
    assert_eq!(detector.sample(y(15.0, 0.2), CRUISE).residual, y(0.0, 0.0));
}

#[test]
fn the_range_is_judged_once_the_motions_are_older_than_the_window() {
    let window = configuration().evaluation.window as u32;
    for (before, alarm) in [(window - 1, false), (window, true)] {
        let mut detector = detector();
        for _ in 0..before {
            detector.sample(y(15.0, 0.0), CRUISE);
        }
        let output = *detector.sample(y(15.0, 0.7), CRUISE);
        assert_eq!((output.monitor, output.alarm), (Monitor::OutOfRange, alarm), "{before}");
    }
}

#[test]
fn what_was_found_of_a_fault_stands_where_nothing_can_be_told() {
    let estimate = Some(FaultEstimate {
        fault_rad: 0.02,
        bound_rad: 0.005,
        onset: 60,
        hypothesis: FaultHypothesis::Steering,
    });
    let mut detector = detector();
    for _ in 0..70 {
        detector.sample(y(15.0, 0.0), CRUISE);
    }
    let mut state = *detector.state();
    state.output.alarm = true;
    state.output.alarm_cause = AlarmCause::SecondTest;
    state.output.estimate = estimate;
    detector.set_state(&state).unwrap();
    let output = *detector.sample(y(31.0, 0.0), CRUISE);
    assert_eq!((output.monitor, output.alarm), (Monitor::OutOfRange, true));
    assert_eq!(output.estimate, estimate);
}

#[test]
fn the_threshold_factor_divides_the_ratio_of_the_second_test() {
    // So high that nothing is taken in, which would depend on the factor.
    let estimator = Some(Estimator { threshold: 1e6, estimate_factor: 2.0, noise: [0.02, 0.002] });
    let told = Configuration { estimator, ..configuration() };
    let mut one = Detector::new(&told).unwrap();
    let mut four = one;
    four.set_threshold_factor(4.0).unwrap();
    let mut largest = 0.0_f64;
    for k in 0..200 {
        let (y, u) = (y(15.0, 0.002 * f64::from(k % 3)), u(78.75, 0.001 * f64::from(k % 5)));
        let ratio = one.sample(y, u).second_ratio;
        assert_eq!(four.sample(y, u).second_ratio, ratio / 4.0, "sample {k}");
        largest = largest.max(ratio);
    }
    assert!(largest > 0.0);
}

#[test]
fn an_alarm_ends_below_its_release_and_not_at_it() {
    let outputs = |threshold: f64| {
        let mut told = configuration();
        // J_th is the threshold alone.
        told.evaluation.start_up_amplitude = 0.0;
        told.evaluation.threshold = threshold;
        let mut detector = Detector::new(&told).unwrap();
        (0..200)
            .map(|k| *detector.sample(y(15.0, if k == 100 { 0.1 } else { 0.0 }), CRUISE))
            .collect::<Vec<_>>()
    };
    // A J below the largest, and a threshold whose release it is to the last bit.
    let j: Vec<f64> = outputs(1.0).iter().map(|x| x.j_rms).collect();
    let largest = j.iter().copied().fold(0.0, f64::max);
    let (at, threshold) = (101..200)
        .filter(|k| j[*k] < 0.9 * largest && j[*k] > 0.0)
        .find_map(|k| {
            let threshold = j[k] / RELEASE;
            (threshold <= largest && RELEASE * threshold == j[k]).then_some((k, threshold))
        })
        .unwrap();
    let outputs = outputs(threshold);
    assert_eq!((outputs[at].j_rms, outputs[at].j_th), (RELEASE * threshold, threshold));
    let low = (101..200).find(|k| j[*k] < RELEASE * threshold).unwrap();
    assert!(outputs[..low].iter().any(|x| x.alarm));
    assert_eq!(outputs[at].alarm, at < low, "J is not below its release there");
}
