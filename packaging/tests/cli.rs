//! The command as users run it: results, exit codes, errors.

#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::PathBuf;

use steerguard::platform::Platform;
use tempfile::TempDir;

#[path = "common/command.rs"]
mod command;

use command::{failure, made_by_command, steerguard, success};

/// The paper's vehicle with a short calibration.
const SPEC: &str = "\
[evaluation.calibration]
speeds = 2
manoeuvres = [\"straight\"]
lateral_acceleration_m_per_s2 = [1.0]
disturbance_frequencies = 1
disturbance_phases = 1
initial_v_y_m_per_s = [0.0]
duration_s = 4.0
search_drives = 0
";

/// A folder with `spec.toml` and its `design.json`.
fn designed() -> PathBuf {
    made_by_command(SPEC, |folder| {
        fs::write(folder.join("spec.toml"), SPEC).unwrap();
        let text = success(folder, &["design", "spec.toml"]);
        for part in ["certified", "beta", "bound", "gamma", "spectral radius", "design.json"] {
            assert!(text.contains(part), "{text}");
        }
    })
}

/// A folder of its own with copies of the spec and the design.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for name in ["spec.toml", "design.json"] {
        fs::copy(designed().join(name), folder.path().join(name)).unwrap();
    }
    folder
}

fn entries(folder: &TempDir) -> Vec<String> {
    let entries = fs::read_dir(folder.path()).unwrap();
    let mut names: Vec<_> =
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn a_sound_design_is_verified_and_a_changed_one_is_not() {
    let folder = folder();
    assert!(success(folder.path(), &["verify", "design.json"]).contains("certified"));
    let json = success(folder.path(), &["verify", "design.json", "--json"]);
    let value: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(value["holds"], true);

    let design = fs::read_to_string(folder.path().join("design.json")).unwrap();
    let changed = design.replacen("\"debounce_samples\": 1", "\"debounce_samples\": 2", 1);
    assert_ne!(design, changed);
    fs::write(folder.path().join("changed.json"), changed).unwrap();
    failure(folder.path(), &["verify", "changed.json"], 1, &["hash", "changed.json", "help: "]);
    failure(folder.path(), &["package", "changed.json"], 1, &["hash"]);
}

#[test]
fn packaging_from_design_or_specification_gives_the_same_bytes() {
    let folder = folder();
    success(folder.path(), &["package", "design.json", "-o", "a.fmu", "--plant", "p.fmu"]);
    success(folder.path(), &["package", "design.json", "-o", "b.fmu"]);
    success(folder.path(), &["package", "spec.toml", "-o", "c.fmu"]);
    let read = |name: &str| fs::read(folder.path().join(name)).unwrap();
    assert_eq!(read("a.fmu"), read("b.fmu"));
    assert_eq!(read("a.fmu"), read("c.fmu"));
    let names = ["a.fmu", "b.fmu", "c.fmu", "design.json", "p.fmu", "spec.toml"];
    assert_eq!(entries(&folder), names);
}

#[test]
fn fmus_are_simulated_with_a_scenario() {
    let folder = folder();
    success(folder.path(), &["package", "design.json", "--plant", "p.fmu"]);
    let scenario = "duration_s = 6.0\ninitial_speeds_m_per_s = [15.0]\n";
    fs::write(folder.path().join("drive.toml"), scenario).unwrap();
    let json = success(
        folder.path(),
        &[
            "simulate",
            "--detector=SteeringFaultDetector.fmu",
            "--plant=p.fmu",
            "--scenario=drive.toml",
            "-o=out",
            "--json",
        ],
    );
    let value: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(value["detections"][0]["fault_onset_s"], 5.0);
    let csv = fs::read_to_string(folder.path().join("out/run-15mps.csv")).unwrap();
    assert!(csv.starts_with("time,v_x,r,u.T_eng,u.delta,fault,"), "{}", &csv[..80]);
    assert_eq!(csv.lines().count(), 601);
    let plot = fs::read_to_string(folder.path().join("out/detection.svg")).unwrap();
    assert!(plot.starts_with("<svg") && plot.trim_end().ends_with("</svg>"));
}

#[test]
fn manoeuvres_and_faults_are_simulated_by_the_names_of_campaigns() {
    let folder = folder();
    success(folder.path(), &["package", "design.json"]);
    let scenario = "duration_s = 12.0\ninitial_speeds_m_per_s = [15.0]\n\
        [manoeuvre]\nkind = \"double lane change\"\n[fault]\nkind = \"bias\"\nangle_deg = 2.0\n";
    fs::write(folder.path().join("drive.toml"), scenario).unwrap();
    let arguments = [
        "simulate",
        "--detector=SteeringFaultDetector.fmu",
        "--scenario=drive.toml",
        "-o=out",
        "--json",
    ];
    let value: serde_json::Value =
        serde_json::from_str(&success(folder.path(), &arguments)).unwrap();
    let detection = &value["detections"][0];
    assert_eq!(detection["fault_onset_s"], 5.0, "{detection}");
    assert_eq!(detection["false_alarms"], 0, "{detection}");
    assert!(detection["delay_s"].as_f64().unwrap() <= 0.4, "{detection}");
}

#[test]
fn the_printed_scenario_is_a_scenario() {
    let folder = folder();
    let text = success(folder.path(), &["simulate", "--print-scenario"]);
    let scenario = steerguard::drive::scenario::Scenario::parse(&text).unwrap();
    let json = success(folder.path(), &["simulate", "--print-scenario", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json, serde_json::to_value(scenario).unwrap());
}

#[test]
fn bad_specifications_name_the_key_and_leave_no_file() {
    for (text, parts) in [
        ("[vehicle", vec!["TOML"]),
        ("[vehicle]\nmass = 3", vec!["vehicle.mass", "help: "]),
        ("[vehicle]\nmass_kg = -1", vec!["vehicle.mass_kg", "-1"]),
        ("[vehicle]\nmass_kg = \"heavy\"", vec!["vehicle.mass_kg"]),
        ("[sampling]\nperiod_s = 0", vec!["sampling.period_s"]),
    ] {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("spec.toml"), text).unwrap();
        failure(folder.path(), &["design", "spec.toml"], 2, &parts);
        failure(folder.path(), &["package", "spec.toml"], 2, &parts);
        assert_eq!(entries(&folder), ["spec.toml"]);
    }
}

#[test]
fn an_infeasible_specification_is_a_no() {
    let folder = tempfile::tempdir().unwrap();
    let text = "[design]\nmethod = \"paper\"\ngamma = 1e-9\ndecay = 0.97\n";
    fs::write(folder.path().join("spec.toml"), text).unwrap();
    let parts = ["infeasible", "(31)", "spec.toml", "design.decay = 0.97", "3.0 per second"];
    failure(folder.path(), &["design", "spec.toml"], 1, &parts);
    assert_eq!(entries(&folder), ["spec.toml"]);
}

#[test]
fn bad_files_are_named() {
    let folder = folder();
    let path = folder.path();
    failure(path, &["design", "missing.toml"], 2, &["missing.toml", "help: "]);
    failure(path, &["verify", "missing.json"], 2, &["missing.json"]);
    failure(path, &["verify", "spec.toml"], 2, &["not a design file", "spec.toml"]);
    failure(path, &["simulate", "--detector", "spec.toml"], 2, &["spec.toml", "zip"]);
    failure(path, &["simulate", "--scenario", "missing.toml"], 2, &["missing.toml"]);
    fs::write(path.join("drive.toml"), "duration = 3\n").unwrap();
    failure(path, &["simulate", "--scenario", "drive.toml"], 2, &["duration", "drive.toml"]);
    failure(
        path,
        &["package", "design.json", "--runtime", "win64=spec.toml"],
        2,
        &["win64", "help: "],
    );
    assert_eq!(entries(&folder), ["design.json", "drive.toml", "spec.toml"]);
}

#[test]
#[cfg(unix)]
fn what_has_no_end_is_not_read() {
    let folder = folder();
    let path = folder.path();
    let too_long = ["/dev/zero", "more than 67108864 bytes", "help: "];
    failure(path, &["verify", "/dev/zero"], 2, &too_long);
    failure(path, &["simulate", "--scenario", "/dev/zero"], 2, &too_long);
    let package = |file: &'static str| ["package", "design.json", "--runtime", file];
    failure(path, &package("win64=/dev/zero"), 2, &too_long);
    failure(path, &package("win64=."), 2, &["`.`", "it is a folder", "help: "]);
    failure(path, &["replay", "design.json", "/dev/zero"], 2, &["a pipe or a device", "help: "]);
    failure(path, &["replay", "design.json", "."], 2, &["is a folder", "help: "]);
}

/// Each message names the key, the limit and what to do, be it the plant that refuses.
#[test]
fn what_the_fmus_refuse_is_told_by_the_scenarios_keys() {
    let folder = folder();
    let path = folder.path();
    success(path, &["package", "design.json", "-o", "d.fmu", "--plant", "p.fmu"]);
    let refused = |scenario: &str, parts: &[&str]| {
        fs::write(path.join("drive.toml"), scenario).unwrap();
        let fmus = ["--detector", "d.fmu", "--plant", "p.fmu", "--scenario", "drive.toml"];
        failure(path, &[&["simulate"], &fmus[..]].concat(), 2, parts);
    };
    refused(
        "[drive_torque_n_m]\noffset = 1e9\n",
        &[
            "u.T_eng",
            "is 1000000012.6 N.m, allowed",
            "-1000000 to 1000000",
            "drive_torque_n_m",
            "help: ",
        ],
    );
    refused(
        "initial_speeds_m_per_s = [1e9]\n",
        &["initial.v_x", "1000000000: 0 to 150", "initial_speeds_m_per_s"],
    );
    let no_fmu = |name: &str, parts: &[&str]| {
        failure(path, &["simulate", "--detector", name], 2, parts);
    };
    no_fmu(".", &["it is a folder, not an FMU", "help: "]);
    no_fmu("spec.toml", &["not a whole zip archive", "steerguard check"]);
    // A design is no scenario, and has a thousand lines to say so of.
    let output = steerguard(path, &["simulate", "--scenario", "design.json"]);
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), error.matches("error: ").count()), (Some(2), 10));
    assert!(error.trim_end().ends_with(" more: mend those above first, or --json tells them all"));
}

