//! The test over onsets, held against what it says of itself: given a state, the next sample.

#![allow(clippy::unwrap_used)]

mod common;

use common::{STATED, u, y};
use steerguard_detector::{
    AlarmCause, Configuration, Detector, EXPLANATIONS, Estimator, FaultEstimate, FaultHypothesis,
    Filter, Gust, Hypothesis, Input, Measurement, Onsets, Output, STATES, Signature, State,
    Vehicle,
};

const THRESHOLD: f64 = 3.0;
const ESTIMATE_FACTOR: f64 = 2.0;
const BANK: f64 = STATED.bank_m_per_s2;
const GUST: Gust = STATED.gust;
const V_X: f64 = 20.0;
/// Samples before the one that is looked at.
const SAMPLES: u64 = 2000;
/// What the error of a mass does no measurement shows, so that a sample adds nothing to a and c.
const MASS: usize = 5;
/// What 1 rad makes of the mass.
const ERROR: f64 = 2.0;
/// c, per rad^2: a standard deviation of 1 mrad.
const INFORMATION: f64 = 1e6;
/// Samples between the onsets that the statistic is of, and that those between them are looked at for.
const SPACING: u64 = 5;
const YOUNG: u64 = 20;
/// Ages in samples: the youngest estimate that is held, and how long it speaks for an alarm.
const SETTLED: u64 = 20;
/// Samples for which a statistic has been clear where the fault is taken in.
const CLEAR_FOR: u64 = 10;
const KNOWN_FOR: u64 = 1000;

fn told() -> Configuration {
    let estimator =
        Estimator { threshold: THRESHOLD, estimate_factor: ESTIMATE_FACTOR, noise: [0.02, 0.002] };
    common::told(STATED, Some(estimator))
}

fn straight() -> (Measurement, Input) {
    (y(V_X, 0.0), u(Vehicle::PAPER.cruise_torque(V_X), 0.0))
}

/// A detector that has seen straight driving, with a change of its state.
fn after(change: impl FnOnce(&mut State)) -> Detector {
    after_samples(&told(), change)
}

/// Another such detector.
fn after_samples(told: &Configuration, change: impl FnOnce(&mut State)) -> Detector {
    let mut detector = Detector::new(told).unwrap();
    let (y, u) = straight();
    for _ in 0..SAMPLES {
        detector.sample(y, u);
    }
    let mut state = *detector.state();
    assert_eq!(state.onsets.samples, SAMPLES);
    state.onsets.hypotheses = Onsets::NONE.hypotheses;
    change(&mut state);
    detector.set_state(&state).unwrap();
    detector
}

/// An onset so many samples ago of a fault of so many rad, which shows in the mass alone.
fn onset(age: u64, fault_rad: f64) -> Hypothesis {
    let mut hypothesis = Hypothesis { onset: Some(SAMPLES - age), ..Hypothesis::default() };
    hypothesis.signatures[0] = Signature {
        error: of_mass(ERROR),
        correlation: fault_rad * INFORMATION,
        information: INFORMATION,
    };
    hypothesis
}

fn of_mass(error: f64) -> [f64; STATES] {
    let mut of_mass = [0.0; STATES];
    of_mass[MASS] = error;
    of_mass
}

fn next(detector: &mut Detector) -> (Output, State) {
    let (y, u) = straight();
    let output = *detector.sample(y, u);
    (output, *detector.state())
}

/// What the next sample makes of onsets.
fn judged(change: impl FnOnce(&mut Onsets)) -> (Output, State) {
    next(&mut after(|state| change(&mut state.onsets)))
}

/// Three tenths of the angle that bank and gust at their bounds look like: axle forces that hold a side force.
fn looks_rad() -> f64 {
    let v = Vehicle::PAPER;
    let per_newton = |ahead_m: f64| {
        let wheelbase = v.front_axle_distance_m + v.rear_axle_distance_m;
        let front = (v.rear_axle_distance_m + ahead_m) / wheelbase;
        let rear = (v.front_axle_distance_m - ahead_m) / wheelbase;
        let slip_front = front / (2.0 * v.front_cornering_stiffness_n_per_rad);
        let slip_rear = rear / (2.0 * v.rear_cornering_stiffness_n_per_rad);
        (slip_front - slip_rear).abs()
    };
    0.3 * (per_newton(0.0) * v.mass_kg * BANK
        + per_newton(GUST.acting_ahead_m) * GUST.side_force(V_X))
}

