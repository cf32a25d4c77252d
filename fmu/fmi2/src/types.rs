//! The C types of `fmi2TypesPlatform.h` and `fmi2FunctionTypes.h`, for the exporting side and for
//! importers alike. Function pointer types are in [`pointers`](crate::pointers).
#![allow(non_camel_case_types)]

use core::ffi::{c_char, c_int, c_uint, c_void};

use steerguard_fmu_core::Status;

/// Instance of an FMU.
pub type fmi2Component = *mut c_void;
/// Pointer of the importer's own, passed back to its callbacks.
pub type fmi2ComponentEnvironment = *mut c_void;
/// Saved state of an instance.
pub type fmi2FMUstate = *mut c_void;
/// Handle of a variable.
pub type fmi2ValueReference = c_uint;
/// Real number.
pub type fmi2Real = f64;
/// Integer and enumeration value.
pub type fmi2Integer = c_int;
/// [`fmi2True`] or [`fmi2False`].
pub type fmi2Boolean = c_int;
/// NUL-terminated string in UTF-8.
pub type fmi2String = *const c_char;
/// Byte of a serialised state.
pub type fmi2Byte = c_char;
/// Kind of FMU, see [`fmi2CoSimulation`]; an integer, since a caller may pass any value.
pub type fmi2Type = c_int;
/// Kind of status, see [`fmi2DoStepStatus`] and its fellows; an integer for the same reason.
pub type fmi2StatusKind = c_int;

/// True.
#[allow(non_upper_case_globals)]
pub const fmi2True: fmi2Boolean = 1;
/// False.
#[allow(non_upper_case_globals)]
pub const fmi2False: fmi2Boolean = 0;
/// FMU for Model Exchange.
#[allow(non_upper_case_globals)]
pub const fmi2ModelExchange: fmi2Type = 0;
/// FMU for Co-Simulation.
#[allow(non_upper_case_globals)]
pub const fmi2CoSimulation: fmi2Type = 1;
/// Status of an asynchronous step.
#[allow(non_upper_case_globals)]
pub const fmi2DoStepStatus: fmi2StatusKind = 0;
/// What an asynchronous step waits for.
#[allow(non_upper_case_globals)]
pub const fmi2PendingStatus: fmi2StatusKind = 1;
/// End of the last successful step.
#[allow(non_upper_case_globals)]
pub const fmi2LastSuccessfulTime: fmi2StatusKind = 2;
/// Whether the FMU wants to end the run.
#[allow(non_upper_case_globals)]
pub const fmi2Terminated: fmi2StatusKind = 3;

/// Result of a call. A number rather than an enumeration: an importer may receive any value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[repr(transparent)]
pub struct fmi2Status(pub c_int);

#[allow(non_upper_case_globals)]
impl fmi2Status {
    /// All well.
    pub const fmi2OK: Self = Self(0);
    /// Not quite right, but the computation can continue.
    pub const fmi2Warning: Self = Self(1);
    /// Not done; the importer decides what to do instead.
    pub const fmi2Discard: Self = Self(2);
    /// Refused or failed.
    pub const fmi2Error: Self = Self(3);
    /// The whole FMU is broken.
    pub const fmi2Fatal: Self = Self(4);
    /// Asynchronous step under way.
    pub const fmi2Pending: Self = Self(5);
}

impl From<Status> for fmi2Status {
    fn from(status: Status) -> Self {
        match status {
            Status::Ok => Self::fmi2OK,
            Status::Warning => Self::fmi2Warning,
            Status::Discard => Self::fmi2Discard,
            Status::Error => Self::fmi2Error,
            Status::Fatal => Self::fmi2Fatal,
        }
    }
}

/// Logger of the importer: environment, instance name, status, category, message as a printf
/// format, and its arguments.
pub type fmi2CallbackLogger = unsafe extern "C" fn(
    fmi2ComponentEnvironment,
    fmi2String,
    fmi2Status,
    fmi2String,
    fmi2String,
    ...
);
/// Allocator of the importer: number and size of objects; zeroed memory or NULL.
pub type fmi2CallbackAllocateMemory = unsafe extern "C" fn(usize, usize) -> *mut c_void;
/// Releases what [`fmi2CallbackAllocateMemory`] gave.
pub type fmi2CallbackFreeMemory = unsafe extern "C" fn(*mut c_void);
/// Called at the end of an asynchronous step.
pub type fmi2StepFinished = unsafe extern "C" fn(fmi2ComponentEnvironment, fmi2Status);

/// Functions that the importer offers to the FMU; all of them may be missing.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
#[allow(non_snake_case)]
pub struct fmi2CallbackFunctions {
    /// Takes log messages.
    pub logger: Option<fmi2CallbackLogger>,
    /// Gives zeroed memory.
    pub allocateMemory: Option<fmi2CallbackAllocateMemory>,
    /// Takes it back.
    pub freeMemory: Option<fmi2CallbackFreeMemory>,
    /// Called after a completed step, which is over by then.
    pub stepFinished: Option<fmi2StepFinished>,
    /// Passed back to the logger.
    pub componentEnvironment: fmi2ComponentEnvironment,
}

/// Result of `fmi2NewDiscreteStates` (Model Exchange).
#[derive(Debug, Clone, Copy)]
#[repr(C)]
#[allow(non_snake_case)]
pub struct fmi2EventInfo {
    /// Another event iteration is wanted.
    pub newDiscreteStatesNeeded: fmi2Boolean,
    /// The run is to end.
    pub terminateSimulation: fmi2Boolean,
    /// Nominal values have changed.
    pub nominalsOfContinuousStatesChanged: fmi2Boolean,
    /// Continuous states have changed.
    pub valuesOfContinuousStatesChanged: fmi2Boolean,
    /// `nextEventTime` is valid.
    pub nextEventTimeDefined: fmi2Boolean,
    /// Time of the next time event.
    pub nextEventTime: fmi2Real,
}
