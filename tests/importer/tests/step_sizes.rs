//! Whatever the communication step, the `fmi` crate sees the plain detector's results, bit for bit.

#![allow(clippy::unwrap_used)]

mod common;
#[path = "../../conformance/tests/common/drive.rs"]
mod drive;

use drive::{DURATION_S, REALS, STEPS, Shown, assert_eventful, inputs, plain};
use fmi::fmi2::instance::{CoSimulation, Common, InstanceCS};
use fmi::traits::FmiImport;

#[test]
fn results_are_the_plain_detectors_for_every_communication_step() {
    let import = common::import("SteeringFaultDetector");
    let reference = |name: &str| {
        import.model_description().model_variable_by_name(name).unwrap().value_reference
    };
    let input_references = ["v_x", "r", "u.T_eng", "u.delta"].map(reference);
    let reals = REALS.map(reference);
    let booleans = ["alarm", "alarm_latched"].map(reference);
    let state = reference("state");
    let shown = |instance: &mut InstanceCS| {
        let (mut values, mut truths, mut number) = ([f64::NAN; 8], [-1; 2], [-1]);
        instance.get_real(&reals, &mut values).unwrap();
        instance.get_boolean(&booleans, &mut truths).unwrap();
        instance.get_integer(&[state], &mut number).unwrap();
        Shown {
            reals: values,
            alarm: truths[0] == 1,
            alarm_latched: truths[1] == 1,
            state: number[0],
        }
    };

    let detector = common::plain_detector();
    let mut period = [f64::NAN];
    for step in STEPS {
        let mut instance = import.instantiate_cs(step.name, false, false).unwrap();
        instance.get_real(&[reference("design.sample_period")], &mut period).unwrap();
        let [period_s] = period;
        instance.setup_experiment(None, 0.0, Some(DURATION_S as f64)).unwrap();
        instance.enter_initialization_mode().unwrap();
        instance.exit_initialization_mode().unwrap();

        let expected = plain(detector, step, period_s);
        assert_eventful(&expected);
        for (i, expected) in expected.iter().enumerate() {
            let (time_s, size_s) = (i as f64 * step.size_s(period_s), step.size_s(period_s));
            instance.set_real(&input_references, &inputs(time_s)).unwrap();
            instance.do_step(time_s, size_s, true).unwrap();
            assert_eq!(shown(&mut instance), *expected, "step size {}, step {i}", step.name);
        }
        instance.terminate().unwrap();
    }
}
