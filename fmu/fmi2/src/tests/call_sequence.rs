//! Every function in every state.

use std::ffi::CStr;
use std::ptr;

use super::fmi2::*;
use super::toy::ToyVariable;
use super::{Component, GUID, Importer};
use crate::types::*;
use crate::{CallState, FUNCTION_COUNT, Function};

/// Calls a function with sound arguments.
fn call(function: Function, c: fmi2Component, state: fmi2FMUstate, bytes: &mut [u8]) -> fmi2Status {
    let (mut real, mut integer, mut boolean) = (0.0, 0, fmi2False);
    let (mut text, mut pointer, mut size) = (c"text".as_ptr(), ptr::null_mut(), 0);
    let [u, order, gain, hold, label] = [
        ToyVariable::Input,
        ToyVariable::Order,
        ToyVariable::Gain,
        ToyVariable::Hold,
        ToyVariable::Label,
    ]
    .map(|variable| variable as u32);
    let c_bytes: *mut fmi2Byte = bytes.as_mut_ptr().cast();
    unsafe {
        match function {
            Function::fmi2GetTypesPlatform => {
                assert_eq!(CStr::from_ptr(fmi2GetTypesPlatform()), c"default");
                fmi2Status::fmi2OK
            }
            Function::fmi2GetVersion => {
                assert_eq!(CStr::from_ptr(fmi2GetVersion()), c"2.0");
                fmi2Status::fmi2OK
            }
            Function::fmi2Instantiate => {
                let name = c"another".as_ptr();
                let c = fmi2Instantiate(name, 1, GUID.as_ptr(), ptr::null(), ptr::null(), 0, 0);
                assert!(!c.is_null());
                fmi2FreeInstance(c);
                fmi2Status::fmi2OK
            }
            Function::fmi2FreeInstance => {
                fmi2FreeInstance(c);
                fmi2Status::fmi2OK
            }
            Function::fmi2SetDebugLogging => fmi2SetDebugLogging(c, 1, 0, ptr::null()),
            Function::fmi2SetupExperiment => fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0),
            Function::fmi2EnterInitializationMode => fmi2EnterInitializationMode(c),
            Function::fmi2ExitInitializationMode => fmi2ExitInitializationMode(c),
            Function::fmi2Terminate => fmi2Terminate(c),
            Function::fmi2Reset => fmi2Reset(c),
            Function::fmi2GetReal => fmi2GetReal(c, &u, 1, &mut real),
            Function::fmi2GetInteger => fmi2GetInteger(c, &order, 1, &mut integer),
            Function::fmi2GetBoolean => fmi2GetBoolean(c, &hold, 1, &mut boolean),
            Function::fmi2GetString => fmi2GetString(c, &label, 1, &mut text),
            Function::fmi2SetReal => fmi2SetReal(c, &gain, 1, &real),
            Function::fmi2SetInteger => fmi2SetInteger(c, &order, 1, &integer),
            Function::fmi2SetBoolean => fmi2SetBoolean(c, &hold, 1, &boolean),
            Function::fmi2SetString => fmi2SetString(c, &label, 0, &text),
            Function::fmi2GetFMUstate => {
                let status = fmi2GetFMUstate(c, &mut pointer);
                Component::free_state(c, &mut pointer);
                status
            }
            Function::fmi2SetFMUstate => fmi2SetFMUstate(c, state),
            Function::fmi2FreeFMUstate => fmi2FreeFMUstate(c, &mut pointer),
            Function::fmi2SerializedFMUstateSize => fmi2SerializedFMUstateSize(c, state, &mut size),
            Function::fmi2SerializeFMUstate => {
                fmi2SerializeFMUstate(c, state, c_bytes, bytes.len())
            }
            Function::fmi2DeSerializeFMUstate => {
                let status = fmi2DeSerializeFMUstate(c, c_bytes, bytes.len(), &mut pointer);
                Component::free_state(c, &mut pointer);
                status
            }
            Function::fmi2GetDirectionalDerivative => {
                fmi2GetDirectionalDerivative(c, &u, 1, &u, 1, &real, &mut { real })
            }
            Function::fmi2SetRealInputDerivatives => {
                fmi2SetRealInputDerivatives(c, &u, 1, &1, &real)
            }
            Function::fmi2GetRealOutputDerivatives => {
                fmi2GetRealOutputDerivatives(c, &u, 1, &1, &mut real)
            }
            Function::fmi2DoStep => fmi2DoStep(c, 0.0, 0.01, fmi2True),
            Function::fmi2CancelStep => fmi2CancelStep(c),
            Function::fmi2GetStatus => fmi2GetStatus(c, 0, &mut fmi2Status::fmi2OK.clone()),
            Function::fmi2GetRealStatus => fmi2GetRealStatus(c, 2, &mut real),
            Function::fmi2GetIntegerStatus => fmi2GetIntegerStatus(c, 0, &mut integer),
            Function::fmi2GetBooleanStatus => fmi2GetBooleanStatus(c, 3, &mut boolean),
            Function::fmi2GetStringStatus => fmi2GetStringStatus(c, 1, &mut text),
            Function::fmi2EnterEventMode => fmi2EnterEventMode(c),
            Function::fmi2NewDiscreteStates => fmi2NewDiscreteStates(c, ptr::null_mut()),
            Function::fmi2EnterContinuousTimeMode => fmi2EnterContinuousTimeMode(c),
            Function::fmi2CompletedIntegratorStep => {
                fmi2CompletedIntegratorStep(c, 0, &mut boolean, &mut integer)
            }
            Function::fmi2SetTime => fmi2SetTime(c, 0.0),
            Function::fmi2SetContinuousStates => fmi2SetContinuousStates(c, &real, 1),
            Function::fmi2GetDerivatives => fmi2GetDerivatives(c, &mut real, 1),
            Function::fmi2GetEventIndicators => fmi2GetEventIndicators(c, &mut real, 1),
            Function::fmi2GetContinuousStates => fmi2GetContinuousStates(c, &mut real, 1),
            Function::fmi2GetNominalsOfContinuousStates => {
                fmi2GetNominalsOfContinuousStates(c, &mut real, 1)
            }
        }
    }
}

