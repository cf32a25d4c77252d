//! The identity of an FMU.

use crate::fields::copy;

/// Length of a [`Guid`], bytes.
pub const GUID_LENGTH: usize = 40;

/// What ties description, binary and saved states of an FMU together, padded with NUL.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Guid(pub [u8; GUID_LENGTH]);

impl Guid {
    /// As text gives it; what does not fit is left out.
    pub fn new(guid: &str) -> Self {
        let mut bytes = [0; GUID_LENGTH];
        copy(guid.as_bytes(), &mut bytes);
        Self(bytes)
    }
}