/// What a fault of 1 rad is divided by: standard deviation, and what is allowed for.
fn per_statistic() -> f64 {
    INFORMATION.sqrt().recip() + looks_rad()
}

/// The bound of an estimate of so much.
fn bound_rad(variance: f64) -> f64 {
    ESTIMATE_FACTOR * (variance.sqrt() + looks_rad())
}

/// The fault whose statistic is so much.
fn fault_of(statistic: f64) -> f64 {
    statistic * per_statistic()
}

#[track_caller]
fn near(found: f64, expected: f64) {
    assert!((found - expected).abs() <= 1e-9 * expected.abs(), "{found}, not {expected}");
}

fn forgotten(state: &State) -> bool {
    state.onsets.samples == 1 && state.onsets.held_rad == 0.0
}

#[test]
fn onsets_are_a_twentieth_of_a_second_apart_and_up_to_a_fifth_old_the_young_a_sample() {
    for (period_s, spacing, oldest) in
        [(0.005, 10, 40), (0.01, SPACING, 20), (0.02, 3, 10), (0.035, 1, 5)]
    {
        let mut told = told();
        told.model.sampling_period_s = period_s;
        let mut detector = Detector::new(&told).unwrap();
        let (y, u) = straight();
        for samples in 1..=3 * oldest {
            detector.sample(y, u);
            let state = detector.state();
            assert_eq!(state.onsets.samples, samples);
            let mut found: Vec<u64> =
                state.onsets.hypotheses.iter().filter_map(|x| x.onset).collect();
            found.sort_unstable();
            let oldest = samples.saturating_sub(oldest).max(1);
            let is_due = |x: &u64| x.is_multiple_of(spacing) || samples - x <= YOUNG;
            let expected: Vec<u64> = (oldest..=samples).filter(is_due).collect();
            // And what explains most, which may be between.
            let what = format!("{period_s} s, after {samples}: {found:?}");
            assert!(expected.iter().all(|x| found.contains(x)), "{what}");
            assert!(found.len() <= expected.len() + EXPLANATIONS, "{what}");
            assert!(found.iter().all(|x| (oldest..=samples).contains(x)), "{what}");
        }
    }
}

#[test]
fn the_statistic_allows_for_what_bank_and_gust_look_like() {
    let (output, state) = judged(|x| x.hypotheses[3] = onset(10, fault_of(2.0)));
    near(state.onsets.looks_rad, looks_rad());
    near(state.onsets.statistic, 2.0);
    near(output.second_ratio, 2.0 / THRESHOLD);
    let (output, _) = judged(|_| {});
    assert_eq!(output.second_ratio, 0.0, "nothing speaks for a fault");
}

#[test]
fn the_likeliest_onset_counts_wherever_it_stands() {
    for (first, second) in [(3.5, -4.5), (-4.5, 3.5), (4.5, 3.5)] {
        let (output, state) = judged(|x| {
            x.hypotheses[2] = onset(20, fault_of(first));
            x.hypotheses[9] = onset(10, fault_of(second));
        });
        near(state.onsets.statistic, 4.5);
        let (age, expected) = if f64::abs(first) > 4.0 { (20, first) } else { (10, second) };
        let found = output.estimate.unwrap();
        near(found.fault_rad, fault_of(expected));
        assert_eq!(found.onset, SAMPLES - age - 1);
    }
    // One that has grown too old no longer counts.
    let (_, state) =
        judged(|x| x.hypotheses[2] = Hypothesis { onset: None, ..onset(20, fault_of(9.0)) });
    assert_eq!(state.onsets.statistic, 0.0);
}

