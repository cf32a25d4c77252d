//! Campaigns as users run them: the same bytes however they are run, and what they must find.

#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::RowAccessor;
use serde_json::Value;
use sha2::{Digest as _, Sha256};
use tempfile::TempDir;

#[path = "common/command.rs"]
mod command;

use command::{failure, made_by_command, success};

#[path = "../../designer/tests/common/designed.rs"]
mod designed;

use designed::designed;
use steerguard_designer::Spec;

/// Drives of the campaign that is run in several ways, and its blocks.
const DRIVES: u64 = 190;
const BLOCKS: usize = 12;

/// A folder with the default design and `whole/`, the results of one uninterrupted run.
fn reference() -> PathBuf {
    made_by_command("a campaign of the default design", |folder| {
        let design = designed(&Spec::default()).unwrap();
        fs::write(folder.join("design.json"), design.to_json().unwrap()).unwrap();
        success(folder, &campaign(&["--jobs", "1", "-o", "whole"]));
    })
}

/// The arguments of the campaign, and further ones.
fn campaign<'a>(further: &[&'a str]) -> Vec<&'a str> {
    let arguments = ["campaign", "design.json", "--drives", "190", "--duration", "30"];
    [&arguments, further].concat()
}

/// A folder of its own with a copy of the design.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::copy(reference().join("design.json"), folder.path().join("design.json")).unwrap();
    folder
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

/// The rows in the block files of a campaign's folder.
fn rows(folder: &Path) -> Vec<Value> {
    let mut rows = Vec::new();
    for path in blocks(folder) {
        rows.extend(json(&fs::read_to_string(path).unwrap())["rows"].as_array().unwrap().clone());
    }
    rows
}

fn blocks(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder.join("blocks")).into_iter().flatten();
    let mut paths: Vec<_> = entries
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "json"))
        .collect();
    paths.sort();
    paths
}

fn assert_results_are_the_references(folder: &Path) {
    for name in ["results.parquet", "report.json", "campaign.json"] {
        let expected = fs::read(reference().join("whole").join(name)).unwrap();
        assert!(fs::read(folder.join(name)).unwrap() == expected, "{name} differs");
    }
}

#[test]
fn results_do_not_depend_on_the_number_of_workers() {
    let folder = folder();
    success(folder.path(), &campaign(&["--jobs", "3", "-o", "c"]));
    assert_results_are_the_references(&folder.path().join("c"));
}

#[test]
fn a_killed_campaign_goes_on_and_gives_the_same_results() {
    let folder = folder();
    let path = folder.path().join("c");
    for _ in 0..3 {
        let done = blocks(&path).len();
        let mut running = Command::new(env!("CARGO_BIN_EXE_steerguard"))
            .current_dir(folder.path())
            .args(campaign(&["--jobs", "1", "-o", "c"]))
            .stdout(Stdio::null())
            .spawn()
            .unwrap();
        while blocks(&path).len() == done {
            assert_eq!(running.try_wait().unwrap(), None, "ended before it was killed");
            std::thread::sleep(Duration::from_millis(2));
        }
        running.kill().unwrap(); // SIGKILL
        running.wait().unwrap();
    }
    let done = blocks(&path).len();
    assert!((3..BLOCKS).contains(&done), "{done} blocks before the last run");
    assert!(!path.join("results.parquet").exists());

    let outcome = json(&success(folder.path(), &campaign(&["-o", "c", "--json"])));
    let driven = outcome["throughput"]["drives"].as_u64().unwrap();
    assert_eq!(driven, DRIVES - 16 * done as u64);
    assert_results_are_the_references(&path);

    let again = json(&success(folder.path(), &campaign(&["-o", "c", "--json"])));
    assert_eq!(again["throughput"], Value::Null);
    assert_results_are_the_references(&path);
}

#[test]
fn parts_merge_into_what_one_run_gives() {
    let folder = folder();
    let merged = folder.path().join("merged/blocks");
    fs::create_dir_all(&merged).unwrap();
    for part in ["1", "2", "3", "4"] {
        let shard = format!("{part}/4");
        let text = success(folder.path(), &campaign(&["--shard", &shard, "-o", part]));
        assert!(text.contains("missing"), "{text}");
        assert!(!folder.path().join(part).join("results.parquet").exists());
        for block in blocks(&folder.path().join(part)) {
            let to = merged.join(block.file_name().unwrap());
            assert!(!to.exists(), "{} is in two parts", to.display());
            fs::copy(block, to).unwrap();
        }
    }
    let outcome = json(&success(folder.path(), &campaign(&["-o", "merged", "--json"])));
    assert_eq!(outcome["throughput"], Value::Null);
    assert_results_are_the_references(&folder.path().join("merged"));
}

