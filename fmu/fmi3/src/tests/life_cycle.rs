//! Creation, logging, initialisation, reset.

use std::ffi::CStr;
use std::ptr;

use steerguard_fmu_core::Block;

use super::toy::{PAYLOAD, ToyVariable as V};
use super::{BLOCK, ERROR, Importer, OK, TOKEN, WARNING, fmi3, log, sealed};
use crate::CallState;
use crate::types::*;

#[test]
fn the_version_is_3_0() {
    assert_eq!(unsafe { CStr::from_ptr(fmi3::fmi3GetVersion()) }, c"3.0");
}

#[test]
fn instantiation_is_refused_with_the_reason() {
    let importer = Importer::default();
    let refused = |c: fmi3Instance, reason: &str| {
        assert!(c.is_null());
        assert!(importer.last().contains(reason), "{}", importer.last());
        assert_eq!(importer.messages.borrow().last().unwrap().0, ERROR);
    };
    refused(importer.try_instantiate(c"", TOKEN, true, true, 0), "name is NULL or empty");
    refused(importer.try_instantiate(c"toy", c"{t}", true, true, 0), "is not the one baked into");
    refused(importer.try_instantiate(c"toy", TOKEN, true, true, 1), "within a step");
    BLOCK.set(&Block::UNBAKED);
    refused(importer.try_instantiate(c"toy", TOKEN, true, true, 0), "no design is baked into");
    BLOCK.set(sealed("{toy}", &[1]));
    refused(importer.try_instantiate(c"toy", TOKEN, true, true, 0), "payload is no number");
    BLOCK.set(sealed("{toy}", &(-1.0_f64).to_le_bytes()));
    refused(importer.try_instantiate(c"toy", TOKEN, true, true, 0), "period");
    BLOCK.set(sealed("{toy}", &PAYLOAD));
    let environment = importer.environment();
    let (name, token) = (c"toy".as_ptr(), TOKEN.as_ptr());
    unsafe {
        let none = ptr::null();
        let c = fmi3::fmi3InstantiateModelExchange(name, token, none, 0, 1, environment, Some(log));
        refused(c, "fmi3InstantiateModelExchange: this FMU is for Co-Simulation");
        let c = fmi3::fmi3InstantiateScheduledExecution(
            name,
            token,
            none,
            0,
            1,
            environment,
            Some(log),
            None,
            None,
            None,
        );
        refused(c, "fmi3InstantiateScheduledExecution: this FMU is for Co-Simulation");
    }
}

#[test]
fn an_importer_may_give_no_log() {
    unsafe {
        let (name, token, null) = (c"toy".as_ptr(), TOKEN.as_ptr(), ptr::null_mut());
        let c = fmi3::fmi3InstantiateCoSimulation(
            name,
            token,
            ptr::null(),
            0,
            1,
            0,
            0,
            ptr::null(),
            0,
            null,
            None,
            None,
        );
        assert!(!c.is_null());
        assert_eq!(fmi3::fmi3EnterStepMode(c), ERROR);
        fmi3::fmi3FreeInstance(c);
        fmi3::fmi3FreeInstance(ptr::null_mut());
        let c = fmi3::fmi3InstantiateCoSimulation(
            ptr::null(),
            ptr::null(),
            ptr::null(),
            0,
            1,
            0,
            0,
            ptr::null(),
            0,
            null,
            None,
            None,
        );
        assert!(c.is_null());
    }
}

#[test]
fn only_categories_that_are_on_are_logged() {
    let importer = Importer::default();
    let component = importer.instantiate();
    let c = component.c;
    let refuse = || {
        importer.messages.borrow_mut().clear();
        assert_eq!(unsafe { fmi3::fmi3EnterStepMode(c) }, ERROR);
        importer.messages.borrow().len()
    };
    assert_eq!(refuse(), 1);
    let set = |on, names: &[*const _]| unsafe {
        fmi3::fmi3SetDebugLogging(c, on, names.len(), names.as_ptr())
    };
    assert_eq!((set(0, &[]), refuse()), (OK, 0));
    assert_eq!((set(1, &[c"logEvents".as_ptr()]), refuse()), (OK, 0));
    assert_eq!((set(1, &[c"logStatusError".as_ptr()]), refuse()), (OK, 1));
    assert_eq!(set(1, &[c"logStatusWarning".as_ptr(), c"logNothing".as_ptr()]), WARNING);
    assert_eq!(importer.last(), "fmi3SetDebugLogging: no category \"logNothing\"");
    assert_eq!((set(1, &[ptr::null()]), set(1, &[])), (ERROR, OK));
}

#[test]
fn initialisation_leads_where_the_importer_handles_events() {
    let importer = Importer::default();
    for (event_mode, state) in [(true, CallState::EventMode), (false, CallState::StepMode)] {
        let component = importer.instantiate_with(event_mode, false);
        let c = component.c;
        unsafe {
            assert_eq!(fmi3::fmi3EnterInitializationMode(c, 0, 0.0, f64::NAN, 0, 0.0), ERROR);
            assert_eq!(fmi3::fmi3EnterInitializationMode(c, 0, 0.0, 5.0, 1, 4.0), ERROR);
            assert_eq!(component.state(), CallState::Instantiated);
            assert_eq!(fmi3::fmi3EnterInitializationMode(c, 1, 1e-6, 5.0, 1, 6.0), OK);
            assert_eq!(fmi3::fmi3ExitInitializationMode(c), OK);
        }
        assert_eq!(component.state(), state);
    }
    let component = importer.instantiate();
    unsafe {
        assert_eq!(fmi3::fmi3SetInt64(component.c, &(V::Mode as u32), 1, &2, 1), OK);
        assert_eq!(fmi3::fmi3EnterInitializationMode(component.c, 0, 0.0, 0.0, 0, 0.0), OK);
        assert_eq!(fmi3::fmi3ExitInitializationMode(component.c), ERROR);
    }
    assert_eq!(importer.last(), "fmi3ExitInitializationMode: the toy was told to fail");
    assert_eq!(component.state(), CallState::Terminated);
}

#[test]
fn a_reset_makes_a_fresh_instance() {
    let importer = Importer::default();
    let fresh = importer.instantiate().serialised();
    let component = importer.instantiate().initialised(2.0, Some(9.0));
    assert_eq!(component.set(V::Input, 1.0), OK);
    assert!(component.step(2.0, 0.5).early);
    assert_ne!(component.serialised(), fresh);
    unsafe { assert_eq!(fmi3::fmi3Reset(component.c), OK) };
    assert_eq!(component.serialised(), fresh);
}
