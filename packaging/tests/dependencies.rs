//! What the shared libraries inside the FMUs are linked from: of this workspace, each its model, its
//! version of FMI and what all are made of, and nothing else.

#![allow(clippy::unwrap_used)]

use std::collections::BTreeSet;
use std::process::Command;

/// What all libraries are linked from.
const COMMON: [&str; 3] =
    ["steerguard-detector", "steerguard-fmu-core", "steerguard-model-description"];

/// Packages of this workspace that `package` is linked from, itself aside.
fn linked(package: &str) -> BTreeSet<String> {
    let output = Command::new(env!("CARGO"))
        .args(["tree", "--offline", "--locked", "--edges", "normal", "--prefix", "none"])
        .args(["--format", "{p}", "--package", package])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let tree = String::from_utf8(output.stdout).unwrap();
    // `name version (path)`; packages from elsewhere have no path.
    let ours = tree.lines().filter(|line| line.contains('/'));
    let names = ours.filter_map(|line| line.split(' ').next()).filter(|&name| name != package);
    names.map(str::to_owned).collect()
}

fn with_common(model: &[&str]) -> BTreeSet<String> {
    COMMON.iter().chain(model).map(|&name| name.to_owned()).collect()
}

#[test]
fn the_detector_links_nothing_of_the_designer() {
    for (library, layer) in [
        ("steerguard-fmu-cdylib", "steerguard-fmi2"),
        ("steerguard-fmi3-cdylib", "steerguard-fmi3"),
    ] {
        assert_eq!(linked(library), with_common(&["steerguard-fmu", layer]));
    }
}

#[test]
fn the_reference_vehicle_links_nothing_of_the_designer() {
    assert_eq!(
        linked("steerguard-plant-cdylib"),
        with_common(&["steerguard-plant", "steerguard-world", "steerguard-fmi2"])
    );
}
