//! Communication steps, derivatives, status.

use std::cell::RefCell;
use std::ffi::c_void;
use std::ptr;

use super::fmi2::*;
use super::toy::ToyVariable as V;
use super::{DISCARD, ERROR, FATAL, GUID, Importer, OK, WARNING};
use crate::CallState;
use crate::types::*;

#[test]
fn a_step_runs_the_samples_that_fall_into_it() {
    let importer = Importer::default();
    for (size, expected) in [
        (0.01, [1, 2, 3, 4, 5, 6]),
        (0.02, [2, 4, 6, 8, 10, 12]),
        (0.08, [8, 16, 24, 32, 40, 48]),
        (0.01 / 3.0, [1, 1, 1, 2, 2, 2]),
        (1.0 / 60.0, [2, 4, 5, 7, 9, 10]),
        (1e-9, [1, 1, 1, 1, 1, 1]),
    ] {
        let component = importer.instantiate().initialised(3.0, None);
        for (i, samples) in expected.into_iter().enumerate() {
            assert_eq!(component.step(3.0 + i as f64 * size, size), OK, "{}", importer.last());
            // The first sample falls into a step unless that ends within the tolerance.
            let samples = if size < 1e-8 { 0.max(samples - 1) } else { samples };
            assert_eq!(component.samples(), samples, "step {i} of {size}");
        }
    }
}

#[test]
fn times_are_checked() {
    let importer = Importer::default();
    let component = importer.instantiate().initialised(0.0, Some(0.05));
    let nan = f64::NAN;
    for (point, size, status, message) in [
        (0.0, 0.0, ERROR, "a step of 0 s from 0 s is not a positive, finite span of time"),
        (0.0, -0.01, ERROR, "is not a positive, finite span of time"),
        (nan, 0.01, ERROR, "is not a positive, finite span of time"),
        (0.02, 0.01, ERROR, "does not begin where the last one ended, at 0 s"),
        (0.0, 0.06, ERROR, "a step of 0.06 s from 0 s ends after the stop time 0.05 s"),
        (0.0, 0.01, OK, "sample 0"),
        (0.012, 0.008, WARNING, "sample 1"),
        (0.02 + 1e-10, 0.03, OK, "sample 4"),
        (0.05, 0.01, ERROR, "ends after the stop time"),
    ] {
        assert_eq!(component.step(point, size), status, "{point} {size}");
        assert!(importer.last().contains(message), "{}", importer.last());
        assert_eq!(component.state(), CallState::StepComplete);
    }
    let text = "fmi2DoStep: the step begins at 0.012 s, but the last one ended at 0.01 s";
    assert!(importer.messages.borrow().iter().any(|message| message.text == text));
    assert_eq!(component.samples(), 5);
}

#[test]
fn a_stop_time_equal_to_the_start_time_is_none() {
    let importer = Importer::default();
    let component = importer.instantiate().initialised(3.0, Some(3.0));
    assert_eq!(component.step(3.0, 5.0), OK, "{}", importer.last());
    assert_eq!(component.samples(), 500);
}

#[test]
fn a_step_of_more_than_a_million_samples_changes_nothing() {
    let importer = Importer::default();
    let component = importer.instantiate().initialised(0.0, None);
    let before = component.serialised();
    assert_eq!(component.step(0.0, 10_000.01), ERROR);
    assert_eq!(
        importer.last(),
        "fmi2DoStep: a step of 10000.01 s from 0 s would run more than 1000000 samples: take \
         shorter ones"
    );
    assert_eq!(component.serialised(), before);
    assert_eq!(unsafe { fmi2SetDebugLogging(component.c, fmi2False, 0, ptr::null()) }, OK);
    assert_eq!(component.step(0.0, 10_000.0), OK);
    assert_eq!(component.samples(), 1_000_000);
}

#[test]
fn times_in_messages_have_all_their_digits() {
    let importer = Importer::default();
    let component = importer.instantiate().initialised(1.7e9, None);
    assert_eq!(component.step(1_700_000_000.25, 0.01), ERROR);
    let text = "fmi2DoStep: a step of 0.01 s from 1700000000.25 s does not begin where the last one \
                ended, at 1700000000 s";
    assert_eq!(importer.last(), text);
}

