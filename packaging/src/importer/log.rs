//! Messages that an FMU logs.

use std::ffi::{CStr, c_char, c_void};
use std::fmt;
use std::sync::{Mutex, PoisonError};

use steerguard_fmi2::types::{
    fmi2CallbackFunctions, fmi2CallbackLogger, fmi2ComponentEnvironment, fmi2Status, fmi2String,
};

/// What an FMU had to say.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LogMessage {
    /// Status that the message accompanies.
    pub status: fmi2Status,
    /// Log category.
    pub category: String,
    /// Text; printf directives, which our own FMUs never send, are left as they are.
    pub text: String,
}

impl fmt::Display for LogMessage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

/// Where the messages of one instance arrive; an FMU may log from any thread.
#[derive(Default)]
pub(super) struct Log(Mutex<Vec<LogMessage>>);

impl Log {
    /// Messages since the last call.
    pub(super) fn take(&self) -> Vec<LogMessage> {
        std::mem::take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Callbacks that log into `self`, which must outlive the instance that is given them.
    pub(super) fn callbacks(&self) -> fmi2CallbackFunctions {
        fmi2CallbackFunctions {
            logger: Some(logger()),
            allocateMemory: Some(calloc),
            freeMemory: Some(free),
            stepFinished: None,
            componentEnvironment: (&raw const *self).cast_mut().cast(),
        }
    }
}

unsafe extern "C" {
    fn calloc(count: usize, size: usize) -> *mut c_void;
    fn free(memory: *mut c_void);
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
    // SAFETY: in the C calling conventions of all supported platforms a variadic call passes its
    // named arguments as a plain call does and the caller removes the others, so a function that
    // reads the named ones alone may be called so. Rust cannot define a variadic function.
    unsafe { std::mem::transmute::<WithoutArguments, fmi2CallbackLogger>(receive) }
}

unsafe extern "C" fn receive(
    environment: fmi2ComponentEnvironment,
    _instance: fmi2String,
    status: fmi2Status,
    category: fmi2String,
    message: fmi2String,
) {
    // SAFETY: `callbacks` made the environment from a `Log` that outlives the instance.
    let Some(log) = (unsafe { environment.cast::<Log>().as_ref() }) else { return };
    // SAFETY: the standard has both be NULL or NUL-terminated strings, valid during the call.
    let (category, text) = unsafe { (text(category), text(message)) };
    let mut messages = log.0.lock().unwrap_or_else(PoisonError::into_inner);
    messages.push(LogMessage { status, category, text });
}

/// # Safety
/// `string` is NULL or a NUL-terminated string.
pub(super) unsafe fn text(string: *const c_char) -> String {
    if string.is_null() {
        return String::new();
    }
    // SAFETY: not NULL, so NUL-terminated, as the caller warrants.
    unsafe { CStr::from_ptr(string) }.to_string_lossy().into_owned()
}
