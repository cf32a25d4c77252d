//! A saved state goes on in another process.
//!
//! The test starts its own program again, for the test `continue_from_file` alone, which finds in its
//! environment what to do.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use std::path::Path;
use std::process::Command;
use std::{env, fs};

use common::Packaged;
use common::raw::Raw;
use steerguard_conformance_tests::Functions;

const JOB: &str = "STEERGUARD_CONTINUE";
const SAVED_AT: [u64; 4] = [0, 1, 1234, 4200];
const END: u64 = 6000;

/// Variables of the job: library, GUID, file, sample, period; separated by line feeds.
fn job(packaged: &Packaged, file: &Path, sample: u64) -> String {
    [
        packaged.library.to_str().unwrap(),
        packaged.guid.to_str().unwrap(),
        file.to_str().unwrap(),
        &sample.to_string(),
        &packaged.sample_period_s().to_string(),
    ]
    .join("\n")
}

/// Reads a state, goes on from it and writes the results in its place.
#[test]
fn continue_from_file() {
    let Ok(job) = env::var(JOB) else { return };
    let [library, guid, file, sample, period_s] = job.lines().collect::<Vec<_>>()[..] else {
        panic!("{job}");
    };
    let (functions, _code) = Functions::load(Path::new(library)).unwrap();
    let guid = std::ffi::CString::new(guid).unwrap();
    // Straight after fmi2Instantiate: the state holds all that the calls since then would bring.
    let raw = Raw::instantiated(&functions, &guid, "elsewhere");
    raw.restore(&fs::read(file).unwrap());
    let results = raw.drive(sample.parse().unwrap()..END, period_s.parse().unwrap());
    fs::write(file, text(&results)).unwrap();
}

fn text(results: &[[u64; 8]]) -> String {
    results.iter().map(|row| format!("{row:?}\n")).collect()
}

#[test]
fn a_state_continues_bit_for_bit_in_another_process() {
    let packaged = Packaged::new();
    let (functions, _code) = packaged.load();
    let period_s = packaged.sample_period_s();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("state");

    let raw = Raw::new(&functions, &packaged.guid, "here");
    let mut saved = Vec::new();
    let mut results = Vec::new();
    for sample in 0..END {
        if SAVED_AT.contains(&sample) {
            saved.push((sample, raw.serialised()));
        }
        results.extend(raw.drive(sample..sample + 1, period_s));
    }
    for (sample, state) in saved {
        fs::write(&file, state).unwrap();
        let output = Command::new(env::current_exe().unwrap())
            .args(["--exact", "continue_from_file"])
            .env(JOB, job(&packaged, &file, sample))
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stdout));
        let found = fs::read_to_string(&file).unwrap();
        assert!(found == text(&results[sample as usize..]), "continued from sample {sample}");
    }
}
