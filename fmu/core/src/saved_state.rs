//! A saved state as bytes.
//!
//! Format, little-endian: `SGST`, version, GUID, length and CRC-32 of the body, body.

use crate::fields::{Archive, checksum, read_fields, write_fields};
use crate::guid::{GUID_LENGTH, Guid};

const MAGIC: [u8; 4] = *b"SGST";
const VERSION: u32 = 1;
/// Length of the part before the body, bytes.
const HEADER: usize = 4 + 4 + GUID_LENGTH + 4 + 4;

/// Length of a state whose body `fields` passes through, bytes.
pub fn length(fields: impl FnOnce(&mut Archive<'_>)) -> usize {
    HEADER + crate::fields::length(fields)
}

/// Writes a state; false unless `buffer` is of its length.
pub fn write(buffer: &mut [u8], guid: &Guid, fields: impl FnOnce(&mut Archive<'_>)) -> bool {
    let Some((header, body)) = buffer.split_at_mut_checked(HEADER) else { return false };
    write_fields(body, fields)
        && write_fields(header, |archive| {
            archive.bytes(&mut { MAGIC });
            archive.u32(&mut { VERSION });
            archive.bytes(&mut { guid.0 });
            archive.u32(&mut { body.len() as u32 });
            archive.u32(&mut { checksum(body) });
        })
}

/// Reads a state through `fields`.
///
/// # Errors
/// What is wrong with it; the fields read so far are then of no use.
pub fn read(
    state: &[u8],
    guid: &Guid,
    fields: impl FnOnce(&mut Archive<'_>),
) -> Result<(), &'static str> {
    let body = checked_body(state, guid)?;
    if read_fields(body, fields) { Ok(()) } else { Err("its contents are not those of a state") }
}

fn checked_body<'a>(state: &'a [u8], guid: &Guid) -> Result<&'a [u8], &'static str> {
    let Some((header, body)) = state.split_at_checked(HEADER) else {
        return Err("it is too short");
    };
    let (mut magic, mut from) = ([0; 4], [0; GUID_LENGTH]);
    let (mut version, mut length, mut crc) = (0, 0, 0);
    read_fields(header, |archive| {
        archive.bytes(&mut magic);
        archive.u32(&mut version);
        archive.bytes(&mut from);
        archive.u32(&mut length);
        archive.u32(&mut crc);
    });
    if magic != MAGIC {
        Err("it is not a state of such an FMU")
    } else if version != VERSION {
        Err("its format has another version")
    } else if from != guid.0 {
        Err("it comes from an FMU with another GUID")
    } else if body.len() as u64 != u64::from(length) {
        Err("its length is wrong")
    } else if checksum(body) != crc {
        Err("its checksum is wrong")
    } else {
        Ok(body)
    }
}
