//! The detector in FMI 3.0 in the hands of the `fmi` crate: its C types are those of the standard's headers,
//! its results the plain detector's, and the alarm an event.
//!
//! # Conventions
//! - The crate's reader refuses attributes of Float64 variables that the schema of FMI 3.0 allows: it gets the
//!   description without them.

#![allow(clippy::unwrap_used)]

mod common;
#[path = "../../conformance/tests/common/drive.rs"]
#[allow(dead_code, reason = "the residual is an array here")]
mod drive;

use std::fs::{self, File};
use std::mem::{align_of, size_of};

use drive::{DURATION_S, STEPS, Shown, Step, assert_eventful, inputs, plain};
use fmi::EventFlags;
use fmi::fmi3::import::Fmi3Import;
use fmi::fmi3::instance::InstanceCS;
use fmi::fmi3::{CoSimulation, Common, Fmi3Model, GetSet, binding};
use fmi::traits::FmiImport;
use steerguard_fmi3::types as ours;
use steerguard_model_description::VariableSet;
use steerguard_model_description::detector::DetectorVariable as V;
use steerguard_model_description::structure::references_beyond_the_table;

const INPUTS: [V; 4] = [V::SpeedX, V::YawRate, V::DriveTorque, V::SteeringAngle];
/// Of `drive::REALS` without the residual, which is an array.
const REALS: [V; 6] =
    [V::LateralSpeed, V::Rms, V::Threshold, V::Ratio, V::Detectability, V::FirstAlarmTime];

/// Attributes of Float64 variables that `fmi` 0.8 does not know.
const UNKNOWN_TO_FMI: [&str; 3] = ["unit", "displayUnit", "nominal"];

fn import() -> Fmi3Import {
    let folder = tempfile::tempdir().unwrap();
    let fmu = File::open(common::fixture("SteeringFaultDetector.fmi3.fmu")).unwrap();
    zip::ZipArchive::new(fmu).unwrap().extract(folder.path()).unwrap();
    let xml = fs::read_to_string(folder.path().join("modelDescription.xml")).unwrap();
    Fmi3Import::new(folder, &xml.lines().map(known_to_fmi).collect::<String>()).unwrap()
}

/// A line of the description as the crate can read it.
fn known_to_fmi(line: &str) -> String {
    let mut line = line.to_owned() + "\n";
    for attribute in UNKNOWN_TO_FMI {
        let start = line.find(&format!(" {attribute}=\"")).filter(|_| line.contains("<Float64 "));
        if let Some(start) = start {
            let value = start + attribute.len() + 3;
            let end = value + line[value..].find('"').unwrap() + 1;
            line.replace_range(start..end, "");
        }
    }
    line
}

/// Should it read them one day, the detour above is to go.
#[test]
fn the_crate_still_refuses_the_description_as_it_is() {
    let path = common::fixture("SteeringFaultDetector.fmi3.fmu");
    let refused = fmi::import::from_path::<Fmi3Import>(&path).unwrap_err().to_string();
    assert!(UNKNOWN_TO_FMI.iter().any(|attribute| refused.contains(attribute)), "{refused}");
}

fn instance(import: &Fmi3Import, event_mode: bool, early_return: bool) -> InstanceCS {
    let mut instance =
        import.instantiate_cs("importer", false, true, event_mode, early_return, &[]).unwrap();
    assert_eq!(instance.get_version(), "3.0");
    instance.enter_initialization_mode(None, 0.0, Some(DURATION_S as f64)).unwrap();
    instance.exit_initialization_mode().unwrap();
    if event_mode {
        handle_event(&mut instance);
    }
    instance
}

/// From Event Mode to Step Mode.
fn handle_event(instance: &mut InstanceCS) {
    let mut flags = EventFlags::default();
    Common::update_discrete_states(instance, &mut flags).unwrap();
    assert_eq!(flags, EventFlags::default());
    instance.enter_step_mode().unwrap();
}

fn shown(instance: &mut InstanceCS) -> Shown {
    let (mut residual, mut others) = ([f64::NAN; 2], [f64::NAN; 6]);
    let (mut alarms, mut state) = ([false; 2], [0_i64]);
    let array = [V::ResidualSpeedX.value_reference()];
    instance.get_float64(&array, &mut residual).unwrap();
    instance.get_float64(&REALS.map(|v| v.value_reference()), &mut others).unwrap();
    let booleans = [V::Alarm, V::AlarmLatched].map(|v| v.value_reference());
    instance.get_boolean(&booleans, &mut alarms).unwrap();
    instance.get_int64(&[V::State.value_reference()], &mut state).unwrap();
    let mut reals = [0.0; 8];
    reals[..2].copy_from_slice(&residual);
    reals[2..].copy_from_slice(&others);
    Shown { reals, alarm: alarms[0], alarm_latched: alarms[1], state: state[0] as i32 }
}

