//! The detector behind the C functions behaves as the plain detector, at its edges too.

#![allow(clippy::unwrap_used)]

mod common;

use common::{Detector, OK, PERIOD, design};
use proptest::prelude::*;
use steerguard_detector::{Input, Measurement, Monitor, Signal};
use steerguard_fmi2::types::fmi2Status;
use steerguard_fmu::DetectorModel;
use steerguard_fmu_core::Model;
use steerguard_model_description::detector::{DetectorVariable as V, INFO};
use steerguard_model_description::xml::{describe, lint};
use steerguard_model_description::{DefaultExperiment, Kind, Value, VariableSet};

/// Straight driving at 15 m/s in balance.
const CRUISE: [f64; 4] = [15.0, 0.0, 78.75, 0.0];
const STATE: [(Monitor, i32); 6] = [
    (Monitor::Starting, 1),
    (Monitor::Monitoring, 2),
    (Monitor::OutOfRange, 3),
    (Monitor::InvalidInput, 4),
    (Monitor::Disabled, 5),
    (Monitor::StaleInput, 6),
];

/// Inputs that vary, leave the range, and are invalid for a while.
fn inputs(step: usize) -> [f64; 4] {
    let t = step as f64;
    let v_x = if (300..340).contains(&step) { 3.0 } else { 15.0 + (0.01 * t).sin() };
    let r = if (500..505).contains(&step) { f64::NAN } else { 0.2 * (0.03 * t).sin() };
    [v_x, r, 80.0, 0.03 * (0.03 * t).cos()]
}

/// Asserts that all outputs equal those of the plain detector, bit for bit.
fn assert_same(fmu: &Detector, plain: &steerguard_detector::Detector, start: f64) {
    let output = plain.output();
    for (variable, expected) in [
        (V::ResidualSpeedX, output.residual.v_x_m_per_s),
        (V::ResidualYawRate, output.residual.r_rad_per_s),
        (V::Rms, output.j_rms),
        (V::Threshold, output.j_th),
        (V::LateralSpeed, output.v_y_hat),
        (V::Ratio, output.j_rms / output.j_th),
        (V::FirstAlarmTime, output.first_alarm.map_or(-1.0, |k| start + k as f64 * PERIOD)),
    ] {
        assert_eq!(fmu.real(variable).to_bits(), expected.to_bits(), "{variable:?}");
    }
    assert_eq!(fmu.boolean(V::Alarm), output.alarm);
    assert_eq!(fmu.boolean(V::AlarmLatched), output.first_alarm.is_some());
    assert!(STATE.contains(&(output.monitor, fmu.integer(V::State))));
}

#[test]
fn the_fmu_is_the_detector_at_every_step_size() {
    for size in [PERIOD, 2.0 * PERIOD, 8.0 * PERIOD, PERIOD / 3.0, 1.0 / 60.0] {
        let start = 2.5;
        let fmu = Detector::initialised(start);
        let mut plain = steerguard_detector::Detector::new(&design().configuration).unwrap();
        assert_same(&fmu, &plain, start);
        for step in 0..2000 {
            let u = inputs(step);
            fmu.set_inputs(u);
            let point = start + step as f64 * size;
            assert!(fmu.step(point, size) <= fmi2Status::fmi2Warning);
            // Samples k with point <= start + k T_s < point + size, in exact arithmetic.
            let per_step = size / PERIOD;
            let end = ((step + 1) as f64 * per_step - 1e-6).ceil() as u64;
            while plain.state().sample < end {
                let [v_x_m_per_s, r_rad_per_s, t_eng_n_m, delta_rad] = u;
                let y = Measurement { v_x_m_per_s, r_rad_per_s };
                plain.sample(y, Input { t_eng_n_m, delta_rad });
            }
            assert_same(&fmu, &plain, start);
        }
        assert!(fmu.boolean(V::AlarmLatched));
    }
}

