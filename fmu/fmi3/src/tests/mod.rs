//! The layer through its C functions, with a toy model.

#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "all of it plays the importer, whose part the layer's contract is to check"
)]

mod call_sequence;
mod events;
mod life_cycle;
mod states;
mod toy;
mod values;

use std::cell::{Cell, RefCell};
use std::ffi::{CStr, c_char, c_void};
use std::ptr;

use steerguard_fmu_core::Block;

use crate::CallState;
use crate::instance::Instance;
use crate::types::*;

const TOKEN: &CStr = c"{toy}";

crate::export_fmi3!(toy::Toy, block = block());

thread_local! {
    /// What instantiation finds baked into "the library".
    static BLOCK: Cell<&'static Block> = Cell::new(sealed("{toy}", &toy::PAYLOAD));
}

fn block() -> &'static Block {
    BLOCK.get()
}

fn sealed(guid: &str, payload: &[u8]) -> &'static Block {
    Box::leak(Box::new(Block::sealed(guid, payload).unwrap()))
}

/// What loads the FMU: takes its messages, as status, category and text.
#[derive(Default)]
struct Importer {
    messages: RefCell<Vec<(fmi3Status, String, String)>>,
}

unsafe extern "C" fn log(
    environment: *mut c_void,
    status: fmi3Status,
    category: *const c_char,
    text: *const c_char,
) {
    let string = |pointer| unsafe { CStr::from_ptr(pointer) }.to_str().unwrap().to_owned();
    let importer = unsafe { &*environment.cast::<Importer>() };
    let text = string(text);
    assert!(!text.contains(['%', '#']), "{text}");
    importer.messages.borrow_mut().push((status, string(category), text));
}

impl Importer {
    fn environment(&self) -> fmi3InstanceEnvironment {
        ptr::from_ref(self).cast_mut().cast()
    }

    /// With Event Mode and early return.
    fn instantiate(&self) -> Component<'_> {
        self.instantiate_with(true, true)
    }

    fn instantiate_with(&self, event_mode: bool, early_return: bool) -> Component<'_> {
        let c = self.try_instantiate(c"toy", TOKEN, event_mode, early_return, 0);
        assert!(!c.is_null(), "{:?}", self.messages);
        Component { c, importer: self }
    }

    fn try_instantiate(
        &self,
        name: &CStr,
        token: &CStr,
        event_mode: bool,
        early_return: bool,
        intermediate: usize,
    ) -> fmi3Instance {
        unsafe {
            fmi3::fmi3InstantiateCoSimulation(
                name.as_ptr(),
                token.as_ptr(),
                ptr::null(),
                fmi3False,
                fmi3True,
                event_mode.into(),
                early_return.into(),
                [0; 4].as_ptr(),
                intermediate,
                self.environment(),
                Some(log),
                None,
            )
        }
    }

    /// The last message's text.
    fn last(&self) -> String {
        self.messages.borrow().last().map(|message| message.2.clone()).unwrap_or_default()
    }
}

/// An instance, freed when dropped.
struct Component<'i> {
    c: fmi3Instance,
    importer: &'i Importer,
}

/// What `fmi3DoStep` says.
#[derive(Debug, PartialEq)]
struct Step {
    status: fmi3Status,
    event: bool,
    early: bool,
    time: f64,
}

