//! A file of which a row may take so much and no more: one without ends of lines would fill the memory.

use std::fs::File;
use std::io::{self, Read};

/// Most bytes of a row, ends of lines and comments before it among them.
pub(super) const MAX_ROW_BYTES: u64 = 1 << 20;

/// The file, and how much may be read of it for this row.
pub(super) struct Bounded {
    file: File,
    left: u64,
}

impl Bounded {
    pub(super) fn new(file: File) -> Self {
        Self { file, left: 0 }
    }

    /// The next row begins.
    pub(super) fn begin_row(&mut self) {
        self.left = MAX_ROW_BYTES;
    }

    /// Whether the row has taken all that it may.
    pub(super) fn is_exhausted(&self) -> bool {
        self.left == 0
    }
}

impl Read for Bounded {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.is_exhausted() {
            return Err(io::ErrorKind::FileTooLarge.into());
        }
        let most = buffer.len().min(usize::try_from(self.left).unwrap_or(usize::MAX));
        let length = self.file.read(buffer.get_mut(..most).unwrap_or_default())?;
        self.left -= length as u64;
        Ok(length)
    }
}