#[test]
fn the_fresh_model_fits_its_description() {
    let model = DetectorModel::new(&design().encode().unwrap()).unwrap();
    for (&variable, row) in V::ALL.iter().zip(V::TABLE) {
        let value = model.get(variable);
        assert!(row.kind.is_type_of(value), "{}", row.name);
        if !matches!(row.kind, Kind::Boolean) && row.role.has_start() {
            assert!(row.kind.admits(value), "{} = {value:?}", row.name);
        }
    }
    let experiment = DefaultExperiment { start_time: 0.0, stop_time: 20.0, step_size: PERIOD };
    let rendered = describe::<V>(&INFO, |variable| model.get(variable), &experiment).unwrap();
    assert_eq!(lint(&rendered.xml), []);
    let hash = String::from_utf8(design().hash.to_vec()).unwrap();
    assert!(rendered.xml.contains(&hash));
}

/// What the detector takes for invalid is what the description says is out of bounds.
#[test]
fn inputs_have_the_limits_that_are_declared() {
    let inputs = [V::SpeedX, V::YawRate, V::DriveTorque, V::SteeringAngle];
    for (variable, signal) in inputs.into_iter().zip(Signal::ALL) {
        let row = &V::TABLE[variable.value_reference() as usize];
        let Kind::Real(real) = row.kind else { panic!("{}", row.name) };
        let limit = signal.limit();
        assert_eq!((real.min, real.max), (Some(-limit), Some(limit)), "{}", row.name);
    }
}

#[test]
fn every_variable_can_be_set_or_keeps_its_value() {
    let mut model = DetectorModel::new(&design().encode().unwrap()).unwrap();
    for (&variable, row) in V::ALL.iter().zip(V::TABLE) {
        let before = format!("{:?}", model.get(variable));
        let value = match row.kind {
            Kind::Real(_) => Value::Real(0.75),
            Kind::Integer { .. } | Kind::Enumeration(_) => Value::Integer(2),
            // The other one.
            Kind::Boolean => Value::Boolean(before == "Boolean(false)"),
            Kind::String => Value::String(c"x"),
        };
        model.set(variable, value);
        use steerguard_model_description::Causality::{Input, Parameter};
        let settable = matches!(row.role.causality, Input | Parameter);
        let expected = if settable { format!("{value:?}") } else { before };
        assert_eq!(format!("{:?}", model.get(variable)), expected, "{}", row.name);
    }
}

#[test]
fn an_alarm_is_raised_latched_and_told() {
    let fmu = Detector::initialised(1.0);
    fmu.set_inputs(CRUISE);
    assert_eq!(fmu.step(1.0, 5.0), OK);
    assert_eq!(fmu.messages("logEvents"), ["monitoring from 1 s"]);
    assert!(!fmu.boolean(V::Alarm));
    assert_eq!(fmu.real(V::FirstAlarmTime), -1.0);

    fmu.set_inputs([15.0, 0.1, 78.75, 0.0]);
    assert_eq!(fmu.step(6.0, 0.02), OK);
    assert!(fmu.boolean(V::Alarm) && fmu.boolean(V::AlarmLatched));
    assert_eq!(fmu.real(V::FirstAlarmTime), 6.0);
    let [event] = &fmu.messages("logEvents")[..] else { panic!("one event expected") };
    assert!(event.starts_with("alarm at 6 s: J_rms = 0.0"), "{event}");

    assert_eq!((fmu.integer(V::AlarmCause), fmu.integer(V::AlarmCauseIndex)), (2, 2));

    // It stays until J has been low for a second.
    fmu.set_inputs(CRUISE);
    assert_eq!(fmu.step(6.02, 1.0), OK);
    assert!(fmu.boolean(V::Alarm));
    assert_eq!(fmu.messages("logEvents"), [""; 0]);
    assert_eq!(fmu.step(7.02, 20.0), OK);
    assert!(!fmu.boolean(V::Alarm) && fmu.boolean(V::AlarmLatched));
    assert_eq!(fmu.integer(V::AlarmCause), 1);
    assert!(fmu.messages("logEvents")[0].starts_with("alarm over at "));
    fmu.reset();
    fmu.initialise(0.0);
    assert!(!fmu.boolean(V::AlarmLatched));
}

