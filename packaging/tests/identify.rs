//! From recorded drives to a specification, as users run it.

#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::PathBuf;

use serde_json::Value;
use steerguard_designer::Spec;
use steerguard_test_support::log::{MOTORWAY, RATIO, VARIED, csv, recorded};

#[path = "common/command.rs"]
mod command;

use command::{failure, made_by_command, steerguard, success};

/// What is told of Table 1's car.
const TOLD: &str = "# Weighed.
[vehicle]
mass_kg = 1476
front_axle_distance_m = 1.13
rear_axle_distance_m = 1.49
";

/// A folder with `varied.csv`, `motorway.csv` and `told.toml`, and what `identify` makes of the first.
fn folder() -> PathBuf {
    made_by_command("drives for identify", |folder| {
        fs::write(folder.join("varied.csv"), csv(&recorded(&VARIED))).unwrap();
        fs::write(folder.join("motorway.csv"), csv(&recorded(&MOTORWAY))).unwrap();
        fs::write(folder.join("told.toml"), TOLD).unwrap();
        let printed = success(folder, &["identify", "varied.csv", "--known", "told.toml"]);
        fs::write(folder.join("printed.txt"), printed).unwrap();
    })
}

/// A fresh folder with the same drives.
fn fresh() -> tempfile::TempDir {
    let fresh = tempfile::tempdir().unwrap();
    for name in ["varied.csv", "motorway.csv", "told.toml"] {
        fs::copy(folder().join(name), fresh.path().join(name)).unwrap();
    }
    fresh
}

#[test]
fn a_varied_drive_becomes_a_specification_with_intervals_and_how_it_came_about() {
    let text = fs::read_to_string(folder().join("car.toml")).unwrap();
    let spec = Spec::from_toml(&text).unwrap();
    assert_eq!(spec.vehicle.mass_kg, 1476.0);
    let close = |value: f64, truth: f64, percent: f64| {
        assert!((value / truth - 1.0).abs() < percent / 100.0, "{value}, {truth}");
    };
    close(spec.sensors.steering_ratio, RATIO, 1.0);
    close(spec.vehicle.front_cornering_stiffness_n_per_rad, 57000.0, 2.0);
    close(spec.vehicle.rear_cornering_stiffness_n_per_rad, 59000.0, 2.0);
    close(spec.vehicle.yaw_inertia_kg_m2, 1810.0, 2.0);
    let longest_s = spec.actuator.delay_s + spec.uncertainty.actuator_delay_s;
    assert!(spec.actuator.delay_s < 0.02 && 0.02 < longest_s && longest_s < 0.03);
    let [low, high] = spec.uncertainty.front_cornering_stiffness_percent;
    assert_eq!((low, high), (-5.0, 5.0));
    // What was written by hand stays.
    assert!(text.contains("# Weighed.\n[vehicle]\nmass_kg = 1476\n"), "{text}");
    assert!(text.contains("rear_cornering_stiffness_n_per_rad = 5"), "{text}");
    assert!(text.contains(" # fitted, standard error 0."), "{text}");
    let plot = fs::read_to_string(folder().join("car.fit.svg")).unwrap();
    assert!(plot.starts_with("<svg") && plot.contains("yaw rate [deg/s]"));
    let printed = fs::read_to_string(folder().join("printed.txt")).unwrap();
    for part in [
        "speed: column \"v [m/s]\"",
        "steering ratio",
        "Left over of the yaw rate: 0.11",
        "white (autocorrelation",
        "Next: steerguard design car.toml",
    ] {
        assert!(printed.contains(part), "{part} is not in\n{printed}");
    }
}

#[test]
fn the_report_as_json_names_keys_errors_and_files() {
    let fresh = fresh();
    let arguments = ["identify", "varied.csv", "--known", "told.toml", "--json", "-o", "a.toml"];
    let report: Value = serde_json::from_str(&success(fresh.path(), &arguments)).unwrap();
    assert_eq!(report["lateral_acceleration"], "used");
    assert_eq!(report["specification"], "a.toml");
    let parameters = report["parameters"].as_array().unwrap();
    let ratio = parameters.iter().find(|of| of["key"] == "sensors.steering_ratio").unwrap();
    assert_eq!(ratio["origin"], "fitted");
    assert!(ratio["standard_error"].as_f64().unwrap() < 0.01);
    // The same bytes as without it.
    let text = fs::read_to_string(fresh.path().join("a.toml")).unwrap();
    assert_eq!(text, fs::read_to_string(folder().join("car.toml")).unwrap());
}

#[test]
fn what_a_motorway_does_not_show_is_named_and_nothing_is_written() {
    let fresh = fresh();
    let arguments = ["identify", "motorway.csv", "--known", "told.toml", "--json"];
    let output = steerguard(fresh.path(), &arguments);
    assert_eq!(output.status.code(), Some(1));
    let error: Value = serde_json::from_slice(&output.stderr).unwrap();
    let messages: Vec<&str> = error["diagnostics"]
        .as_array()
        .unwrap()
        .iter()
        .map(|of| of["message"].as_str().unwrap())
        .collect();
    for parameter in
        ["steering ratio", "steering offset", "yaw-rate bias", "front cornering", "rear cornering"]
    {
        assert!(
            messages.iter().any(|of| of.contains(parameter)),
            "{parameter} is not in {messages:?}"
        );
    }
    assert_eq!(fs::read_dir(fresh.path()).unwrap().count(), 3);
}

#[test]
fn wrong_preparations_are_named() {
    let fresh = fresh();
    let told = ["--known", "told.toml"];
    let with =
        |further: &[&'static str]| [&["identify", "varied.csv"], &told[..], further].concat();
    let turned = with(&["--yaw", "yaw_rate [deg/s]:-deg/s"]);
    failure(fresh.path(), &turned, 1, &["go against each other", "--yaw NAME:-deg/s"]);
    let late = with(&["--delay", "yaw=0.05"]);
    failure(
        fresh.path(),
        &late,
        1,
        &["the steering is recorded 2", "ms late", "--delay steering=0.02"],
    );
    let none = ["identify", "varied.csv"];
    failure(fresh.path(), &none, 2, &["neither the mass of the car", "--known FILE", "mass_kg"]);
    let over = with(&["-o", "varied.csv"]);
    failure(fresh.path(), &over, 2, &["written over itself"]);
    assert_eq!(fs::read_dir(fresh.path()).unwrap().count(), 3);
}

#[test]
fn mistakes_in_what_is_known_show_their_line() {
    let fresh = fresh();
    let text = "[vehicle]\nmas_kg = 1476\nfront_axle_distance_m = -1\n";
    fs::write(fresh.path().join("told.toml"), text).unwrap();
    let arguments = ["identify", "varied.csv", "--known", "told.toml"];
    let parts = [
        "told.toml:2",
        "mas_kg",
        "mass_kg",
        "told.toml:3",
        "rear_axle_distance_m",
        "weigh the axles",
    ];
    failure(fresh.path(), &arguments, 2, &parts);
}
