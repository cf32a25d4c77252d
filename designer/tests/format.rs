//! The design file's format: what a version of it holds, and that files in it are current.

#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::Path;

use serde_json::Value;
use steerguard_designer::{Design, FORMAT, Spec, design};

#[path = "common/fixtures.rs"]
mod fixtures;

/// Paths of all numbers below `value`, a line each, elements of an array as one.
fn paths(value: &Value, path: &str, lines: &mut Vec<String>) {
    match value {
        Value::Object(keys) => {
            for (key, value) in keys {
                paths(value, &format!("{path}.{key}"), lines);
            }
        }
        Value::Array(elements) if !elements.is_empty() => {
            paths(&elements[0], &format!("{path}[{}]", elements.len()), lines);
        }
        _ => lines.push(path.to_owned()),
    }
}

/// What is baked is another design format as soon as it has another field: then FORMAT gets another
/// number, docs/formats.md and the proof's reader know the field, and a list of that name is added here.
#[test]
fn a_field_more_or_less_in_the_detector_is_another_format() {
    // That with the second test.
    let fixture = fixtures::all().into_iter().find(|fixture| fixture.name == "gap").unwrap();
    let text = fs::read_to_string(&fixture.design).unwrap();
    let design = Design::from_json(&text).unwrap();
    let mut lines = Vec::new();
    paths(&serde_json::to_value(design.detector).unwrap(), "detector", &mut lines);
    let name = format!("{}.detector.txt", FORMAT.replace('/', "-"));
    let list = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures").join(name);
    let listed = fs::read_to_string(&list).unwrap();
    assert_eq!(lines.join("\n") + "\n", listed, "{}", list.display());
}

/// `cargo run --release -p steerguard-designer --example fixtures` renews them.
fn assert_current(name: &str) {
    let fixture = fixtures::all().into_iter().find(|fixture| fixture.name == name).unwrap();
    let spec = Spec::from_toml(&fs::read_to_string(&fixture.specification).unwrap()).unwrap();
    let made = design(&spec, &mut |_| {}).unwrap().to_json().unwrap();
    let stored = fs::read_to_string(&fixture.design).unwrap();
    assert!(made == stored, "{} is not what its specification gives", fixture.design.display());
}

#[test]
fn fixture_paper_is_current() {
    assert_current("paper");
}

#[test]
fn fixture_gap_is_current() {
    assert_current("gap");
}

#[test]
fn fixture_noise_is_current() {
    assert_current("noise");
}

#[test]
fn fixture_guaranteed_is_current() {
    assert_current("guaranteed");
}
