//! Recorded drives through the packaged detector, as users run them. The drives are made by the one world.

#![allow(clippy::unwrap_used)]

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

#[path = "common/command.rs"]
mod command;

use command::{failure, made_by_command, steerguard, success};

/// A stored design: the default specification with the second test.
fn design() -> String {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../designer/verify/tests/fixtures");
    format!("{folder}/gap.json")
}

/// A folder with `weave.csv`, a fault-free minute of the reference vehicle as a campaign prints it, and
/// `weave.parquet`, the same.
fn recordings() -> PathBuf {
    made_by_command("recordings for replay", |folder| {
        let design = design();
        let common = ["campaign", &design, "--drives", "2", "--faults", "none", "--seed", "1"];
        let drive = success(folder, &[&common[..], &["--drive", "1"]].concat());
        fs::write(folder.join("weave.csv"), drive).unwrap();
        let one = ["campaign", &design, "--drives", "1", "--faults", "none", "--signals"];
        success(folder, &[&one[..], &["first.parquet"]].concat());
    })
}

/// The samples of `weave.csv`: `[time, v_x, r, u.T_eng, u.delta]`.
fn samples() -> Vec<[f64; 5]> {
    let text = fs::read_to_string(recordings().join("weave.csv")).unwrap();
    let rows = text.lines().skip(1).map(|line| {
        let mut cells = line.split(',').map(|cell| cell.parse::<f64>().unwrap());
        std::array::from_fn(|_| cells.next().unwrap())
    });
    rows.collect()
}

/// Writes `name` with a header and what `row` makes of the samples.
fn write(folder: &Path, name: &str, header: &str, row: impl Fn([f64; 5]) -> Option<String>) {
    let rows = samples().into_iter().filter_map(row).collect::<Vec<_>>().join("\n");
    fs::write(folder.join(name), format!("{header}\n{rows}\n")).unwrap();
}

/// The usual header, and a row under it.
const HEADER: &str = "t [s],v [m/s],r [rad/s],hw [rad],torque [N m]";
fn usual([t, v_x, r, torque, delta]: [f64; 5]) -> Option<String> {
    Some(format!("{t},{v_x},{r},{delta},{torque}"))
}

/// Runs `replay` on `drive` and returns exit code and summary.
fn replayed(folder: &Path, drive: &str, further: &[&str]) -> (Option<i32>, Value) {
    let design = design();
    let arguments = [&["replay", &design, drive, "--json", "-o", "out"], further].concat();
    let output = steerguard(folder, &arguments);
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(error, "", "{arguments:?}");
    let summary = fs::read_to_string(folder.join("out/summary.json")).unwrap();
    assert_eq!(summary, String::from_utf8(output.stdout).unwrap());
    (output.status.code(), serde_json::from_str(&summary).unwrap())
}

/// The column of a CSV file.
fn column(path: &Path, name: &str) -> Vec<String> {
    let text = fs::read_to_string(path).unwrap();
    let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let place = lines.next().unwrap().iter().position(|cell| *cell == name).unwrap();
    lines.map(|cells| cells[place].to_owned()).collect()
}

#[test]
fn a_recording_of_the_simulated_world_gives_the_same_to_the_last_bit() {
    let folder = tempfile::tempdir().unwrap();
    let drive = recordings().join("weave.csv");
    let (code, summary) = replayed(folder.path(), drive.to_str().unwrap(), &["--fault-free"]);
    assert_eq!(code, Some(0));
    let trace = folder.path().join("out/weave.trace.csv");
    for name in ["v_x", "r", "u.delta", "residual.r", "J_rms", "J_th", "state", "second_ratio"] {
        assert_eq!(column(&trace, name), column(&drive, name), "{name}");
    }
    assert_eq!(summary["total"]["alarms"], 0);
    assert_eq!(summary["total"]["alarms_per_hour"]["lower"], 0.0);
    assert!(summary["total"]["monitored_share"].as_f64().unwrap() > 0.95);
    assert!(fs::read_to_string(folder.path().join("out/weave.svg")).unwrap().contains("J_rms"));
}

#[test]
fn parquet_is_a_drive_too() {
    let folder = tempfile::tempdir().unwrap();
    let drive = recordings().join("first.parquet");
    let (code, summary) = replayed(folder.path(), drive.to_str().unwrap(), &["--fault-free"]);
    assert_eq!((code, &summary["drives"][0]["reading"]), (Some(0), &"Parquet".into()));
    assert_eq!(summary["drives"][0]["rows"], 6000);
}

