//! Arrays, strings and saved states as C passes them.
//!
//! # Safety
//! For all functions here: pointers are NULL or valid for as many elements as the call says, for as long as
//! what is made of them is used; strings are NUL-terminated.
#![allow(clippy::missing_safety_doc, reason = "one contract for all, above")]

use core::ffi::{CStr, c_char, c_void};
use core::mem::MaybeUninit;
use core::slice;

use crate::Memory;

/// An array from C, if it may be one: not NULL unless empty, aligned, of possible size.
pub unsafe fn array<'a, T>(pointer: *const T, length: usize) -> Option<&'a [T]> {
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
pub unsafe fn array_mut<'a, T>(pointer: *mut T, length: usize) -> Option<&'a mut [MaybeUninit<T>]> {
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
pub unsafe fn place<'a, T>(pointer: *mut T) -> Option<&'a mut MaybeUninit<T>> {
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
#[inline]
pub unsafe fn string<'a>(pointer: *const c_char) -> Option<&'a CStr> {
    // SAFETY: the contract of this module.
    (!pointer.is_null()).then(|| unsafe { CStr::from_ptr(pointer) })
}

/// A saved state in memory, which C knows by its address: its length, then that many bytes.
#[repr(C)]
pub struct HeldState {
    length: usize,
    bytes: [u8; 0],
}

impl HeldState {
    /// The bytes of a state that [`Self::prepare`] made; `None` for what cannot be one.
    #[inline]
    pub unsafe fn bytes<'a>(state: *mut c_void) -> Option<&'a [u8]> {
        let state: *const Self = state.cast_const().cast();
        if state.is_null() || !state.is_aligned() {
            return None;
        }
        // SAFETY: by the contract of this module the state is one that `prepare` made.
        unsafe { array((&raw const (*state).bytes).cast(), (*state).length) }
    }

    /// Room for `length` bytes at `*state`: what is there if it has that length, or new from `memory`,
    /// where the old one came from.
    ///
    /// # Errors
    /// Why there is none.
    #[inline]
    pub unsafe fn prepare<'a>(
        memory: Memory,
        state: *mut *mut c_void,
        length: usize,
    ) -> Result<&'a mut [u8], &'static str> {
        // SAFETY: the contract of this module.
        let state = unsafe { state.as_mut() }.ok_or("argument FMUstate is NULL")?;
        let old: *const Self = state.cast_const().cast();
        // SAFETY: by the contract of this module the state is NULL or one that was made here.
        if unsafe { old.as_ref() }.is_none_or(|old| old.length != length) {
            let new = memory.allocate_bytes(size_of::<Self>().saturating_add(length));
            let new = new.ok_or("out of memory")?;
            // SAFETY: the memory is aligned and large enough for the length; `*state` is NULL or,
            // being replaced, not used any more.
            unsafe {
                new.cast::<usize>().write(length);
                memory.release(*state);
            }
            *state = new.as_ptr();
        }
        let header: *mut Self = state.cast();
        // SAFETY: `length` bytes follow the header, zeroed when allocated.
        Ok(unsafe { slice::from_raw_parts_mut((&raw mut (*header).bytes).cast(), length) })
    }
}
