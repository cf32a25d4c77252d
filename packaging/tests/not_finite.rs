//! FMUs of others that give what is no number: whatever drives them ends there and says which, what and when.

#![allow(clippy::unwrap_used)]
#![cfg(target_os = "linux")]

#[path = "common/command.rs"]
mod command;
mod common;
#[path = "common/fmu.rs"]
mod fmu;
#[path = "common/subject.rs"]
mod subject;

use std::io::{Cursor, Read as _, Write as _};
use std::path::Path;
use std::process::Command;

use steerguard::campaign::drive::Drive;
use steerguard::campaign::settings::{FaultMix, Mix, Sensors, Settings, Uncertainty};
use steerguard::campaign::simulation::TestBench;
use steerguard::fmu::package::{detector_fmu, plant_fmu};
use steerguard::fmu::runtime::Runtimes;
use steerguard::platform::Platform;
use steerguard::replay::{Bench, OpenDrive, Outputs, drive};
use steerguard::report::design_summary::Record;
use steerguard_designer::spec::UncertaintyTable;
use steerguard_detector::{Interval, Vehicle, Zero};
use steerguard_drives::Columns;
use steerguard_model_description::VariableSet as _;
use steerguard_model_description::detector::DetectorVariable;
use steerguard_model_description::names;
use steerguard_model_description::plant::PlantVariable;
use zip::write::SimpleFileOptions;
use zip::{ZipArchive, ZipWriter};

use command::failure;
use fmu::open;
use subject::SUBJECT;

fn detector() -> Vec<u8> {
    detector_fmu(&common::design(), &Record::default(), &Runtimes::detector()).unwrap()
}

fn plant() -> Vec<u8> {
    plant_fmu(&Runtimes::plant()).unwrap()
}

/// `fmu` of model `name` with a library written in C, whose variable `reference` is `number` from 0.99 s on.
fn broken(fmu: &[u8], name: &str, reference: u32, number: &str) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let library = folder.path().join("library.so");
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/not_finite.c");
    let defined =
        [("REFERENCE", reference.to_string()), ("NUMBER", number.into()), ("TIME", "0.995".into())];
    let compiled = Command::new("cc")
        .args(["-shared", "-fPIC", "-o"])
        .arg(&library)
        .args(defined.map(|(name, value)| format!("-D{name}={value}")))
        .arg(source)
        .status();
    assert!(compiled.unwrap().success());
    let path = Platform::HOST.unwrap().library_path(name);
    let mut from = ZipArchive::new(Cursor::new(fmu)).unwrap();
    let mut to = ZipWriter::new(Cursor::new(Vec::new()));
    for index in 0..from.len() {
        let mut entry = from.by_index(index).unwrap();
        let name = entry.name().unwrap().into_owned();
        let mut bytes = Vec::new();
        entry.read_to_end(&mut bytes).unwrap();
        if name == path {
            bytes = std::fs::read(&library).unwrap();
        }
        to.start_file(name, SimpleFileOptions::default()).unwrap();
        to.write_all(&bytes).unwrap();
    }
    to.finish().unwrap().into_inner()
}

fn broken_detector(variable: DetectorVariable, number: &str) -> Vec<u8> {
    broken(&detector(), names::DETECTOR, variable.value_reference(), number)
}

fn broken_plant(variable: PlantVariable, number: &str) -> Vec<u8> {
    broken(&plant(), names::PLANT, variable.value_reference(), number)
}

#[test]
fn simulate_ends_at_the_first() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let write = |name: &str, bytes| std::fs::write(path.join(name), bytes).unwrap();
    write("detector.fmu", detector());
    write("plant.fmu", plant());
    write("nan.fmu", broken_detector(DetectorVariable::Threshold, "NAN"));
    write("infinite.fmu", broken_detector(DetectorVariable::SecondRatio, "-INFINITY"));
    write("plant-nan.fmu", broken_plant(PlantVariable::YawRate, "NAN"));
    for (detector, plant, expected) in [
        ("nan.fmu", "plant.fmu", "detector: `J_th` = NaN at 0.99 s"),
        ("infinite.fmu", "plant.fmu", "detector: `second_ratio` = -inf at 0.99 s"),
        ("detector.fmu", "plant-nan.fmu", "plant: `r` = NaN at 1 s"),
    ] {
        let arguments = ["simulate", "--detector", detector, "--plant", plant];
        failure(path, &arguments, 2, &[expected, "help: "]);
        let written = std::fs::read_dir(path.join("steerguard-out")).unwrap().count();
        assert_eq!(written, 0, "no file of a run that has not ended");
    }
}

#[test]
fn a_drive_of_a_campaign_ends_at_the_first() {
    let settings = Settings {
        seed: 1,
        drives: 1,
        duration_s: 5.0,
        mix: Mix::Standard,
        faults: FaultMix::None,
        fault_deg: [0.1, 2.0],
        large_fault_deg: None,
        uncertainty: Uncertainty { bounds: UncertaintyTable::DEFAULT, saturation: true },
        sensors: Sensors {
            v_x_noise_m_per_s: 0.0,
            r_noise_rad_per_s: 0.0,
            v_x_bias_m_per_s: 0.0,
            r_bias_rad_per_s: 0.0,
        },
    };
    let of_plant = broken_plant(PlantVariable::SpeedX, "INFINITY");
    let of_detector = broken_detector(DetectorVariable::ResidualYawRate, "NAN");
    for (detector, plant, expected, steps) in [
        (detector(), of_plant, "plant: `v_x` = inf at 1 s, which is no finite number", 100),
        (
            of_detector,
            plant(),
            "detector: `residual.r` = NaN at 0.99 s, which is no finite number",
            99,
        ),
    ] {
        let bench = TestBench { detector: open(&detector), plant: open(&plant), subject: SUBJECT };
        let mut seen = 0;
        let error = bench.run(&Drive::draw(&settings, &SUBJECT, 0), |_| seen += 1).unwrap_err();
        assert_eq!((error.to_string().as_str(), seen), (expected, steps));
    }
}

#[test]
fn a_replay_ends_at_the_first() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("drive.csv");
    let row = |k: u32| {
        let t = f64::from(k) * 0.01;
        format!("{t:.2},{:.4},{:.5},{:.6}\n", 15.0 + 0.1 * t.sin(), 0.1 * t.cos(), 0.02 * t.cos())
    };
    let rows: String = (0..500).map(row).collect();
    std::fs::write(&file, format!("t [s],v [m/s],r [rad/s],steering [rad]\n{rows}")).unwrap();
    let bench = Bench {
        fmu: open(&broken_detector(DetectorVariable::LateralSpeed, "NAN")),
        vehicle: Vehicle::PAPER,
        zero: Zero::default(),
        steering_ratio: 1.0,
        speeds: Interval::new(5.0, 30.0),
        period_s: 0.01,
    };
    let outputs = Outputs { folder: folder.path().to_owned() };
    let opened = OpenDrive::open(&file, &Columns::default(), "drive".into()).unwrap();
    let error = drive(&bench, opened, &[], None, true, &outputs).unwrap_err().to_string();
    assert_eq!(error, "detector: `v_y_hat` = NaN at 0.99 s, which is no finite number");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "the drive alone");
}