#[test]
fn an_injected_degree_is_seen_to_either_side() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "drive.csv", HEADER, usual);
    let faults = ["--fault", "bias=1@30s", "--fault", "drift=1,rise_s=2@20", "--fault-free"];
    let (code, summary) = replayed(folder.path(), "drive.csv", &faults);
    assert_eq!(code, Some(0));
    let injected = summary["drives"][0]["injected"].as_array().unwrap();
    let angles: Vec<_> = injected.iter().map(|run| run["angle_deg"].as_f64().unwrap()).collect();
    assert_eq!(angles, [1.0, -1.0, 1.0, -1.0]);
    for run in injected {
        assert_eq!(run["verdict"], "detected", "{run}");
    }
    for (run, angle_deg) in injected.iter().zip([1.0, -1.0]) {
        assert!(run["delay_s"].as_f64().unwrap() < 0.3, "{run}");
        // Actual less commanded, left positive, as the second test estimates it.
        let error = run["estimate_deg"].as_f64().unwrap() - angle_deg;
        assert!(error.abs() < 0.5, "{run}");
    }
    // The detector is told the command: recorded less the fault.
    let delta = |file: &str| -> f64 {
        column(&folder.path().join("out").join(file), "u.delta")[4000].parse().unwrap()
    };
    let less = delta("drive.trace.csv") - delta("drive.bias+1deg-from30s.trace.csv");
    assert!((less.to_degrees() - 1.0).abs() < 1e-9, "{less}");
    assert_eq!(summary["total"]["smallest_seen_deg"].as_f64().unwrap().abs(), 1.0);
}

#[test]
fn without_a_torque_that_of_the_speeds_course_is_taken() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "drive.csv", "t,v [km/h],yaw_rate_deg_s,steering_deg", |row| {
        let [t, v_x, r, _, delta] = row;
        let [r, delta] = [r, delta].map(f64::to_degrees);
        Some(format!("{t},{},{r},{delta}", 3.6 * v_x))
    });
    let (code, summary) = replayed(folder.path(), "drive.csv", &["--fault-free"]);
    assert_eq!(code, Some(0), "{summary}");
    let columns = summary["drives"][0]["columns"].to_string();
    assert!(columns.contains("no column; that of the speed's course is taken"), "{columns}");
}

#[test]
fn a_hand_wheel_with_a_varying_ratio_is_read_by_its_table() {
    let folder = tempfile::tempdir().unwrap();
    // 20 : 1 up to 0.5 deg of the road wheel, then 10 : 1.
    let hand_wheel = |road: f64| {
        let bend = 0.5_f64.to_radians();
        let size = 20.0 * road.abs().min(bend) + 10.0 * (road.abs() - bend).max(0.0);
        size.copysign(road)
    };
    write(folder.path(), "drive.csv", HEADER, |[t, v_x, r, torque, delta]| {
        usual([t, v_x, r, torque, hand_wheel(delta)])
    });
    let columns = "[steering]\nroad_wheel_deg = [[0, 0], [10, 0.5], [50, 4.5]]\n";
    fs::write(folder.path().join("columns.toml"), columns).unwrap();
    let told = ["--columns", "columns.toml", "--fault-free"];
    let (code, summary) = replayed(folder.path(), "drive.csv", &told);
    assert_eq!(code, Some(0), "{summary}");
    let columns = summary["drives"][0]["columns"].to_string();
    assert!(columns.contains("to the road wheel by 5 points"), "{columns}");
    let angles = column(&folder.path().join("out/drive.trace.csv"), "u.delta");
    let largest = samples().iter().map(|sample| sample[4].abs()).fold(0.0, f64::max);
    assert!(largest.to_degrees() > 0.8, "the bend is in the drive: {largest}");
    for (angle, sample) in angles.iter().zip(samples()) {
        assert!((angle.parse::<f64>().unwrap() - sample[4]).abs() < 1e-12, "{angle}, {sample:?}");
    }
}

