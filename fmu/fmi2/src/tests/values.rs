//! Getting and setting values.

use std::ffi::CStr;
use std::ptr;

use steerguard_model_description::VariableSet;

use super::fmi2::*;
use super::toy::ToyVariable as V;
use super::{Component, ERROR, Importer, OK};
use crate::CallState;
use crate::types::*;

#[test]
fn values_of_all_types_come_back() {
    let importer = Importer::default();
    let component = importer.instantiate();
    let c = component.c;
    unsafe {
        let (reals, mut read) = ([0.25, 2.0, -7.5], [0.0; 3]);
        let vr = [V::Input, V::Gain, V::Offset].map(|variable| variable as u32);
        assert_eq!(fmi2SetReal(c, vr.as_ptr(), 3, reals.as_ptr()), OK);
        assert_eq!(fmi2GetReal(c, vr.as_ptr(), 3, read.as_mut_ptr()), OK);
        assert_eq!(read, reals);

        let (integers, mut read) = ([-3, 2], [0; 2]);
        let vr = [V::Order, V::Mode].map(|variable| variable as u32);
        assert_eq!(fmi2SetInteger(c, vr.as_ptr(), 2, integers.as_ptr()), OK);
        assert_eq!(fmi2GetInteger(c, vr.as_ptr(), 2, read.as_mut_ptr()), OK);
        assert_eq!(read, integers);

        let (hold, mut read) = (V::Hold as u32, 7);
        assert_eq!(fmi2SetBoolean(c, &hold, 1, &-5), OK);
        assert_eq!(fmi2GetBoolean(c, &hold, 1, &mut read), OK);
        assert_eq!(read, fmi2True);

        let (label, mut read) = (V::Label as u32, ptr::null());
        assert_eq!(fmi2SetString(c, &label, 1, &c"some text".as_ptr()), OK);
        assert_eq!(fmi2GetString(c, &label, 1, &mut read), OK);
        assert_eq!(CStr::from_ptr(read), c"some text");
    }
}

#[test]
fn empty_requests_need_no_arrays() {
    let importer = Importer::default();
    let component = importer.instantiate();
    unsafe {
        assert_eq!(fmi2GetReal(component.c, ptr::null(), 0, ptr::null_mut()), OK);
        assert_eq!(fmi2SetString(component.c, ptr::null(), 0, ptr::null()), OK);
    }
}

#[test]
fn arguments_that_are_no_arrays_are_refused() {
    let importer = Importer::default();
    let component = importer.instantiate();
    let (c, vr) = (component.c, V::Gain as u32);
    let (mut value, odd) = ([0.0; 2], ptr::dangling::<u8>().cast::<u32>());
    unsafe {
        assert_eq!(fmi2GetReal(c, ptr::null(), 1, value.as_mut_ptr()), ERROR);
        assert_eq!(fmi2GetReal(c, &vr, 1, ptr::null_mut()), ERROR);
        assert_eq!(importer.last(), "fmi2GetReal: argument value is NULL or no valid array");
        assert_eq!(fmi2GetReal(c, odd, 1, value.as_mut_ptr()), ERROR);
        assert_eq!(fmi2GetReal(c, &vr, usize::MAX, value.as_mut_ptr()), ERROR);
        assert_eq!(fmi2SetReal(c, ptr::null(), 1, value.as_ptr()), ERROR);
        assert_eq!(fmi2SetReal(c, &vr, 1, ptr::null()), ERROR);
        assert_eq!(fmi2SetReal(c, &vr, usize::MAX / 4, value.as_ptr()), ERROR);
        assert_eq!(fmi2SetString(c, &(V::Label as u32), 1, &ptr::null()), ERROR);
        assert_eq!(fmi2GetRealStatus(c, fmi2LastSuccessfulTime, ptr::null_mut()), ERROR);
        assert_eq!(fmi2SetRealInputDerivatives(c, &0, 1, ptr::null(), value.as_ptr()), ERROR);
    }
}

#[test]
fn every_variable_is_of_its_type_alone() {
    let importer = Importer::default();
    let component = importer.instantiate();
    let (c, unknown) = (component.c, V::ALL.len() as u32);
    unsafe {
        for &variable in V::ALL {
            let row = V::TABLE[variable as usize];
            let vr = variable as u32;
            let got = [
                fmi2GetReal(c, &vr, 1, &mut 0.0),
                fmi2GetInteger(c, &vr, 1, &mut 0),
                fmi2GetBoolean(c, &vr, 1, &mut 0),
                fmi2GetString(c, &vr, 1, &mut ptr::null()),
            ];
            let place = match row.kind.name() {
                "Real" => 0,
                "Integer" | "Enumeration" => 1,
                "Boolean" => 2,
                _ => 3,
            };
            let expected = std::array::from_fn(|i| if i == place { OK } else { ERROR });
            assert_eq!(got, expected, "{}", row.name);
            importer.messages.take();
            let wrong = if place == 0 {
                fmi2SetInteger(c, &vr, 1, &0)
            } else {
                fmi2SetReal(c, &vr, 1, &0.0)
            };
            assert_eq!(wrong, ERROR);
            assert!(importer.last().contains(&format!("is of type {}", row.kind.name())));
        }
        for vr in [unknown, u32::MAX] {
            assert_eq!(fmi2GetReal(c, &vr, 1, &mut 0.0), ERROR);
            assert_eq!(fmi2SetReal(c, &vr, 1, &0.0), ERROR);
            let expected = format!("fmi2SetReal: no variable has value reference {vr}");
            assert_eq!(importer.last(), expected);
        }
    }
}

