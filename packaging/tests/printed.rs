//! What the command prints of designs, campaigns and FMUs.
//!
//! The texts are kept in `printed/`: `INSTA_UPDATE=always` writes them anew, as is due where the stored
//! designs are renewed.

#![allow(clippy::unwrap_used)]

use std::fs;
use std::io::{Cursor, Read as _, Write as _};
use std::path::PathBuf;

use steerguard::report::design_summary::DesignSummary;
use steerguard_designer::Design;
use zip::write::SimpleFileOptions;
use zip::{ZipArchive, ZipWriter};

#[path = "common/command.rs"]
mod command;

use command::{steerguard, success};

macro_rules! assert_printed {
    ($name:expr, $text:expr) => {
        let mut settings = insta::Settings::clone_current();
        settings.set_snapshot_path("printed");
        settings.set_prepend_module_to_snapshot(false);
        settings.set_omit_expression(true);
        settings.bind(|| insta::assert_snapshot!($name, $text));
    };
}

/// A stored design, made by `cargo run --release -p steerguard-designer --example fixtures`.
fn stored(design: &str) -> PathBuf {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../designer/verify/tests/fixtures");
    PathBuf::from(folder).join(design).with_extension("json")
}

#[test]
fn summaries_of_designs() {
    for name in ["paper", "noise", "guaranteed"] {
        let design = Design::from_json(&fs::read_to_string(stored(name)).unwrap()).unwrap();
        assert_printed!(format!("design_{name}"), DesignSummary::of(&design).text(None));
    }
}

#[test]
fn the_report_of_a_campaign() {
    let folder = tempfile::tempdir().unwrap();
    let design = stored("gap");
    let arguments = ["--drives", "30", "--duration", "15", "--seed", "5", "--faults", "mixed"];
    let arguments = [&["campaign", design.to_str().unwrap(), "-o", "."], &arguments[..]].concat();
    let text = success(folder.path(), &arguments);
    // How long it took is another matter, on each machine.
    let (report, took) = text.split_once("\n30 drives in ").unwrap();
    assert!(took.contains("drive-seconds per second"), "{took}");
    assert_printed!("campaign", report);
}

#[test]
fn the_summary_of_a_replay() {
    let folder = tempfile::tempdir().unwrap();
    let design = stored("gap");
    let design = design.to_str().unwrap();
    let drive = ["campaign", design, "--faults", "none", "--duration", "20", "--drive"];
    for (name, index) in [("monday.csv", "1"), ("tuesday.csv", "3")] {
        let text = success(folder.path(), &[&drive[..], &[index]].concat());
        fs::write(folder.path().join(name), text).unwrap();
    }
    let drives = ["monday.csv", "tuesday.csv", "--fault-free"];
    let faults = ["--fault", "bias=0.1@10s", "--fault", "bias=1@10s", "--fault", "loss=0.5@10s"];
    let arguments = [&["replay", design], &drives[..], &faults, &["-o", "replayed"]].concat();
    assert_printed!("replay", success(folder.path(), &arguments));
}

#[test]
fn findings_in_an_fmu() {
    let folder = tempfile::tempdir().unwrap();
    let (fmu, design) = (folder.path().join("X.fmu"), stored("paper"));
    success(folder.path(), &["package", design.to_str().unwrap(), "-o", "X.fmu"]);
    fs::write(&fmu, damaged(&fs::read(&fmu).unwrap())).unwrap();
    let output = steerguard(folder.path(), &["check", "X.fmu"]);
    assert_eq!(output.status.code(), Some(1));
    assert_eq!(output.stderr, b"");
    assert_printed!("check", String::from_utf8(output.stdout).unwrap());
}

/// An FMU without its library, and so without what differs from machine to machine, whose description
/// says what cannot be, and with entries that trouble importers.
fn damaged(fmu: &[u8]) -> Vec<u8> {
    let mut from = ZipArchive::new(Cursor::new(fmu)).unwrap();
    let mut to = ZipWriter::new(Cursor::new(Vec::new()));
    let mut add = |name: &str, bytes: &[u8]| {
        to.start_file(name, SimpleFileOptions::default()).unwrap();
        to.write_all(bytes).unwrap();
    };
    for index in 0..from.len() {
        let mut entry = from.by_index(index).unwrap();
        let name = entry.name().unwrap().into_owned();
        let mut bytes = Vec::new();
        entry.read_to_end(&mut bytes).unwrap();
        match name.as_str() {
            "modelDescription.xml" => {
                let mut text = String::from_utf8(bytes).unwrap();
                for (good, bad) in [
                    ("fmiVersion=\"2.0\"", "fmiVersion=\"2.1\""),
                    ("unit=\"m/s\"", "unit=\"mph\""),
                    ("name=\"u.delta\"", "name=\"u.T_eng\""),
                ] {
                    assert!(text.contains(good), "{good}");
                    text = text.replacen(good, bad, 1);
                }
                add(&name, text.as_bytes());
            }
            "model.png" => add(&name, b"GIF89a"),
            _ if name.starts_with("binaries/") || name.starts_with("documentation/") => {}
            _ => add(&name, &bytes),
        }
    }
    add("resources\\table.csv", b"");
    add("../escape", b"");
    add("binaries/amiga/SteeringFaultDetector.library", b"");
    to.finish().unwrap().into_inner()
}
