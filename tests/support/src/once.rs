//! What several tests need and is slow to make: made once, then read from `target/tests/cache`.
//!
//! Runners start a process for each test, so that nothing in memory is shared. What is made is kept
//! under the SHA-256 of its key, of the test's executable and of the programs that it runs: whatever
//! is built anew makes its own anew. Where `STEERGUARD_ONE_BUILD` is set, as by tests/run, which empties the
//! folder after its one build, the key alone tells, and all executables share.

use std::fs::{self, File};
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

/// The folder that `make` filled for this `key`, by this executable and with these `programs`.
///
/// Another process that asks for the same waits until it is made. Its users share the folder and
/// leave it as it is.
///
/// # Errors
/// What `make` says; nothing is kept then.
///
/// # Panics
/// If files cannot be read or written.
pub fn made_once<E>(
    key: &str,
    programs: &[&Path],
    make: impl FnOnce(&Path) -> Result<(), E>,
) -> Result<PathBuf, E> {
    let test = std::env::current_exe().unwrap();
    let programs: Vec<&Path> = programs.iter().copied().chain([test.as_path()]).collect();
    made_by(key, &programs, make)
}

/// The same of what these `programs` make alone, whichever executable runs them.
///
/// # Errors
/// What `make` says; nothing is kept then.
///
/// # Panics
/// If files cannot be read or written.
pub fn made_by<E>(
    key: &str,
    programs: &[&Path],
    make: impl FnOnce(&Path) -> Result<(), E>,
) -> Result<PathBuf, E> {
    // target/PROFILE/deps/NAME-HASH
    let test = std::env::current_exe().unwrap();
    let cache = test.ancestors().nth(3).unwrap().join("tests/cache");
    fs::create_dir_all(&cache).unwrap();

    let mut digest = Sha256::new();
    if std::env::var_os("STEERGUARD_ONE_BUILD").is_none() {
        for file in programs {
            digest.update(Sha256::digest(fs::read(file).unwrap()));
        }
    }
    digest.update(key);
    let name: String = digest.finalize().iter().map(|byte| format!("{byte:02x}")).collect();

    let lock = File::create(cache.join(format!("{name}.lock"))).unwrap();
    lock.lock().unwrap();
    let made = cache.join(name);
    if !made.is_dir() {
        let partly = tempfile::tempdir_in(&cache).unwrap();
        make(partly.path())?;
        fs::rename(partly.keep(), &made).unwrap();
    }
    Ok(made)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_is_made_once_and_failures_are_not_kept() {
        // A key of this run, as what is kept outlives it.
        let key = format!("{:?} {}", std::time::SystemTime::now(), std::process::id());
        let make = |text: &'static str| {
            made_once::<()>(&key, &[], |folder| {
                fs::write(folder.join("text"), text).unwrap();
                Ok(())
            })
            .unwrap()
        };
        assert_eq!(made_once(&key, &[], |_| Err("failed")), Err("failed"));
        let (first, second) = (make("first"), make("second"));
        assert_eq!(first, second);
        assert_eq!(fs::read_to_string(second.join("text")).unwrap(), "first");
        let other = made_once::<()>(&format!("{key}, another"), &[], |_| Ok(())).unwrap();
        assert_ne!(first, other);
        for folder in [first, other] {
            fs::remove_dir_all(folder).unwrap();
        }
    }
}
