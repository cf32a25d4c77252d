//! Memory from the importer's callbacks, or from the C library where it does not give both.

use core::ffi::c_void;
use core::ptr::NonNull;

use crate::types::fmi2CallbackFunctions;

unsafe extern "C" {
    fn calloc(count: usize, size: usize) -> *mut c_void;
    fn free(pointer: *mut c_void);
}

/// What C's allocation functions align to, at least.
const ALIGNMENT: usize = align_of::<u64>();

/// Memory for a `T`.
pub(crate) fn allocate<T>(callbacks: &fmi2CallbackFunctions) -> Option<NonNull<T>> {
    const { assert!(align_of::<T>() <= ALIGNMENT) }
    allocate_bytes(callbacks, size_of::<T>()).map(NonNull::cast)
}

/// Zeroed memory, aligned as a `u64`.
pub(crate) fn allocate_bytes(
    callbacks: &fmi2CallbackFunctions,
    size: usize,
) -> Option<NonNull<c_void>> {
    let pointer = match (callbacks.allocateMemory, callbacks.freeMemory) {
        // SAFETY: the importer gave the function for this use.
        (Some(allocate), Some(_)) => unsafe { allocate(1, size) },
        // SAFETY: calloc takes any arguments.
        _ => unsafe { calloc(1, size) },
    };
    let pointer = NonNull::new(pointer)?;
    if pointer.addr().get().is_multiple_of(ALIGNMENT) {
        Some(pointer)
    } else {
        // SAFETY: allocated above with the same callbacks.
        unsafe { release(callbacks, pointer.as_ptr()) };
        None
    }
}

/// Gives memory back.
///
/// # Safety
/// `pointer` is NULL, or comes from this module with the same callbacks and is not used any more.
pub(crate) unsafe fn release(callbacks: &fmi2CallbackFunctions, pointer: *mut c_void) {
    if pointer.is_null() {
        return;
    }
    match (callbacks.allocateMemory, callbacks.freeMemory) {
        // SAFETY: this function's own contract.
        (Some(_), Some(release)) => unsafe { release(pointer) },
        // SAFETY: this function's own contract.
        _ => unsafe { free(pointer) },
    }
}
