//! An actuator between command and road wheel, with and without a model of it, through packaged FMUs.

#![allow(clippy::unwrap_used)]

#[path = "../../designer/tests/common/designed.rs"]
mod designed;
#[path = "common/fmu.rs"]
mod fmu;

use steerguard::drive::cosimulation::{Excitation, Rig};
use steerguard::fmu::package::{detector_fmu, plant_fmu};
use steerguard::fmu::runtime::Runtimes;
use steerguard::importer::Fmu;
use steerguard::report::design_summary::{Record, baked};
use steerguard_designer::Spec;
use steerguard_detector::{Actuator, Vehicle};
use steerguard_world::steady_angle;

use designed::designed;
use fmu::open;

/// The paper's design, with few drives in the calibration.
const PAPER: &str = r#"
    vehicle.centre_of_gravity_height_m = 0
    operating_range.v_y_m_per_s = [-1.5, 1.5]
    operating_range.r_rad_per_s = [-0.55, 0.55]
    noise.v_x.white_std_m_per_s = 0
    noise.r.white_std_rad_per_s = 0
    design.method = "paper"
    [evaluation]
    weights = [1, 1]
    [evaluation.calibration]
    speeds = 2
    manoeuvres = ["straight", "step_steer"]
    lateral_acceleration_m_per_s2 = [3]
    disturbance_frequencies = 2
    disturbance_phases = 2
    initial_v_y_m_per_s = [0]
    search_drives = 0
"#;
const SPEED_M_PER_S: f64 = 8.0;
const STEP_S: f64 = 0.01;
/// method 7: 0.3 g.
const TURN_IN_M_PER_S2: f64 = 0.3 * 9.81;
const STEERING_RATE_RAD_PER_S: f64 = 0.3;
/// When steering or fault begin, and the run ends, s.
const START_S: f64 = 3.0;
const END_S: f64 = 6.0;

/// The detector of a specification with `[actuator]`, and its threshold.
fn detector(actuator: &str) -> (Fmu, f64) {
    let design = designed(&Spec::from_toml(&format!("{actuator}\n{PAPER}")).unwrap()).unwrap();
    let bytes =
        detector_fmu(&baked(&design).unwrap(), &Record::default(), &Runtimes::detector()).unwrap();
    (open(&bytes), design.detector.evaluation.threshold)
}

/// The largest J from the start of `course` on: command and fault by the time since then.
fn largest_j(
    detector: &Fmu,
    plant: &Fmu,
    actuator: Option<&Actuator>,
    course: impl Fn(f64) -> [f64; 2],
) -> f64 {
    let excitation = |time_s: f64| {
        let since_s = time_s - START_S;
        let [steering_angle, fault] = if since_s < 0.0 { [0.0; 2] } else { course(since_s) };
        let drive_torque = Vehicle::PAPER.cruise_torque(SPEED_M_PER_S);
        Excitation { drive_torque, steering_angle, fault, ..Excitation::default() }
    };
    let mut rig = Rig::new(detector, plant).unwrap();
    rig.plant.set_real(plant.reals(["initial.v_x"]).unwrap(), [SPEED_M_PER_S]).unwrap();
    if let Some(actuator) = actuator {
        rig.set_actuator(plant, actuator).unwrap();
    }
    rig.initialise(END_S, &excitation(0.0)).unwrap();
    let mut largest = 0.0_f64;
    for k in 0..(END_S / STEP_S) as u32 {
        let time_s = f64::from(k) * STEP_S;
        let sample = rig.step(time_s, STEP_S, |_| excitation(time_s)).unwrap();
        assert_eq!(sample.state, 2, "monitoring at {time_s} s");
        if time_s > START_S {
            largest = largest.max(sample.j_rms);
        }
    }
    largest
}

/// A ramp to the angle of a steady turn.
fn turn_in(since_s: f64) -> [f64; 2] {
    let full = steady_angle(&Vehicle::PAPER, SPEED_M_PER_S, TURN_IN_M_PER_S2);
    [(STEERING_RATE_RAD_PER_S * since_s).min(full), 0.0]
}

#[test]
fn a_modelled_actuator_is_no_fault_and_one_left_out_is_a_large_one() {
    let plant = open(&plant_fmu(&Runtimes::plant()).unwrap());
    let (without, _) = detector("");
    let one_degree = 1_f64.to_radians();
    let faulty = largest_j(&without, &plant, None, |_| [0.0, one_degree]);
    let quiet = largest_j(&without, &plant, None, turn_in);
    for (spec, actuator, least_deg) in [
        ("actuator.lag_s = 0.1", Actuator { lag_s: 0.1, ..Actuator::NONE }, 1.0),
        ("actuator.delay_s = 0.037", Actuator { delay_s: 0.037, ..Actuator::NONE }, 0.4),
        (
            "actuator.rate_limit_rad_per_s = 0.15",
            Actuator { rate_limit_rad_per_s: Some(0.15), ..Actuator::NONE },
            1.0,
        ),
    ] {
        let (with, threshold) = detector(spec);
        // The plant takes the actuator of the design.
        let modelled = largest_j(&with, &plant, None, turn_in);
        let left_out = largest_j(&without, &plant, Some(&actuator), turn_in);
        let equivalent_deg = left_out / faulty;
        println!(
            "{spec}: J {modelled:.6} with the model (threshold {threshold:.6}), {left_out:.6} without, \
             like a fault of {equivalent_deg:.2} degrees; no actuator at all {quiet:.6}"
        );
        assert!(modelled < threshold, "{spec}: {modelled}, {threshold}");
        assert!(modelled < quiet + 0.01 * left_out, "{spec}: {modelled}, {quiet}");
        assert!(equivalent_deg > least_deg, "{spec}: {equivalent_deg}");
    }
}