impl Component<'_> {
    /// Makes it believe to be in a state, reachable or not.
    fn force(&self, state: CallState) {
        unsafe { (*self.c.cast::<Instance<toy::Toy>>()).machine.state = state };
    }

    fn state(&self) -> CallState {
        unsafe { (*self.c.cast::<Instance<toy::Toy>>()).machine.state }
    }

    /// Through initialisation, from `start` to `stop`, to Step Mode.
    fn initialised(self, start: f64, stop: Option<f64>) -> Self {
        let (defined, stop) = (fmi3Boolean::from(stop.is_some()), stop.unwrap_or(0.0));
        unsafe {
            assert_eq!(fmi3::fmi3EnterInitializationMode(self.c, 0, 0.0, start, defined, stop), OK);
            assert_eq!(fmi3::fmi3ExitInitializationMode(self.c), OK);
            if self.state() == CallState::EventMode {
                self.update();
                assert_eq!(fmi3::fmi3EnterStepMode(self.c), OK);
            }
        }
        self
    }

    fn step(&self, point: f64, size: f64) -> Step {
        let (mut event, mut terminate, mut early, mut time) = (7, 7, 7, f64::NAN);
        let status = unsafe {
            let flags = (&mut event, &mut terminate, &mut early, &mut time);
            fmi3::fmi3DoStep(self.c, point, size, fmi3True, flags.0, flags.1, flags.2, flags.3)
        };
        if status < ERROR {
            assert_eq!(terminate, fmi3False);
        }
        Step { status, event: event == fmi3True, early: early == fmi3True, time }
    }

    /// `fmi3UpdateDiscreteStates`, which never asks for more.
    fn update(&self) {
        let (mut flags, mut time) = ([7; 5], f64::NAN);
        let [a, b, c, d, e] = &mut flags;
        let status = unsafe { fmi3::fmi3UpdateDiscreteStates(self.c, a, b, c, d, e, &mut time) };
        assert_eq!((status, flags), (OK, [fmi3False; 5]), "{}", self.importer.last());
    }

    fn ticks(&self) -> bool {
        let mut active = 7;
        let status = unsafe { fmi3::fmi3GetClock(self.c, &toy::CLOCK, 1, &mut active) };
        assert_eq!(status, OK, "{}", self.importer.last());
        active == fmi3ClockActive
    }

    fn set(&self, variable: toy::ToyVariable, value: f64) -> fmi3Status {
        unsafe { fmi3::fmi3SetFloat64(self.c, &(variable as u32), 1, &value, 1) }
    }

    fn get(&self, reference: u32) -> f64 {
        let mut value = f64::NAN;
        let status = unsafe { fmi3::fmi3GetFloat64(self.c, &reference, 1, &mut value, 1) };
        assert_eq!(status, OK, "{}", self.importer.last());
        value
    }

    fn samples(&self) -> i32 {
        let mut value = -1;
        let vr = toy::ToyVariable::Samples as u32;
        assert_eq!(unsafe { fmi3::fmi3GetInt32(self.c, &vr, 1, &mut value, 1) }, OK);
        value
    }

    /// Its whole state, serialised.
    fn serialised(&self) -> Vec<u8> {
        let mut state = ptr::null_mut();
        let mut size = 0;
        unsafe {
            assert_eq!(fmi3::fmi3GetFMUState(self.c, &mut state), OK);
            assert_eq!(fmi3::fmi3SerializedFMUStateSize(self.c, state, &mut size), OK);
            let mut bytes = vec![0; size];
            let status = fmi3::fmi3SerializeFMUState(self.c, state, bytes.as_mut_ptr(), size);
            assert_eq!(status, OK);
            assert_eq!(fmi3::fmi3FreeFMUState(self.c, &mut state), OK);
            assert!(state.is_null());
            bytes
        }
    }

    /// Takes a serialised state on; the status of the first call that is refused.
    fn restore(&self, bytes: &[u8]) -> fmi3Status {
        let mut state = ptr::null_mut();
        unsafe {
            let status =
                fmi3::fmi3DeserializeFMUState(self.c, bytes.as_ptr(), bytes.len(), &mut state);
            if status != OK {
                assert!(state.is_null());
                return status;
            }
            let status = fmi3::fmi3SetFMUState(self.c, state);
            assert_eq!(fmi3::fmi3FreeFMUState(self.c, &mut state), OK);
            status
        }
    }
}

impl Drop for Component<'_> {
    fn drop(&mut self) {
        if !self.c.is_null() {
            self.force(CallState::Instantiated);
            unsafe { fmi3::fmi3FreeInstance(self.c) };
        }
    }
}

const OK: fmi3Status = fmi3Status::fmi3OK;
const WARNING: fmi3Status = fmi3Status::fmi3Warning;
const DISCARD: fmi3Status = fmi3Status::fmi3Discard;
const ERROR: fmi3Status = fmi3Status::fmi3Error;
const FATAL: fmi3Status = fmi3Status::fmi3Fatal;