#[test]
fn one_drive_alone_is_its_row() {
    let folder = folder();
    let rows = rows(&reference().join("whole"));
    for index in [0, 17, 189] {
        let number = index.to_string();
        let row = json(&success(folder.path(), &campaign(&["--drive", &number, "--json"])));
        assert_eq!(row, rows[index]);

        let samples = success(folder.path(), &campaign(&["--drive", &number]));
        assert!(samples.starts_with("time,v_x,r,u.T_eng,u.delta,fault,"), "{samples:.80}");
        assert_eq!(samples.lines().count(), 1 + 3000);
    }
    assert!(!folder.path().join("steerguard-campaign").exists());
}

#[test]
fn a_prepared_folder_names_the_blocks_that_are_missing() {
    let folder = folder();
    let prepare = || json(&success(folder.path(), &campaign(&["-o", "c", "--prepare", "--json"])));
    let outcome = prepare();
    assert_eq!(outcome["blocks"], BLOCKS);
    assert_eq!(outcome["missing_blocks"], Value::from_iter(0..BLOCKS));
    assert_eq!(outcome["throughput"], Value::Null);

    success(folder.path(), &campaign(&["-o", "c", "--shard", "2/4"]));
    assert_eq!(prepare()["missing_blocks"], Value::from_iter((0..3).chain(6..BLOCKS)));
    success(folder.path(), &campaign(&["-o", "c"]));
    assert_eq!(prepare()["missing_blocks"], Value::Array(vec![]));
    assert_results_are_the_references(&folder.path().join("c"));
}

/// The signals of a part, drive by drive, are the samples that the drive alone gives.
#[test]
fn signals_are_the_samples_of_the_drives() {
    let folder = folder();
    success(folder.path(), &campaign(&["--signals", "part", "--shard", "2/3", "--jobs", "2"]));
    assert!(!folder.path().join("steerguard-campaign").exists());
    let file = fs::File::open(folder.path().join("part")).unwrap();
    let reader = SerializedFileReader::new(file).unwrap();
    let columns = reader.metadata().file_metadata().schema_descr().columns().to_vec();
    assert_eq!(reader.num_row_groups(), 64);
    for (group, index) in [(0, 64_i64), (63, 127)] {
        let number = index.to_string();
        let samples = success(folder.path(), &campaign(&["--drive", &number]));
        let mut samples = csv::Reader::from_reader(samples.as_bytes());
        let names = samples.headers().unwrap().clone();
        let mut samples = samples.records();
        for record in reader.get_row_group(group).unwrap().get_row_iter(None).unwrap() {
            let (record, sample) = (record.unwrap(), samples.next().unwrap().unwrap());
            assert_eq!(record.get_long(0).unwrap(), index);
            for (place, column) in columns.iter().enumerate().skip(1) {
                let expected = names.iter().position(|name| name == column.name()).unwrap();
                let expected: f64 = sample[expected].parse().unwrap();
                let value = record.get_double(place);
                let value = value.or_else(|_| record.get_long(place).map(|value| value as f64));
                assert_eq!(value.unwrap(), expected, "{}", column.name());
            }
        }
        assert!(samples.next().is_none());
    }
}

