//! Files that appear whole or not at all.
//!
//! # Conventions
//! A file is written beside its place and renamed to it, through symbolic links to their target. What exists and is no
//! regular file, a device or a pipe, is written into. Where that is the standard output, results go to the standard
//! error output instead ([`is_taken`]).

pub mod lines;
mod place;
pub mod table;
pub mod temporary;

use std::fs::{self, File, OpenOptions};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use place::Place;
use temporary::TemporaryFile;

/// Whether a file was written to the standard output.
static TAKEN: AtomicBool = AtomicBool::new(false);

/// Whether a file was written to the standard output, which holds nothing else then.
pub fn is_taken() -> bool {
    TAKEN.load(Ordering::Relaxed)
}

/// A file or folder that could not be written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write `{}`: {source}", path.display())]
pub struct OutputError {
    /// What was to be written.
    pub path: PathBuf,
    /// Why it failed.
    pub source: io::Error,
}

impl OutputError {
    fn at(path: &Path) -> impl FnOnce(io::Error) -> Self + '_ {
        |source| {
            let source = if temporary::holds(path) { temporary::elsewhere(source) } else { source };
            Self { path: path.to_owned(), source }
        }
    }
}

/// Writes `bytes` to a temporary file beside `path` and renames it, so that no partial file is
/// ever left at `path`, not even by a crash of the machine; or into what `path` is.
///
/// # Errors
/// [`OutputError`] if the folder is missing or not writable, or `path` is a folder.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    let mut output = begin(path)?;
    output.write_all(bytes).map_err(OutputError::at(path))?;
    output.finish()
}

/// A file that is being written, and is nowhere if it is dropped.
#[derive(Debug)]
pub struct Output {
    /// As it was named.
    path: PathBuf,
    place: Place,
    file: TemporaryFile,
}

/// Begins the file at `path`.
///
/// # Errors
/// As [`write`].
pub fn begin(path: &Path) -> Result<Output, OutputError> {
    let begun = || -> io::Result<Output> {
        let place = Place::of(path)?;
        let file = match &place {
            Place::File(target) => {
                let folder = target.parent().filter(|folder| !folder.as_os_str().is_empty());
                TemporaryFile::new(folder.unwrap_or(Path::new(".")))?
            }
            Place::Device(_) | Place::StandardOutput => TemporaryFile::new(&std::env::temp_dir())?,
        };
        Ok(Output { path: path.to_owned(), place, file })
    };
    begun().map_err(OutputError::at(path))
}

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.as_file().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.as_file().flush()
    }
}

impl Output {
    /// Puts the file in its place.
    ///
    /// # Errors
    /// As [`write`].
    pub fn finish(self) -> Result<(), OutputError> {
        let Self { path, place, mut file } = self;
        let mut put = || match &place {
            Place::File(_) => file.as_file().sync_all(),
            Place::Device(device) => {
                copied(file.as_file(), &mut OpenOptions::new().write(true).open(device)?)
            }
            Place::StandardOutput => {
                TAKEN.store(true, Ordering::Relaxed);
                copied(file.as_file(), &mut io::stdout().lock())
            }
        };
        put().map_err(OutputError::at(&path))?;
        match &place {
            Place::File(target) => file.persist(target).map_err(OutputError::at(&path)),
            Place::Device(_) | Place::StandardOutput => Ok(()),
        }
    }
}

/// Copies all of `file`.
fn copied(file: &mut File, to: &mut dyn Write) -> io::Result<()> {
    file.seek(SeekFrom::Start(0))?;
    io::copy(file, to)?;
    to.flush()
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
        drop(begin(&folder.path().join("b")));
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[cfg(unix)]
    #[test]
    fn links_stay_and_their_targets_are_written() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("there")).unwrap();
        for (link, target) in [("old", "there/file"), ("new", "there/not-yet"), ("far", "new")] {
            symlink(target, at(link)).unwrap();
        }
        fs::write(at("there/file"), "before").unwrap();
        write(&at("old"), b"one").unwrap();
        assert_eq!(fs::read(at("there/file")).unwrap(), b"one");
        write(&at("far"), b"two").unwrap();
        assert_eq!(fs::read(at("there/not-yet")).unwrap(), b"two");
        for link in ["old", "new", "far"] {
            assert!(at(link).is_symlink(), "{link}");
        }
        symlink("circle", at("circle")).unwrap();
        assert!(write(&at("circle"), b"three").is_err());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 5);
    }
}