/// What a step says: event handling needed, early return, last successful time.
fn do_step(instance: &mut InstanceCS, time_s: f64, size_s: f64) -> (bool, bool, f64) {
    let (mut event, mut terminate, mut early, mut reached) = (true, true, true, f64::NAN);
    instance
        .do_step(time_s, size_s, true, &mut event, &mut terminate, &mut early, &mut reached)
        .unwrap();
    assert!(!terminate);
    (event, early, reached)
}

fn set(instance: &mut InstanceCS, time_s: f64) {
    instance.set_float64(&INPUTS.map(|v| v.value_reference()), &inputs(time_s)).unwrap();
}

#[test]
fn results_are_the_plain_detectors_for_every_communication_step() {
    let (import, detector) = (import(), common::plain_detector());
    for step in STEPS {
        let mut instance = instance(&import, false, false);
        let mut period = [f64::NAN];
        instance.get_float64(&[V::DesignSamplePeriod.value_reference()], &mut period).unwrap();
        let [period_s] = period;
        let expected = plain(detector, step, period_s);
        assert_eventful(&expected);
        for (i, expected) in expected.iter().enumerate() {
            let (time_s, size_s) = (i as f64 * step.size_s(period_s), step.size_s(period_s));
            set(&mut instance, time_s);
            let (event, early, _) = do_step(&mut instance, time_s, size_s);
            assert!(!event && !early);
            assert_eq!(shown(&mut instance), *expected, "step size {}, step {i}", step.name);
        }
        instance.terminate().unwrap();
    }
}

/// In steps of ten samples the events are at the samples where the plain detector's alarm changes.
#[test]
fn the_alarm_is_an_event_at_its_sample() {
    const TEN: Step = Step { name: "ten", samples: (10, 1) };
    const PERIOD_S: f64 = 0.01;
    let (import, detector) = (import(), common::plain_detector());
    let [clock, clock_time, _] = references_beyond_the_table::<V>();

    // The same inputs sample by sample, held over ten.
    let mut plain_detector = detector;
    let (mut expected, mut alarm) = (Vec::new(), false);
    let size_s = TEN.size_s(PERIOD_S);
    for sample in 0..TEN.count(PERIOD_S) * 10 {
        let [v_x_m_per_s, r_rad_per_s, t_eng_n_m, delta_rad] =
            inputs((sample / 10) as f64 * size_s);
        let y = steerguard_detector::Measurement { v_x_m_per_s, r_rad_per_s };
        let u = steerguard_detector::Input { t_eng_n_m, delta_rad };
        let now = plain_detector.sample(y, u).alarm;
        if now != alarm {
            expected.push((sample as f64 * PERIOD_S, now));
            alarm = now;
        }
    }
    assert!(!expected.is_empty());

    let mut instance = instance(&import, true, true);
    let mut found = Vec::new();
    let whole = plain(detector, TEN, PERIOD_S);
    for (i, whole) in whole.iter().enumerate() {
        let (start_s, end_s) = (i as f64 * size_s, (i + 1) as f64 * size_s);
        set(&mut instance, start_s);
        let mut time_s = start_s;
        loop {
            let (event, early, reached) = do_step(&mut instance, time_s, end_s - time_s);
            assert_eq!(event, early, "events are at samples, which lie within the step");
            if !early {
                break;
            }
            Common::enter_event_mode(&mut instance).unwrap();
            let (mut active, mut at, mut alarm) = ([false], [f64::NAN], [false]);
            instance.get_clock(&[clock], &mut active).unwrap();
            instance.get_float64(&[clock_time], &mut at).unwrap();
            instance.get_boolean(&[V::Alarm.value_reference()], &mut alarm).unwrap();
            assert!(active[0] && start_s <= reached && reached < end_s);
            found.push((at[0], alarm[0]));
            handle_event(&mut instance);
            time_s = reached;
        }
        assert_eq!(shown(&mut instance), *whole, "step {i}");
    }
    assert_eq!(found, expected);
}

/// Size and alignment of types of the same name.
macro_rules! assert_same_layout {
    ($($name:ident)+) => { $(
        assert_eq!(size_of::<ours::$name>(), size_of::<binding::$name>(), stringify!($name));
        assert_eq!(align_of::<ours::$name>(), align_of::<binding::$name>(), stringify!($name));
    )+ };
}

/// The same types: assignable to each other without a cast.
macro_rules! assert_same_type {
    ($($name:ident)+) => { $( let _: fn(ours::$name) -> binding::$name = |x| x; )+ };
}

#[test]
fn types_are_those_of_the_standards_headers() {
    assert_same_type!(
        fmi3Instance fmi3InstanceEnvironment fmi3FMUState fmi3ValueReference fmi3Float32 fmi3Float64
        fmi3Int8 fmi3UInt8 fmi3Int16 fmi3UInt16 fmi3Int32 fmi3UInt32 fmi3Int64 fmi3UInt64
        fmi3String fmi3Byte fmi3Binary
    );
    // A byte that a caller may set to anything, in place of C's bool.
    assert_same_layout!(fmi3Boolean fmi3Clock fmi3Status fmi3DependencyKind fmi3IntervalQualifier);
}
