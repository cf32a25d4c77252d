//! Fields as bytes, little-endian: one pass over them serves to count, write and read.

use crc::{CRC_32_ISO_HDLC, Crc};

static CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// CRC-32 of bytes, as in zip and PNG.
pub fn checksum(bytes: &[u8]) -> u32 {
    CRC.checksum(bytes)
}

/// Fields on their way into or out of bytes. Call its methods for the same fields in the same order
/// whatever the direction.
pub struct Archive<'a> {
    direction: Direction<'a>,
    position: usize,
    sound: bool,
}

enum Direction<'a> {
    Count,
    Write(&'a mut [u8]),
    Read(&'a [u8]),
}

impl Archive<'_> {
    /// A real number, bit for bit.
    #[inline(never)] // small code: it is called for some hundred fields
    pub fn real(&mut self, value: &mut f64) {
        let mut bytes = value.to_le_bytes();
        if self.bytes(&mut bytes) {
            *value = f64::from_le_bytes(bytes);
        }
    }

    /// A real number that must be finite.
    #[inline(never)]
    pub fn finite(&mut self, value: &mut f64) {
        self.real(value);
        self.require(value.is_finite());
    }

    /// An unsigned integer.
    #[inline(never)]
    pub fn u64(&mut self, value: &mut u64) {
        let mut bytes = value.to_le_bytes();
        if self.bytes(&mut bytes) {
            *value = u64::from_le_bytes(bytes);
        }
    }

    /// An unsigned integer.
    #[inline(never)]
    pub fn u32(&mut self, value: &mut u32) {
        let mut bytes = value.to_le_bytes();
        if self.bytes(&mut bytes) {
            *value = u32::from_le_bytes(bytes);
        }
    }

    /// A size or index.
    #[inline(never)]
    pub fn size(&mut self, value: &mut usize) {
        let mut wide = *value as u64;
        self.u64(&mut wide);
        match usize::try_from(wide) {
            Ok(narrow) => *value = narrow,
            Err(_) => self.require(false),
        }
    }

    /// A truth value.
    pub fn flag(&mut self, value: &mut bool) {
        let mut byte = u8::from(*value);
        self.code(&mut byte, 2);
        *value = byte != 0;
    }

    /// A code below `count`.
    #[inline(never)]
    pub fn code(&mut self, value: &mut u8, count: u8) {
        let mut byte = [*value];
        if self.bytes(&mut byte) {
            [*value] = byte;
        }
        self.require(*value < count);
    }

    /// One of the `items`, by its index.
    pub fn choice<T: Copy + PartialEq>(&mut self, value: &mut T, items: &[T]) {
        let index = items.iter().position(|item| item == value);
        let mut code = index.unwrap_or(usize::from(u8::MAX)) as u8;
        self.code(&mut code, u8::MAX);
        match items.get(usize::from(code)) {
            Some(item) => *value = *item,
            None => self.require(false),
        }
    }

    /// A number that may be missing.
    pub fn optional<T: Copy + Default>(
        &mut self,
        value: &mut Option<T>,
        field: impl FnOnce(&mut Self, &mut T),
    ) {
        let mut present = value.is_some();
        let mut inner = value.unwrap_or_default();
        self.flag(&mut present);
        field(self, &mut inner);
        *value = present.then_some(inner);
    }

    /// States an invariant of the fields so far: what was read is refused where it does not hold.
    pub fn require(&mut self, holds: bool) {
        self.sound &= holds;
    }

    /// Plain bytes; true where they were read.
    #[inline(never)]
    pub fn bytes(&mut self, bytes: &mut [u8]) -> bool {
        let end = self.position.saturating_add(bytes.len());
        let range = self.position..end;
        self.position = end;
        match &mut self.direction {
            Direction::Count => false,
            Direction::Write(buffer) => {
                match buffer.get_mut(range) {
                    Some(place) => copy(bytes, place),
                    None => self.sound = false,
                }
                false
            }
            Direction::Read(buffer) => match buffer.get(range) {
                Some(place) => {
                    copy(place, bytes);
                    true
                }
                None => {
                    self.sound = false;
                    false
                }
            },
        }
    }
}

/// Copies as much as both hold, without the panic of `copy_from_slice`.
pub fn copy(from: &[u8], to: &mut [u8]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to = *from;
    }
}

/// Writes the bare fields that `fields` passes through; false unless they fill `buffer`.
pub fn write_fields(buffer: &mut [u8], fields: impl FnOnce(&mut Archive<'_>)) -> bool {
    let length = buffer.len();
    let mut archive = Archive { direction: Direction::Write(buffer), position: 0, sound: true };
    fields(&mut archive);
    archive.sound && archive.position == length
}

/// Reads bare fields; false unless `bytes` hold exactly these, each with an admissible value. What
/// was read is of no use then.
pub fn read_fields(bytes: &[u8], fields: impl FnOnce(&mut Archive<'_>)) -> bool {
    let mut archive = Archive { direction: Direction::Read(bytes), position: 0, sound: true };
    fields(&mut archive);
    archive.sound && archive.position == bytes.len()
}

/// Length of what `fields` passes through, bytes.
pub fn length(fields: impl FnOnce(&mut Archive<'_>)) -> usize {
    let mut archive = Archive { direction: Direction::Count, position: 0, sound: true };
    fields(&mut archive);
    archive.position
}