#[test]
fn a_gap_restarts_the_detector() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "drive.csv", HEADER, |row| {
        usual(row).filter(|_| !(20.0..23.5).contains(&row[0]))
    });
    let (code, summary) = replayed(folder.path(), "drive.csv", &["--fault-free"]);
    assert_eq!(code, Some(0), "{summary}");
    let drive = &summary["drives"][0];
    assert_eq!((&drive["pieces"], &drive["rows"]), (&2.into(), &5650.into()));
    assert_eq!(drive["driven_s"], 56.5);
    let trace = folder.path().join("out/drive.trace.csv");
    let (times, pieces) = (column(&trace, "time"), column(&trace, "piece"));
    let first = pieces.iter().position(|piece| piece == "1").unwrap();
    assert_eq!((first, times[first].parse::<f64>().unwrap()), (2000, 23.5));
    // The threshold of a start stands there again.
    let j_th: Vec<f64> = column(&trace, "J_th").iter().map(|cell| cell.parse().unwrap()).collect();
    assert!(j_th[first] > 1.2 * j_th[first - 1], "{} {}", j_th[first], j_th[first - 1]);
}

#[test]
fn jitter_losses_and_messages_of_their_own_raise_no_alarm() {
    let folder = tempfile::tempdir().unwrap();
    // A row a message: speed each 20 ms, the rest each 10 ms a little later, every 20th lost.
    let mut text = String::from("time_ms;v [m/s];r [rad/s];hw [rad]\n");
    for (k, [t, v_x, r, _, delta]) in samples().into_iter().enumerate() {
        let t = 1e3 * t;
        if k % 2 == 0 {
            writeln!(text, "{t:.1};{v_x:.3};;").unwrap();
        }
        if k % 20 != 7 {
            writeln!(text, "{:.1};;{r:.5};{delta:.6}", t + 0.1 * (k % 5) as f64).unwrap();
        }
    }
    fs::write(folder.path().join("bus.csv"), text.replace('.', ",")).unwrap();
    let (code, summary) = replayed(folder.path(), "bus.csv", &["--fault-free"]);
    assert_eq!(code, Some(0), "{summary}");
    assert_eq!(summary["drives"][0]["pieces"], 1);
}

#[test]
fn a_wrong_preparation_is_named() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "drive.csv", HEADER, usual);
    write(folder.path(), "degrees.csv", HEADER, |[t, v_x, r, torque, delta]| {
        usual([t, v_x, r, torque, delta.to_degrees()])
    });
    write(folder.path(), "km_per_h.csv", HEADER, |[t, v_x, r, torque, delta]| {
        usual([t, 3.6 * v_x, r, torque, delta])
    });
    for (drive, flags, remark) in [
        ("drive.csv", &["--yaw", "r:-rad/s"][..], "an axis is turned"),
        ("drive.csv", &["--steering", "hw:-rad"], "an axis is turned"),
        ("drive.csv", &["--steering", "hw:deg"], "steering in rad is read as deg"),
        ("degrees.csv", &[], "steering in deg is read as rad"),
        ("km_per_h.csv", &[], "--speed NAME:km/h"),
    ] {
        let (code, summary) = replayed(folder.path(), drive, &[&["--fault-free"], flags].concat());
        let remarks = summary["drives"][0]["remarks"].to_string();
        assert!(remarks.contains(remark), "{drive} {flags:?}: {remarks}");
        let alarms = summary["total"]["alarms"].as_u64().unwrap();
        assert_eq!(code, Some(i32::from(alarms > 0)), "{drive} {flags:?}");
    }
    // Late by 0.3 s, and off by 0.8 degrees, is more than this design forgives.
    let (code, summary) =
        replayed(folder.path(), "drive.csv", &["--fault-free", "--delay", "steering=-0.3"]);
    let remarks = summary["drives"][0]["remarks"].to_string();
    assert!(code == Some(1) && remarks.contains("ms later than the yaw rate"), "{remarks}");
    write(folder.path(), "offset.csv", HEADER, |[t, v_x, r, torque, delta]| {
        usual([t, v_x, r, torque, delta + 0.8_f64.to_radians()])
    });
    let (code, summary) = replayed(folder.path(), "offset.csv", &["--fault-free"]);
    let remarks = summary["drives"][0]["remarks"].to_string();
    assert!(code == Some(1) && remarks.contains("the car goes straight at +0.8"), "{remarks}");
    write(folder.path(), "ratio.csv", HEADER, |[t, v_x, r, torque, delta]| {
        usual([t, v_x, r, torque, 1.5 * delta])
    });
    let (code, summary) = replayed(folder.path(), "ratio.csv", &["--fault-free"]);
    let remarks = summary["drives"][0]["remarks"].to_string();
    assert!(
        code == Some(1) && remarks.contains("sensors.steering_ratio of 1.5 would"),
        "{remarks}"
    );
    // Without --fault-free it may be a fault.
    let (code, summary) = replayed(folder.path(), "offset.csv", &[]);
    assert_eq!((code, &summary["drives"][0]["remarks"]), (Some(0), &serde_json::json!([])));
}