#[test]
fn the_alarm_is_raised_from_the_threshold_on_and_ends_at_a_distance() {
    for factor in [1.0, 2.0] {
        let alarm = |statistic: f64, stands: bool| {
            let mut detector = after(|state| {
                state.onsets.hypotheses[0] = onset(5, fault_of(statistic * THRESHOLD));
                if stands {
                    state.output.alarm = true;
                    state.output.alarm_cause = AlarmCause::SecondTest;
                }
            });
            detector.set_threshold_factor(factor).unwrap();
            next(&mut detector).0.alarm
        };
        assert!(!alarm(0.99 * factor, false) && alarm(1.01 * factor, false), "{factor}");
        assert!(!alarm(0.79 * factor, true) && alarm(0.81 * factor, true), "{factor}");
    }
}

#[test]
fn a_fault_is_taken_in_when_it_is_settled_or_clear() {
    for factor in [1.0, 2.0] {
        let taken = |age: u64, statistic: f64, clear: u64| {
            let mut detector = after(|state| {
                state.onsets.clear = clear;
                state.onsets.hypotheses[0] = onset(age, fault_of(statistic * THRESHOLD * factor));
            });
            detector.set_threshold_factor(factor).unwrap();
            next(&mut detector).1.onsets.held_rad != 0.0
        };
        assert!(!taken(SETTLED, 0.99, 0) && taken(SETTLED, 1.01, 0), "{factor}");
        let younger = SETTLED - SPACING;
        assert!(!taken(younger, 3.01, CLEAR_FOR - 2), "{factor}");
        assert!(!taken(younger, 2.99, CLEAR_FOR - 1), "{factor}");
        assert!(taken(younger, 3.01, CLEAR_FOR - 1), "{factor}");
    }
}

#[test]
fn a_fault_that_is_taken_in_the_filter_has_always_known() {
    let fault_rad = fault_of(1.5 * THRESHOLD);
    // A mass that is known better than at first, so that no cap hides what is added.
    let known_mass = |state: &mut State| {
        for row in &mut state.filter.p {
            row[MASS] = 0.0;
        }
        state.filter.p[MASS] = [0.0; STATES];
        state.filter.p[MASS][MASS] = 1e-4;
    };
    let (_, without) = next(&mut after(known_mass));
    let (output, with) = next(&mut after(|state| {
        known_mass(state);
        state.onsets.hypotheses[4] = onset(40, fault_rad);
    }));
    let Onsets { held_rad, held_variance, largest_rad, held_onset, held_since, .. } = with.onsets;
    near(held_rad, fault_rad);
    near(held_variance, 1.0 / INFORMATION);
    near(largest_rad, fault_rad);
    assert_eq!((held_onset, held_since), (SAMPLES - 40, SAMPLES));
    // Those from which it was found have ended; this sample begins one, as every fifth does.
    assert!(with.onsets.hypotheses.iter().all(|x| x.onset.is_none_or(|x| x > SAMPLES)));
    // The state moves by the fault's error, and is as uncertain as that.
    let (Filter { x, p }, plain) = (with.filter, without.filter);
    assert!((x[MASS] - plain.x[MASS] - ERROR * fault_rad).abs() < 1e-12);
    let more = p[MASS][MASS] - plain.p[MASS][MASS];
    assert!((more - ERROR * ERROR / INFORMATION).abs() < 1e-12, "{more}");
    Detector::new(&told()).unwrap().set_state(&with).unwrap();
    let estimate = output.estimate.unwrap();
    near(estimate.fault_rad, fault_rad);
    near(estimate.bound_rad, bound_rad(1.0 / INFORMATION));
    assert_eq!(estimate.onset, SAMPLES - 41);
}

/// A fault known for a while.
fn known(x: &mut Onsets, held_rad: f64, largest_rad: f64, since: u64) {
    (x.held_rad, x.largest_rad, x.held_variance) = (held_rad, largest_rad, 3e-6);
    (x.held_onset, x.held_since) = (since - 50, since);
}

