//! Edited designs whose hash was made right again: refused by `verify`, and by `package` before it does
//! anything, with the same words; and what `package` and `campaign` take nevertheless.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::fs;
use std::path::Path;

use serde_json::{Value, json};
use steerguard_verify::content_hash;

#[path = "common/command.rs"]
mod command;

use command::{failure, success};

/// The default specification's design.
const DESIGN: &str = include_str!("../../designer/verify/tests/fixtures/gap.json");

/// `design.json` after `edit`, with the hash of its content, in a folder of its own.
fn edited(edit: impl FnOnce(&mut Value)) -> tempfile::TempDir {
    let mut design: Value = serde_json::from_str(DESIGN).unwrap();
    edit(&mut design);
    assert_ne!(design, serde_json::from_str::<Value>(DESIGN).unwrap(), "nothing was edited");
    design["hash"] = content_hash(&design).unwrap().into();
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("design.json"), design.to_string()).unwrap();
    folder
}

/// Applies `change` to the number at `pointer`.
fn change(design: &mut Value, pointer: &str, change: impl Fn(f64) -> f64) {
    let number = design.pointer_mut(pointer).unwrap_or_else(|| panic!("no {pointer}"));
    *number = change(number.as_f64().unwrap()).into();
}

fn set(design: &mut Value, pointer: &str, value: Value) {
    *design.pointer_mut(pointer).unwrap_or_else(|| panic!("no {pointer}")) = value;
}

fn each_of_e(design: &mut Value, to: impl Fn(f64) -> f64) {
    for row in 0..3 {
        for column in 0..2 {
            change(design, &format!("/detector/gains/e/{row}/{column}"), &to);
        }
    }
}

const COMMANDS: [&[&str]; 3] = [
    &["verify", "design.json"],
    &["package", "design.json", "--allow", "uncertified"],
    &["campaign", "design.json", "--drives", "1", "--allow", "uncertified", "-o", "campaign"],
];

/// Refused by `commands`, with `part` in what they say, whatever is allowed.
fn refused(commands: &[&[&str]], folder: &Path, exit: i32, part: &str) {
    for arguments in commands {
        failure(folder, arguments, exit, &[part, "design.json", "help: "]);
    }
    assert_eq!(fs::read_dir(folder).unwrap().count(), 1, "nothing is left behind");
}

/// A test of each edit: its name, what it does to the design, and what is said of it.
macro_rules! edits {
    ($($name:ident: $edit:expr => $part:expr;)*) => {$(
        #[test]
        fn $name() {
            let edit: fn(&mut Value) = $edit;
            refused(&COMMANDS[..2], edited(edit).path(), 1, $part);
        }
    )*};
}

const THRESHOLD: &str = "/detector/evaluation/threshold";
const SHARE: &str = "/detector/evaluation/uncertainty_share";

