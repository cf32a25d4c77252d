//! The layer through its C functions, with a toy model.

#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "all of it plays the importer, whose part the layer's contract is to check"
)]

mod call_sequence;
mod life_cycle;
mod states;
mod steps;
mod toy;
mod values;

use std::cell::{Cell, RefCell};
use std::ffi::{CStr, c_char, c_void};
use std::ptr;

use steerguard_fmu_core::Block;

use crate::CallState;
use crate::instance::Instance;
use crate::types::*;

const GUID: &CStr = c"{toy}";

crate::export_fmi2!(toy::Toy, block = block());

thread_local! {
    /// What `fmi2Instantiate` finds baked into "the library".
    static BLOCK: Cell<&'static Block> = Cell::new(sealed("{toy}", &toy::PAYLOAD));
    /// Allocations less releases through the callbacks.
    static LIVE: Cell<i64> = const { Cell::new(0) };
    /// Whether the next allocations fail.
    static EXHAUSTED: Cell<bool> = const { Cell::new(false) };
}

fn block() -> &'static Block {
    BLOCK.get()
}

fn sealed(guid: &str, payload: &[u8]) -> &'static Block {
    Box::leak(Box::new(Block::sealed(guid, payload).unwrap()))
}

/// A log message: instance name, status, category, text.
#[derive(Debug, Clone, PartialEq)]
struct Message {
    name: String,
    status: fmi2Status,
    category: String,
    text: String,
}

/// What loads the FMU: takes its messages.
#[derive(Default)]
struct Importer {
    messages: RefCell<Vec<Message>>,
}

/// The logger, without the variable arguments: a message is finished text and has none.
unsafe extern "C" fn log(
    environment: *mut c_void,
    name: *const c_char,
    status: fmi2Status,
    category: *const c_char,
    text: *const c_char,
) {
    let string = |pointer| unsafe { CStr::from_ptr(pointer) }.to_str().unwrap().to_owned();
    let importer = unsafe { &*environment.cast::<Importer>() };
    let text = string(text);
    assert!(!text.contains(['%', '#']), "{text}");
    let (name, category) = (string(name), string(category));
    importer.messages.borrow_mut().push(Message { name, status, category, text });
}

unsafe extern "C" fn allocate(count: usize, size: usize) -> *mut c_void {
    if EXHAUSTED.get() {
        return ptr::null_mut();
    }
    LIVE.set(LIVE.get() + 1);
    // The size goes in front, so that the memory can be given back.
    let words = vec![0_u64; (count * size).div_ceil(8) + 1].into_boxed_slice();
    let length = words.len();
    let start = Box::into_raw(words).cast::<u64>();
    unsafe {
        start.write(length as u64);
        start.add(1).cast()
    }
}

unsafe extern "C" fn release(pointer: *mut c_void) {
    LIVE.set(LIVE.get() - 1);
    unsafe {
        let start = pointer.cast::<u64>().sub(1);
        let length = start.read() as usize;
        drop(Box::from_raw(ptr::slice_from_raw_parts_mut(start, length)));
    }
}

impl Importer {
    fn callbacks(&self) -> fmi2CallbackFunctions {
        type Plain = unsafe extern "C" fn(
            *mut c_void,
            *const c_char,
            fmi2Status,
            *const c_char,
            *const c_char,
        );
        fmi2CallbackFunctions {
            // A caller passes fixed arguments to a variadic function as to any other on the
            // platforms that run these tests.
            logger: Some(unsafe { std::mem::transmute::<Plain, fmi2CallbackLogger>(log) }),
            allocateMemory: Some(allocate),
            freeMemory: Some(release),
            stepFinished: None,
            componentEnvironment: ptr::from_ref(self).cast_mut().cast(),
        }
    }

    fn instantiate(&self) -> Component<'_> {
        let c = self.try_instantiate(c"toy", fmi2CoSimulation, GUID);
        assert!(!c.is_null(), "{:?}", self.messages);
        Component { c, importer: self }
    }

    fn try_instantiate(&self, name: &CStr, kind: fmi2Type, guid: &CStr) -> fmi2Component {
        let (callbacks, resources) = (self.callbacks(), c"file:///resources");
        unsafe {
            fmi2::fmi2Instantiate(
                name.as_ptr(),
                kind,
                guid.as_ptr(),
                resources.as_ptr(),
                &callbacks,
                fmi2False,
                fmi2True,
            )
        }
    }

    /// The last message's text.
    fn last(&self) -> String {
        self.messages.borrow().last().map(|message| message.text.clone()).unwrap_or_default()
    }
}

