//! Recorded drives that a threshold counts, as users name them. The drives are made by the one world.

#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;
use steerguard_designer::Design;
use steerguard_verify::verify;

#[path = "common/command.rs"]
mod command;

use command::{failure, made_by_command, steerguard, success};

/// A specification whose design takes seconds.
const SPECIFICATION: &str = "[design]
method = \"paper\"
[evaluation.calibration]
speeds = 2
disturbance_phases = 1
search_drives = 0
";

/// The fault in `faulty.csv`, rad, and when it begins, s.
const FAULT: (f64, f64) = (0.035, 30.0);

/// A folder with `sound.csv`, a fault-free minute of the reference vehicle, `faulty.csv`, the same with a fault
/// from the middle on, and the designs `none.json`, `sound.json` and `both.json`, whose thresholds count
/// none, the first and both of them.
fn designs() -> PathBuf {
    made_by_command("designs that count recorded drives", |folder| {
        let of_fixtures =
            concat!(env!("CARGO_MANIFEST_DIR"), "/../designer/verify/tests/fixtures/gap.json");
        let drive = success(
            folder,
            &[
                "campaign",
                of_fixtures,
                "--drives",
                "2",
                "--faults",
                "none",
                "--seed",
                "1",
                "--drive",
                "1",
            ],
        );
        let with_fault = drive.lines().enumerate().map(|(line, text)| {
            let mut cells: Vec<String> = text.split(',').map(str::to_owned).collect();
            if line > 0 && cells[0].parse::<f64>().unwrap() > FAULT.1 {
                cells[4] = (cells[4].parse::<f64>().unwrap() - FAULT.0).to_string();
            }
            cells.join(",")
        });
        let with_fault = with_fault.collect::<Vec<_>>().join("\n");
        fs::write(folder.join("faulty.csv"), with_fault).unwrap();
        fs::write(folder.join("sound.csv"), drive).unwrap();
        for (name, drives) in
            [("none", ""), ("sound", "\"sound.csv\""), ("both", "\"sound.csv\", \"faulty.csv\"")]
        {
            let text = format!("{SPECIFICATION}drives = [{drives}]\n");
            fs::write(folder.join(format!("{name}.toml")), text).unwrap();
            // Blind, and not only by what is recorded: the paper's method is.
            let specification = format!("{name}.toml");
            let output = format!("{name}.json");
            let told = steerguard(folder, &["design", &specification, "-o", &output]);
            fs::write(folder.join(format!("{name}.txt")), &told.stdout).unwrap();
            fs::write(folder.join(format!("{name}.notes.txt")), &told.stderr).unwrap();
        }
    })
}

fn json(path: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}

#[test]
fn a_drive_within_what_is_stated_leaves_the_threshold_as_it_is() {
    let [none, sound] = ["none.json", "sound.json"].map(|name| json(&designs().join(name)));
    assert_eq!(none["detector"], sound["detector"]);
    assert_eq!(none["threshold"].get("recorded"), None);
    let recorded = &sound["threshold"]["recorded"][0];
    assert_eq!((&recorded["file"], &recorded["samples"]), (&"sound.csv".into(), &6000.into()));
    let ratio = recorded["level"].as_f64().unwrap();
    assert!(ratio < sound["threshold"]["uncertain"]["level"].as_f64().unwrap());
    verify(&fs::read_to_string(designs().join("sound.json")).unwrap()).unwrap();
}

