//! The way in for every function: the instance behind a pointer, and arrays and strings from C.

use core::ffi::CStr;
use core::mem::MaybeUninit;
use core::slice;

use steerguard_fmu_core::{Fmu, Model};

use crate::Function;
use crate::instance::Instance;
use crate::types::{fmi2Component, fmi2Status, fmi2String};

pub(super) const OK: fmi2Status = fmi2Status::fmi2OK;

/// The instance behind `c`, if `function` may be called on it now.
///
/// # Errors
/// The status to return otherwise.
pub(super) unsafe fn enter<'a, F: Fmu>(
    c: fmi2Component,
    function: Function,
) -> Result<&'a mut Instance<F::Model>, fmi2Status> {
    // SAFETY: the contract of this module.
    let instance = unsafe { c.cast::<Instance<F::Model>>().as_mut() };
    let instance = instance.ok_or(fmi2Status::fmi2Error)?;
    let state = instance.machine.state;
    if function.allowed_states().contains(state) {
        Ok(instance)
    } else {
        Err(instance.refuse(function, |text| {
            text.str("not allowed in state ").str(state.name());
        }))
    }
}

/// Runs `body` on the instance behind `c`, if `function` may be called on it now.
pub(super) unsafe fn call<F: Fmu>(
    c: fmi2Component,
    function: Function,
    body: impl FnOnce(&mut Instance<F::Model>, Function) -> Result<fmi2Status, fmi2Status>,
) -> fmi2Status {
    // SAFETY: the contract of this module.
    let instance = unsafe { enter::<F>(c, function) };
    match instance.and_then(|instance| body(instance, function)) {
        Ok(status) | Err(status) => status,
    }
}

/// An array from C, if it may be one: not NULL unless empty, aligned, of possible size.
pub(super) unsafe fn array<'a, T>(pointer: *const T, length: usize) -> Option<&'a [T]> {
    if length == 0 {
        Some(&[])
    } else if is_array(pointer, length) {
        // SAFETY: just checked, and the contract of this module.
        Some(unsafe { slice::from_raw_parts(pointer, length) })
    } else {
        None
    }
}

/// The same for an array to be written.
pub(super) unsafe fn array_mut<'a, T>(
    pointer: *mut T,
    length: usize,
) -> Option<&'a mut [MaybeUninit<T>]> {
    if length == 0 {
        Some(&mut [])
    } else if is_array(pointer, length) {
        // SAFETY: just checked, and the contract of this module.
        Some(unsafe { slice::from_raw_parts_mut(pointer.cast(), length) })
    } else {
        None
    }
}

/// A place for one result.
pub(super) unsafe fn place<'a, T>(pointer: *mut T) -> Option<&'a mut MaybeUninit<T>> {
    // SAFETY: the contract of this module.
    unsafe { array_mut(pointer, 1) }?.first_mut()
}

fn is_array<T>(pointer: *const T, length: usize) -> bool {
    let bytes = length.checked_mul(size_of::<T>());
    !pointer.is_null()
        && pointer.is_aligned()
        && bytes.is_some_and(|bytes| isize::try_from(bytes).is_ok())
}

/// A string from C, unless NULL.
pub(super) unsafe fn string<'a>(pointer: fmi2String) -> Option<&'a CStr> {
    // SAFETY: the contract of this module.
    (!pointer.is_null()).then(|| unsafe { CStr::from_ptr(pointer) })
}

impl<M: Model> Instance<M> {
    /// Refuses an argument that is NULL or no array.
    #[cold]
    pub(super) fn null(&self, function: Function, argument: &str) -> fmi2Status {
        self.refuse(function, |text| {
            text.str("argument ").str(argument).str(" is NULL or no valid array");
        })
    }

    /// Refuses for a fixed reason.
    #[cold]
    pub(super) fn refuse_because(&self, function: Function, reason: &str) -> fmi2Status {
        self.refuse(function, |text| {
            text.str(reason);
        })
    }
}