edits! {
    e_zero: |d| each_of_e(d, |_| 0.0) => "M - (I + E C)";
    e_times_ten: |d| each_of_e(d, |x| 10.0 * x) => "M - (I + E C)";
    one_entry_of_e: |d| change(d, "/detector/gains/e/1/1", |x| x + 1e-7) => "M - (I + E C)";
    window: |d| change(d, "/detector/evaluation/window", |_| 41.0) => "`detector.evaluation.window`";
    weights: |d| change(d, "/detector/evaluation/weights/1", |x| 1.1 * x)
        => "`detector.evaluation.weights`";
    weights_in_both: |d| {
        change(d, "/detector/evaluation/weights/1", |x| 1.1 * x);
        change(d, "/spec/evaluation/weights/1", |x| 1.1 * x);
    } => "does not hold";
    debounce: |d| set(d, "/detector/evaluation/debounce_samples", json!(2))
        => "`detector.evaluation.debounce_samples`";
    threshold_kind: |d| set(d, "/threshold/kind", json!("constant")) => "`threshold.kind`";
    threshold_kind_in_both: |d| {
        set(d, "/threshold/kind", json!("calibrated"));
        set(d, "/spec/evaluation/threshold", json!("calibrated"));
    } => "`threshold.uncertain`";
    no_second_test: |d| set(d, "/detector/estimator", Value::Null) => "`detector.estimator";
    second_threshold: |d| change(d, "/detector/estimator/threshold", |x| 2.0 * x)
        => "`detector.estimator.threshold`";
    second_noise: |d| change(d, "/detector/estimator/noise/0", |x| 2.0 * x)
        => "`detector.estimator.noise`";
    second_level: |d| change(d, "/threshold/second/in_99_of_100", |x| 0.5 * x)
        => "`detector.estimator.estimate_factor`";
    second_in_spec_alone: |d| set(d, "/spec/estimator/enabled", json!(false))
        => "`detector.estimator";
    threshold_margin: |d| change(d, "/threshold/margin", |x| 2.0 * x) => "`threshold.margin`";
    start_up_amplitude: |d| change(d, "/detector/evaluation/start_up_amplitude", |_| 0.0)
        => "`detector.evaluation.start_up_amplitude` = 0";
    start_up_decay: |d| change(d, "/detector/evaluation/start_up_decay", |x| 0.9 * x)
        => "start-up: the inequality";
    certified_beta: |d| change(d, "/performance/certified/beta", |x| 2.0 * x)
        => "`performance.certified.beta`";
    certified_gamma: |d| change(d, "/performance/certified/gamma", |x| x / 2.0)
        => "`performance.certified.gamma`";
    certified_gap: |d| change(d, "/performance/certified/gap", |_| 1e9)
        => "`performance.certified.gap` = 1000000000";
    frozen_gap: |d| change(d, "/performance/frozen/gap", |_| 1e9) => "`performance.frozen.gap`";
    synthesis_gap: |d| change(d, "/synthesis/gap", |_| 1e9) => "`synthesis.gap`";
    mass_in_both: |d| {
        change(d, "/spec/vehicle/mass_kg", |x| x + 100.0);
        change(d, "/detector/model/vehicle/mass_kg", |x| x + 100.0);
    } => "`vertices[0].A`";
    mass_in_the_detector: |d| change(d, "/detector/model/vehicle/mass_kg", |x| x + 100.0)
        => "`vertices[0].A`";
    period_in_both: |d| {
        change(d, "/spec/sampling/period_s", |x| 2.0 * x);
        change(d, "/detector/model/sampling_period_s", |x| 2.0 * x);
    } => "`vertices[0].A`";
    disturbance_bound: |d| change(d, "/spec/disturbance/0/bound_m_per_s2", |x| 50.0 * x)
        => "`performance.certified.gap`";
    threshold_huge: |d| change(d, THRESHOLD, |_| 1e300) => "`detector.evaluation.threshold`";
    threshold_tiny: |d| change(d, THRESHOLD, |_| 1e-300) => "`detector.evaluation.threshold`";
    threshold_twice: |d| change(d, THRESHOLD, |x| 2.0 * x) => "`detector.evaluation.threshold`";
    share_zero: |d| change(d, SHARE, |_| 0.0) => "`detector.evaluation.uncertainty_share`";
    share_huge: |d| change(d, SHARE, |_| 1e6) => "`detector.evaluation.uncertainty_share`";
    detection_ratio: |d| change(d, "/performance/detection_ratio", |_| 1e9)
        => "`performance.detection_ratio` is 1000000000.0";
    range: |d| change(d, "/detector/model/range/v_y/max", |x| 2.0 * x)
        => "`detector.model.range.v_y`";
    hysteresis: |d| change(d, "/detector/hysteresis/2", |_| 0.0) => "`detector.hysteresis`";
    euler_correction: |d| set(d, "/detector/deviations/euler_correction", json!(false))
        => "`detector.deviations.euler_correction`";
    smallest_fault: |d| change(d, "/detector/deviations/smallest_fault/1", |x| 0.5 * x)
        => "`detector.deviations.smallest_fault[1]`";
    uncertainty_of_the_mass: |d| change(d, "/detector/deviations/uncertainty/mass", |x| 0.5 * x)
        => "`detector.deviations.uncertainty.mass`";
    uncertainty_of_the_bank: |d| {
        change(d, "/detector/deviations/uncertainty/bank_m_per_s2", |x| 0.5 * x);
    } => "`detector.deviations.uncertainty.bank_m_per_s2`";
    gust: |d| {
        change(d, "/detector/deviations/uncertainty/gust/coefficient_n_s2_per_m2", |x| 0.5 * x);
    } => "`detector.deviations.uncertainty.gust.coefficient_n_s2_per_m2`";
    air_density: |d| change(d, "/constants/air_density_kg_per_m3", |x| 0.5 * x)
        => "`constants.air_density_kg_per_m3`";
    gravity: |d| change(d, "/constants/gravity_m_per_s2", |_| 9.81) => "gravity";
    alarm_hold: |d| set(d, "/detector/evaluation/alarm_hold_s", json!(0.0))
        => "`detector.evaluation.alarm_hold_s`";
    friction: |d| set(d, "/detector/deviations/uncertainty/friction", json!(0.5))
        => "`detector.deviations.uncertainty.friction`";
    load_transfer: |d| set(d, "/detector/deviations/uncertainty/load_transfer", json!(0.0))
        => "`detector.deviations.uncertainty.load_transfer`";
    steering_ratio: |d| set(d, "/detector/deviations/uncertainty/steering_ratio", json!(0.1))
        => "`detector.deviations.uncertainty.steering_ratio`";
    uncertainty_of_the_steering_offset: |d| set(d, "/detector/deviations/uncertainty/steering_offset_rad", json!(0.1))
        => "`detector.deviations.uncertainty.steering_offset_rad`";
    uncertainty_of_the_yaw_rate_bias: |d| set(d, "/detector/deviations/uncertainty/yaw_rate_bias_rad_per_s", json!(0.1))
        => "`detector.deviations.uncertainty.yaw_rate_bias_rad_per_s`";
    v_x_scale: |d| set(d, "/detector/deviations/uncertainty/v_x_scale", json!(0.1))
        => "`detector.deviations.uncertainty.v_x_scale`";
    steering_offset: |d| set(d, "/detector/zero/steering_offset_rad", json!(0.1))
        => "`detector.zero.steering_offset_rad`";
    yaw_rate_bias: |d| set(d, "/detector/zero/yaw_rate_bias_rad_per_s", json!(0.1))
        => "`detector.zero.yaw_rate_bias_rad_per_s`";
    stale_after: |d| set(d, "/detector/staleness/after_s", json!(0.0))
        => "`detector.staleness.after_s`";
    v_x_jump: |d| set(d, "/detector/staleness/v_x_jump_m_per_s", json!(0.0))
        => "`detector.staleness.v_x_jump_m_per_s`";
    r_jump: |d| set(d, "/detector/staleness/r_jump_rad_per_s", json!(0.0))
        => "`detector.staleness.r_jump_rad_per_s`";
    angle_limit: |d| set(d, "/detector/actuator/angle_limit_rad", json!(0.5))
        => "`detector.actuator.angle_limit_rad`";
    height: |d| set(d, "/detector/model/vehicle/centre_of_gravity_height_m", json!(0.0))
        => "`detector.model.vehicle`";
    specified_alarm_hold: |d| set(d, "/spec/evaluation/alarm_hold_s", json!(0.0))
        => "`detector.evaluation.alarm_hold_s`";
    specified_friction: |d| set(d, "/spec/uncertainty/friction", json!([0.5, 1.0]))
        => "`detector.deviations.uncertainty.friction`";
    specified_load_transfer: |d| set(d, "/spec/uncertainty/load_transfer_percent", json!(20.0))
        => "`detector.deviations.uncertainty.load_transfer`";
    specified_steering_ratio: |d| set(d, "/spec/uncertainty/steering_ratio_percent", json!([0.0, 5.0]))
        => "`detector.deviations.uncertainty.steering_ratio`";
    specified_uncertainty_of_the_steering_offset: |d| set(d, "/spec/uncertainty/steering_offset_deg", json!(0.1))
        => "`detector.deviations.uncertainty.steering_offset_rad`";
    specified_uncertainty_of_the_yaw_rate_bias: |d| set(d, "/spec/uncertainty/yaw_rate_bias_deg_per_s", json!(0.1))
        => "`detector.deviations.uncertainty.yaw_rate_bias_rad_per_s`";
    specified_v_x_scale: |d| set(d, "/spec/uncertainty/v_x_scale_percent", json!(1.0))
        => "`detector.deviations.uncertainty.v_x_scale`";
    specified_steering_offset: |d| set(d, "/spec/sensors/steering_offset_deg", json!(0.1))
        => "`detector.zero.steering_offset_rad`";
    specified_yaw_rate_bias: |d| set(d, "/spec/sensors/yaw_rate_bias_deg_per_s", json!(0.1))
        => "`detector.zero.yaw_rate_bias_rad_per_s`";
    specified_angle_limit: |d| set(d, "/spec/actuator/angle_limit_deg", json!(35.0))
        => "`detector.actuator.angle_limit_rad`";
    specified_height: |d| set(d, "/spec/vehicle/centre_of_gravity_height_m", json!(0.0))
        => "`detector.model.vehicle`";
    specified_window: |d| d["spec"]["evaluation"]["window_s"] = json!(0.5)
        => "`detector.evaluation.window`";
    specified_window_in_samples: |d| d["spec"]["evaluation"]["window_samples"] = json!(41)
        => "`detector.evaluation.window`";
    actuator: |d| change(d, "/detector/actuator/lag_s", |_| 0.05)
        => "`detector.actuator.lag_s`";
    gains_of_a_rule: |d| change(d, "/detector/gains/n/2/1/1", |x| x + 1e-7)
        => "`detector.gains.n[2]`";
    calibrated_level: |d| change(d, "/threshold/calibration/level", |x| 2.0 * x)
        => "`detector.evaluation.threshold`";
    uncertified_with_figures: |d| set(d, "/synthesis/status", json!("uncertified"))
        => "`performance.certified`";
    certified_without_figures: |d| set(d, "/performance/certified", Value::Null)
        => "`performance.certified`";
}

