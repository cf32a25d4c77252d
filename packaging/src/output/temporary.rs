//! Temporary files and folders: named ours, and removed when they are no longer needed, when the command is
//! interrupted, or, where it was killed, by the next one.
//!
//! # Conventions
//! Whoever makes one holds a lock on it, of a folder on a file inside, for as long as it lives. What is not locked
//! was left over by a command that was killed.

use std::collections::BTreeSet;
use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::{Builder, NamedTempFile, TempDir};

/// What names of files begin with, and of folders.
const FILE: &str = ".steerguard-";
const FOLDER: &str = "steerguard-fmu-";
/// The file in a folder that is locked, and what it is called until it is.
const LOCK: &str = ".lock";
const UNLOCKED: &str = ".lock-new";

/// The folders that were swept: once is enough, and a campaign writes thousands of blocks into one.
static SWEPT: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// What there is at the moment.
static LIVE: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

fn locked(paths: &'static Mutex<BTreeSet<PathBuf>>) -> MutexGuard<'static, BTreeSet<PathBuf>> {
    paths.lock().unwrap_or_else(PoisonError::into_inner)
}

fn live() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    locked(&LIVE)
}

/// Removes all that there is at the moment: the command ends.
pub fn remove_all() {
    for path in live().iter() {
        remove(path);
    }
}

/// What cannot be removed stays.
fn remove(path: &Path) {
    let _ = if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
}

/// Whether `path` is inside a folder that there is at the moment.
pub(super) fn holds(path: &Path) -> bool {
    live().iter().any(|folder| path.starts_with(folder))
}

/// What went wrong in the folder where temporary files belong, with what to do.
pub(super) fn elsewhere(error: io::Error) -> io::Error {
    let folder = std::env::temp_dir();
    let why = match error.kind() {
        io::ErrorKind::NotFound if !folder.exists() => "there is no such folder".into(),
        io::ErrorKind::NotADirectory => "it is no folder".into(),
        _ => error.to_string(),
    };
    let variable = if cfg!(windows) { "TMP" } else { "TMPDIR" };
    let message = format!(
        "in `{}`: {why}; set the environment variable {variable} to a folder that you may write to",
        folder.display()
    );
    io::Error::new(error.kind(), message)
}

/// An entry of [`LIVE`].
#[derive(Debug)]
struct Entry(PathBuf);

impl Entry {
    fn new(path: &Path) -> Self {
        live().insert(path.to_owned());
        Self(path.to_owned())
    }
}

impl Drop for Entry {
    fn drop(&mut self) {
        live().remove(&self.0);
    }
}

/// A file.
#[derive(Debug)]
pub(super) struct TemporaryFile {
    file: NamedTempFile,
    _entry: Entry,
}

impl TemporaryFile {
    /// A file in `folder`.
    pub fn new(folder: &Path) -> io::Result<Self> {
        sweep_files(folder);
        loop {
            let mut builder = Builder::new();
            builder.prefix(FILE);
            #[cfg(unix)]
            builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666)); // less the umask
            let file = builder.tempfile_in(folder)?;
            let entry = Entry::new(file.path());
            // Where there are no locks, nothing is swept either.
            let _ = file.as_file().lock();
            // Another command may have taken it for a left-over before it was locked.
            if file.path().exists() {
                return Ok(Self { file, _entry: entry });
            }
        }
    }

    pub fn as_file(&mut self) -> &mut File {
        self.file.as_file_mut()
    }

    /// Renames it to `path`.
    pub fn persist(self, path: &Path) -> io::Result<()> {
        self.file.persist(path).map(|_| ()).map_err(|error| error.error)
    }
}

/// A folder, removed with what is in it.
#[derive(Debug)]
pub struct TemporaryFolder {
    folder: TempDir,
    _lock: File,
    _entry: Entry,
}

