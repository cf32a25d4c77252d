//! The scenario of method 7 driven by the `fmi` crate: the fault is detected, nothing
//! else is, and the detector FMU gives what the plain detector gives.

#![allow(clippy::unwrap_used)]

mod common;

use std::f64::consts::PI;

use fmi::fmi2::import::Fmi2Import;
use fmi::fmi2::instance::{CoSimulation, Common, InstanceCS};
use fmi::traits::FmiImport;
use steerguard_detector::{Detector, Input, Measurement, Monitor, Vehicle};

const FAULT_ONSET_S: f64 = 5.0;
const LARGEST_DELAY_S: f64 = 0.10;
const DURATION_S: f64 = 20.0;
const SIDE_WIND_LEVER_ARM_M: f64 = 0.25;

/// An instance and the value references of its variables.
struct Fmu<'a> {
    import: &'a Fmi2Import,
    instance: InstanceCS,
}

impl<'a> Fmu<'a> {
    fn new(import: &'a Fmi2Import, start: &[(&str, f64)]) -> Self {
        let instance = import.instantiate_cs("importer", false, false).unwrap();
        assert_eq!((instance.get_version(), instance.get_types_platform()), ("2.0", "default"));
        let mut fmu = Self { import, instance };
        fmu.instance.setup_experiment(None, 0.0, Some(DURATION_S)).unwrap();
        fmu.set(start);
        fmu.instance.enter_initialization_mode().unwrap();
        fmu.instance.exit_initialization_mode().unwrap();
        fmu
    }

    fn reference(&self, name: &str) -> u32 {
        self.import.model_description().model_variable_by_name(name).unwrap().value_reference
    }

    fn set(&mut self, values: &[(&str, f64)]) {
        for (name, value) in values {
            self.instance.set_real(&[self.reference(name)], &[*value]).unwrap();
        }
    }

    fn real(&mut self, name: &str) -> f64 {
        let mut value = [f64::NAN];
        self.instance.get_real(&[self.reference(name)], &mut value).unwrap();
        value[0]
    }

    fn boolean(&mut self, name: &str) -> bool {
        let mut value = [-1];
        self.instance.get_boolean(&[self.reference(name)], &mut value).unwrap();
        value[0] == 1
    }

    fn integer(&mut self, name: &str) -> i32 {
        let mut value = [-1];
        self.instance.get_integer(&[self.reference(name)], &mut value).unwrap();
        value[0]
    }

    fn step(&mut self, time_s: f64, step_s: f64) {
        self.instance.do_step(time_s, step_s, true).unwrap();
    }
}

/// Steering fault at the road wheel, rad.
fn fault(time_s: f64) -> f64 {
    if time_s < FAULT_ONSET_S - 1e-9 {
        0.0
    } else {
        (0.5 + 0.1 * (-0.1 * PI * time_s).sin()).to_radians()
    }
}

/// The results of the last sample are the plain detector's, bit for bit: it computes in `+ - * /`
/// and `sqrt` only, in a fixed order.
fn assert_same(fmu: &mut Fmu, plain: &Detector, time_s: f64) {
    let output = plain.output();
    for (name, value) in [
        ("residual.v_x", output.residual.v_x_m_per_s),
        ("residual.r", output.residual.r_rad_per_s),
        ("v_y_hat", output.v_y_hat),
        ("J_rms", output.j_rms),
        ("J_th", output.j_th),
        ("J_ratio", output.j_rms / output.j_th),
    ] {
        assert_eq!(fmu.real(name), value, "{name} at {time_s} s");
    }
    let state = steerguard_fmu::state(output.monitor).value();
    assert_eq!(fmu.integer("state"), state, "state at {time_s} s");
    assert_eq!(fmu.boolean("alarm"), output.alarm, "alarm at {time_s} s");
    assert_eq!(fmu.boolean("alarm_latched"), output.first_alarm.is_some());
}

fn run(speed: f64) {
    let (plant, detector) =
        (common::import("VehiclePlant"), common::import("SteeringFaultDetector"));
    let mut plain = common::plain_detector();
    let mut plant = Fmu::new(&plant, &[("initial.v_x", speed), ("initial.v_y", 1.0)]);
    let mut detector = Fmu::new(&detector, &[]);

    let step_s = detector.real("design.sample_period");
    let mass_kg = plant.real("vehicle.M_v");
    let drive_torque = Vehicle::PAPER.cruise_torque(speed);
    for k in 0..(DURATION_S / step_s).round() as u32 {
        let time_s = f64::from(k) * step_s;
        let angle = 0.02 * (0.5 * time_s).sin() * (5.0 / speed).sqrt();
        let side_force = mass_kg * 0.1 * (-0.1 * PI * time_s).sin();

        let y = Measurement { v_x_m_per_s: plant.real("v_x"), r_rad_per_s: plant.real("r") };
        let u = Input { t_eng_n_m: drive_torque, delta_rad: angle };
        detector.set(&[
            ("v_x", y.v_x_m_per_s),
            ("r", y.r_rad_per_s),
            ("u.T_eng", u.t_eng_n_m),
            ("u.delta", u.delta_rad),
        ]);
        plant.set(&[
            ("u.T_eng", drive_torque),
            ("u.delta", angle),
            ("fault", fault(time_s)),
            ("disturbance.side_force", side_force),
            ("disturbance.yaw_moment", SIDE_WIND_LEVER_ARM_M * side_force),
        ]);
        detector.step(time_s, step_s);
        plant.step(time_s, step_s);
        plain.sample(y, u);

        assert_same(&mut detector, &plain, time_s);
        assert_eq!(plain.output().monitor, Monitor::Monitoring, "at {time_s} s");
        if time_s < FAULT_ONSET_S - 1e-9 {
            assert!(!detector.boolean("alarm"), "false alarm at {time_s} s and {speed} m/s");
        }
    }
    let delay_s = detector.real("first_alarm_time") - FAULT_ONSET_S;
    assert!(
        detector.boolean("alarm_latched") && (0.0..LARGEST_DELAY_S + 1e-9).contains(&delay_s),
        "detected {delay_s} s after the onset at {speed} m/s"
    );
    detector.instance.terminate().unwrap();
    plant.instance.terminate().unwrap();
}

#[test]
fn fault_is_detected_at_6_m_per_s() {
    run(6.0);
}

#[test]
fn fault_is_detected_at_15_m_per_s() {
    run(15.0);
}

#[test]
fn fault_is_detected_at_25_m_per_s() {
    run(25.0);
}

#[test]
fn a_state_saved_by_the_importer_restores() {
    let import = common::import("SteeringFaultDetector");
    let start = [("v_x", 15.0), ("r", 0.02), ("u.T_eng", 78.75)];
    let mut fmu = Fmu::new(&import, &start);
    let step_s = fmu.real("design.sample_period");
    let run = |fmu: &mut Fmu| {
        let j = |k| {
            fmu.step(f64::from(k) * step_s, step_s);
            fmu.real("J_rms")
        };
        (1..100).map(j).collect::<Vec<f64>>()
    };
    fmu.step(0.0, step_s);
    let state = fmu.instance.get_fmu_state().unwrap();
    let first = run(&mut fmu);
    let bytes = fmu.instance.serialize_fmu_state(&state).unwrap();
    let restored = fmu.instance.deserialize_fmu_state(&bytes).unwrap();
    use fmi::traits::FmiStatus;
    fmu.instance.set_fmu_state(&restored).ok().unwrap();
    assert_eq!(run(&mut fmu), first);
    assert!(first.last() > Some(&0.0));
}
