//! `campaign --worst` as users run it: what it writes is replayed through both FMUs to the same J/J_th.

#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::Path;

use serde_json::Value;

#[path = "common/command.rs"]
mod command;

use command::{failure, made_by_command, steerguard, success};

/// Everything of `[uncertainty]` stated, a sensor that is off, an actuator with a limit; made in little time.
const SPECIFICATION: &str = "
    design.search_budget = 1
    [sensors]
    steering_offset_deg = 0.3
    yaw_rate_bias_deg_per_s = -0.1
    [actuator]
    lag_s = 0.05
    rate_limit_rad_per_s = 0.6
    [uncertainty]
    actuator_lag_s = 0.005
    actuator_delay_s = 0.012
    steering_ratio_percent = [-1, 2]
    steering_offset_deg = 0.05
    yaw_rate_bias_deg_per_s = 0.05
    v_x_scale_percent = 0.5
    friction = [0.9, 1.0]
    [estimator]
    enabled = true
    [evaluation.calibration]
    speeds = 3
    manoeuvres = ['weave', 'step_steer']
    disturbance_frequencies = 1
    disturbance_phases = 1
    initial_v_y_m_per_s = [0]
    search_drives = 400
";

/// A search of the design in `folder`.
fn search(folder: &Path, further: &[&str]) -> Value {
    let arguments = ["campaign", "design.json", "--allow", "blind,uncertified"];
    let worst = ["--worst", "--budget", "100", "--seed", "3", "--json"];
    let text = success(folder, &[&arguments, &worst[..], further].concat());
    serde_json::from_str(&text).unwrap()
}

/// A folder with the design, its FMU, and `worst/`, what a search on one processor wrote.
fn made() -> std::path::PathBuf {
    made_by_command(SPECIFICATION, |folder| {
        fs::write(folder.join("spec.toml"), SPECIFICATION).unwrap();
        // Few syntheses make a design, a good one or not.
        steerguard(folder, &["design", "spec.toml"]);
        let fmu = ["package", "design.json", "--allow", "blind,uncertified", "-o", "detector.fmu"];
        success(folder, &fmu);
        let report = search(folder, &["--jobs", "1", "-o", "worst"]);
        fs::write(folder.join("report.json"), report.to_string()).unwrap();
    })
}

fn report() -> Value {
    serde_json::from_str(&fs::read_to_string(made().join("report.json")).unwrap()).unwrap()
}

#[test]
fn worst_drives_are_replayed_through_both_fmus() {
    let report = report();
    let [families, second] =
        ["families", "second_families"].map(|key| report[key].as_array().unwrap().clone());
    assert_eq!([families.len(), second.len()], [13, 13]);
    let folder = tempfile::tempdir().unwrap();
    let of_residual = families.iter().map(|family| (family, "", ["J_rms", "J_th"]));
    let of_second =
        second.iter().map(|family| (family, "second_", ["second_ratio", "second_ratio"]));
    for (family, prefix, columns) in of_residual.chain(of_second) {
        let name = family["family"].as_str().unwrap();
        let group = if family["stated"] == true { "ratio" } else { "not_stated" };
        assert_eq!(report[format!("{prefix}{group}")][name], family["ratio"]);
        let scenario = made().join(family["scenario"].as_str().unwrap());
        let detector = made().join("detector.fmu");
        let [detector, scenario] = [&detector, &scenario].map(|path| path.to_str().unwrap());
        let arguments = ["simulate", "--detector", detector, "--scenario", scenario, "--json"];
        let simulated: Value = serde_json::from_str(&success(folder.path(), &arguments)).unwrap();
        let replayed = simulated["detections"][0]["largest_fault_free_ratio"].as_f64().unwrap();
        let ratio = family["ratio"].as_f64().unwrap();
        // Where the vehicle has left S_x the search no longer counts, and the replay may show more.
        let time_s = family["time_s"].as_f64().unwrap();
        let [at, of] = recorded(folder.path(), time_s, columns);
        if prefix.is_empty() {
            let at = at / of;
            assert!((at / ratio - 1.0).abs() < 1e-12, "{name}: {at} at {time_s} s for {ratio}");
            assert!(replayed >= ratio * (1.0 - 1e-12), "{name}: {replayed} for {ratio}");
        } else {
            // What reaches its threshold changes what follows.
            assert!(ratio >= 1.0 || (at / ratio - 1.0).abs() < 1e-9, "{name}: {at} for {ratio}");
        }
    }
    let below = second.iter().filter(|family| family["ratio"].as_f64().unwrap() < 1.0).count();
    assert!(below > 0, "none of the second test's drives is compared");
}

/// Two variables at a time, of the run recorded in `folder`.
fn recorded(folder: &Path, time_s: f64, columns: [&str; 2]) -> [f64; 2] {
    let results = fs::read_dir(folder.join("steerguard-out")).unwrap();
    let mut paths = results.map(|entry| entry.unwrap().path());
    let path = paths.find(|path| path.extension().is_some_and(|e| e == "csv")).unwrap();
    let mut reader = csv::Reader::from_path(&path).unwrap();
    let headers = reader.headers().unwrap().clone();
    let column = |name: &str| headers.iter().position(|header| header == name).unwrap();
    let time = column("time");
    let record = reader
        .records()
        .map(|record| record.unwrap())
        .find(|record| (record[time].parse::<f64>().unwrap() - time_s).abs() < 1e-6)
        .unwrap();
    fs::remove_file(path).unwrap();
    columns.map(|name| record[column(name)].parse().unwrap())
}

#[test]
fn a_search_writes_the_same_whatever_the_number_of_workers() {
    let folder = tempfile::tempdir().unwrap();
    fs::copy(made().join("design.json"), folder.path().join("design.json")).unwrap();
    assert_eq!(search(folder.path(), &["--jobs", "3", "-o", "worst"]), report());
    for family in report()["families"].as_array().unwrap() {
        let path = family["scenario"].as_str().unwrap();
        let [one, three] = [made().as_path(), folder.path()].map(|of| fs::read(of.join(path)));
        assert!(one.unwrap() == three.unwrap(), "{path} differs");
    }
}

#[test]
fn a_search_takes_no_settings_of_random_drives() {
    let folder = tempfile::tempdir().unwrap();
    for (further, part) in [
        (["--worst", "--drives=5"], "--drives"),
        (["--worst", "--friction=0.5..1"], "--friction"),
        (["--worst", "--budget=99"], "99"),
        (["--budget=1000", "--seed=2"], "--worst"),
    ] {
        let arguments = [&["campaign", "design.json"][..], &further].concat();
        failure(folder.path(), &arguments, 2, &[part]);
    }
}