/// An instance, freed when dropped.
struct Component<'i> {
    c: fmi2Component,
    importer: &'i Importer,
}

impl Component<'_> {
    /// Makes it believe to be in a state, reachable or not.
    fn force(&self, state: CallState) {
        unsafe { (*self.c.cast::<Instance<toy::Toy>>()).machine.state = state };
    }

    fn state(&self) -> CallState {
        unsafe { (*self.c.cast::<Instance<toy::Toy>>()).machine.state }
    }

    /// Through initialisation, from `start` to `stop`.
    fn initialised(self, start: f64, stop: Option<f64>) -> Self {
        let (defined, stop) = (fmi2Boolean::from(stop.is_some()), stop.unwrap_or(0.0));
        unsafe {
            assert_eq!(fmi2::fmi2SetupExperiment(self.c, 0, 0.0, start, defined, stop), OK);
            assert_eq!(fmi2::fmi2EnterInitializationMode(self.c), OK);
            assert_eq!(fmi2::fmi2ExitInitializationMode(self.c), OK);
        }
        self
    }

    fn step(&self, point: f64, size: f64) -> fmi2Status {
        unsafe { fmi2::fmi2DoStep(self.c, point, size, fmi2True) }
    }

    fn set(&self, variable: toy::ToyVariable, value: f64) -> fmi2Status {
        unsafe { fmi2::fmi2SetReal(self.c, &(variable as u32), 1, &value) }
    }

    fn get(&self, variable: toy::ToyVariable) -> f64 {
        let mut value = f64::NAN;
        let status = unsafe { fmi2::fmi2GetReal(self.c, &(variable as u32), 1, &mut value) };
        assert_eq!(status, OK, "{}", self.importer.last());
        value
    }

    fn samples(&self) -> i32 {
        let mut value = -1;
        let vr = toy::ToyVariable::Samples as u32;
        assert_eq!(unsafe { fmi2::fmi2GetInteger(self.c, &vr, 1, &mut value) }, OK);
        value
    }

    fn last_successful_time(&self) -> f64 {
        let mut time = f64::NAN;
        let status = unsafe { fmi2::fmi2GetRealStatus(self.c, fmi2LastSuccessfulTime, &mut time) };
        assert_eq!(status, OK);
        time
    }

    /// Its whole state, serialised.
    fn serialised(&self) -> Vec<u8> {
        let mut state = ptr::null_mut();
        let mut size = 0;
        unsafe {
            assert_eq!(fmi2::fmi2GetFMUstate(self.c, &mut state), OK);
            assert_eq!(fmi2::fmi2SerializedFMUstateSize(self.c, state, &mut size), OK);
            let mut bytes = vec![0; size];
            let status =
                fmi2::fmi2SerializeFMUstate(self.c, state, bytes.as_mut_ptr().cast(), size);
            assert_eq!(status, OK);
            assert_eq!(fmi2::fmi2FreeFMUstate(self.c, &mut state), OK);
            assert!(state.is_null());
            bytes
        }
    }

    /// Takes a serialised state on; the status of the first call that is refused.
    fn restore(&self, bytes: &[u8]) -> fmi2Status {
        let mut state = ptr::null_mut();
        unsafe {
            let status = fmi2::fmi2DeSerializeFMUstate(
                self.c,
                bytes.as_ptr().cast(),
                bytes.len(),
                &mut state,
            );
            if status != OK {
                assert!(state.is_null());
                return status;
            }
            let status = fmi2::fmi2SetFMUstate(self.c, state);
            assert_eq!(fmi2::fmi2FreeFMUstate(self.c, &mut state), OK);
            status
        }
    }
}

impl Drop for Component<'_> {
    fn drop(&mut self) {
        if !self.c.is_null() {
            self.force(CallState::Instantiated);
            unsafe { fmi2::fmi2FreeInstance(self.c) };
        }
    }
}

const OK: fmi2Status = fmi2Status::fmi2OK;
const WARNING: fmi2Status = fmi2Status::fmi2Warning;
const DISCARD: fmi2Status = fmi2Status::fmi2Discard;
const ERROR: fmi2Status = fmi2Status::fmi2Error;
const FATAL: fmi2Status = fmi2Status::fmi2Fatal;