#[test]
fn drives_that_cannot_be_read_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write(path, "drive.csv", HEADER, usual);
    write(path, "yaw_deg.csv", HEADER, |[t, v_x, r, torque, delta]| {
        usual([t, v_x, r.to_degrees(), torque, delta])
    });
    write(path, "milliseconds.csv", "t,v_mps,r_rad_s,hw_rad", |[t, v_x, r, _, delta]| {
        Some(format!("{},{v_x},{r},{delta}", 1e3 * t))
    });
    write(path, "no_unit.csv", "t,speed,r_rad_s,hw_rad", |[t, v_x, r, _, delta]| {
        Some(format!("{t},{v_x},{r},{delta}"))
    });
    let text = fs::read_to_string(path.join("drive.csv")).unwrap();
    fs::write(path.join("back.csv"), format!("{text}{}", text.lines().nth(1).unwrap())).unwrap();
    fs::write(path.join("empty.csv"), "").unwrap();
    fs::write(path.join("columns.toml"), "[speed]\ncolum = 'v'\n").unwrap();
    let design = design();
    for (arguments, parts) in [
        (&["yaw_deg.csv"][..], &["yaw_deg.csv:", "deg/s read as rad/s"][..]),
        (&["milliseconds.csv"], &["milliseconds.csv:2", "looks like ms", "--time NAME:ms"]),
        (&["no_unit.csv"], &["nothing says the unit of column `speed`", "--speed 'speed:UNIT'"]),
        (&["back.csv"], &["back.csv:6002", "time runs back"]),
        (&["empty.csv"], &["empty.csv", "is empty"]),
        (&["missing.csv"], &["missing.csv", "cannot be read"]),
        (&["drive.csv", "--columns", "columns.toml"], &["columns.toml", "unknown field `colum`"]),
        (&["drive.csv", "--speed", "u:m/s"], &["there is no column `u`"]),
        (&["drive.csv", "--speed", "v:rad"], &["`rad` is no unit of it", "m/s, km/h"]),
        (&["drive.csv", "--fault", "stuck=1@3"], &["what can are bias, drift"]),
        (&["drive.csv", "drive.csv", "--gap", "0"], &["from 0.001 to 60"]),
        (
            &["drive.csv", "--fault", "bias=1@3", "--fault", "bias=1.0@3s"],
            &["two results would be"],
        ),
    ] {
        failure(path, &[&["replay", &design], arguments].concat(), 2, parts);
    }
    // Nothing is left of drives that ended early, and nothing is written over.
    let left = fs::read_dir(path.join("steerguard-replay")).unwrap().count();
    assert_eq!(left, 0);
    fs::create_dir(path.join("in")).unwrap();
    fs::copy(path.join("drive.csv"), path.join("in/drive")).unwrap();
    fs::rename(path.join("in/drive"), path.join("in/drive.svg")).unwrap();
    failure(
        path,
        &["replay", &design, "in/drive.svg", "-o", "in"],
        2,
        &["`in/drive.svg` would be written over itself", "another folder"],
    );
}

/// `cargo test --release -p steerguard --test replay -- --ignored --nocapture` on an idle core: an hour of
/// 100 Hz is to take no longer than a five-hundredth, in less than 200 MB.
#[test]
#[ignore = "measures, and states no limit: depends on the machine"]
fn an_hour_of_100_hz() {
    let folder = tempfile::tempdir().unwrap();
    let rows = samples();
    let mut text = format!("{HEADER}\n");
    for k in 0..360_000 {
        let [_, v_x, r, torque, delta] = rows[k % rows.len()];
        let t = k as f64 * 0.01;
        writeln!(text, "{t:.2},{v_x:.4},{r:.6},{delta:.6},{torque:.2}").unwrap();
    }
    fs::write(folder.path().join("hour.csv"), text).unwrap();
    let begin = std::time::Instant::now();
    success(folder.path(), &["replay", &design(), "hour.csv", "-o", "out"]);
    let wall_s = begin.elapsed().as_secs_f64();
    println!("one hour in {wall_s:.2} s: {:.0} times real time", 3600.0 / wall_s);
}