#[test]
fn leaving_the_range_against_the_command_is_an_alarm_of_its_own_cause() {
    let fmu = Detector::initialised(0.0);
    fmu.set_inputs(CRUISE);
    assert_eq!(fmu.step(0.0, 5.0), OK);
    fmu.messages("logEvents");
    fmu.set_inputs([15.0, 0.7, 78.75, 0.0]);
    assert_eq!(fmu.step(5.0, PERIOD), OK);
    assert!(fmu.boolean(V::Alarm));
    assert_eq!((fmu.integer(V::State), fmu.integer(V::AlarmCause)), (3, 3));
    assert_eq!(fmu.integer(V::StateCause), 3);
    assert_eq!(
        fmu.messages("logEvents"),
        [
            "r changes by 0.7 rad/s within a sample at 5 s, 3.5 times the most that a vehicle and the \
             sensor's noise allow: is it in deg/s?",
            "alarm at 5 s: r = 0.7 is not in [-0.55, 0.55], although the command does not lead there",
            "outside the range of the design from 5 s: r = 0.7 is not in [-0.55, 0.55]",
        ]
    );
}

#[test]
fn a_detector_that_is_switched_off_gives_no_alarm_and_starts_clean() {
    let fmu = Detector::initialised(0.0);
    fmu.set_inputs(CRUISE);
    assert_eq!(fmu.step(0.0, 5.0), OK);
    fmu.set_inputs([15.0, 0.1, 78.75, 0.0]);
    assert_eq!(fmu.step(5.0, 0.25), OK);
    assert!(fmu.boolean(V::Alarm));
    fmu.messages("logEvents");
    assert_eq!(fmu.set_boolean(V::Enabled, false), OK);
    assert_eq!(fmu.step(5.25, 1.0), OK);
    assert!(!fmu.boolean(V::Alarm) && fmu.boolean(V::AlarmLatched) && !fmu.boolean(V::Excited));
    assert_eq!((fmu.integer(V::State), fmu.integer(V::StateIndex)), (5, 5));
    assert_eq!((fmu.integer(V::StateCause), fmu.integer(V::StateCauseIndex)), (8, 8));
    let events = fmu.messages("logEvents");
    assert_eq!(events[1..], ["switched off by the input enabled from 5.25 s"]);
    assert_eq!(fmu.set_boolean(V::Enabled, true), OK);
    assert_eq!(fmu.step(6.25, PERIOD), OK);
    assert_eq!((fmu.integer(V::State), fmu.real(V::Rms)), (2, 0.0));
}

#[test]
fn measurements_that_no_longer_change_are_told_once() {
    let fmu = Detector::instantiated();
    assert_eq!(fmu.set(V::StaleAfter, 0.2), OK);
    fmu.initialise(0.0);
    fmu.set_inputs(CRUISE);
    assert_eq!(fmu.step(0.0, 5.0), OK);
    assert_eq!((fmu.integer(V::State), fmu.integer(V::StateCause)), (6, 7));
    assert!(!fmu.boolean(V::Excited));
    let events = fmu.messages("logEvents");
    assert_eq!(events.len(), 2, "{events:?}");
    assert_eq!(
        events[1],
        "v_x and r have not changed for 0.2 s at 0.21 s: no alarm until they do; for simulations \
         without noise set the parameter stale_after_s = 0"
    );
    // Off as designed.
    let fmu = Detector::initialised(0.0);
    fmu.set_inputs(CRUISE);
    assert_eq!(fmu.step(0.0, 5.0), OK);
    assert_eq!(fmu.integer(V::State), 2);
}

