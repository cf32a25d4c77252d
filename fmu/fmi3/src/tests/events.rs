//! Steps, early return, Event Mode and the clock.

use std::ptr;

use super::toy::{CLOCK_TIME, TIME, ToyVariable as V};
use super::{DISCARD, ERROR, FATAL, Importer, OK, Step, WARNING, fmi3};
use crate::CallState;
use crate::types::*;

fn step(event: bool, early: bool, time: f64) -> Step {
    Step { status: OK, event, early, time }
}

#[test]
fn a_step_returns_at_the_sample_that_changes_the_flag() {
    let importer = Importer::default();
    let component = importer.instantiate().initialised(0.0, None);
    // Samples 1 and 2 leave the flag, the third changes it.
    assert_eq!(component.set(V::Input, f64::NAN), OK);
    let third = 2.0 * 0.01;
    assert_eq!(component.step(0.0, 0.1), step(true, true, third));
    assert_eq!((component.samples(), component.get(TIME)), (3, third));

    // Step Mode until Event Mode is entered: no tick yet.
    assert!(!component.ticks());
    unsafe { assert_eq!(fmi3::fmi3EnterEventMode(component.c), OK) };
    assert!(component.ticks(), "at the event");
    assert!(component.ticks(), "asking does not end it");
    assert_eq!(component.get(CLOCK_TIME), third);
    component.update();
    assert!(!component.ticks(), "the event is handled");
    unsafe { assert_eq!(fmi3::fmi3EnterStepMode(component.c), OK) };

    // On to the end of the interval: its sample 2 is not run again.
    let sixth = 5.0 * 0.01;
    assert_eq!(component.step(third, 0.1 - third), step(true, true, sixth));
    assert_eq!(component.samples(), 6);
}

#[test]
fn a_sample_on_the_communication_point_returns_there() {
    let importer = Importer::default();
    let component = importer.instantiate().initialised(1.0, None);
    assert_eq!(component.set(V::Input, 1.0), OK);
    assert_eq!(component.step(1.0, 0.01), step(true, true, 1.0));
    unsafe {
        assert_eq!(fmi3::fmi3EnterEventMode(component.c), OK);
        assert_eq!(fmi3::fmi3EnterStepMode(component.c), OK);
    }
    assert!(!component.ticks(), "left without an update");
    // The same step once more has nothing left to do.
    assert_eq!(component.step(1.0, 0.01), step(false, false, 1.01));
    assert_eq!(component.samples(), 1);
    assert_eq!(component.step(1.01, 0.05), step(false, false, 1.01 + 0.05));
    assert_eq!(component.samples(), 6);
}

#[test]
fn without_early_return_the_step_is_done_whole_and_the_clock_ticks_at_its_end() {
    let importer = Importer::default();
    let component = importer.instantiate_with(true, false).initialised(0.0, None);
    assert_eq!(component.set(V::Input, f64::NAN), OK);
    assert_eq!(component.step(0.0, 0.1), step(true, false, 0.1));
    assert_eq!(component.samples(), 10);
    unsafe { assert_eq!(fmi3::fmi3EnterEventMode(component.c), OK) };
    assert!(component.ticks());
    assert_eq!(component.get(CLOCK_TIME), 8.0 * 0.01, "the last of three changes");
}

#[test]
fn without_event_mode_the_step_is_done_whole_and_nothing_is_said() {
    let importer = Importer::default();
    for early_return in [false, true] {
        let component = importer.instantiate_with(false, early_return).initialised(0.0, None);
        assert_eq!(component.state(), CallState::StepMode, "straight from initialisation");
        assert_eq!(component.set(V::Input, f64::NAN), OK);
        assert_eq!(component.step(0.0, 0.1), step(false, false, 0.1));
        assert_eq!(component.samples(), 10);
        assert_eq!(component.get(CLOCK_TIME), 8.0 * 0.01);
        unsafe { assert_eq!(fmi3::fmi3EnterEventMode(component.c), ERROR) };
        let text = "fmi3EnterEventMode: the importer said at instantiation that it does not use \
                    Event Mode";
        assert_eq!(importer.last(), text);
        assert_eq!(component.state(), CallState::StepMode);
    }
}

#[test]
fn event_mode_may_be_entered_without_a_tick() {
    let importer = Importer::default();
    let component = importer.instantiate().initialised(0.0, None);
    assert_eq!(component.step(0.0, 0.02), step(false, false, 0.02));
    unsafe { assert_eq!(fmi3::fmi3EnterEventMode(component.c), OK) };
    assert!(!component.ticks());
    assert_eq!(component.get(CLOCK_TIME), -1.0);
    // Inputs and tunable parameters are set there, too.
    assert_eq!(component.set(V::Input, 0.5), OK);
    component.update();
    unsafe { assert_eq!(fmi3::fmi3Terminate(component.c), OK) };
}

