//! The importer's side of an instance: callbacks that count and that check what they are told.

use std::cell::Cell;
use std::ffi::{CStr, c_void};
use std::ptr;

use steerguard_fmi2::types::{
    fmi2CallbackFunctions, fmi2CallbackLogger, fmi2ComponentEnvironment, fmi2Status, fmi2String,
};

/// What the FMU has asked of the callbacks on this thread.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Calls of allocateMemory that gave memory.
    pub allocations: u64,
    /// Calls of freeMemory.
    pub frees: u64,
    /// Log messages.
    pub messages: u64,
}

thread_local! {
    static COUNTS: Cell<Counts> = const {
        Cell::new(Counts { allocations: 0, frees: 0, messages: 0 })
    };
    static OUT_OF_MEMORY: Cell<bool> = const { Cell::new(false) };
}

/// What the FMU has asked for so far on this thread.
pub fn counts() -> Counts {
    COUNTS.get()
}

/// Whether allocateMemory fails from now on, on this thread.
pub fn set_out_of_memory(out: bool) {
    OUT_OF_MEMORY.set(out);
}

/// Memory and log of this module.
pub fn callbacks() -> fmi2CallbackFunctions {
    fmi2CallbackFunctions {
        logger: Some(logger()),
        allocateMemory: Some(allocate),
        freeMemory: Some(release),
        stepFinished: None,
        componentEnvironment: environment(),
    }
}

/// The categories of the standard, and our own.
const CATEGORIES: [&str; 9] = [
    "logEvents",
    "logSingularLinearSystems",
    "logNonlinearSystems",
    "logDynamicStateSelection",
    "logStatusWarning",
    "logStatusDiscard",
    "logStatusError",
    "logStatusFatal",
    "logStatusPending",
];

static ENVIRONMENT: u8 = 0;

fn environment() -> fmi2ComponentEnvironment {
    (&raw const ENVIRONMENT).cast_mut().cast()
}

unsafe extern "C" {
    fn calloc(count: usize, size: usize) -> *mut c_void;
    fn free(memory: *mut c_void);
}

unsafe extern "C" fn allocate(count: usize, size: usize) -> *mut c_void {
    if OUT_OF_MEMORY.get() {
        return ptr::null_mut();
    }
    // SAFETY: calloc takes any arguments.
    let memory = unsafe { calloc(count, size) };
    if !memory.is_null() {
        COUNTS.set(Counts { allocations: counts().allocations + 1, ..counts() });
    }
    memory
}

unsafe extern "C" fn release(memory: *mut c_void) {
    assert!(!memory.is_null(), "the FMU frees NULL");
    COUNTS.set(Counts { frees: counts().frees + 1, ..counts() });
    // SAFETY: the FMU gives back what `allocate` gave; valgrind and AddressSanitizer watch.
    unsafe { free(memory) }
}

fn logger() -> fmi2CallbackLogger {
    type WithoutArguments = unsafe extern "C" fn(
        fmi2ComponentEnvironment,
        fmi2String,
        fmi2Status,
        fmi2String,
        fmi2String,
    );
    let receive: WithoutArguments = receive;
    // SAFETY: in the C calling conventions of all supported platforms a function that reads the
    // named arguments alone may be called as a variadic one. Rust cannot define a variadic function.
    unsafe { std::mem::transmute::<WithoutArguments, fmi2CallbackLogger>(receive) }
}

unsafe extern "C" fn receive(
    from: fmi2ComponentEnvironment,
    _instance: fmi2String,
    status: fmi2Status,
    category: fmi2String,
    message: fmi2String,
) {
    COUNTS.set(Counts { messages: counts().messages + 1, ..counts() });
    assert_eq!(from, environment(), "the environment pointer comes back");
    assert!((0..=4).contains(&status.0), "status {status:?} of a message");
    let [category, message] = [category, message].map(|text| {
        assert!(!text.is_null(), "a message has a category and a text");
        // SAFETY: the standard has both be NUL-terminated and valid during the call.
        unsafe { CStr::from_ptr(text) }.to_str().expect("messages are UTF-8")
    });
    assert!(CATEGORIES.contains(&category), "category {category:?}");
    assert!(!message.is_empty() && !message.contains(['%', '#']), "message {message:?}");
}
