//! What the command says of mistaken files, as a terminal of 80 columns shows it.
//!
//! The messages are kept in `diagnostics/`: `INSTA_UPDATE=always` writes them anew.

#![allow(clippy::unwrap_used)]

use std::fs;
use std::process::Command;

/// What `steerguard ARGUMENTS file` says of a file with `bytes`.
fn said(arguments: &[&str], file: &str, bytes: &[u8]) -> String {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join(file), bytes).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_steerguard"));
    let output = command.current_dir(folder.path()).args(arguments).arg(file).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(output.stdout, b"");
    let text = String::from_utf8(output.stderr).unwrap();
    for line in text.lines() {
        assert!(line.chars().count() <= 80, "{line}");
    }
    text
}

macro_rules! assert_said {
    ($name:literal, $arguments:expr, $bytes:expr) => {
        let mut settings = insta::Settings::clone_current();
        settings.set_snapshot_path("diagnostics");
        settings.set_prepend_module_to_snapshot(false);
        settings.set_omit_expression(true);
        let file = concat!($name, ".toml");
        settings.bind(|| insta::assert_snapshot!($name, said($arguments, file, $bytes.as_ref())));
    };
}

#[test]
fn all_mistakes_of_a_specification_are_shown() {
    let text = r#"# A delivery van.
[vehicle]
mass_g = 1450                          # unknown key
yaw_inertia_kg_m2 = "about 2500"       # wrong type

[operating_range]
v_x_m_per_s = [5.0, 40.0]

[actuator]
lag_s = -0.1                           # out of range

[[disturbance]]                        # no name
kind = "side_wind"
bound_m_per_s2 = 0.2

[evaluation]
threshold = "calibrated"
constant = 0.002                       # contradicts the line above
"#;
    assert_said!("specification", &["design"], text);
}

#[test]
fn all_that_is_no_toml_is_shown() {
    let text =
        "[vehicle]\nmass_kg = 14 50\nyaw_inertia_kg_m2 = 2500\n\n[sampling\nperiod_s = 0.01\n";
    assert_said!("malformed", &["design"], text);
}

#[test]
fn speeds_at_which_some_vehicle_is_unstable_are_shown() {
    let text = r#"[vehicle]                              # rear heavy, on narrow rear tyres
front_axle_distance_m = 1.4
rear_axle_distance_m = 1.2
rear_cornering_stiffness_n_per_rad = 55000

[operating_range]
v_x_m_per_s = [5.0, 40.0]
"#;
    assert_said!("critical_speed", &["design"], text);
}

#[test]
fn values_of_several_tables_that_contradict_each_other_are_shown_together() {
    let text = r#"[sampling]
period_s = 0.02

[operating_range]
v_x_m_per_s = [3.0, 30.0]
v_y_m_per_s = [-0.8, 0.8]

[noise.v_x]
white_std_m_per_s = 0.05

[evaluation]
threshold = "guaranteed"
"#;
    assert_said!("contradictions", &["design"], text);
}

#[test]
fn long_and_hostile_texts_are_cut_and_harmless() {
    let long = "x".repeat(100_000);
    let text = format!("vehicle.mass_kg = '{long}'\n\"key \\u001b[2J\" = 1\n");
    assert_said!("hostile", &["design"], text);
}

#[test]
fn other_encodings_are_named() {
    assert_said!("latin1", &["design"], b"# fine\n# f\xfcr das Auto\n");
    let utf16: Vec<u8> = "\u{feff}[vehicle]".encode_utf16().flat_map(u16::to_le_bytes).collect();
    assert_said!("utf16", &["design"], utf16);
}

#[test]
fn all_mistakes_of_a_scenario_are_shown() {
    let text = r#"duration = 20.0
initial_speeds_m_per_s = [15.0, -3.0]

[steering_angle_rad]
offset = nan

[actuator]
delay_s = 0.8

[sensor_noise]
seed = 1.5
"#;
    assert_said!("scenario", &["simulate", "--scenario"], text);
}

#[test]
fn manoeuvres_and_faults_of_a_scenario_that_contradict_the_rest_are_shown() {
    let text = r#"[steering_angle_rad]
amplitude = 0.01

[manoeuvre]
kind = "stop and go"
lowest_speed_m_per_s = 7.0
radius_m = 20.0                        # of a roundabout

[fault]
kind = "drifd"                         # unknown
size_deg = 1.0                         # unknown

[steering_fault_deg]
offset = 0.5
"#;
    assert_said!("scenario_kinds", &["simulate", "--scenario"], text);
}
