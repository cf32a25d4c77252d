//! Instantiation, logging, initialisation, reset, memory.

use std::ffi::CStr;
use std::ptr;

use steerguard_fmu_core::{BLOCK_SIZE, Block};

use super::fmi2::*;
use super::toy::{PAYLOAD, ToyVariable as V};
use super::{BLOCK, ERROR, EXHAUSTED, GUID, Importer, LIVE, OK, WARNING, sealed};
use crate::CallState;
use crate::types::*;

#[test]
fn instantiation_is_refused_with_the_reason() {
    let damaged = {
        let block = sealed("{toy}", &PAYLOAD).load();
        let mut bytes = block;
        bytes[70] ^= 1;
        // SAFETY: a block is its bytes.
        Box::leak(Box::new(unsafe { std::mem::transmute::<[u8; BLOCK_SIZE], Block>(bytes) }))
    };
    static UNBAKED: Block = Block::UNBAKED;
    let good = sealed("{toy}", &PAYLOAD);
    let infinite = sealed("{toy}", &f64::INFINITY.to_le_bytes());
    let cases: [(&'static Block, &CStr, fmi2Type, &CStr, &str); 8] = [
        (good, c"", 1, GUID, "the instance name is NULL or empty"),
        (good, c"a", 0, GUID, "for Co-Simulation"),
        (good, c"a", 7, GUID, "for Co-Simulation"),
        (good, c"a", 1, c"{other}", "the GUID is not the one baked into this library"),
        (&UNBAKED, c"a", 1, GUID, "no design is baked into this library"),
        (damaged, c"a", 1, GUID, "the design baked into this library is damaged"),
        (sealed("{toy}", b"123"), c"a", 1, GUID, "the toy's payload is no number"),
        (infinite, c"a", 1, GUID, "the sample period baked into this library is not positive"),
    ];
    let importer = Importer::default();
    for (block, name, kind, guid, reason) in cases {
        BLOCK.set(block);
        assert!(importer.try_instantiate(name, kind, guid).is_null());
        let messages = importer.messages.take();
        let [message] = messages.as_slice() else { panic!("{messages:?}") };
        assert!(message.text.starts_with("fmi2Instantiate: ") && message.text.contains(reason));
        assert_eq!((message.status, message.category.as_str()), (ERROR, "logStatusError"));
        assert_eq!(message.name.as_bytes(), name.to_bytes());
    }
    BLOCK.set(good);
    EXHAUSTED.set(true);
    assert!(importer.try_instantiate(c"a", 1, GUID).is_null());
    EXHAUSTED.set(false);
    assert_eq!(importer.last(), "fmi2Instantiate: out of memory");
    assert_eq!(LIVE.get(), 0);
}

#[test]
fn callbacks_may_be_missing_and_are_copied() {
    let run = |callbacks: *const fmi2CallbackFunctions| unsafe {
        let c = fmi2Instantiate(
            c"a".as_ptr(),
            fmi2CoSimulation,
            GUID.as_ptr(),
            ptr::null(),
            callbacks,
            fmi2False,
            fmi2True,
        );
        assert!(!c.is_null());
        let mut state = ptr::null_mut();
        assert_eq!(fmi2GetFMUstate(c, &mut state), OK);
        assert_eq!(fmi2DoStep(c, 0.0, 0.01, 0), ERROR);
        assert_eq!(fmi2FreeFMUstate(c, &mut state), OK);
        fmi2FreeInstance(c);
        let wrong = c"{wrong}".as_ptr();
        let none = fmi2Instantiate(c"a".as_ptr(), 1, wrong, ptr::null(), callbacks, 0, 0);
        assert!(none.is_null());
    };
    run(ptr::null());
    let importer = Importer::default();
    let all = importer.callbacks();
    let none = fmi2CallbackFunctions {
        logger: None,
        allocateMemory: None,
        freeMemory: None,
        ..importer.callbacks()
    };
    run(&none);
    run(&fmi2CallbackFunctions { logger: None, ..all });
    run(&fmi2CallbackFunctions { freeMemory: None, ..all });
    assert_eq!(LIVE.get(), 0);

    let mut callbacks = Box::new(all);
    unsafe {
        let mut name = c"name".to_owned().into_bytes_with_nul();
        let pointer: *const std::ffi::c_char = name.as_ptr().cast();
        let c = fmi2Instantiate(pointer, 1, GUID.as_ptr(), ptr::null(), &*callbacks, 0, 1);
        callbacks.logger = None;
        drop(callbacks);
        name.fill(b'x');
        assert_eq!(fmi2CancelStep(c), ERROR);
        fmi2FreeInstance(c);
        fmi2FreeInstance(ptr::null_mut());
    }
    assert_eq!(importer.messages.borrow().last().unwrap().name, "name");
}

#[test]
fn long_and_odd_names_are_safe() {
    let importer = Importer::default();
    let long = std::ffi::CString::new("n".repeat(1000)).unwrap();
    assert!(importer.try_instantiate(&long, 0, GUID).is_null());
    assert_eq!(importer.messages.borrow()[0].name, "n".repeat(255));
}

#[test]
fn only_enabled_categories_are_logged() {
    let importer = Importer::default();
    let component = importer.instantiate().initialised(0.0, None);
    let categories = |names: &[&CStr]| {
        let names: Vec<_> = names.iter().map(|name| name.as_ptr()).collect();
        unsafe { fmi2SetDebugLogging(component.c, 1, names.len(), names.as_ptr()) }
    };
    let mut point = 0.0;
    let mut logged = || {
        importer.messages.take();
        assert_eq!(component.step(point, 0.01), OK);
        assert_eq!(component.step(point, 0.0), ERROR);
        point += 0.01;
        let messages = importer.messages.take();
        messages.into_iter().map(|message| message.category).collect::<Vec<_>>()
    };
    assert_eq!(logged(), ["logEvents", "logStatusError"]);
    assert_eq!(categories(&[c"logEvents"]), OK);
    assert_eq!(logged(), ["logEvents"]);
    assert_eq!(categories(&[c"logStatusError", c"logStatusDiscard"]), OK);
    assert_eq!(logged(), ["logStatusError"]);
    assert_eq!(categories(&[c"logAll"]), OK);
    assert_eq!(logged(), ["logEvents", "logStatusError"]);
    assert_eq!(categories(&[c"logStatusWarning", c"100%", c"logEvents"]), WARNING);
    assert_eq!(importer.last(), "fmi2SetDebugLogging: no category \"100?\"");
    assert_eq!(logged(), ["logEvents"]);
    unsafe {
        assert_eq!(fmi2SetDebugLogging(component.c, 0, 0, ptr::null()), OK);
        assert_eq!(logged(), [""; 0]);
        assert_eq!(fmi2SetDebugLogging(component.c, 1, 1, &ptr::null()), ERROR);
        assert_eq!(fmi2SetDebugLogging(component.c, 1, 1, ptr::null()), ERROR);
    }
    assert_eq!(categories(&[]), OK);
    assert_eq!(logged(), ["logEvents", "logStatusError"]);
}

#[test]
fn impossible_experiments_are_refused() {
    let importer = Importer::default();
    let component = importer.instantiate();
    let nan = f64::NAN;
    for (start, defined, stop, status) in [
        (nan, 0, 0.0, ERROR),
        (f64::INFINITY, 0, 0.0, ERROR),
        (0.0, 1, nan, ERROR),
        (0.0, 1, -1.0, ERROR),
        (0.0, 1, f64::INFINITY, ERROR),
        (0.0, 0, nan, OK),
        (-5.0, 1, -5.0, OK),
        (1.7e9, 1, 1.8e9, OK),
        (1e17, 0, 0.0, ERROR),
        (-1e300, 1, 0.0, ERROR),
    ] {
        let got = unsafe { fmi2SetupExperiment(component.c, 1, nan, start, defined, stop) };
        assert_eq!(got, status, "{start} {stop}");
    }
    assert_eq!(unsafe { fmi2SetupExperiment(component.c, 0, 0.0, 1e17, 0, 0.0) }, ERROR);
    let reason = "time cannot advance from 1e17 s: numbers there are 16 s apart, samples 0.01 s";
    assert_eq!(importer.last(), format!("fmi2SetupExperiment: {reason}"));
    // What is refused changes nothing: the run still starts where the last one accepted does.
    unsafe {
        assert_eq!(fmi2EnterInitializationMode(component.c), OK);
        assert_eq!(fmi2ExitInitializationMode(component.c), OK);
    }
    assert_eq!(component.step(1.7e9, 0.01), OK, "{}", importer.last());
}

#[test]
fn a_failed_initialisation_is_an_error_that_reset_ends() {
    let importer = Importer::default();
    let component = importer.instantiate();
    let fresh = component.serialised();
    unsafe {
        assert_eq!(fmi2SetInteger(component.c, &(V::Mode as u32), 1, &2), OK);
        assert_eq!(fmi2EnterInitializationMode(component.c), OK);
        assert_eq!(fmi2ExitInitializationMode(component.c), ERROR);
        assert_eq!(importer.last(), "fmi2ExitInitializationMode: the toy was told to fail");
        assert_eq!(component.state(), CallState::Error);
        assert_eq!(fmi2Reset(component.c), OK);
    }
    assert_eq!(component.serialised(), fresh);
    let component = component.initialised(0.0, None);
    assert_eq!(component.step(0.0, 0.01), OK);
}

#[test]
fn reset_is_a_fresh_instance_bit_for_bit() {
    let importer = Importer::default();
    let fresh = importer.instantiate().serialised();
    let component = importer.instantiate();
    assert_eq!(component.set(V::Gain, 3.0), OK);
    let component = component.initialised(1.0, Some(2.0));
    assert_eq!(component.set(V::Input, 0.5), OK);
    assert_eq!(component.step(1.0, 0.05), OK);
    assert_ne!(component.serialised(), fresh);
    unsafe { assert_eq!(fmi2Reset(component.c), OK) };
    assert_eq!(component.serialised(), fresh);
    assert_eq!(component.state(), CallState::Instantiated);
}

#[test]
fn all_memory_is_given_back_and_steps_take_none() {
    {
        let importer = Importer::default();
        let component = importer.instantiate().initialised(0.0, None);
        assert_eq!(LIVE.get(), 1);
        EXHAUSTED.set(true);
        for k in 0..100 {
            assert_eq!(component.set(V::Input, 0.5), OK);
            assert_eq!(component.step(f64::from(k) * 0.01, 0.01), OK);
        }
        let mut state = ptr::null_mut();
        assert_eq!(unsafe { fmi2GetFMUstate(component.c, &mut state) }, ERROR);
        assert_eq!(importer.last(), "fmi2GetFMUstate: out of memory");
        EXHAUSTED.set(false);
    }
    assert_eq!(LIVE.get(), 0);
}
