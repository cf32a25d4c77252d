//! Saving and restoring states.
//!
//! A saved state is its serialised form in memory: one format, checked in one place, for both.

use core::ptr;

use steerguard_fmu_core::foreign::{HeldState, array, array_mut, place};
use steerguard_fmu_core::{Fmu, fields, saved_state};

use super::call::{OK, call};
use crate::Function;
use crate::types::*;

pub unsafe fn fmi2GetFMUstate<F: Fmu>(c: fmi2Component, state: *mut fmi2FMUstate) -> fmi2Status {
    // SAFETY: the contract of this module.
    unsafe {
        call::<F>(c, Function::fmi2GetFMUstate, |instance, function| {
            let machine = &mut instance.machine;
            let length = saved_state::length(|archive| machine.archive(archive));
            let bytes = HeldState::prepare(instance.environment.memory(), state, length)
                .map_err(|reason| instance.refuse_because(function, reason))?;
            let machine = &mut instance.machine;
            if saved_state::write(bytes, &instance.guid, |archive| machine.archive(archive)) {
                Ok(OK)
            } else {
                Err(instance.refuse_because(function, "the state cannot be saved"))
            }
        })
    }
}

pub unsafe fn fmi2SetFMUstate<F: Fmu>(c: fmi2Component, state: fmi2FMUstate) -> fmi2Status {
    // SAFETY: the contract of this module.
    unsafe {
        call::<F>(c, Function::fmi2SetFMUstate, |instance, function| {
            let bytes =
                HeldState::bytes(state).ok_or_else(|| instance.null(function, "FMUstate"))?;
            instance.machine = instance.restored(function, bytes)?;
            Ok(OK)
        })
    }
}

pub unsafe fn fmi2FreeFMUstate<F: Fmu>(c: fmi2Component, state: *mut fmi2FMUstate) -> fmi2Status {
    // SAFETY: the contract of this module; a freed state is not used any more.
    unsafe {
        call::<F>(c, Function::fmi2FreeFMUstate, |instance, _| {
            if let Some(state) = state.as_mut() {
                instance.environment.memory().release(*state);
                *state = ptr::null_mut();
            }
            Ok(OK)
        })
    }
}

pub unsafe fn fmi2SerializedFMUstateSize<F: Fmu>(
    c: fmi2Component,
    state: fmi2FMUstate,
    size: *mut usize,
) -> fmi2Status {
    // SAFETY: the contract of this module.
    unsafe {
        call::<F>(c, Function::fmi2SerializedFMUstateSize, |instance, function| {
            let bytes =
                HeldState::bytes(state).ok_or_else(|| instance.null(function, "FMUstate"))?;
            let size = place(size).ok_or_else(|| instance.null(function, "size"))?;
            size.write(bytes.len());
            Ok(OK)
        })
    }
}

pub unsafe fn fmi2SerializeFMUstate<F: Fmu>(
    c: fmi2Component,
    state: fmi2FMUstate,
    serialized: *mut fmi2Byte,
    size: usize,
) -> fmi2Status {
    // SAFETY: the contract of this module.
    unsafe {
        call::<F>(c, Function::fmi2SerializeFMUstate, |instance, function| {
            let bytes =
                HeldState::bytes(state).ok_or_else(|| instance.null(function, "FMUstate"))?;
            let buffer = array_mut(serialized.cast::<u8>(), size)
                .ok_or_else(|| instance.null(function, "serializedState"))?;
            if buffer.len() < bytes.len() {
                return Err(instance.refuse(function, |text| {
                    text.str("the buffer holds ").integer(size as i64).str(" bytes, the state ");
                    text.integer(bytes.len() as i64);
                }));
            }
            for (place, &byte) in buffer.iter_mut().zip(bytes) {
                place.write(byte);
            }
            Ok(OK)
        })
    }
}

pub unsafe fn fmi2DeSerializeFMUstate<F: Fmu>(
    c: fmi2Component,
    serialized: *const fmi2Byte,
    size: usize,
    state: *mut fmi2FMUstate,
) -> fmi2Status {
    // SAFETY: the contract of this module.
    unsafe {
        call::<F>(c, Function::fmi2DeSerializeFMUstate, |instance, function| {
            let bytes = array(serialized.cast::<u8>(), size)
                .ok_or_else(|| instance.null(function, "serializedState"))?;
            instance.restored(function, bytes)?;
            let buffer = HeldState::prepare(instance.environment.memory(), state, size)
                .map_err(|reason| instance.refuse_because(function, reason))?;
            fields::copy(bytes, buffer);
            Ok(OK)
        })
    }
}
