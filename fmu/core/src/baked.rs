//! The block inside the shared library that a design is baked into after linking.
//!
//! It sits in a section of its own ([`SECTION_ELF`], [`SECTION_MACH_O`], [`SECTION_PE`]), so that a
//! packaging tool finds it in the file and writes it with [`seal`]: one library serves every design.
//!
//! Format, little-endian: magic, layout version, payload capacity, sealed or not, payload length,
//! CRC-32 of GUID and payload, GUID padded with NUL, payload.

use core::ffi::CStr;

use crate::fields::{checksum, copy};
use crate::guid::GUID_LENGTH;

/// Section of the block in ELF files.
pub const SECTION_ELF: &str = ".steerguard";
/// Section of the block in Mach-O files, in segment `__DATA`.
pub const SECTION_MACH_O: &str = "__steerguard";
/// Section of the block in PE files.
pub const SECTION_PE: &str = ".sguard";

/// Size of the block, bytes.
pub const BLOCK_SIZE: usize = 8192;
/// Largest payload, bytes.
pub const PAYLOAD_CAPACITY: usize = BLOCK_SIZE - HEADER;
/// Longest GUID, bytes: `{8-4-4-4-12}` and more.
pub const GUID_CAPACITY: usize = GUID_LENGTH - 1;

const MAGIC: [u8; 8] = *b"SGBLOCK\0";
const VERSION: u32 = 1;
const HEADER: usize = 8 + 5 * 4 + GUID_LENGTH;

/// The block, as a static of the shared library.
#[repr(C, align(8))]
pub struct Block([u8; BLOCK_SIZE]);

/// Contents of a sealed block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Baked<'a> {
    /// GUID of the model description that belongs to the payload.
    pub guid: &'a str,
    /// Numbers of the model, in its own format.
    pub payload: &'a [u8],
}

/// Why a block cannot be used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BakedError {
    /// Nothing was baked into the library.
    Unbaked,
    /// The block does not hold what was baked into it.
    Damaged,
}

impl BakedError {
    /// For messages.
    pub const fn description(self) -> &'static str {
        match self {
            Self::Unbaked => "no design is baked into this library",
            Self::Damaged => "the design baked into this library is damaged",
        }
    }
}

/// Why bytes cannot be baked into a section.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SealError {
    /// The section holds no block of this layout version.
    NoBlock,
    /// GUID empty, longer than [`GUID_CAPACITY`] or with a NUL.
    Guid,
    /// Payload longer than [`PAYLOAD_CAPACITY`]: its length in bytes.
    TooLong(usize),
}

impl core::fmt::Display for SealError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::NoBlock => f.write_str("the section holds no block of this version"),
            Self::Guid => {
                write!(f, "the GUID must have 1 to {GUID_CAPACITY} bytes and hold no NUL")
            }
            Self::TooLong(length) => {
                write!(f, "the payload has {length} bytes, at most {PAYLOAD_CAPACITY} fit")
            }
        }
    }
}

impl core::error::Error for SealError {}

impl Block {
    /// A block that nothing is baked into yet.
    pub const UNBAKED: Self = {
        let mut bytes = [0; BLOCK_SIZE];
        let (version, capacity) = (VERSION.to_le_bytes(), (PAYLOAD_CAPACITY as u32).to_le_bytes());
        let mut i = 0;
        while i < 8 {
            bytes[i] = MAGIC[i];
            if i < 4 {
                bytes[8 + i] = version[i];
                bytes[12 + i] = capacity[i];
            }
            i += 1;
        }
        Self(bytes)
    };

    /// A block with a design in it.
    ///
    /// # Errors
    /// As [`seal`].
    pub fn sealed(guid: &str, payload: &[u8]) -> Result<Self, SealError> {
        let mut block = Self::UNBAKED;
        seal(&mut block.0, guid, payload)?;
        Ok(block)
    }

    /// The bytes as they are in the loaded library.
    pub fn load(&self) -> [u8; BLOCK_SIZE] {
        let mut bytes = self.0;
        for (place, byte) in bytes.iter_mut().zip(&self.0) {
            // SAFETY: a reference is valid for reads. They are volatile because the bytes in the
            // file change after linking: the compiler must not conclude from the initial ones.
            *place = unsafe { (&raw const *byte).read_volatile() };
        }
        bytes
    }
}

