//! Saving and restoring states.
//!
//! A saved state is its serialised form in memory: one format, checked in one place, for both.

use core::ptr;

use steerguard_fmu_core::foreign::{HeldState, array, array_mut, place};
use steerguard_fmu_core::{Memory, fields, saved_state};

use super::call::{Fmi3, OK, call};
use crate::Function;
use crate::types::*;

pub unsafe fn fmi3GetFMUState<F: Fmi3>(
    instance: fmi3Instance,
    state: *mut fmi3FMUState,
) -> fmi3Status {
    // SAFETY: the contract of this module.
    unsafe {
        call::<F>(instance, Function::fmi3GetFMUState, |instance, function| {
            let machine = &mut instance.machine;
            let length = saved_state::length(|archive| machine.archive(archive));
            let bytes = HeldState::prepare(Memory::C, state, length)
                .map_err(|reason| instance.refuse_because(function, reason))?;
            let machine = &mut instance.machine;
            if saved_state::write(bytes, &instance.token, |archive| machine.archive(archive)) {
                Ok(OK)
            } else {
                Err(instance.refuse_because(function, "the state cannot be saved"))
            }
        })
    }
}

pub unsafe fn fmi3SetFMUState<F: Fmi3>(instance: fmi3Instance, state: fmi3FMUState) -> fmi3Status {
    // SAFETY: the contract of this module.
    unsafe {
        call::<F>(instance, Function::fmi3SetFMUState, |instance, function| {
            let bytes =
                HeldState::bytes(state).ok_or_else(|| instance.null(function, "FMUState"))?;
            instance.machine = instance.restored(function, bytes)?;
            Ok(OK)
        })
    }
}

pub unsafe fn fmi3FreeFMUState<F: Fmi3>(
    instance: fmi3Instance,
    state: *mut fmi3FMUState,
) -> fmi3Status {
    // SAFETY: the contract of this module; a freed state is not used any more.
    unsafe {
        call::<F>(instance, Function::fmi3FreeFMUState, |_, _| {
            if let Some(state) = state.as_mut() {
                Memory::C.release(*state);
                *state = ptr::null_mut();
            }
            Ok(OK)
        })
    }
}

pub unsafe fn fmi3SerializedFMUStateSize<F: Fmi3>(
    instance: fmi3Instance,
    state: fmi3FMUState,
    size: *mut usize,
) -> fmi3Status {
    // SAFETY: the contract of this module.
    unsafe {
        call::<F>(instance, Function::fmi3SerializedFMUStateSize, |instance, function| {
            let bytes =
                HeldState::bytes(state).ok_or_else(|| instance.null(function, "FMUState"))?;
            let size = place(size).ok_or_else(|| instance.null(function, "size"))?;
            size.write(bytes.len());
            Ok(OK)
        })
    }
}

pub unsafe fn fmi3SerializeFMUState<F: Fmi3>(
    instance: fmi3Instance,
    state: fmi3FMUState,
    serialized: *mut fmi3Byte,
    size: usize,
) -> fmi3Status {
    // SAFETY: the contract of this module.
    unsafe {
        call::<F>(instance, Function::fmi3SerializeFMUState, |instance, function| {
            let bytes =
                HeldState::bytes(state).ok_or_else(|| instance.null(function, "FMUState"))?;
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

pub unsafe fn fmi3DeserializeFMUState<F: Fmi3>(
    instance: fmi3Instance,
    serialized: *const fmi3Byte,
    size: usize,
    state: *mut fmi3FMUState,
) -> fmi3Status {
    // SAFETY: the contract of this module.
    unsafe {
        call::<F>(instance, Function::fmi3DeserializeFMUState, |instance, function| {
            let bytes = array(serialized.cast::<u8>(), size)
                .ok_or_else(|| instance.null(function, "serializedState"))?;
            instance.restored(function, bytes)?;
            let buffer = HeldState::prepare(Memory::C, state, size)
                .map_err(|reason| instance.refuse_because(function, reason))?;
            fields::copy(bytes, buffer);
            Ok(OK)
        })
    }
}
