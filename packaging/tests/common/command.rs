//! Running the command as users do.

#![allow(dead_code, reason = "not every test needs all")]

use std::convert::Infallible;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use steerguard_test_support::once::made_once;

/// Runs the command in `folder`.
pub fn steerguard(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_steerguard"))
        .current_dir(folder)
        .env_remove("COLUMNS")
        .args(arguments)
        .output()
        .unwrap()
}

/// Runs what must succeed and returns its standard output.
pub fn success(folder: &Path, arguments: &[&str]) -> String {
    let output = steerguard(folder, arguments);
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {error}");
    assert_eq!(error, "", "{arguments:?}");
    String::from_utf8(output.stdout).unwrap()
}

/// The folder that `make` fills by running the command, once for all tests of a run that give `key`.
pub fn made_by_command(key: &str, make: impl FnOnce(&Path)) -> PathBuf {
    let command = Path::new(env!("CARGO_BIN_EXE_steerguard"));
    let made = made_once(key, &[command], |folder| {
        make(folder);
        Ok::<(), Infallible>(())
    });
    made.unwrap()
}

/// Runs what must fail with `code`, print no result, and name all `parts` in its error.
pub fn failure(folder: &Path, arguments: &[&str], code: i32, parts: &[&str]) {
    let output = steerguard(folder, arguments);
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {error}");
    assert_eq!(output.stdout, b"", "{arguments:?}");
    assert!(error.starts_with("error: "), "{arguments:?}: {error}");
    for part in parts {
        assert!(error.contains(part), "{arguments:?}: `{part}` is missing in\n{error}");
    }
}
