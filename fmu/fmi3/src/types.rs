//! The C types of `fmi3PlatformTypes.h` and `fmi3FunctionTypes.h`, for the exporting side and for importers
//! alike. Function pointer types are in [`pointers`](crate::pointers).
#![allow(non_camel_case_types)]

use core::ffi::{c_char, c_int, c_void};

use steerguard_fmu_core::Status;

/// Instance of an FMU.
pub type fmi3Instance = *mut c_void;
/// Pointer of the importer's own, passed back to its callbacks.
pub type fmi3InstanceEnvironment = *mut c_void;
/// Saved state of an instance.
pub type fmi3FMUState = *mut c_void;
/// Handle of a variable.
pub type fmi3ValueReference = u32;
/// Single precision.
pub type fmi3Float32 = f32;
/// Double precision.
pub type fmi3Float64 = f64;
/// 8 bits, signed.
pub type fmi3Int8 = i8;
/// 8 bits, unsigned.
pub type fmi3UInt8 = u8;
/// 16 bits, signed.
pub type fmi3Int16 = i16;
/// 16 bits, unsigned.
pub type fmi3UInt16 = u16;
/// 32 bits, signed.
pub type fmi3Int32 = i32;
/// 32 bits, unsigned.
pub type fmi3UInt32 = u32;
/// 64 bits, signed; also for enumerations.
pub type fmi3Int64 = i64;
/// 64 bits, unsigned.
pub type fmi3UInt64 = u64;
/// C's `bool`: [`fmi3True`] or [`fmi3False`]; a byte, since a caller may pass any value.
pub type fmi3Boolean = u8;
/// NUL-terminated string in UTF-8.
pub type fmi3String = *const c_char;
/// Byte of a serialised state.
pub type fmi3Byte = u8;
/// Binary data.
pub type fmi3Binary = *const fmi3Byte;
/// C's `bool`: [`fmi3ClockActive`] or [`fmi3ClockInactive`].
pub type fmi3Clock = u8;
/// Kind of a dependency; an integer, since a caller may pass any value.
pub type fmi3DependencyKind = c_int;
/// What is known of a clock's interval; an integer for the same reason.
pub type fmi3IntervalQualifier = c_int;

/// True.
#[allow(non_upper_case_globals)]
pub const fmi3True: fmi3Boolean = 1;
/// False.
#[allow(non_upper_case_globals)]
pub const fmi3False: fmi3Boolean = 0;
/// The clock ticks.
#[allow(non_upper_case_globals)]
pub const fmi3ClockActive: fmi3Clock = 1;
/// It does not.
#[allow(non_upper_case_globals)]
pub const fmi3ClockInactive: fmi3Clock = 0;

/// Result of a call. A number rather than an enumeration: an importer may receive any value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[repr(transparent)]
pub struct fmi3Status(pub c_int);

#[allow(non_upper_case_globals)]
impl fmi3Status {
    /// All well.
    pub const fmi3OK: Self = Self(0);
    /// Not quite right, but the computation can continue.
    pub const fmi3Warning: Self = Self(1);
    /// Not done; the importer decides what to do instead.
    pub const fmi3Discard: Self = Self(2);
    /// Refused or failed.
    pub const fmi3Error: Self = Self(3);
    /// The whole FMU is broken.
    pub const fmi3Fatal: Self = Self(4);
}

impl From<Status> for fmi3Status {
    fn from(status: Status) -> Self {
        match status {
            Status::Ok => Self::fmi3OK,
            Status::Warning => Self::fmi3Warning,
            Status::Discard => Self::fmi3Discard,
            Status::Error => Self::fmi3Error,
            Status::Fatal => Self::fmi3Fatal,
        }
    }
}

/// Takes log messages: environment, status, category, message.
pub type fmi3LogMessageCallback =
    unsafe extern "C" fn(fmi3InstanceEnvironment, fmi3Status, fmi3String, fmi3String);
/// Called within a step that offers intermediate values: never here.
pub type fmi3IntermediateUpdateCallback = unsafe extern "C" fn(
    fmi3InstanceEnvironment,
    fmi3Float64,
    fmi3Boolean,
    fmi3Boolean,
    fmi3Boolean,
    fmi3Boolean,
    *mut fmi3Boolean,
    *mut fmi3Float64,
);
/// Called at a clock's tick in Scheduled Execution: never here.
pub type fmi3ClockUpdateCallback = unsafe extern "C" fn(fmi3InstanceEnvironment);
/// Called around what must not be preempted in Scheduled Execution: never here.
pub type fmi3LockPreemptionCallback = unsafe extern "C" fn();
/// Its counterpart.
pub type fmi3UnlockPreemptionCallback = unsafe extern "C" fn();
