//! Memory from the importer's callbacks, or from the C library where it does not give both.

use core::ffi::c_void;
use core::ptr::NonNull;

unsafe extern "C" {
    fn calloc(count: usize, size: usize) -> *mut c_void;
    fn free(pointer: *mut c_void);
}

/// What C's allocation functions align to, at least.
const ALIGNMENT: usize = align_of::<u64>();

/// Gives zeroed memory, or NULL: number and size of objects.
pub type Allocate = unsafe extern "C" fn(usize, usize) -> *mut c_void;
/// Takes back what [`Allocate`] gave.
pub type Release = unsafe extern "C" fn(*mut c_void);

/// Where memory comes from.
#[derive(Debug, Clone, Copy)]
pub struct Memory {
    allocate: Allocate,
    release: Release,
}

impl Memory {
    /// The C library's.
    pub const C: Self = Self { allocate: calloc, release: free };

    /// The importer's, if it gives both functions; the C library's otherwise.
    ///
    /// # Safety
    /// The functions do what their types say, for as long as this value and its copies are used.
    pub unsafe fn of_importer(allocate: Option<Allocate>, release: Option<Release>) -> Self {
        match allocate.zip(release) {
            Some((allocate, release)) => Self { allocate, release },
            None => Self::C,
        }
    }

    /// Memory for a `T`.
    pub fn allocate<T>(&self) -> Option<NonNull<T>> {
        const { assert!(align_of::<T>() <= ALIGNMENT) }
        self.allocate_bytes(size_of::<T>()).map(NonNull::cast)
    }

    /// Zeroed memory, aligned as a `u64`.
    pub fn allocate_bytes(&self, size: usize) -> Option<NonNull<c_void>> {
        // SAFETY: the function takes any arguments.
        let pointer = NonNull::new(unsafe { (self.allocate)(1, size) })?;
        if pointer.addr().get().is_multiple_of(ALIGNMENT) {
            Some(pointer)
        } else {
            // SAFETY: it comes from here and goes nowhere else.
            unsafe { self.release(pointer.as_ptr()) };
            None
        }
    }

    /// Gives memory back.
    ///
    /// # Safety
    /// `pointer` is NULL, or comes from this value or a copy of it and is not used any more.
    pub unsafe fn release(&self, pointer: *mut c_void) {
        if !pointer.is_null() {
            // SAFETY: this function's own contract.
            unsafe { (self.release)(pointer) };
        }
    }
}