#[test]
fn the_importer_is_told_of_completed_steps_if_it_asks() {
    thread_local! {
        static TOLD: RefCell<Vec<(fmi2Status, f64)>> = const { RefCell::new(Vec::new()) };
    }
    unsafe extern "C" fn tell(environment: *mut c_void, status: fmi2Status) {
        // The instance may be asked from here.
        let mut y = f64::NAN;
        let c = unsafe { *environment.cast::<fmi2Component>() };
        assert_eq!(unsafe { fmi2GetReal(c, &(V::Output as u32), 1, &mut y) }, OK);
        TOLD.with_borrow_mut(|told| told.push((status, y)));
    }
    let mut c: fmi2Component = ptr::null_mut();
    let callbacks = fmi2CallbackFunctions {
        logger: None,
        stepFinished: Some(tell),
        componentEnvironment: (&raw mut c).cast(),
        ..Importer::default().callbacks()
    };
    unsafe {
        c = fmi2Instantiate(c"toy".as_ptr(), 1, GUID.as_ptr(), ptr::null(), &callbacks, 0, 0);
        assert_eq!(fmi2SetReal(c, &(V::Input as u32), 1, &1.0), OK);
        assert_eq!(fmi2EnterInitializationMode(c), OK);
        assert_eq!(fmi2ExitInitializationMode(c), OK);
        assert_eq!(fmi2DoStep(c, 0.0, 0.01, 1), OK);
        assert_eq!(fmi2DoStep(c, 0.0, -0.01, 1), ERROR);
        assert_eq!(fmi2DoStep(c, 0.012, 0.008, 1), WARNING);
        assert_eq!(fmi2SetInteger(c, &(V::Order as u32), 1, &-1), OK);
        assert_eq!(fmi2DoStep(c, 0.02, 0.01, 1), DISCARD);
        fmi2FreeInstance(c);
    }
    assert_eq!(TOLD.take(), [(OK, 0.01), (WARNING, 0.02)]);
}

#[test]
fn a_step_that_fails_leads_to_the_standard_s_state() {
    for (order, status, state) in [
        (-1, DISCARD, CallState::StepFailed),
        (-2, ERROR, CallState::Error),
        (-3, FATAL, CallState::Fatal),
        (-4, WARNING, CallState::StepComplete),
    ] {
        let importer = Importer::default();
        let component = importer.instantiate().initialised(0.0, None);
        assert_eq!(component.step(0.0, 0.03), OK);
        assert_eq!(component.last_successful_time(), 0.03);
        unsafe {
            assert_eq!(fmi2SetInteger(component.c, &(V::Order as u32), 1, &order), OK);
            assert_eq!(component.step(0.03, 0.03), status);
            assert_eq!(component.state(), state);
            if state == CallState::StepFailed {
                assert_eq!(component.last_successful_time(), 0.03);
                assert_eq!(component.step(0.03, 0.01), ERROR);
                assert_eq!(fmi2Terminate(component.c), OK);
            }
        }
    }
}

#[test]
fn derivatives_extrapolate_the_input_within_one_step() {
    let importer = Importer::default();
    let component = importer.instantiate().initialised(0.0, None);
    let vr = V::Input as u32;
    let derive = |order: i32, value: f64| unsafe {
        fmi2SetRealInputDerivatives(component.c, &vr, 1, &order, &value)
    };
    assert_eq!(component.set(V::Input, 1.0), OK);
    assert_eq!(derive(1, 10.0), OK);
    assert_eq!(component.step(0.0, 0.05), OK);
    assert!((component.get(V::Seen) - 1.4).abs() < 1e-15);
    assert_eq!(component.get(V::Input), 1.0, "the value set stays");
    assert_eq!(component.step(0.05, 0.05), OK);
    assert_eq!(component.get(V::Seen), 1.0, "derivatives hold for one step");

    assert_eq!((derive(1, 1.0), derive(2, 2.0), derive(3, 6.0)), (OK, OK, OK));
    assert_eq!(component.step(0.1, 0.1), OK);
    let t = 0.09_f64;
    assert!((component.get(V::Seen) - (1.0 + t + t * t + t.powi(3))).abs() < 1e-14);

    for order in [0, 4, -1, i32::MIN, i32::MAX] {
        assert_eq!(derive(order, 1.0), ERROR);
    }
    unsafe {
        let gain = V::Gain as u32;
        assert_eq!(fmi2SetRealInputDerivatives(component.c, &gain, 1, &1, &1.0), ERROR);
        assert!(importer.last().ends_with("variable \"gain\" is not an input"));
        let order = V::Order as u32;
        assert_eq!(fmi2SetRealInputDerivatives(component.c, &order, 1, &1, &1.0), ERROR);
        assert_eq!(fmi2SetRealInputDerivatives(component.c, &99, 1, &1, &1.0), ERROR);
    }
}

#[test]
fn status_is_answered_where_there_is_one() {
    let importer = Importer::default();
    let component = importer.instantiate().initialised(0.5, None);
    let (c, mut flag, mut time) = (component.c, 7, 0.0);
    unsafe {
        assert_eq!(fmi2GetBooleanStatus(c, fmi2Terminated, &mut flag), OK);
        assert_eq!(flag, fmi2False);
        assert_eq!(component.last_successful_time(), 0.5);
        assert_eq!(fmi2GetStatus(c, fmi2DoStepStatus, &mut { OK }), DISCARD);
        assert_eq!(fmi2GetRealStatus(c, fmi2Terminated, &mut time), DISCARD);
        assert_eq!(fmi2GetIntegerStatus(c, fmi2PendingStatus, &mut 0), DISCARD);
        assert_eq!(fmi2GetStringStatus(c, fmi2PendingStatus, &mut ptr::null()), DISCARD);
        assert_eq!(fmi2GetBooleanStatus(c, 99, &mut flag), DISCARD);
        assert_eq!(fmi2CancelStep(c), ERROR);
        assert_eq!(fmi2GetRealOutputDerivatives(c, &2, 1, &1, &mut time), ERROR);
        assert_eq!(importer.last().split(": ").nth(1), Some("output derivatives are not provided"));
    }
}
