//! Where a path leads: what exists and is no regular file is written into, never replaced.

use std::fs::{self, Metadata};
use std::io;
use std::path::{Path, PathBuf};

/// Links to links that are followed.
const MOST_LINKS: usize = 40;

/// Where a path leads.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Place {
    /// A regular file, there or not yet; links are followed.
    File(PathBuf),
    /// A device or a pipe.
    Device(PathBuf),
    /// What the command's standard output is.
    StandardOutput,
}

impl Place {
    /// Where `path` leads.
    pub fn of(path: &Path) -> io::Result<Self> {
        match fs::metadata(path) {
            Ok(there) if is_standard_output(&there) => Ok(Self::StandardOutput),
            Ok(there) if there.is_dir() => Err(io::ErrorKind::IsADirectory.into()),
            Ok(there) if there.is_file() => Ok(Self::File(fs::canonicalize(path)?)),
            Ok(_) => Ok(Self::Device(path.to_owned())),
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                Ok(Self::File(end_of_links(path)?))
            }
            Err(error) => Err(error),
        }
    }
}

/// The path that links from `path` on lead to, where nothing is yet.
fn end_of_links(path: &Path) -> io::Result<PathBuf> {
    let mut end = path.to_owned();
    for _ in 0..MOST_LINKS {
        match fs::read_link(&end) {
            Ok(target) => end = end.parent().unwrap_or(Path::new("")).join(target),
            Err(_) => return Ok(end),
        }
    }
    Err(io::Error::other("its links lead in a circle"))
}

#[cfg(unix)]
fn is_standard_output(there: &Metadata) -> bool {
    use std::os::fd::AsFd;
    use std::os::unix::fs::MetadataExt;
    let standard_output = io::stdout().as_fd().try_clone_to_owned();
    let standard_output = standard_output.and_then(|file| fs::File::from(file).metadata());
    // Nothing that is written to the null device is missed: it is a device like others.
    standard_output.is_ok_and(|other| {
        (there.dev(), there.ino()) == (other.dev(), other.ino()) && !is_null(there)
    })
}

#[cfg(unix)]
fn is_null(there: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    fs::metadata("/dev/null").is_ok_and(|null| there.rdev() != 0 && there.rdev() == null.rdev())
}

#[cfg(not(unix))]
fn is_standard_output(_: &Metadata) -> bool {
    false
}