#[test]
fn a_further_step_adds_to_what_is_known() {
    let step = fault_of(2.0 * THRESHOLD);
    let (output, state) = judged(|x| {
        known(x, 0.1, 0.12, SAMPLES - 300);
        x.hypotheses[0] = onset(35, step);
    });
    let Onsets { held_rad, held_variance, largest_rad, held_onset, held_since, .. } = state.onsets;
    near(held_rad, 0.1 + step);
    near(held_variance, 3e-6 + 1.0 / INFORMATION);
    near(largest_rad, f64::max(0.12, 0.1 + step));
    assert_eq!((held_onset, held_since), (SAMPLES - 350, SAMPLES), "the onset of the first");
    near(output.estimate.unwrap().fault_rad, held_rad);
}

#[test]
fn an_estimate_counts_what_is_known_and_what_is_about_to_be() {
    let step = fault_of(1.5 * THRESHOLD);
    let holds = |found: FaultEstimate, fault_rad: f64, variance: f64, onset: u64| {
        near(found.fault_rad, fault_rad);
        near(found.bound_rad, bound_rad(variance));
        assert_eq!(found.onset, onset);
    };
    let first = |x: &mut Onsets| x.hypotheses[0] = onset(10, step);
    let held = |x: &mut Onsets| known(x, 0.1, 0.1, SAMPLES - 300);
    let both = |x: &mut Onsets| {
        held(x);
        first(x);
    };
    let found = |change: &dyn Fn(&mut Onsets)| judged(change).0.estimate.unwrap();
    holds(found(&first), step, 1.0 / INFORMATION, SAMPLES - 11);
    holds(found(&held), 0.1, 3e-6, SAMPLES - 351);
    holds(found(&both), 0.1 + step, 3e-6 + 1.0 / INFORMATION, SAMPLES - 351);
    // Nothing is found where an alarm stands for another reason.
    let mut detector = after(|state| {
        state.output.alarm = true;
        state.output.alarm_cause = AlarmCause::Residual;
    });
    detector.set_alarm_hold_s(1.0).unwrap();
    let (output, _) = next(&mut detector);
    assert!(output.alarm && output.estimate.is_none(), "{output:?}");
}

#[test]
fn what_is_known_speaks_for_ten_seconds() {
    let alarm = |age: u64| judged(|x| known(x, 0.1, 0.1, SAMPLES + 1 - age)).0.alarm;
    assert!(alarm(KNOWN_FOR) && !alarm(KNOWN_FOR + 1));
}

#[test]
fn a_fault_is_over_where_little_of_it_is_left() {
    let over = |held: f64, left: f64| {
        let (_, state) = judged(|x| {
            known(x, held, held.abs(), SAMPLES - 300);
            x.hypotheses[0] = onset(35, left - held);
        });
        forgotten(&state)
    };
    // Less than a fifth of the largest.
    assert!(over(0.2, 0.199 * 0.2) && !over(0.2, 0.201 * 0.2));
    assert!(over(-0.2, -0.199 * 0.2) && !over(-0.2, -0.201 * 0.2));
    // Or no more than what the test would have found.
    let uncertain = f64::sqrt(3e-6 + 1.0 / INFORMATION) + looks_rad();
    let bound = THRESHOLD * uncertain;
    assert!(0.2 * 0.03 < 0.9 * bound && bound < 0.02, "{bound}");
    assert!(over(0.03, 0.99 * bound) && !over(0.03, 1.01 * bound));
    // What ends one needs less than what begins one; what adds to it does not.
    let taken = |held: f64, statistic: f64| {
        let (_, state) = judged(|x| {
            known(x, held, 0.2, SAMPLES - 300);
            x.hypotheses[0] = onset(35, fault_of(statistic * THRESHOLD));
        });
        state.onsets.held_rad != held
    };
    assert!(taken(-0.2, 0.81) && !taken(-0.2, 0.79) && !taken(0.2, 0.99) && taken(0.2, 1.01));
    // A first fault is none that ends, however small.
    let (_, state) = judged(|x| x.hypotheses[0] = onset(35, fault_of(1.01 * THRESHOLD)));
    assert!(!forgotten(&state));
}