#[test]
fn what_the_sensors_show_at_zero_is_a_parameter() {
    let residual = |offset: f64, bias: f64, shown: [f64; 2]| {
        let fmu = Detector::instantiated();
        assert_eq!(fmu.set(V::SteeringOffset, offset), OK);
        assert_eq!(fmu.set(V::YawRateBias, bias), OK);
        fmu.initialise(0.0);
        let [r, delta] = shown;
        fmu.set_inputs([15.0, r, 78.75, delta]);
        assert_eq!(fmu.step(0.0, 1.0), OK);
        fmu.real(V::Rms)
    };
    assert_eq!(residual(0.01, -0.02, [-0.02, 0.01]), residual(0.0, 0.0, [0.0, 0.0]));
    assert_ne!(residual(0.01, 0.0, [0.0, 0.0]), residual(0.0, 0.0, [0.0, 0.0]));
}

#[test]
fn invalid_inputs_are_warned_about_once_an_episode_and_hold_the_outputs() {
    let fmu = Detector::initialised(0.0);
    let mut point = 0.0;
    let mut step = |inputs: [f64; 4]| {
        fmu.set_inputs(inputs);
        let status = fmu.step(point, PERIOD);
        point += PERIOD;
        status
    };
    assert_eq!(step(CRUISE), OK);
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300] {
        for place in 0..4 {
            let mut inputs = CRUISE;
            inputs[place] = bad;
            let j_th = fmu.real(V::Threshold);
            assert_eq!(step(inputs), fmi2Status::fmi2Warning);
            assert_eq!(step(inputs), OK);
            assert_eq!(step(inputs), OK);
            assert_eq!(fmu.integer(V::State), 4);
            assert_eq!(fmu.real(V::Threshold), j_th);
            assert_eq!(fmu.integer(V::StateCause), place as i32 + 2);
            let [warning] = &fmu.messages("logStatusWarning")[..] else { panic!("one expected") };
            let name = ["v_x", "r", "u.T_eng", "u.delta"][place];
            assert!(warning.starts_with(&format!("{name} = ")), "{warning}");
            assert_eq!(step(CRUISE), OK);
            assert_eq!(fmu.integer(V::State), 2);
        }
    }
}

#[test]
fn outside_the_range_the_residual_raises_no_alarm() {
    let fmu = Detector::initialised(0.0);
    assert_eq!(fmu.integer(V::State), 1);
    assert_eq!(fmu.real(V::ResidualSpeedX), 0.0);
    fmu.set_inputs([3.0, 0.5, 0.0, 0.0]);
    assert_eq!(fmu.step(0.0, 1.0), OK);
    assert_eq!((fmu.integer(V::State), fmu.boolean(V::Alarm)), (3, false));
    assert_eq!(
        fmu.messages("logEvents"),
        ["outside the range of the design from 0 s: v_x = 3 is not in [5, 30]"]
    );
}

#[test]
fn parameters_act() {
    let j_th = |factor: f64| {
        let fmu = Detector::instantiated();
        assert_eq!(fmu.set(V::ThresholdFactor, factor), OK);
        fmu.initialise(0.0);
        fmu.set_inputs(CRUISE);
        assert_eq!(fmu.step(0.0, 10.0), OK);
        fmu.real(V::Threshold)
    };
    assert!((j_th(3.0) / j_th(1.0) - 3.0).abs() < 1e-12);

    let alarm_after = |debounce: i32| {
        let fmu = Detector::initialised(0.0);
        fmu.set_inputs(CRUISE);
        assert_eq!(fmu.step(0.0, 5.0), OK);
        assert_eq!(fmu.set_integer(V::DebounceSamples, debounce), OK);
        fmu.set_inputs([15.0, 0.1, 78.75, 0.0]);
        assert_eq!(fmu.step(5.0, 0.2), OK);
        fmu.real(V::FirstAlarmTime)
    };
    assert!((alarm_after(4) - alarm_after(1) - 3.0 * PERIOD).abs() < 1e-12);

    let residual = |initialisation: i32| {
        let fmu = Detector::instantiated();
        assert_eq!(fmu.set_integer(V::Initialisation, initialisation), OK);
        assert_eq!(fmu.set(V::InitialZ1, 14.0), OK);
        fmu.initialise(0.0);
        fmu.set_inputs(CRUISE);
        assert_eq!(fmu.step(0.0, PERIOD), OK);
        fmu.real(V::ResidualSpeedX)
    };
    assert_eq!((residual(1), residual(2)), (0.0, 1.0));
}

