//! Unpacking an FMU into a temporary folder, with every size bounded.

use std::fs;
use std::io::Read;
use std::path::{Component, Path};

use zip::ZipArchive;
use zip::result::ZipError;

/// Most entries an FMU may have.
pub(crate) const MAX_ENTRIES: usize = 10_000;
/// Most bytes an FMU may unpack to.
pub(crate) const MAX_UNPACKED_BYTES: u64 = 1 << 30;

/// An FMU file that cannot be unpacked, or had better not be.
#[derive(Debug, thiserror::Error)]
pub enum UnpackError {
    /// The file cannot be read, or the folder not be written.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// The file is a folder.
    #[error("it is a folder, not an FMU")]
    Folder,
    /// The file is not a sound zip archive.
    #[error("not a whole zip archive, be it cut short or something else: {0}")]
    Zip(#[from] ZipError),
    /// The archive has too many entries.
    #[error("{0} entries, more than the {MAX_ENTRIES} allowed")]
    TooManyEntries(usize),
    /// The archive unpacks to too much.
    #[error("unpacks to more than {MAX_UNPACKED_BYTES} bytes")]
    TooLarge,
    /// An entry would be written outside the folder, or is not a plain file or folder.
    #[error("entry `{0}` is not a file or folder inside the archive")]
    UnsafeEntry(String),
}

/// Unpacks the FMU at `path` into the existing `folder`.
///
/// # Errors
/// [`UnpackError`]; `folder` may then hold a part of the archive.
pub(super) fn unpack(path: &Path, folder: &Path) -> Result<(), UnpackError> {
    let file = fs::File::open(path)?;
    if file.metadata()?.is_dir() {
        return Err(UnpackError::Folder);
    }
    let mut archive = ZipArchive::new(file)?;
    if archive.len() > MAX_ENTRIES {
        return Err(UnpackError::TooManyEntries(archive.len()));
    }
    let mut left = MAX_UNPACKED_BYTES;
    for index in 0..archive.len() {
        let mut entry = archive.by_index(index)?;
        let name = entry.name()?.into_owned();
        if !is_safe(&name) || entry.is_symlink() {
            return Err(UnpackError::UnsafeEntry(name));
        }
        let target = folder.join(&name);
        if entry.is_dir() {
            fs::create_dir_all(&target)?;
            continue;
        }
        if let Some(parent) = target.parent() {
            fs::create_dir_all(parent)?;
        }
        // One byte more than is left: what a header claims of its size proves nothing.
        let mut file = fs::File::create(&target)?;
        let written = std::io::copy(&mut (&mut entry).take(left + 1), &mut file)?;
        left = left.checked_sub(written).ok_or(UnpackError::TooLarge)?;
    }
    Ok(())
}

/// Whether an entry name is relative and stays inside, on every operating system.
pub(super) fn is_safe(name: &str) -> bool {
    !name.is_empty()
        && !name.contains(['\\', ':', '\0'])
        && Path::new(name).components().all(|part| matches!(part, Component::Normal(_)))
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    fn archive(names: &[&str]) -> tempfile::NamedTempFile {
        let mut writer = zip::ZipWriter::new(tempfile::NamedTempFile::new().unwrap());
        for name in names {
            writer.start_file(*name, zip::write::SimpleFileOptions::default()).unwrap();
            writer.write_all(b"content").unwrap();
        }
        writer.finish().unwrap()
    }

    #[test]
    fn plain_entries_are_unpacked() {
        let folder = tempfile::tempdir().unwrap();
        unpack(archive(&["a", "b/c.txt"]).path(), folder.path()).unwrap();
        assert_eq!(fs::read(folder.path().join("b/c.txt")).unwrap(), b"content");
    }

    #[test]
    fn entries_that_leave_the_folder_are_refused() {
        for name in ["../evil", "a/../../evil", "/evil", "c:/evil", "a\\..\\evil"] {
            let folder = tempfile::tempdir().unwrap();
            let inside = folder.path().join("inside");
            fs::create_dir(&inside).unwrap();
            let error = unpack(archive(&["fine", name]).path(), &inside).unwrap_err();
            assert!(matches!(error, UnpackError::UnsafeEntry(_)), "{name}: {error}");
            assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "{name}");
        }
    }

    #[test]
    fn what_is_no_archive_is_refused() {
        let mut file = tempfile::NamedTempFile::new().unwrap();
        file.write_all(b"no archive").unwrap();
        let folder = tempfile::tempdir().unwrap();
        assert!(matches!(unpack(file.path(), folder.path()), Err(UnpackError::Zip(_))));
        assert!(matches!(unpack(Path::new("missing"), folder.path()), Err(UnpackError::Io(_))));
    }
}