#[test]
fn the_table_holds_every_drive_once_and_in_order() {
    let whole = reference().join("whole");
    let file = fs::File::open(whole.join("results.parquet")).unwrap();
    let reader = SerializedFileReader::new(file).unwrap();
    let metadata = reader.metadata().file_metadata();
    let manifest = &metadata.key_value_metadata().unwrap()[0];
    assert_eq!(manifest.key, "steerguard-campaign");
    let expected = fs::read_to_string(whole.join("campaign.json")).unwrap();
    assert_eq!(manifest.value.as_deref(), Some(expected.as_str()));

    let rows = rows(&whole);
    let names: Vec<_> =
        metadata.schema_descr().columns().iter().map(|column| column.name().to_owned()).collect();
    assert_eq!(reader.get_row_iter(None).unwrap().count(), rows.len());
    for (k, (record, row)) in reader.get_row_iter(None).unwrap().zip(&rows).enumerate() {
        let record = record.unwrap();
        assert_eq!(record.get_long(0).unwrap(), k as i64);
        for (column, name) in names.iter().enumerate() {
            let expected = row["drive"].get(name).or(row["outcome"].get(name)).unwrap();
            match expected {
                Value::Null => assert!(record.get_double(column).is_err(), "{name}"),
                Value::String(text) => assert_eq!(record.get_string(column).unwrap(), text),
                Value::Number(number) if number.is_f64() => {
                    let cell = record.get_double(column).unwrap();
                    assert_eq!(Some(cell), number.as_f64(), "{name}");
                }
                number => assert_eq!(Some(record.get_long(column).unwrap()), number.as_i64()),
            }
        }
    }
}

/// What the adaptive threshold is for: vehicles, roads and winds that are not those of the design.
#[test]
fn an_uncertain_vehicle_alarms_a_constant_threshold_and_not_an_adaptive_one() {
    let folder = folder();
    fs::write(folder.path().join("bare.toml"), "evaluation.threshold = 'calibrated'").unwrap();
    success(folder.path(), &["design", "bare.toml", "-o", "bare.json"]);
    let false_alarms = |design: &str| {
        let fault_free = ["--drives", "120", "--duration", "30", "--faults", "none"];
        let line = [
            &["campaign", design, "-o", design.trim_end_matches(".json"), "--json"],
            &fault_free[..],
        ];
        let outcome = json(&success(folder.path(), &line.concat()));
        outcome["report"]["false_alarms"][0].clone()
    };
    let (adaptive, constant) = (false_alarms("design.json"), false_alarms("bare.json"));
    assert_eq!(adaptive["episodes"], 0, "{adaptive}");
    assert!(adaptive["largest_ratio"].as_f64().unwrap() < 1.0, "{adaptive}");
    assert!(constant["episodes"].as_u64().unwrap() > 10, "{constant}");
}

#[test]
fn a_healthy_nominal_vehicle_raises_no_alarm() {
    let folder = folder();
    let arguments = campaign(&["--faults", "none", "--nominal", "--json"]);
    let report = &json(&success(folder.path(), &arguments))["report"];
    let all = &report["false_alarms"][0];
    assert_eq!((&all["group"], &all["drives"]), (&"all drives".into(), &DRIVES.into()));
    assert_eq!((all["episodes"].as_u64(), all["per_hour"]["lower"].as_f64()), (Some(0), Some(0.0)));
    // It was driven hard enough to tell.
    assert!(all["largest_ratio"].as_f64().unwrap() > 0.1, "{all}");
    assert!(
        report["monitored_h"].as_f64().unwrap() > 0.9 * 30.0 * DRIVES as f64 / 3600.0,
        "{report}"
    );
    assert_eq!(report["detections"], Value::Array(vec![]));
}

#[test]
fn a_bias_of_two_degrees_is_always_detected() {
    let folder = folder();
    let arguments = ["--faults", "bias", "--fault-deg", "2..2", "--nominal", "--json"];
    let report = &json(&success(folder.path(), &campaign(&arguments)))["report"];
    let all = &report["detections"][0];
    assert_eq!((&all["kind"], &all["group"]), (&"bias".into(), &"all".into()));
    assert_eq!((all["faults"].as_u64(), all["not_exposed"].as_u64()), (Some(DRIVES), Some(0)));
    assert_eq!(all["detected"].as_u64(), Some(DRIVES));
    assert!(all["delay_median_s"].as_f64().unwrap() <= 0.1, "{all}");
}

#[test]
fn a_fault_that_changes_nothing_is_not_exposed() {
    let folder = folder();
    // Under this seed the wheel sticks in five straight drives.
    let arguments = ["--drives", "190", "--duration", "30", "--seed", "5", "-o", "c"];
    success(folder.path(), &[&["campaign", "design.json"][..], &arguments].concat());
    let rows = rows(&folder.path().join("c"));
    let stuck = |row: &&Value| row["drive"]["fault"] == "stuck";
    let verdict = |row: &Value| row["outcome"]["verdict"].clone();
    let (straight, steered): (Vec<_>, Vec<_>) =
        rows.iter().filter(stuck).partition(|row| row["drive"]["manoeuvre"] == "straight");
    assert!(!straight.is_empty() && !steered.is_empty());
    assert!(straight.iter().all(|row| verdict(row) == "not exposed"));
    assert!(steered.iter().any(|row| verdict(row) == "detected"));
}

