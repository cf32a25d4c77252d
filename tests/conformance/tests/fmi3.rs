//! The detector in FMI 3.0 in the hands of `fmi-rs`: results are the plain detector's, bit for bit, and the
//! alarm an event.
#![allow(clippy::unwrap_used)]

mod common;

use std::fs;

use common::Packaged;
use common::drive::{STEPS, Shown, assert_eventful, inputs, plain};
use fmi_rs::fmi3::FMU3;
use fmi_rs::fmi3::builder::FMU3Builder;
use fmi_rs::fmi3::types::fmi3Status;
use steerguard::fmu::package::detector_fmi3;
use steerguard::fmu::runtime::Runtimes;
use steerguard::report::design_summary::{Record, baked};

const INPUTS: [&str; 4] = ["v_x", "r", "u.T_eng", "u.delta"];
/// The array counts as two.
const REALS: [&str; 7] =
    ["residual", "v_y_hat", "J_rms", "J_th", "J_ratio", "detectability", "first_alarm_time"];

struct Unpacked {
    packaged: Packaged,
    builder: FMU3Builder,
    _folder: tempfile::TempDir,
}

impl Unpacked {
    fn new() -> Self {
        let packaged = Packaged::new();
        let design = baked(&packaged.design).unwrap();
        let bytes = detector_fmi3(&design, &Record::default(), &Runtimes::detector_fmi3()).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("X.fmi3.fmu");
        fs::write(&path, bytes).unwrap();
        Self { packaged, builder: FMU3Builder::new(&path).unwrap(), _folder: folder }
    }

    fn reference(&self, name: &str) -> u32 {
        self.builder.model_description.variable_by_name(name).unwrap().valueReference
    }
}

/// What a step says: event handling needed, early return, last successful time.
fn step(fmu: &FMU3, time_s: f64, size_s: f64) -> (bool, bool, f64) {
    let (mut event, mut terminate, mut early, mut reached) = (true, true, true, f64::NAN);
    let status =
        fmu.doStep(time_s, size_s, true, &mut event, &mut terminate, &mut early, &mut reached);
    assert!(matches!(status, fmi3Status::Ok | fmi3Status::Warning), "{status:?}");
    assert!(!terminate);
    (event, early, reached)
}

#[test]
fn results_and_events_of_fmi_rs() {
    let unpacked = Unpacked::new();
    let period_s = unpacked.packaged.sample_period_s();
    let [inputs_of, reals_of] = [&INPUTS[..], &REALS[..]]
        .map(|names| names.iter().map(|name| unpacked.reference(name)).collect::<Vec<u32>>());
    let booleans_of = ["alarm", "alarm_latched"].map(|name| unpacked.reference(name));
    let [state_of, clock] = ["state", "alarm_change"].map(|name| unpacked.reference(name));
    for of in STEPS {
        let expected = plain(unpacked.packaged.plain_detector(), of, period_s);
        assert_eventful(&expected);
        // The builder asks for Event Mode and early return.
        let fmu = unpacked.builder.instantiate_cs("foreign").unwrap();
        assert_eq!(fmu.enterInitializationMode(None, 0.0, Some(60.0)), fmi3Status::Ok);
        assert_eq!(fmu.exitInitializationMode(), fmi3Status::Ok);
        let handle_event = || {
            let (mut more, mut end, mut nominals, mut values) = (true, true, true, true);
            let mut next = Some(0.0);
            let status = fmu.updateDiscreteStates(
                &mut more,
                &mut end,
                &mut nominals,
                &mut values,
                &mut next,
            );
            assert_eq!((status, more, end, next), (fmi3Status::Ok, false, false, None));
            assert_eq!(fmu.enterStepMode(), fmi3Status::Ok);
        };
        handle_event();
        let (mut events, mut alarm) = (0, false);
        for (i, expected) in expected.iter().enumerate() {
            let (start_s, size_s) = (i as f64 * of.size_s(period_s), of.size_s(period_s));
            assert_eq!(fmu.setFloat64(&inputs_of, &inputs(start_s)), fmi3Status::Ok);
            let mut time_s = start_s;
            loop {
                let (event, early, reached) = step(&fmu, time_s, start_s + size_s - time_s);
                assert_eq!(event, early);
                if !early {
                    break;
                }
                assert_eq!(fmu.enterEventMode(), fmi3Status::Ok);
                let (mut active, mut now) = ([false], [alarm]);
                assert_eq!(fmu.getClock(&[clock], &mut active), fmi3Status::Ok);
                assert_eq!(fmu.getBoolean(&booleans_of[..1], &mut now), fmi3Status::Ok);
                assert!(active[0] && now[0] != alarm);
                handle_event();
                (events, alarm, time_s) = (events + 1, now[0], reached);
            }
            let (mut reals, mut truths, mut number) = ([f64::NAN; 8], [false; 2], [0]);
            assert_eq!(fmu.getFloat64(&reals_of, &mut reals), fmi3Status::Ok);
            assert_eq!(fmu.getBoolean(&booleans_of, &mut truths), fmi3Status::Ok);
            assert_eq!(fmu.getInt64(&[state_of], &mut number), fmi3Status::Ok);
            let [alarm, alarm_latched] = truths;
            let found = Shown { reals, alarm, alarm_latched, state: number[0] as i32 };
            assert_eq!(found, *expected, "step size {}, step {i}", of.name);
        }
        assert!(events > 0, "step size {}", of.name);
    }
}

/// It would not have the clock among the initial unknowns, where the wording of the standard and FMPy want it.
#[test]
fn fmi_rs_finds_nothing_in_the_description_but_the_clock_among_the_unknowns() {
    let description = Unpacked::new().builder.model_description;
    let problems: Vec<String> =
        description.validate().into_iter().map(|problem| problem.message).collect();
    assert_eq!(problems.len(), 1, "{problems:?}");
    assert!(problems[0].starts_with("The initial unknowns do not match"), "{problems:?}");
}