#[test]
fn a_drive_beyond_it_raises_the_threshold_above_itself() {
    let folder = designs();
    let [none, both] = ["none.json", "both.json"].map(|name| json(&folder.join(name)));
    let share =
        |design: &Value| design["detector"]["evaluation"]["uncertainty_share"].as_f64().unwrap();
    let faulty = &both["threshold"]["recorded"][1];
    let level = faulty["level"].as_f64().unwrap();
    let margin = both["threshold"]["margin"].as_f64().unwrap();
    assert_eq!(share(&both), margin * level);
    assert!(share(&both) > 2.0 * share(&none));
    verify(&fs::read_to_string(folder.join("both.json")).unwrap()).unwrap();
    let told = fs::read_to_string(folder.join("both.txt")).unwrap();
    assert!(told.contains("of 2 recorded fault-free drives (faulty.csv)"), "{told}");
    assert!(told.contains("what [uncertainty] states does not explain that drive"), "{told}");
    let notes = fs::read_to_string(folder.join("both.notes.txt")).unwrap();
    assert!(notes.contains("steering: column \"u.delta\", rad -> rad (guessed)"), "{notes}");

    // The packaged detector agrees: the one design says what is wrong with the drive, the other was told
    // that nothing is.
    let replayed = |design: &str| {
        let out = tempfile::tempdir().unwrap();
        let arguments =
            ["replay", design, "faulty.csv", "--fault-free", "--json", "--allow", "blind", "-o"];
        let arguments = [&arguments[..], &[out.path().to_str().unwrap()]].concat();
        let output = steerguard(&folder, &arguments);
        let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
        (output.status.code(), summary["drives"][0]["largest_ratio"].as_f64().unwrap())
    };
    assert_eq!(replayed("none.json").0, Some(1));
    let (code, ratio) = replayed("both.json");
    assert_eq!(code, Some(0));
    // The start-up term, which the level leaves out, is gone by then.
    assert!((ratio - level / share(&both)).abs() < 1e-6, "{ratio}, {level}");
}

#[test]
fn a_level_that_is_not_the_thresholds_is_refuted() {
    let text = fs::read_to_string(designs().join("both.json")).unwrap();
    let mut design = Design::from_json(&text).unwrap();
    design.threshold.recorded[1].level *= 0.9;
    design.hash = design.computed_hash().unwrap();
    let refusal = verify(&design.to_json().unwrap()).unwrap_err().to_string();
    assert!(refusal.contains("detector.evaluation.threshold"), "{refusal}");
    design.threshold.recorded.pop();
    design.hash = design.computed_hash().unwrap();
    let refusal = verify(&design.to_json().unwrap()).unwrap_err().to_string();
    assert!(refusal.contains("threshold.recorded"), "{refusal}");
}

#[test]
fn what_cannot_count_is_said_with_its_key() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |further: &str, top: &str, code: i32, parts: &[&str]| {
        let text = format!("{top}{SPECIFICATION}{further}\n");
        fs::write(folder.path().join("car.toml"), text).unwrap();
        failure(folder.path(), &["design", "car.toml"], code, parts);
    };
    let absent = "drives = [\"no.csv\"]";
    refused(absent, "", 2, &["no.csv", "cannot be read"]);
    let kind = "evaluation.threshold = \"constant\"\nevaluation.constant = 0.01\n";
    let parts = ["evaluation.calibration.drives", "recorded drives count for"];
    refused(absent, kind, 2, &parts);
    let twice = "drives = [\"no.csv\", \"no.csv\"]";
    refused(twice, "", 2, &["evaluation.calibration.drives[1]", "each file once"]);
    refused("columns = \"columns.toml\"", "", 2, &["nothing without `drives`"]);
    let described = "drives = [\"no.csv\"]\ncolumns = \"columns.toml\"";
    refused(described, "", 2, &["columns.toml"]);

    // A drive at walking speed: the detector never monitors.
    let rows = (0..2000).map(|k| format!("{:.2},1.0,0.0,0.0\n", f64::from(k) * 0.01));
    let slow = String::from("t [s],v [m/s],r [rad/s],steering [rad]\n") + &rows.collect::<String>();
    fs::write(folder.path().join("slow.csv"), slow).unwrap();
    let drives = "drives = [\"slow.csv\"]";
    fs::write(folder.path().join("slow.toml"), format!("{SPECIFICATION}{drives}\n")).unwrap();
    let output = steerguard(folder.path(), &["design", "slow.toml"]);
    let error = String::from_utf8(output.stderr).unwrap();
    let error = error.split_whitespace().collect::<Vec<_>>().join(" ");
    assert_eq!(output.status.code(), Some(1));
    for part in ["monitored no sample", "`slow.csv`", "leave the drive"] {
        assert!(error.contains(part), "{error}");
    }
}