#[test]
#[cfg(unix)]
fn temporary_files_need_a_folder() {
    let folder = folder();
    for (name, why) in [("missing", "there is no such folder"), ("spec.toml", "it is no folder")] {
        let output = std::process::Command::new(env!("CARGO_BIN_EXE_steerguard"))
            .current_dir(folder.path())
            .env("TMPDIR", folder.path().join(name))
            .args(["campaign", "design.json", "--drives", "1"])
            .output()
            .unwrap();
        let error = String::from_utf8(output.stderr).unwrap().replace('\n', " ");
        let error = error.split_whitespace().collect::<Vec<_>>().join(" ");
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert!(error.contains(why) && error.contains("variable TMPDIR to a folder"), "{error}");
    }
}

#[test]
fn what_cannot_be_written_is_named() {
    let folder = folder();
    let path = folder.path();
    failure(path, &["design", "spec.toml", "-o", "no/d.json"], 2, &["no/d.json", "help: "]);
    failure(path, &["package", "design.json", "-o", "no/x.fmu"], 2, &["no/x.fmu"]);
    fs::create_dir(path.join("taken")).unwrap();
    fs::write(path.join("taken/file"), "").unwrap();
    failure(path, &["package", "design.json", "-o", "taken"], 2, &["taken"]);
    failure(path, &["--out", "spec.toml/out"], 2, &["spec.toml/out"]);
    assert_eq!(entries(&folder), ["design.json", "spec.toml", "taken"]);
}

