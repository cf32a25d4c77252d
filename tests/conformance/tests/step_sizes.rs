//! Whatever the importer and its communication step, the results are those of the plain detector, bit
//! for bit: it computes with `+ - * /` and `sqrt` only, in a fixed order.
#![allow(clippy::unwrap_used)]

mod common;

use std::fs;
use std::io::Write;
use std::path::Path;

use common::Packaged;
use common::drive::{REALS, STEPS, Shown, Step, assert_eventful, inputs, plain};
use fmi_rs::fmi2::builder::FMU2Builder;
use fmi_rs::fmi2::types::fmi2Status;
use fmi_rs::fmi2::{CS, FMU2};
use steerguard::importer::{Fmu, Instance, Type};

const INPUTS: [&str; 4] = ["v_x", "r", "u.T_eng", "u.delta"];
const BOOLEANS: [&str; 2] = ["alarm", "alarm_latched"];

/// Drives an importer with each step and compares.
fn compare(packaged: &Packaged, drive: impl Fn(Step, f64) -> Vec<Shown>) {
    let period_s = packaged.sample_period_s();
    for step in STEPS {
        let expected = plain(packaged.plain_detector(), step, period_s);
        assert_eventful(&expected);
        let found = drive(step, period_s);
        assert_eq!(found.len(), expected.len());
        for (i, (found, expected)) in found.iter().zip(&expected).enumerate() {
            assert_eq!(found, expected, "step size {}, step {i}", step.name);
        }
    }
}

/// `instance` through the drive, by its own functions for inputs, step and results.
fn record<I>(
    instance: &mut I,
    step: Step,
    period_s: f64,
    set: impl Fn(&mut I, [f64; 4]),
    do_step: impl Fn(&mut I, f64, f64),
    get: impl Fn(&I) -> Shown,
) -> Vec<Shown> {
    let size_s = step.size_s(period_s);
    (0..step.count(period_s))
        .map(|i| {
            let time_s = i as f64 * size_s;
            set(instance, inputs(time_s));
            do_step(instance, time_s, size_s);
            get(instance)
        })
        .collect()
}

#[test]
fn native_importer() {
    let packaged = Packaged::new();
    let fmu = Fmu::open(&packaged.fmu).unwrap();
    let (inputs, reals) = (fmu.reals(INPUTS).unwrap(), fmu.reals(REALS).unwrap());
    let booleans = BOOLEANS.map(|name| fmu.variable(name, Type::Boolean).unwrap());
    let state = fmu.variable("state", Type::Enumeration).unwrap();
    compare(&packaged, |step, period_s| {
        let mut instance = fmu.instantiate("native").unwrap();
        instance.setup_experiment(60.0).unwrap();
        instance.enter_initialization_mode().unwrap();
        instance.exit_initialization_mode().unwrap();
        record(
            &mut instance,
            step,
            period_s,
            |instance: &mut Instance, values| instance.set_real(inputs, values).unwrap(),
            |instance, time_s, size_s| instance.do_step(time_s, size_s).unwrap(),
            |instance| {
                let [alarm, alarm_latched] =
                    instance.get_boolean(booleans).unwrap().map(|b| b == 1);
                let [state] = instance.get_integer([state]).unwrap();
                Shown { reals: instance.get_real(reals).unwrap(), alarm, alarm_latched, state }
            },
        )
    });
}

#[test]
#[allow(clippy::arc_with_non_send_sync, reason = "the importer's own choice")]
fn fmi_rs() {
    let packaged = Packaged::new();
    let description = FMU2Builder::new(&packaged.fmu).unwrap().model_description;
    let reference = |name: &str| description.variable_by_name(name).unwrap().valueReference;
    let (inputs, reals) = (INPUTS.map(reference), REALS.map(reference));
    let (booleans, state) = (BOOLEANS.map(reference), reference("state"));
    compare(&packaged, |step, period_s| {
        let mut instance =
            FMU2Builder::new(&packaged.fmu).unwrap().instantiate_cs("foreign").unwrap();
        assert_eq!(instance.setupExperiment(None, 0.0, Some(60.0)), fmi2Status::Ok);
        assert_eq!(instance.enterInitializationMode(), fmi2Status::Ok);
        assert_eq!(instance.exitInitializationMode(), fmi2Status::Ok);
        record(
            &mut instance,
            step,
            period_s,
            |instance: &mut std::sync::Arc<FMU2<CS>>, values| {
                assert_eq!(instance.setReal(&inputs, &values), fmi2Status::Ok);
            },
            |instance, time_s, size_s| {
                let status = instance.doStep(time_s, size_s, 1);
                assert!(matches!(status, fmi2Status::Ok | fmi2Status::Warning), "{status:?}");
            },
            |instance| {
                let (mut shown, mut truths, mut number) = ([f64::NAN; 8], [-1; 2], [-1]);
                assert_eq!(instance.getReal(&reals, &mut shown), fmi2Status::Ok);
                assert_eq!(instance.getBoolean(&booleans, &mut truths), fmi2Status::Ok);
                assert_eq!(instance.getInteger(&[state], &mut number), fmi2Status::Ok);
                Shown {
                    reals: shown,
                    alarm: truths[0] == 1,
                    alarm_latched: truths[1] == 1,
                    state: number[0],
                }
            },
        )
    });
}

#[test]
fn fmi_rs_finds_nothing_in_the_description() {
    let packaged = Packaged::new();
    let description = FMU2Builder::new(&packaged.fmu).unwrap().model_description;
    let problems = description.validate();
    assert!(problems.is_empty(), "{problems:?}");
}

/// Writes the plain detector's records to the fixtures of the Python tests, which hold other
/// importers against them.
#[test]
fn records_for_importers_in_python() {
    let Some(fixtures) = std::env::var_os("STEERGUARD_FIXTURES") else { return };
    let folder = Path::new(&fixtures).join("plain_detector");
    fs::create_dir_all(&folder).unwrap();
    let packaged = Packaged::new();
    let period_s = packaged.sample_period_s();
    for step in STEPS {
        let file = fs::File::create(folder.join(format!("{}.csv", step.name))).unwrap();
        let mut file = std::io::BufWriter::new(file);
        let columns = [&INPUTS[..], &REALS, &BOOLEANS, &["state"]].concat();
        writeln!(file, "{}", columns.join(",")).unwrap();
        let size_s = step.size_s(period_s);
        for (i, row) in plain(packaged.plain_detector(), step, period_s).iter().enumerate() {
            for value in inputs(i as f64 * size_s).iter().chain(&row.reals) {
                write!(file, "{value},").unwrap();
            }
            let [alarm, latched] = [row.alarm, row.alarm_latched].map(u8::from);
            writeln!(file, "{alarm},{latched},{}", row.state).unwrap();
        }
    }
}