#[test]
fn a_restored_state_continues_bit_for_bit_and_reset_is_fresh() {
    let fmu = Detector::initialised(0.0);
    let fresh = Detector::instantiated().serialised();
    let run = |fmu: &Detector, from: usize, to: usize| {
        for step in from..to {
            fmu.set_inputs(inputs(step));
            assert!(fmu.step(step as f64 * PERIOD, PERIOD) <= fmi2Status::fmi2Warning);
        }
    };
    // The state is taken while tracking, out of range, and invalid.
    let mut from = 0;
    for to in [200, 320, 502] {
        run(&fmu, from, to);
        let saved = fmu.serialised();
        let other = Detector::instantiated();
        other.restore(&saved);
        assert_eq!(other.serialised(), saved);
        run(&fmu, to, 700);
        run(&other, to, 700);
        assert_eq!(fmu.serialised(), other.serialised());
        fmu.restore(&saved);
        from = to;
    }
    let given = Detector::instantiated();
    assert_eq!(given.set_integer(V::Initialisation, 2), OK);
    given.initialise(0.0);
    let other = Detector::instantiated();
    other.restore(&given.serialised());
    run(&given, 0, 5);
    run(&other, 0, 5);
    assert_eq!(given.serialised(), other.serialised());

    fmu.reset();
    assert_eq!(fmu.serialised(), fresh);
}

fn input() -> impl Strategy<Value = f64> {
    prop_oneof![
        -40.0..40.0_f64,
        -1e9..1e9_f64,
        any::<f64>(),
        Just(f64::NAN),
        Just(f64::INFINITY),
        Just(15.0),
    ]
}

proptest! {
    #[test]
    fn no_input_makes_an_output_that_is_not_finite(
        inputs in prop::collection::vec([input(), input(), input(), input()], 1..60),
    ) {
        let fmu = Detector::initialised(0.0);
        for (step, inputs) in inputs.into_iter().enumerate() {
            fmu.set_inputs(inputs);
            let status = fmu.step(step as f64 * PERIOD, PERIOD);
            prop_assert!(status <= fmi2Status::fmi2Warning);
            for (&variable, row) in V::ALL.iter().zip(V::TABLE).skip(4) {
                if matches!(row.kind, Kind::Real(_)) {
                    prop_assert!(fmu.real(variable).is_finite(), "{}", row.name);
                }
            }
        }
        let saved = fmu.serialised();
        fmu.restore(&saved);
    }

    /// Large inputs from a vehicle that is in range: the estimate must not run away.
    #[test]
    fn a_large_input_in_range_leaves_the_outputs_finite(
        torque in -1e9..1e9_f64, delta in -1e9..1e9_f64, r in -0.5..0.5_f64,
    ) {
        let fmu = Detector::initialised(0.0);
        for step in 0..40 {
            fmu.set_inputs([15.0, r, torque, delta]);
            let status = fmu.step(f64::from(step) * PERIOD, PERIOD);
            prop_assert!(status <= fmi2Status::fmi2Warning);
            prop_assert!(fmu.real(V::LateralSpeed).is_finite());
            prop_assert!(fmu.real(V::Rms).is_finite());
        }
    }
}

#[test]
fn instances_on_many_threads_do_not_disturb_each_other() {
    let run = |instances: usize| {
        let fmus: Vec<_> = (0..instances).map(|_| Detector::initialised(0.0)).collect();
        for step in 0..600 {
            for fmu in &fmus {
                fmu.set_inputs(inputs(step));
                assert!(fmu.step(step as f64 * PERIOD, PERIOD) <= fmi2Status::fmi2Warning);
            }
        }
        fmus.iter().map(Detector::serialised).collect::<Vec<_>>()
    };
    let alone = run(1);
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..8).map(|_| scope.spawn(|| run(8))).collect();
        for thread in threads {
            assert!(thread.join().unwrap().iter().all(|state| *state == alone[0]));
        }
    });
}