#[test]
fn other_arguments_in_the_same_folder_are_refused() {
    let folder = folder();
    success(folder.path(), &campaign(&["-o", "c", "--shard", "1/6"]));
    let other = campaign(&["-o", "c", "--seed", "2"]);
    failure(folder.path(), &other, 2, &["`c`", "another campaign", "seed: 1 there, 2 now", "-o"]);
    // How it is run is no part of what it is.
    success(folder.path(), &campaign(&["-o", "c", "--jobs", "2"]));
    assert_results_are_the_references(&folder.path().join("c"));
}

#[test]
fn damaged_and_foreign_blocks_are_refused() {
    let folder = folder();
    success(folder.path(), &campaign(&["-o", "c"]));
    let block = folder.path().join("c/blocks/000002.json");
    let good = fs::read_to_string(&block).unwrap();
    let other = fs::read_to_string(folder.path().join("c/blocks/000003.json")).unwrap();
    success(folder.path(), &campaign(&["-o", "d", "--seed", "2", "--shard", "3/12"]));
    let foreign = fs::read_to_string(folder.path().join("d/blocks/000002.json")).unwrap();
    let forged = |from: &str, to: &str| {
        let (bytes, _) = good.split_once(",\"sha256\"").unwrap();
        let bytes = bytes.replacen(from, to, 1);
        assert!(!good.starts_with(&bytes), "{from}");
        let digest: String = Sha256::digest(&bytes).iter().map(|b| format!("{b:02x}")).collect();
        format!("{bytes},\"sha256\":\"{digest}\"}}\n")
    };
    let monitored = "\"monitored_s\":";
    for (text, part) in [
        (good[..good.len() / 2].to_owned(), "no digest at its end"),
        (good.replacen(monitored, "\"monitored_s\":1", 1), "its digest is not that of its rows"),
        (forged(monitored, "\"monitored_s\":99"), "monitored for 99"),
        (other, "its drives are not those of this block"),
        (foreign, "belongs to another campaign"),
    ] {
        fs::write(&block, text).unwrap();
        let parts = ["000002.json", part, "delete the file"];
        failure(folder.path(), &campaign(&["-o", "c"]), 2, &parts);
    }
    fs::remove_file(&block).unwrap();
    success(folder.path(), &campaign(&["-o", "c"]));
    assert_results_are_the_references(&folder.path().join("c"));
}

#[test]
fn bad_arguments_are_explained() {
    let folder = folder();
    for arguments in [
        &["--drives", "0"][..],
        &["--duration", "nan"],
        &["--duration", "1"],
        &["--seed", "-1"],
        &["--jobs", "0"],
        &["--faults", "some"],
        &["--fault-deg", "1"],
        &["--fault-deg", "2..1"],
        &["--fault-deg", "0..inf"],
        &["--parameters", "-1"],
        &["--bank", "91"],
        &["--gust", "x"],
        &["--r-noise", "-0.1"],
        &["--shard", "0/3"],
        &["--shard", "4/3"],
        &["--shard", "2"],
        &["--nominal", "--bank", "1"],
        &["--drive", "1", "--shard", "1/2"],
        &["--prepare", "--drive", "1"],
        &["--signals", "s", "--prepare"],
        &["--signals", "s", "-o", "c"],
    ] {
        let all = [&["campaign", "design.json"], arguments].concat();
        failure(folder.path(), &all, 2, &[arguments[0], "help"]);
    }
    failure(folder.path(), &["campaign"], 2, &["<DESIGN>"]);
    failure(folder.path(), &["campaign", "none.json"], 2, &["none.json"]);
    let beyond = ["campaign", "design.json", "--drives", "5", "--drive", "5"];
    failure(folder.path(), &beyond, 2, &["no drive 5", "--drives"]);
    let taken = campaign(&["-o", "design.json/c"]);
    failure(folder.path(), &taken, 2, &["design.json/c", "-o DIR"]);
    let nowhere = campaign(&["--signals", "none/s"]);
    failure(folder.path(), &nowhere, 2, &["none/s", "-o DIR"]);
}
