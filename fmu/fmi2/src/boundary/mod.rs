//! The C side: raw pointers in, checked values out. One generic function for each function of the
//! standard, with its name and signature; [`export_fmi2!`](crate::export_fmi2) gives them their
//! symbols.
//!
//! # Safety
//! For all functions here, as the standard demands of an importer: `c` is NULL or comes from
//! [`fmi2Instantiate`] of the same `F` and was not freed; no other call on the same instance is
//! under way; pointers are NULL or valid for as many elements as the call says; strings are
//! NUL-terminated; a state is NULL or comes from an instance of the same `F` and was not freed;
//! callbacks are what the standard says they are.
#![allow(non_snake_case)]
#![allow(missing_docs, reason = "the standard documents these functions")]
#![allow(clippy::missing_safety_doc, reason = "one contract for all, above")]

mod co_simulation;
mod life_cycle;
mod states;
mod values;

use core::ffi::CStr;
use core::mem::MaybeUninit;
use core::slice;

pub use co_simulation::*;
pub use life_cycle::*;
pub use states::*;
pub use values::*;

use steerguard_fmu_core::{Fmu, Model};

use crate::Function;
use crate::instance::Instance;
use crate::types::{fmi2Component, fmi2Status, fmi2String};

const OK: fmi2Status = fmi2Status::fmi2OK;

/// The instance behind `c`, if `function` may be called on it now.
///
/// # Errors
/// The status to return otherwise.
unsafe fn enter<'a, F: Fmu>(
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
unsafe fn call<F: Fmu>(
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
unsafe fn array<'a, T>(pointer: *const T, length: usize) -> Option<&'a [T]> {
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
unsafe fn array_mut<'a, T>(pointer: *mut T, length: usize) -> Option<&'a mut [MaybeUninit<T>]> {
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
unsafe fn place<'a, T>(pointer: *mut T) -> Option<&'a mut MaybeUninit<T>> {
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
unsafe fn string<'a>(pointer: fmi2String) -> Option<&'a CStr> {
    // SAFETY: the contract of this module.
    (!pointer.is_null()).then(|| unsafe { CStr::from_ptr(pointer) })
}

impl<M: Model> Instance<M> {
    /// Refuses an argument that is NULL or no array.
    #[cold]
    fn null(&self, function: Function, argument: &str) -> fmi2Status {
        self.refuse(function, |text| {
            text.str("argument ").str(argument).str(" is NULL or no valid array");
        })
    }

    /// Refuses for a fixed reason.
    #[cold]
    fn refuse_because(&self, function: Function, reason: &str) -> fmi2Status {
        self.refuse(function, |text| {
            text.str(reason);
        })
    }
}

/// What all functions for Model Exchange do.
pub unsafe fn model_exchange<F: Fmu>(c: fmi2Component, function: Function) -> fmi2Status {
    // SAFETY: the contract of this module.
    unsafe {
        call::<F>(c, function, |instance, function| {
            // Not reached: the call is allowed in no state.
            Err(instance.refuse_because(function, "this FMU is not for Model Exchange"))
        })
    }
}