#[test]
fn a_fault_that_no_wheel_can_have_is_none() {
    let lost = |held: f64, found: f64| {
        let (_, state) = judged(|x| {
            known(x, held, held, SAMPLES - 300);
            x.hypotheses[0] = onset(35, found);
            x.hypotheses[0].signatures[0].error = of_mass(0.0);
        });
        forgotten(&state)
    };
    assert!(lost(1.0, 0.61) && !lost(1.0, 0.59));
    assert!(!lost(1.0, -0.61), "it has become smaller");
    // The largest that a road wheel turns by is one that it can have.
    let alone = |found: f64| {
        let (_, state) = judged(|x| {
            x.hypotheses[0] = onset(35, found);
            x.hypotheses[0].signatures[0].error = of_mass(0.0);
        });
        forgotten(&state)
    };
    assert!(alone(1.61) && !alone(1.6));
}

#[test]
fn onsets_that_no_test_can_have_are_refused() {
    let mut detector = after(|_| {});
    let before = detector;
    let spoil: [fn(&mut Onsets); 13] = [
        |x| x.hypotheses[7].onset = Some(x.samples + 1),
        |x| x.hypotheses[7].signatures[0].error[STATES - 1] = f64::NAN,
        |x| x.hypotheses[7].signatures[1].correlation = f64::INFINITY,
        |x| x.hypotheses[7].signatures[2].information = f64::INFINITY,
        |x| x.hypotheses[7].signatures[0].information = -1e-9,
        |x| x.held_rad = f64::NAN,
        |x| x.largest_rad = f64::NAN,
        |x| x.held_variance = -1e-9,
        |x| x.statistic = f64::NAN,
        |x| x.looks_rad = f64::NAN,
        |x| x.held_onset = x.samples + 1,
        |x| x.held_since = x.samples + 1,
        |x| x.clear = x.samples + 1,
    ];
    for (k, spoil) in spoil.into_iter().enumerate() {
        let mut state = *before.state();
        spoil(&mut state.onsets);
        assert!(detector.set_state(&state).is_err(), "{k}");
        assert_eq!(detector, before);
    }
    let mut state = *before.state();
    state.onsets.hypotheses[0].onset = Some(SAMPLES);
    (state.onsets.held_onset, state.onsets.held_since) = (SAMPLES, SAMPLES);
    detector.set_state(&state).unwrap();
}

/// A filter in a bend, its state off by so much.
fn in_a_bend(change: impl FnOnce(&mut State)) -> Detector {
    let mut detector = Detector::new(&told()).unwrap();
    let torque = Vehicle::PAPER.cruise_torque(V_X);
    for k in 0..100 {
        // Less than the model turns, so that innovations are there.
        let ramp = f64::from(k.min(50)) / 50.0;
        detector.sample(y(V_X, 0.1 * ramp), u(torque, 0.02 * ramp));
    }
    let mut state = *detector.state();
    state.onsets.hypotheses = Onsets::NONE.hypotheses;
    change(&mut state);
    detector.set_state(&state).unwrap();
    detector.sample(y(V_X + 0.01, 0.11), u(torque, 0.02));
    detector
}

#[test]
fn an_error_of_the_state_shifts_innovations_by_what_a_and_c_say() {
    // A small one: the filter's measurement is linear in all but products of two errors.
    let shift = 1e-4;
    for k in 0..9 {
        let of = |shift: f64| {
            let detector = in_a_bend(|state| {
                state.filter.x[k] += shift;
                let error = &mut state.onsets.hypotheses[0].signatures[0].error;
                error[k] = 1.0;
                // None has begun at the last sample: it stays what it is given here.
                state.onsets.hypotheses[0].onset = Some(state.onsets.samples - 7);
            });
            detector.state().onsets.hypotheses[0].signatures[0]
        };
        let (plain, shifted) = (of(0.0), of(shift));
        let measured = [0, 2].contains(&k);
        assert_eq!(plain.information > 0.0, measured, "{k}");
        // Innovations nu - shift s: a loses shift times s' s, which is c.
        let lost = (plain.correlation - shifted.correlation) / shift;
        assert!((lost - plain.information).abs() <= 1e-6 * plain.information, "{k}: {lost}");
    }
}