/// Functions that take no instance.
fn without_instance(function: Function) -> bool {
    use Function::{fmi2GetTypesPlatform, fmi2GetVersion, fmi2Instantiate};
    matches!(function, fmi2GetTypesPlatform | fmi2GetVersion | fmi2Instantiate)
}

/// Whether a function is refused in a state for the call sequence.
fn refused(function: Function, state: CallState) -> bool {
    let importer = Importer::default();
    let mut component = importer.instantiate();
    let mut saved = ptr::null_mut();
    assert_eq!(unsafe { fmi2GetFMUstate(component.c, &mut saved) }, fmi2Status::fmi2OK);
    let mut bytes = component.serialised();
    component.force(state);
    importer.messages.borrow_mut().clear();

    let c = component.c;
    let status = call(function, c, saved, &mut bytes);
    let expected = format!("{}: not allowed in state {}", function.name(), state.name());
    let refused = importer.last() == expected;
    if refused && function != Function::fmi2FreeInstance {
        assert_eq!(status, fmi2Status::fmi2Error);
        assert_eq!(component.state(), state, "a refused call changes nothing");
    }
    if function == Function::fmi2FreeInstance && !refused {
        component.c = ptr::null_mut();
    }
    let another = importer.instantiate();
    Component::free_state(another.c, &mut saved);
    refused
}

#[test]
fn every_function_is_refused_exactly_where_the_table_says() {
    let mut cells = 0;
    for &function in Function::ALL {
        // Start and end: there is no instance.
        let status = call(function, ptr::null_mut(), ptr::null_mut(), &mut []);
        let needs_instance = !without_instance(function) && function != Function::fmi2FreeInstance;
        let expected = if needs_instance { fmi2Status::fmi2Error } else { fmi2Status::fmi2OK };
        assert_eq!(status, expected, "{function:?} without an instance");
        cells += 1;

        for state in CallState::ALL.into_iter().skip(1) {
            if !without_instance(function) {
                let allowed = function.allowed_states().contains(state as u8);
                assert_eq!(refused(function, state), !allowed, "{function:?} in {state:?}");
                cells += 1;
            }
        }
    }
    println!("call sequence: {cells} cells of (function, state) checked");
    assert_eq!(cells, FUNCTION_COUNT + 41 * 9);
}

#[test]
fn only_reading_values_early_is_tolerated_beyond_the_standard() {
    let mut tolerated = Vec::new();
    for &function in Function::ALL {
        for state in CallState::ALL {
            let standard = function.standard_states().contains(state as u8);
            let allowed = function.allowed_states().contains(state as u8);
            assert!(allowed || !standard);
            if allowed && !standard {
                tolerated.push((function.name(), state));
            }
        }
    }
    let early = |function| (function, CallState::Instantiated);
    assert_eq!(
        tolerated,
        ["fmi2GetReal", "fmi2GetInteger", "fmi2GetBoolean", "fmi2GetString"].map(early)
    );
}