#[test]
fn platforms_are_chosen_among_those_that_there_are() {
    let folder = folder();
    let path = folder.path();
    let host = Platform::HOST.unwrap().folder();
    let version = success(path, &["--version"]);
    assert!(version.lines().any(|line| line.starts_with("FMUs for: ") && line.contains(host)));
    assert_eq!(success(path, &["-V"]).lines().count(), 1);

    let package = ["package", "design.json", "--plant", "plant.fmu", "--system", "system.ssp"];
    let text = success(path, &[&package[..], &["--only", host]].concat());
    assert!(text.ends_with(&format!("for {host}\n")), "{text}");
    let other = if host == "win64" { "linux64" } else { "win64" };
    // A detector for a further platform, which the vehicle has not: `--only` leaves it out again.
    fs::write(path.join("library"), "").unwrap();
    let runtime = format!("{other}=library");
    let with_runtime = [&package[..], &["--runtime", &runtime, "--only", host]].concat();
    assert_eq!(success(path, &with_runtime), text);

    if !version.contains(other) {
        let wrong = [&package[..2], &["--only", other]].concat();
        failure(
            path,
            &wrong,
            2,
            &["SteeringFaultDetector for", other, "this command has", "help: "],
        );
        let wrong = [&package[..], &["--runtime", &runtime, "--only", other]].concat();
        failure(path, &wrong, 2, &["VehiclePlant for", other, "help: "]);
    }
    failure(path, &["package", "design.json", "--only", "amiga"], 2, &["amiga", "linux64"]);
}