#[test]
fn what_may_be_set_depends_on_role_and_state() {
    let importer = Importer::default();
    let component = importer.instantiate();
    let states = [CallState::Instantiated, CallState::InitializationMode, CallState::StepComplete];
    for (variable, settable, reason) in [
        (V::Input, [true; 3], ""),
        (V::Gain, [true; 3], ""),
        (V::Offset, [true, true, false], "is a fixed parameter and cannot be set after init"),
        (V::Output, [false; 3], "is an output and cannot be set"),
        (V::Seen, [false; 3], "is a local variable and cannot be set"),
        (V::Period, [false; 3], "is a constant and cannot be set"),
    ] {
        for (state, settable) in states.into_iter().zip(settable) {
            component.force(state);
            let status = component.set(variable, 1.0);
            assert_eq!(status == OK, settable, "{variable:?} in {state:?}");
            assert!(settable || importer.last().contains(reason), "{}", importer.last());
            assert_eq!(component.state(), state);
        }
    }
}

#[test]
fn parameters_stay_within_their_limits_and_inputs_take_anything() {
    let importer = Importer::default();
    let component = importer.instantiate();
    let c = component.c;
    for value in [-0.1, 10.1, f64::NAN, f64::INFINITY] {
        assert_eq!(component.set(V::Gain, value), ERROR);
        assert!(importer.last().contains("variable \"gain\" cannot be "), "{}", importer.last());
        assert_eq!(component.get(V::Gain), 1.0);
        assert_eq!(component.set(V::Input, value), OK);
    }
    for (vr, value, reason) in [
        (V::Order, 1, "variable \"order\" cannot be 1: -4 to 0 is allowed"),
        (V::Mode, 3, "variable \"mode\" cannot be 3: its items are 1 Run, 2 Fail"),
    ] {
        assert_eq!(unsafe { fmi2SetInteger(c, &(vr as u32), 1, &value) }, ERROR);
        assert_eq!(importer.last(), format!("fmi2SetInteger: {reason}"));
    }
    for (variable, value, reason) in [
        (V::Gain, 10.000_000_1, "variable \"gain\" cannot be 10.0000001: 0 to 10 is allowed"),
        (V::Offset, f64::NAN, "variable \"offset\" cannot be NaN: finite values are allowed"),
    ] {
        assert_eq!(component.set(variable, value), ERROR);
        assert_eq!(importer.last(), format!("fmi2SetReal: {reason}"));
    }
    for (variable, value, status) in
        [(V::Order, 1, ERROR), (V::Order, -4, OK), (V::Mode, 0, ERROR), (V::Mode, 3, ERROR)]
    {
        assert_eq!(unsafe { fmi2SetInteger(c, &(variable as u32), 1, &value) }, status);
    }
}

#[test]
fn a_refused_call_sets_nothing() {
    let importer = Importer::default();
    let component = importer.instantiate();
    let vr = [V::Input, V::Gain, V::Output].map(|variable| variable as u32);
    unsafe {
        assert_eq!(fmi2SetReal(component.c, vr.as_ptr(), 3, [0.5; 3].as_ptr()), ERROR);
        let orders = [1, 4];
        let derivatives = [1.0, 1.0];
        let status = fmi2SetRealInputDerivatives(
            component.c,
            [0, 0].as_ptr(),
            2,
            orders.as_ptr(),
            derivatives.as_ptr(),
        );
        assert_eq!(status, ERROR);
    }
    assert_eq!((component.get(V::Input), component.get(V::Gain)), (0.0, 1.0));
    let fresh = Importer::default();
    assert_eq!(component.serialised(), fresh.instantiate().serialised());
}

#[test]
fn values_can_be_read_in_every_state_that_allows_it() {
    let importer = Importer::default();
    let component: Component<'_> = importer.instantiate();
    for state in CallState::ALL.into_iter().skip(1) {
        component.force(state);
        let allowed = crate::Function::fmi2GetReal.allowed_states().contains(state as u8);
        let mut value = 0.0;
        let status = unsafe { fmi2GetReal(component.c, &(V::Period as u32), 1, &mut value) };
        assert_eq!((status == OK, value == 0.01), (allowed, allowed));
    }
}
