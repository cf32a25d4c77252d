//! Reading files within bounds: what people name may be a device, or far larger than they think.

use std::fs::File;
use std::io::{self, Read as _};
use std::path::Path;

/// Largest file of text that is read, bytes: specification, scenario, design, block of a campaign.
pub const MAX_TEXT_BYTES: u64 = 64 << 20;

/// Largest library that is read, bytes: with debugging information they have some millions.
pub const MAX_LIBRARY_BYTES: u64 = 64 << 20;

/// The bytes of the file at `path`, `most` at most. Pipes are read, as far as that; nothing is read of a larger file.
///
/// # Errors
/// If the file cannot be read, is a folder, or has more bytes.
pub fn read(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let file = File::open(path)?;
    let metadata = file.metadata()?;
    if metadata.is_dir() {
        return Err(io::Error::new(io::ErrorKind::IsADirectory, "it is a folder"));
    }
    let too_large = || {
        let message = format!("it has more than {most} bytes, the most that is read");
        io::Error::new(io::ErrorKind::FileTooLarge, message)
    };
    if metadata.len() > most {
        return Err(too_large());
    }
    let mut bytes = Vec::new();
    file.take(most + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most { Err(too_large()) } else { Ok(bytes) }
}

/// The text of the file at `path`, as [`read`].
///
/// # Errors
/// As [`read`], and if the bytes are not UTF-8.
pub fn read_text(path: &Path) -> io::Result<String> {
    let bytes = read(path, MAX_TEXT_BYTES)?;
    String::from_utf8(bytes).map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_of_the_most_bytes_is_read_and_a_longer_one_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        std::fs::write(&path, [7; 10]).unwrap();
        assert_eq!(read(&path, 10).unwrap(), [7; 10]);
        let error = read(&path, 9).unwrap_err();
        assert_eq!(error.to_string(), "it has more than 9 bytes, the most that is read");
        assert_eq!(read(folder.path(), 9).unwrap_err().to_string(), "it is a folder");
    }

    #[cfg(unix)]
    #[test]
    fn a_device_without_end_is_refused() {
        let error = read(Path::new("/dev/zero"), 1 << 20).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::FileTooLarge);
    }
}
