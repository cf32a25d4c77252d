//! Blind designs: what is said of them, and where they are used.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::fs;
use std::io::Read as _;

use serde_json::Value;

#[path = "common/command.rs"]
mod command;

use command::{failure, steerguard as run, success};

/// The paper's design under fifty times its side wind, in little time.
const BLIND: &str = r#"
[[disturbance]]
kind = "side_wind"
name = "storm"
bound_m_per_s2 = 5.0
[noise.v_x]
white_std_m_per_s = 0.0
[noise.r]
white_std_rad_per_s = 0.0
[design]
method = "paper"
[evaluation]
threshold = "calibrated"
[evaluation.calibration]
speeds = 2
manoeuvres = ["straight"]
lateral_acceleration_m_per_s2 = [1.0]
disturbance_frequencies = 1
disturbance_phases = 1
initial_v_y_m_per_s = [0.0]
duration_s = 4.0
search_drives = 0
"#;

#[test]
fn blind_designs_are_written_and_used_only_where_allowed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    fs::write(path.join("storm.toml"), BLIND).unwrap();
    let designed = run(path, &["design", "storm.toml", "--json"]);
    assert_eq!(designed.status.code(), Some(1));
    let design: Value = serde_json::from_slice(&designed.stdout).unwrap();
    assert_eq!(design["design"]["status"], "blind");
    let hidden = &design["design"]["sight"]["blind"]["hidden_by"];
    assert_eq!(hidden["key"], "bound_m_per_s2 of disturbance \"storm\"");
    let seen_at = hidden["seen_at"][0].as_f64().unwrap();
    assert!(0.0 < seen_at && seen_at < 5.0, "{seen_at}");

    let verified = run(path, &["verify", "design.json"]);
    assert_eq!(verified.status.code(), Some(1));
    let text = String::from_utf8(verified.stdout).unwrap();
    for part in ["certified: ", "blind, as it says of itself", "`performance.sight`"] {
        assert!(text.contains(part), "{part} in {text}");
    }
    let verified = run(path, &["verify", "design.json", "--json"]);
    let verified: Value = serde_json::from_slice(&verified.stdout).unwrap();
    assert_eq!(verified["blind"], true);

    let campaign =
        ["campaign", "design.json", "--drives", "1", "--duration", "5", "-o", "campaign"];
    for arguments in [&["package", "design.json"][..], &campaign] {
        let parts = ["the design is blind", "0.5 deg", "\"storm\"", "--allow blind"];
        failure(path, arguments, 1, &parts);
        let other = [arguments, &["--allow", "uncertified"]].concat();
        failure(path, &other, 1, &["--allow blind"]);
    }
    let text = success(path, &["package", "design.json", "--allow", "blind"]);
    assert!(text.contains("The design is blind"), "{text}");
    let both = ["package", "design.json", "--allow", "uncertified,blind", "--json"];
    let json: Value = serde_json::from_str(&success(path, &both)).unwrap();
    assert_eq!(json["status"], "blind");
    let text = success(path, &[&campaign[..], &["--allow", "blind"]].concat());
    assert!(text.contains("The design is blind"), "{text}");

    let fmu = fs::read(path.join("SteeringFaultDetector.fmu")).unwrap();
    let mut archive = zip::ZipArchive::new(std::io::Cursor::new(fmu)).unwrap();
    let mut page = String::new();
    archive.by_name("documentation/index.html").unwrap().read_to_string(&mut page).unwrap();
    for part in ["BLIND: its drives miss", "the design is BLIND", "<td>missed", "seen from deg"] {
        assert!(page.contains(part), "{part} in {page}");
    }
}