#[test]
fn bad_usage_is_explained() {
    let folder = folder();
    for arguments in [
        &["fly"][..],
        &["package"],
        &["design", "spec.toml", "--fast"],
        &["package", "design.json", "--runtime", "amiga=x"],
    ] {
        failure(folder.path(), arguments, 2, &["help"]);
    }
    let help = success(folder.path(), &["--help"]);
    assert!(help.contains("Examples:") && help.contains("Exit status"), "{help}");
}

/// What a newcomer sees first.
#[test]
fn the_main_job_detects_the_fault_in_time() {
    let folder = tempfile::tempdir().unwrap();
    let json = success(folder.path(), &["--out", "results", "--json"]);
    let value: serde_json::Value = serde_json::from_str(&json).unwrap();

    let design = &value["design"];
    assert_eq!(design["status"], "certified");
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    assert!(number(&design["detection_ratio"]) >= 5.0, "{design}");
    assert!(number(&design["certified"]["gap"]) >= 5.0, "{design}");
    assert_eq!(value["proof"]["holds"], true);
    assert_eq!(design["threshold_kind"], "adaptive");
    let by_cause = design["threshold_by_cause"].as_array().unwrap();
    assert!(by_cause.iter().all(|point| number(&point["j_th"]) > number(&design["threshold"])));

    let detections = value["detections"].as_array().unwrap();
    assert_eq!(detections.len(), 4);
    for detection in detections {
        assert_eq!(detection["false_alarms"], 0, "{detection}");
        assert_eq!(detection["fault_onset_s"], 5.0, "{detection}");
        let speed = number(&detection["initial_speed_m_per_s"]);
        if speed == 5.0 {
            continue; // the edge of the range: reported, not promised
        }
        assert_eq!(detection["monitored_share"], 1.0, "{detection}");
        // With sensor noise and a threshold that bears gusts of 10 m/s, a bank of 3 deg, a vehicle that is
        // 10 % off, the products of these, and tyres that end: 0.33 s at 25 m/s. Without, method 7 leaves
        // 0.10 s: tests/python/test_scenario.py.
        assert!(number(&detection["delay_s"]) <= 0.40 + 1e-9, "{detection}");
        let reached = number(&detection["largest_faulty_j"]);
        assert!(number(&detection["threshold"]) <= reached / 1.5, "{detection}");
    }
    let files = &value["files"];
    let mut paths = vec![&files["design"], &files["plot"]];
    paths.extend(files["fmus"].as_array().unwrap().iter().map(|fmu| &fmu["file"]));
    paths.extend(files["csv"].as_array().unwrap());
    for path in paths {
        assert!(folder.path().join(path.as_str().unwrap()).is_file(), "{path}");
    }
}