/// Bakes `guid` and `payload` into `section`, which begins with the block of a library; what was
/// baked before is replaced.
///
/// # Errors
/// [`SealError`], with `section` unchanged.
pub fn seal(section: &mut [u8], guid: &str, payload: &[u8]) -> Result<(), SealError> {
    let block: &mut [u8; BLOCK_SIZE] = section.first_chunk_mut().ok_or(SealError::NoBlock)?;
    let Block(template) = Block::UNBAKED;
    if block.iter().zip(&template).take(16).any(|(a, b)| a != b) {
        return Err(SealError::NoBlock);
    }
    if guid.is_empty() || guid.len() > GUID_CAPACITY || guid.bytes().any(|byte| byte == 0) {
        return Err(SealError::Guid);
    }
    if payload.len() > PAYLOAD_CAPACITY {
        return Err(SealError::TooLong(payload.len()));
    }
    *block = template;
    let mut sealed = &mut block[16..];
    for field in [1, payload.len() as u32, 0] {
        let (place, rest) = sealed.split_at_mut(4);
        copy(&u32::to_le_bytes(field), place);
        sealed = rest;
    }
    copy(guid.as_bytes(), sealed);
    copy(payload, &mut sealed[GUID_LENGTH..]);
    let crc = checksum(&sealed[..GUID_LENGTH + payload.len()]);
    copy(&crc.to_le_bytes(), &mut block[24..]);
    Ok(())
}

/// Checks the bytes of a block and returns what was baked into it.
///
/// # Errors
/// [`BakedError`].
pub fn open(block: &[u8; BLOCK_SIZE]) -> Result<Baked<'_>, BakedError> {
    parse(block).ok_or(BakedError::Damaged)?
}

fn parse(block: &[u8]) -> Option<Result<Baked<'_>, BakedError>> {
    let (magic, rest) = block.split_first_chunk::<8>()?;
    let mut rest = rest;
    let mut field = || {
        let (bytes, after) = rest.split_first_chunk::<4>()?;
        rest = after;
        Some(u32::from_le_bytes(*bytes))
    };
    let [version, capacity, sealed, length, crc] =
        [field()?, field()?, field()?, field()?, field()?];
    if *magic != MAGIC || version != VERSION || capacity as usize != PAYLOAD_CAPACITY {
        return None;
    }
    match [sealed, length, crc] {
        [0, 0, 0] => return Some(Err(BakedError::Unbaked)),
        [1, ..] => {}
        _ => return None,
    }
    let checked = rest.get(..GUID_LENGTH.checked_add(length as usize)?)?;
    if checksum(checked) != crc {
        return None;
    }
    let (guid, payload) = checked.split_at_checked(GUID_LENGTH)?;
    let guid = CStr::from_bytes_until_nul(guid).ok()?.to_str().ok()?;
    Some(Ok(Baked { guid, payload }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_sealed_is_opened() {
        let payload: Vec<u8> = (0..200).collect();
        let block = Block::sealed("{guid}", &payload).unwrap();
        assert_eq!(open(&block.load()), Ok(Baked { guid: "{guid}", payload: &payload }));
        assert_eq!(open(&Block::UNBAKED.load()), Err(BakedError::Unbaked));

        let full = vec![7; PAYLOAD_CAPACITY];
        let again = Block::sealed("g", &full).unwrap();
        assert_eq!(open(&again.load()), Ok(Baked { guid: "g", payload: &full }));
    }

    #[test]
    fn every_damaged_bit_is_noticed() {
        let Block(sealed) = Block::sealed("{guid}", b"payload").unwrap();
        for bit in 0..8 * (HEADER + 7) {
            let mut block = sealed;
            block[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(open(&block), Err(BakedError::Damaged), "bit {bit}");
        }
    }

    #[test]
    fn sealing_refuses_what_does_not_fit_and_leaves_the_section_alone() {
        let Block(block) = Block::UNBAKED;
        let long = [0; PAYLOAD_CAPACITY + 1];
        for (guid, payload, error) in [
            ("", &long[..1], SealError::Guid),
            ("a\0b", &long[..1], SealError::Guid),
            ("0123456789012345678901234567890123456789", &long[..1], SealError::Guid),
            ("g", &long[..], SealError::TooLong(long.len())),
        ] {
            let mut section = block;
            assert_eq!(seal(&mut section, guid, payload), Err(error));
            assert_eq!(section, block);
        }
        assert_eq!(seal(&mut [0; 64], "g", b""), Err(SealError::NoBlock));
        assert_eq!(seal(&mut [0; BLOCK_SIZE], "g", b""), Err(SealError::NoBlock));
    }
}
