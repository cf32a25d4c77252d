//! Every function in every state.

use std::ffi::c_char;
use std::ptr;

use super::{Component, ERROR, Importer, OK, fmi3};
use crate::types::*;
use crate::{CallState, FUNCTION_COUNT, Function, PROVIDED_COUNT};

/// Arguments that are sound and ask for little: no elements, fresh memory for results.
trait Sound {
    fn sound() -> Self;
}

macro_rules! sound {
    ($($type:ty: $value:expr;)+) => { $(impl Sound for $type {
        fn sound() -> Self {
            $value
        }
    })+ };
}

sound! {
    usize: 0;
    f64: 0.0;
    u32: 0;
    u8: 0;
    *mut std::ffi::c_void: ptr::null_mut();
}

impl<T> Sound for Option<T> {
    fn sound() -> Self {
        None
    }
}

/// Memory of its own, never given back.
fn memory<T>() -> *mut T {
    Box::leak(Box::new([0_u64; 8])).as_mut_ptr().cast()
}

macro_rules! memory {
    ($($type:ty)+) => { $(
        impl Sound for *mut $type {
            fn sound() -> Self {
                memory()
            }
        }

        impl Sound for *const $type {
            fn sound() -> Self {
                memory()
            }
        }
    )+ };
}

memory! { f32 f64 i8 u8 i16 u16 i32 u32 i64 u64 usize *const u8 *const c_char *mut std::ffi::c_void }

/// What a function says, where it says something.
trait Answer {
    fn status(self) -> Option<fmi3Status>;
}

impl Answer for fmi3Status {
    fn status(self) -> Option<fmi3Status> {
        Some(self)
    }
}

macro_rules! no_answer {
    ($($type:ty)+) => { $(impl Answer for $type {
        fn status(self) -> Option<fmi3Status> {
            None
        }
    })+ };
}

no_answer! { () *mut std::ffi::c_void *const c_char }

macro_rules! argument {
    (instance, $c:ident) => {
        $c
    };
    ($other:ident, $c:ident) => {
        Sound::sound()
    };
}

macro_rules! define_call {
    ({}
        provided: $(fn $p:ident($($pa:ident: $pt:ty),*) -> $pr:ty;)+
        $(absent $reason:literal: $(fn $a:ident($($aa:ident: $at:ty),*) -> $ar:ty;)+)+
    ) => {
        /// Calls a function with sound arguments.
        fn call(function: Function, _c: fmi3Instance) -> Option<fmi3Status> {
            unsafe {
                match function {
                    $(Function::$p => fmi3::$p($(argument!($pa, _c)),*).status(),)+
                    $($(Function::$a => fmi3::$a($(argument!($aa, _c)),*).status(),)+)+
                }
            }
        }

        /// Why a function is not provided.
        fn reason(function: Function) -> Option<&'static str> {
            match function {
                $($(Function::$a => Some($reason),)+)+
                _ => None,
            }
        }
    };
}

crate::fmi3_functions!([define_call] {});

/// Functions that take no instance.
fn without_instance(function: Function) -> bool {
    use Function::*;
    matches!(
        function,
        fmi3GetVersion
            | fmi3InstantiateCoSimulation
            | fmi3InstantiateModelExchange
            | fmi3InstantiateScheduledExecution
    )
}

#[test]
fn every_function_is_refused_exactly_where_the_table_says() {
    let mut cells = 0;
    for &function in Function::ALL.iter().take(PROVIDED_COUNT) {
        if without_instance(function) {
            continue;
        }
        // Start and end: there is no instance.
        let status = call(function, ptr::null_mut());
        assert!(status.is_none_or(|status| status == ERROR), "{function:?} without an instance");
        for state in CallState::ALL.into_iter().skip(1) {
            let importer = Importer::default();
            let mut component = importer.instantiate();
            component.force(state);
            let status = call(function, component.c);
            let expected = format!("{}: not allowed in state {}", function.name(), state.name());
            let refused = importer.last() == expected;
            let allowed = function.allowed_states().contains(state as u8);
            assert_eq!(refused, !allowed, "{function:?} in {state:?}: {}", importer.last());
            if function == Function::fmi3FreeInstance && !refused {
                component.c = ptr::null_mut();
            } else if refused {
                assert_eq!(component.state(), state, "a refused call changes nothing");
                assert!(status.is_none_or(|status| status == ERROR));
            }
            cells += 1;
        }
    }
    assert_eq!(cells, (PROVIDED_COUNT - 4) * 6);
}

#[test]
fn what_is_not_provided_says_so_in_every_state() {
    let mut absent = 0;
    for &function in Function::ALL {
        let Some(reason) = reason(function) else { continue };
        assert_eq!(call(function, ptr::null_mut()), Some(ERROR));
        for state in CallState::ALL.into_iter().skip(1) {
            let importer = Importer::default();
            let component = importer.instantiate();
            component.force(state);
            assert_eq!(call(function, component.c), Some(ERROR));
            assert_eq!(importer.last(), format!("{}: {reason}", function.name()));
            let messages = importer.messages.borrow();
            assert_eq!((messages[0].0, messages[0].1.as_str()), (ERROR, "logStatusError"));
            assert_eq!(component.state(), state);
        }
        absent += 1;
    }
    assert_eq!(absent, FUNCTION_COUNT - PROVIDED_COUNT);
}

#[test]
fn types_that_no_variable_has_take_no_variable() {
    use Function::*;
    let importer = Importer::default();
    let component = importer.instantiate();
    let (c, vr) = (component.c, 0);
    for function in [fmi3GetFloat32, fmi3SetInt8, fmi3GetUInt64, fmi3SetBinary] {
        assert_eq!(call(function, c), Some(OK), "none is asked for");
    }
    let (mut single, wide) = (0.0, 0);
    unsafe {
        assert_eq!(fmi3::fmi3GetFloat32(c, &vr, 1, &mut single, 1), ERROR);
        assert_eq!(importer.last(), "fmi3GetFloat32: no variable is of this type");
        assert_eq!(fmi3::fmi3SetUInt64(c, &vr, 1, &wide, 1), ERROR);
        assert_eq!(importer.last(), "fmi3SetUInt64: no variable is of this type");
    }
}

#[test]
fn only_asking_for_the_clock_outside_event_mode_is_tolerated_beyond_the_standard() {
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
    let clock = |state| ("fmi3GetClock", state);
    let states = [CallState::InitializationMode, CallState::StepMode, CallState::Terminated];
    assert_eq!(tolerated, states.map(clock));
    // It does not tick there.
    let importer = Importer::default();
    let component = importer.instantiate().initialised(0.0, None);
    assert!(!component.ticks());
    drop::<Component<'_>>(component);
}