#[test]
fn the_samples_of_a_run_are_the_same_with_and_without_events() {
    let importer = Importer::default();
    let run = |event_mode| {
        let component = importer.instantiate_with(event_mode, true).initialised(0.0, None);
        let mut seen = Vec::new();
        for k in 0..30 {
            let input = if k % 7 < 3 { 1.0 } else { -1.0 };
            assert_eq!(component.set(V::Input, input), OK);
            let (mut time, end) = (f64::from(k) * 0.025, f64::from(k + 1) * 0.025);
            while time < end {
                let done = component.step(time, end - time);
                assert_eq!(done.status, OK, "{}", importer.last());
                if done.event {
                    unsafe { assert_eq!(fmi3::fmi3EnterEventMode(component.c), OK) };
                    assert!(component.ticks());
                    component.update();
                    unsafe { assert_eq!(fmi3::fmi3EnterStepMode(component.c), OK) };
                }
                time = if done.early { done.time } else { end };
            }
            seen.push((component.samples(), component.get(CLOCK_TIME)));
        }
        seen
    };
    let events = run(true);
    assert_eq!(events, run(false));
    assert_eq!(events.last().unwrap().0, 75);
}

#[test]
fn a_step_that_fails_ends_there() {
    let importer = Importer::default();
    for (order, status, state) in [
        (-1, DISCARD, CallState::StepMode),
        (-2, ERROR, CallState::Terminated),
        (-3, FATAL, CallState::Fatal),
    ] {
        let component = importer.instantiate().initialised(0.0, None);
        assert_eq!(component.step(0.0, 0.02).status, OK);
        let vr = V::Order as u32;
        unsafe { assert_eq!(fmi3::fmi3SetInt32(component.c, &vr, 1, &order, 1), OK) };
        let done = component.step(0.02, 0.05);
        assert_eq!((done.status, done.time), (status, 0.02));
        assert_eq!(component.state(), state);
    }
}

#[test]
fn times_are_checked() {
    let importer = Importer::default();
    let component = importer.instantiate().initialised(0.0, Some(0.05));
    for (point, size, status, message) in [
        (0.0, 0.0, ERROR, "a step of 0 s from 0 s is not a positive, finite span of time"),
        (0.02, 0.01, ERROR, "does not begin where the last one ended, at 0 s"),
        (0.0, 0.06, ERROR, "ends after the stop time 0.05 s"),
        (0.0, 0.01, OK, "ends after the stop time 0.05 s"),
        (0.012, 0.008, WARNING, "the step begins at 0.012 s, but the last one ended at 0.01 s"),
    ] {
        assert_eq!(component.step(point, size).status, status, "{point} {size}");
        assert!(importer.last().contains(message), "{}", importer.last());
        assert_eq!(component.state(), CallState::StepMode);
    }
}

#[test]
fn results_need_places() {
    let importer = Importer::default();
    let component = importer.instantiate().initialised(0.0, None);
    let (c, mut flag, mut time) = (component.c, 0, 0.0);
    let before = component.serialised();
    unsafe {
        let no_flag = ptr::null_mut();
        let place: *mut fmi3Boolean = &mut flag;
        for (places, name) in [
            ([no_flag, place, place], "eventHandlingNeeded"),
            ([place, no_flag, place], "terminateSimulation"),
            ([place, place, no_flag], "earlyReturn"),
        ] {
            let [a, b, d] = places;
            assert_eq!(fmi3::fmi3DoStep(c, 0.0, 0.01, 1, a, b, d, &mut time), ERROR);
            let text = format!("fmi3DoStep: argument {name} is NULL or no valid array");
            assert_eq!(importer.last(), text);
        }
        let none = ptr::null_mut();
        assert_eq!(fmi3::fmi3DoStep(c, 0.0, 0.01, 1, place, place, place, none), ERROR);
        assert_eq!(component.serialised(), before);
        assert_eq!(fmi3::fmi3EnterEventMode(c), OK);
        let status =
            fmi3::fmi3UpdateDiscreteStates(c, place, place, place, place, no_flag, &mut time);
        assert_eq!(status, ERROR);
        assert!(importer.last().contains("nextEventTimeDefined is NULL"), "{}", importer.last());
    }
}