#[test]
fn campaign_verifies_first() {
    let folder = edited(|design| each_of_e(design, |_| 0.0));
    refused(&COMMANDS[2..], folder.path(), 1, "M - (I + E C)");
}

#[test]
fn designs_of_another_age_or_none_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let oldest = DESIGN.replacen("steerguard-design/4", "steerguard-design/1", 1);
    let older = DESIGN.replacen("steerguard-design/4", "steerguard-design/3", 1);
    for (text, part) in [
        (&*oldest, "a design of format \"steerguard-design/1\""),
        (&*older, "a design of format \"steerguard-design/3\""),
        ("", "an empty file is no design"),
        (" \n", "an empty file is no design"),
        (&DESIGN[..DESIGN.len() / 2], "cut short"),
        ("{}", "`format` is missing"),
        ("mass_kg = 1476\n", "not a design file"),
    ] {
        fs::write(folder.path().join("design.json"), text).unwrap();
        refused(&COMMANDS, folder.path(), 2, part);
    }
    // What to do with an old one.
    fs::write(folder.path().join("design.json"), older).unwrap();
    failure(
        folder.path(),
        &["package", "design.json"],
        2,
        &["`steerguard design design.json -o NEW.json`"],
    );
}

#[test]
fn a_design_is_made_anew_from_the_specification_inside_an_old_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let mut old: Value =
        serde_json::from_str(&DESIGN.replacen("steerguard-design/2", "steerguard-design/1", 1))
            .unwrap();
    let few = json!({
        "speeds": 1, "manoeuvres": ["straight"], "lateral_acceleration_m_per_s2": [1.0],
        "disturbance_frequencies": 1, "disturbance_phases": 1, "initial_v_y_m_per_s": [0.0],
        "duration_s": 2.0, "steering_rate_rad_per_s": 0.3, "search_drives": 0,
    });
    set(&mut old, "/spec/evaluation/calibration", few.clone());
    set(&mut old, "/spec/design/method", json!("paper"));
    // Half a degree drowns in what the paper's gains make of noise, and few drives ask for a margin.
    set(&mut old, "/spec/evaluation/margin", json!(2.0));
    set(&mut old, "/spec/fault/0/smallest_deg", json!(5.0));
    old.as_object_mut().unwrap().remove("detector");
    fs::write(path.join("old.json"), old.to_string()).unwrap();
    success(path, &["design", "old.json", "-o", "new.json"]);
    success(path, &["verify", "new.json"]);
    let new: Value =
        serde_json::from_str(&fs::read_to_string(path.join("new.json")).unwrap()).unwrap();
    assert_eq!(new["format"], "steerguard-design/4");
    assert_eq!(new["spec"]["evaluation"]["calibration"], few);

    // Nothing is written over what is read, under whatever name.
    let before = fs::read(path.join("old.json")).unwrap();
    for output in ["old.json", "./old.json"] {
        failure(
            path,
            &["design", "old.json", "-o", output],
            2,
            &["written over itself", "-o FILE"],
        );
    }
    failure(path, &["package", "new.json", "-o", "new.json"], 2, &["written over itself"]);
    assert_eq!(fs::read(path.join("old.json")).unwrap(), before);

    // An empty specification is legal, an empty design is not.
    fs::write(path.join("empty.json"), "").unwrap();
    failure(path, &["design", "empty.json"], 2, &["empty", "empty.json", "help: "]);
    fs::write(path.join("other.json"), "{\"format\": \"another/3\"}").unwrap();
    failure(path, &["design", "other.json"], 2, &["another/3"]);
}