impl TemporaryFolder {
    /// A folder where temporary files belong.
    ///
    /// # Errors
    /// If there can be none.
    pub fn new() -> io::Result<Self> {
        let parent = std::env::temp_dir();
        sweep(&parent, FOLDER, lock_of);
        loop {
            let folder = Builder::new().prefix(FOLDER).tempdir_in(&parent).map_err(elsewhere)?;
            let entry = Entry::new(folder.path());
            match locked_inside(folder.path()) {
                Ok(lock) => return Ok(Self { folder, _lock: lock, _entry: entry }),
                // Another command has taken it for a left-over before it was locked.
                Err(_) if !folder.path().exists() => {}
                Err(error) => return Err(elsewhere(error)),
            }
        }
    }

    /// Its path.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }
}

/// The lock file in `folder`, locked.
fn locked_inside(folder: &Path) -> io::Result<File> {
    let unlocked = folder.join(UNLOCKED);
    let lock = File::create(&unlocked)?;
    if lock.lock().is_ok() {
        fs::rename(unlocked, folder.join(LOCK))?;
    }
    Ok(lock)
}

/// The lock file in `folder`, be it that its command was killed before it was locked.
fn lock_of(folder: &Path) -> Option<File> {
    [LOCK, UNLOCKED].iter().find_map(|name| File::open(folder.join(name)).ok())
}

/// Removes the files that killed commands have left in `folder`.
pub fn sweep_files(folder: &Path) {
    sweep(folder, FILE, |path| File::open(path).ok());
}

/// Removes, the first time that it is asked to, what is left over in `folder` under names that begin with `prefix` and
/// whose lock, opened by `lock`, nobody holds.
fn sweep(folder: &Path, prefix: &str, lock: impl Fn(&Path) -> Option<File>) {
    if !locked(&SWEPT).insert(folder.join(prefix)) {
        return;
    }
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        if !entry.file_name().to_string_lossy().starts_with(prefix) {
            continue;
        }
        let path = entry.path();
        let Some(file) = lock(&path) else {
            // A folder without a lock is empty: its command was killed at once, or makes another if it lives.
            let _ = fs::remove_dir(&path);
            continue;
        };
        match file.try_lock() {
            Ok(()) => remove(&path),
            Err(TryLockError::WouldBlock | TryLockError::Error(_)) => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_killed_command_left_is_removed_and_what_lives_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let left = folder.path().join(".steerguard-left");
        let other = folder.path().join("steerguard-notes.txt");
        fs::write(&left, "half").unwrap();
        fs::write(&other, "kept").unwrap();
        let first = TemporaryFile::new(folder.path()).unwrap();
        assert!(!left.exists() && other.exists());
        let _second = TemporaryFile::new(folder.path()).unwrap();
        assert!(first.file.path().exists());
        first.persist(&folder.path().join("a")).unwrap();
    }

    #[test]
    fn folders_are_swept_by_the_lock_inside() {
        let parent = tempfile::tempdir().unwrap();
        let made = |name: &str| {
            let folder = parent.path().join(format!("{FOLDER}{name}"));
            fs::create_dir(&folder).unwrap();
            let lock = File::create(folder.join(LOCK)).unwrap();
            (folder, lock)
        };
        let (held, lock) = made("held");
        lock.lock().unwrap();
        let (left, _) = made("left");
        let (early, _) = made("early");
        fs::rename(early.join(LOCK), early.join(UNLOCKED)).unwrap();
        let (foreign, _) = made("foreign");
        fs::rename(foreign.join(LOCK), foreign.join("notes")).unwrap();
        let (empty, _) = made("empty");
        fs::remove_file(empty.join(LOCK)).unwrap();
        sweep(parent.path(), FOLDER, lock_of);
        assert!(held.exists() && !left.exists() && !early.exists() && foreign.exists());
        assert!(!empty.exists(), "killed before there was a lock");
    }

    #[test]
    fn what_lives_is_known_until_it_is_dropped() {
        let folder = TemporaryFolder::new().unwrap();
        let path = folder.path().to_owned();
        assert!(live().contains(&path) && path.exists());
        drop(folder);
        assert!(!live().contains(&path) && !path.exists());
    }
}
