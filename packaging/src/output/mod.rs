//! Files that appear whole or not at all.

pub mod table;

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

/// A file or folder that could not be written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write `{}`: {source}", path.display())]
pub struct OutputError {
    /// What was to be written.
    pub path: PathBuf,
    /// Why it failed.
    pub source: std::io::Error,
}

impl OutputError {
    fn at(path: &Path) -> impl FnOnce(std::io::Error) -> Self + '_ {
        |source| Self { path: path.to_owned(), source }
    }
}

/// Writes `bytes` to a temporary file beside `path` and renames it, so that no partial file is
/// ever left at `path`, not even by a crash of the machine.
///
/// # Errors
/// [`OutputError`] if the folder is missing or not writable, or `path` is a folder.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    let mut file = begin(path)?;
    file.write_all(bytes).map_err(OutputError::at(path))?;
    finish(file, path)
}

/// Begins a file that [`finish`] puts at `path`: a temporary one beside it.
///
/// # Errors
/// As [`write`].
pub fn begin(path: &Path) -> Result<NamedTempFile, OutputError> {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(".steerguard-");
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666)); // less the umask
    builder.tempfile_in(folder).map_err(OutputError::at(path))
}

/// Renames a file that [`begin`] began to `path`.
///
/// # Errors
/// As [`write`].
pub fn finish(file: NamedTempFile, path: &Path) -> Result<(), OutputError> {
    file.as_file().sync_all().map_err(OutputError::at(path))?;
    file.persist(path).map_err(|error| OutputError::at(path)(error.error))?;
    Ok(())
}

/// Creates `folder` and its parents where they are missing.
///
/// # Errors
/// [`OutputError`] if that is not possible.
pub fn create_folder(folder: &Path) -> Result<(), OutputError> {
    fs::create_dir_all(folder).map_err(OutputError::at(folder))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn replaces_the_file_and_leaves_no_other() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        write(&path, b"one").unwrap();
        write(&path, b"two").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"two");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn failure_leaves_nothing_behind() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        fs::create_dir(&path).unwrap();
        fs::write(path.join("kept"), "").unwrap();
        assert!(write(&path, b"one").is_err());
        assert!(write(&folder.path().join("missing/a"), b"one").is_err());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
