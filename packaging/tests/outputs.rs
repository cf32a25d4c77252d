//! What the command does to the places it writes to, and what it leaves behind when it is ended.

#![cfg(unix)]
#![allow(clippy::unwrap_used)]

use std::fs;
use std::io::{Read as _, pipe};
use std::os::unix::fs::FileTypeExt;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

#[path = "common/command.rs"]
mod command;

use command::{failure, steerguard, success};

const DESIGN: &str =
    concat!(env!("CARGO_MANIFEST_DIR"), "/../designer/verify/tests/fixtures/paper.json");

/// The command, whose temporary files go into `temporary`.
fn with_temporary(temporary: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_steerguard"));
    command.env("TMPDIR", temporary).stdout(Stdio::null()).stderr(Stdio::null());
    command
}

/// A campaign of many drives, once its temporary files are there.
fn begun(folder: &Path, temporary: &Path) -> Child {
    let mut campaign = with_temporary(temporary);
    campaign.current_dir(folder).args(["campaign", DESIGN, "--drives", "100000", "-o", "out"]);
    let child = campaign.spawn().unwrap();
    let start = Instant::now();
    // Each of the two FMUs is unpacked.
    while fs::read_dir(temporary).unwrap().count() < 2 || !folder.join("out").is_dir() {
        assert!(start.elapsed() < Duration::from_secs(120), "nothing begins");
        thread::sleep(Duration::from_millis(5));
    }
    child
}

#[test]
fn the_standard_output_gets_the_file_alone() {
    let folder = tempfile::tempdir().unwrap();
    let output = steerguard(folder.path(), &["package", DESIGN, "-o", "/dev/stdout"]);
    assert_eq!(output.status.code(), Some(0));
    assert!(output.stdout.starts_with(b"PK"), "an archive");
    let told = String::from_utf8(output.stderr).unwrap();
    assert!(told.contains("/dev/stdout") && told.contains("bytes"), "{told}");
    success(folder.path(), &["package", DESIGN, "-o", "a.fmu"]);
    assert_eq!(output.stdout, fs::read(folder.path().join("a.fmu")).unwrap());
    assert!(fs::metadata("/dev/stdout").is_ok());
}

#[test]
fn a_pipe_is_written_into_and_stays() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("pipe.fmu");
    assert!(Command::new("mkfifo").arg(&path).status().unwrap().success());
    let reader = thread::spawn({
        let path = path.clone();
        move || fs::read(path).unwrap()
    });
    success(folder.path(), &["package", DESIGN, "-o", "pipe.fmu"]);
    assert!(reader.join().unwrap().starts_with(b"PK"));
    assert!(fs::symlink_metadata(&path).unwrap().file_type().is_fifo());
}

#[test]
fn a_device_is_written_into_and_stays() {
    let folder = tempfile::tempdir().unwrap();
    success(folder.path(), &["package", DESIGN, "-o", "/dev/null"]);
    assert!(fs::metadata("/dev/null").unwrap().file_type().is_char_device());
    let parts = ["/dev/full", "No space left on device"];
    failure(folder.path(), &["package", DESIGN, "-o", "/dev/full"], 2, &parts);
    assert!(fs::metadata("/dev/full").unwrap().file_type().is_char_device());
}

#[test]
fn a_result_that_nobody_takes_is_an_error() {
    let (reader, writer) = pipe().unwrap();
    drop(reader);
    let mut command = Command::new(env!("CARGO_BIN_EXE_steerguard"));
    command.args(["simulate", "--print-scenario"]).stdout(writer).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    let mut told = String::new();
    child.stderr.take().unwrap().read_to_string(&mut told).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(2), "{told}");
    assert!(told.contains("cannot write the result"), "{told}");
}

#[test]
fn what_is_interrupted_leaves_nothing_and_what_is_killed_leaves_it_to_the_next() {
    let [folder, temporary] = [(); 2].map(|()| tempfile::tempdir().unwrap());
    let left = || fs::read_dir(temporary.path()).unwrap().count();
    for signal in ["-INT", "-TERM"] {
        let mut child = begun(folder.path(), temporary.path());
        let pid = child.id().to_string();
        assert!(Command::new("kill").args([signal, &pid]).status().unwrap().success());
        assert_eq!(child.wait().unwrap().code(), Some(130), "{signal}");
        assert_eq!(left(), 0, "{signal}");
        fs::remove_dir_all(folder.path().join("out")).unwrap();
    }
    let mut child = begun(folder.path(), temporary.path());
    // What lives is left alone.
    let simulate = ["simulate", "--print-scenario"];
    assert!(with_temporary(temporary.path()).args(simulate).status().unwrap().success());
    assert!(left() >= 2);
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(left() >= 2, "a killed command cannot clean up");
    let check = ["replay", DESIGN, "no.csv"];
    assert!(!with_temporary(temporary.path()).args(check).status().unwrap().success());
    fs::write(folder.path().join("drive.csv"), drive()).unwrap();
    let mut replay = with_temporary(temporary.path());
    replay.current_dir(folder.path()).args(["replay", DESIGN, "drive.csv", "-o", "replayed"]);
    assert!(replay.status().unwrap().success());
    assert_eq!(left(), 0);
}

/// Ten seconds straight on.
fn drive() -> String {
    let rows = (0..1000).map(|k| format!("{:.2},15.0,0.0,0.0\n", f64::from(k) * 0.01));
    String::from("t [s],v [m/s],r [rad/s],steering [rad]\n") + &rows.collect::<String>()
}