/// A design without a proof is used where that is asked for, and what is made of it says so.
#[test]
fn uncertified_designs_are_used_only_where_allowed() {
    let folder = edited(|design| {
        set(design, "/synthesis/status", json!("uncertified"));
        set(design, "/synthesis/unproven", json!("no gain was found"));
        set(design, "/performance/certified", Value::Null);
        set(design, "/certificate/a_posteriori", Value::Null);
    });
    let path = folder.path();
    failure(path, &["package", "design.json"], 1, &["not certified", "--allow uncertified"]);
    let campaign =
        ["campaign", "design.json", "--drives", "1", "--duration", "5", "-o", "campaign"];
    failure(path, &campaign, 1, &["not certified", "--allow uncertified"]);
    assert_eq!(fs::read_dir(path).unwrap().count(), 1, "nothing is left behind");

    let text = success(path, &["package", "design.json", "--allow", "uncertified"]);
    assert!(text.contains("The design is not certified."), "{text}");
    let json = success(path, &["package", "design.json", "--allow=uncertified", "--json"]);
    let value: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(value["status"], "uncertified");
    let text = success(path, &[&campaign[..], &["--allow", "uncertified"]].concat());
    assert!(text.contains("The design is not certified."), "{text}");

    let fmu = fs::read(path.join("SteeringFaultDetector.fmu")).unwrap();
    let mut archive = zip::ZipArchive::new(std::io::Cursor::new(fmu)).unwrap();
    let mut page = String::new();
    let mut entry = archive.by_name("documentation/index.html").unwrap();
    std::io::Read::read_to_string(&mut entry, &mut page).unwrap();
    assert!(page.contains("NOT CERTIFIED"), "{page}");
    let other = ["package", "design.json", "--allow", "blind"];
    failure(path, &other, 1, &["not certified", "--allow uncertified"]);
    failure(path, &["package", "design.json", "--allow", "deaf"], 2, &["uncertified", "blind"]);
}