/// What is named where the three explain so much, in the order of their signatures, from onsets of their own.
fn named(explained: [f64; EXPLANATIONS]) -> Option<FaultHypothesis> {
    let (output, _) = judged(|x| {
        for (k, explained) in explained.into_iter().enumerate() {
            let onset = SAMPLES - 10 - k as u64 * SPACING;
            // An estimate that errs by as much as the sensor: the sample to come shows nothing of either.
            let mut error = [0.0; STATES];
            [error[0], error[2]] = [[0.0, 0.0], [0.0, -1.0], [-V_X, 0.0]][k];
            let signature = Signature {
                error,
                correlation: (explained * INFORMATION).sqrt(),
                information: INFORMATION,
            };
            x.hypotheses[k] = Hypothesis { onset: Some(onset), ..Hypothesis::default() };
            x.hypotheses[k].signatures[k] = signature;
        }
    });
    output.estimate.map(|x| x.hypothesis)
}

#[test]
fn what_explains_clearly_more_than_both_others_is_named() {
    // More than the threshold: what the statistic is of speaks for a fault.
    let steering = (fault_of(1.5 * THRESHOLD) / INFORMATION.sqrt().recip()).powi(2);
    for (more, sensor) in [(11.9, false), (12.1, true)] {
        let expected = |of| Some(if sensor { of } else { FaultHypothesis::Undecided });
        let most = steering + more;
        assert_eq!(named([steering, most, 0.0]), expected(FaultHypothesis::YawRateSensor));
        assert_eq!(named([steering, 0.0, most]), expected(FaultHypothesis::SpeedSensor));
        assert_eq!(named([steering, most, most]), Some(FaultHypothesis::Undecided));
        let less = steering - more;
        assert_eq!(named([steering, less, 0.0]), expected(FaultHypothesis::Steering));
        assert_eq!(named([steering, 0.0, less]), expected(FaultHypothesis::Steering));
    }
    // Of much more than 12 a share counts: 2 % of what the likeliest explains.
    for (share, expected) in
        [(0.981, FaultHypothesis::Undecided), (0.979, FaultHypothesis::YawRateSensor)]
    {
        let most = 1e5;
        assert!(share * most > steering);
        assert_eq!(named([share * most, most, 0.0]), Some(expected));
    }
}

#[test]
fn what_is_named_stays_until_the_fault_is_over() {
    let hypothesis = |known_before: bool, statistic: f64| {
        let (_, state) = judged(|x| {
            x.hypothesis = FaultHypothesis::SpeedSensor;
            x.hypotheses[0] = onset(5, fault_of(statistic * THRESHOLD));
            if known_before {
                known(x, 0.1, 0.1, SAMPLES - 300);
            }
        });
        state.onsets.hypothesis
    };
    assert_eq!(hypothesis(false, 1.5), FaultHypothesis::SpeedSensor);
    assert_eq!(hypothesis(true, 0.5), FaultHypothesis::SpeedSensor);
    assert_eq!(hypothesis(false, 0.5), FaultHypothesis::Undecided);
}

#[test]
fn what_explains_most_is_kept_as_it_ages() {
    // So fast that some are neither young nor too old, and neither of the onsets that the statistic is of.
    let mut told = told();
    told.model.sampling_period_s = 0.005;
    let mut detector = after_samples(&told, |state| {
        state.onsets.hypotheses[0] = onset(YOUNG + 4, fault_of(1.0));
        state.onsets.hypotheses[1] = onset(YOUNG + 6, fault_of(2.0));
    });
    let (_, state) = next(&mut detector);
    let mut onsets: Vec<u64> = state.onsets.hypotheses.iter().filter_map(|x| x.onset).collect();
    onsets.sort_unstable();
    assert_eq!(onsets, [SAMPLES - YOUNG - 6, SAMPLES + 1]);
}
