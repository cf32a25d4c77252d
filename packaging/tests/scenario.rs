//! A scenario drives what a campaign's drive of the same kind drives, to the last bit.

#![allow(clippy::unwrap_used)]

mod common;
#[path = "common/fmu.rs"]
mod fmu;

use steerguard::campaign::drive::Drive;
use steerguard::campaign::names::{FaultName, ManoeuvreName};
use steerguard::campaign::settings::Subject;
use steerguard::campaign::simulation::TestBench;
use steerguard::drive::cosimulation::{self, Sample};
use steerguard::drive::scenario::Scenario;
use steerguard::fmu::package::{detector_fmu, plant_fmu};
use steerguard::fmu::runtime::Runtimes;
use steerguard::report::design_summary::Record;
use steerguard_detector::{Actuator, Gust, Interval, Vehicle, Zero};
use steerguard_world::{Gusts, Steering, Tyres};

use fmu::open;

const ACTUATOR: Actuator =
    Actuator { lag_s: 0.05, delay_s: 0.03, rate_limit_rad_per_s: Some(0.5), angle_limit_rad: None };

fn bench() -> TestBench {
    TestBench {
        detector: open(
            &detector_fmu(&common::design(), &Record::default(), &Runtimes::detector()).unwrap(),
        ),
        plant: open(&plant_fmu(&Runtimes::plant()).unwrap()),
        subject: Subject {
            vehicle: Vehicle::PAPER,
            actuator: ACTUATOR,
            zero: Zero::default(),
            period_s: 0.01,
            armed_v_x: Interval::new(5.5, 29.5),
            lateral_acceleration_m_per_s2: 3.0,
            steering_rate_rad_per_s: 0.2,
            smallest_fault_deg: 0.5,
            gust: Gust { speed_m_per_s: 0.0, coefficient_n_s2_per_m2: 2.64, acting_ahead_m: 0.25 },
        },
    }
}

/// The scenario of a manoeuvre and a fault in still air.
fn scenario(manoeuvre: ManoeuvreName, fault: FaultName) -> Scenario {
    let text = format!(
        r#"
        duration_s = 12.0
        initial_speeds_m_per_s = [9.0]
        initial_lateral_speed_m_per_s = 0.0
        [side_wind_m_per_s2]
        [manoeuvre]
        kind = "{}"
        lateral_acceleration_m_per_s2 = -1.5
        steering_rate_rad_per_s = 0.2
        start_s = 0.5
        [fault]
        kind = "{}"
        start_s = 2.0
        [actuator]
        lag_s = 0.05
        delay_s = 0.03
        rate_limit_rad_per_s = 0.5
        "#,
        manoeuvre.name(),
        fault.name()
    );
    Scenario::parse(&text).unwrap()
}

/// The drive that `scenario` describes, as campaigns describe it.
fn drive(scenario: &Scenario) -> Drive {
    let gusts = Gusts { speed_m_per_s: 0.0, duration_s: 1.0, start_s: 1.0, pause_s: 1.0 };
    Drive {
        index: 0,
        duration_s: scenario.duration_s,
        plan: scenario.manoeuvre.unwrap().plan(9.0),
        bank_deg: 0.0,
        gusts,
        noise: scenario.sensor_noise,
        sensor_bias: [0.0; 2],
        vehicle: Vehicle::PAPER,
        tyres: Tyres::Linear,
        steering: Steering::of(ACTUATOR),
        v_x_scale: 0.0,
        fault: scenario.fault.unwrap().fault(),
    }
}

#[test]
fn a_scenario_drives_what_a_campaign_drives() {
    let bench = bench();
    let pairs = ManoeuvreName::ALL
        .iter()
        .flat_map(|&manoeuvre| FaultName::ALL.iter().map(move |&fault| (manoeuvre, fault)));
    for (manoeuvre, fault) in pairs {
        let scenario = scenario(manoeuvre, fault);
        let run = cosimulation::run(&bench.detector, &bench.plant, &scenario, 9.0).unwrap();
        let mut samples: Vec<Sample> = Vec::new();
        bench.run(&drive(&scenario), |sample| samples.push(*sample)).unwrap();
        assert_eq!(run.samples.len(), 1200);
        assert_eq!(run.samples, samples, "{manoeuvre:?} with {fault:?}");

        let steers = samples.iter().any(|sample| sample.steering_angle != 0.0);
        assert_eq!(steers, manoeuvre != ManoeuvreName::Straight, "{manoeuvre:?}");
        let acts = samples.iter().any(|sample| sample.fault != 0.0);
        let adds = [FaultName::Bias, FaultName::Drift, FaultName::Oscillation].contains(&fault);
        assert_eq!(acts, fault != FaultName::None && (steers || adds), "{manoeuvre:?}, {fault:?}");
        assert!(samples.iter().all(|sample| sample.time >= 2.0 || sample.fault == 0.0));
    }
}

/// A fault departs from whatever is commanded, of which the paper's sine is one.
#[test]
fn a_wheel_that_sticks_stays_under_a_signal_too() {
    let bench = bench();
    let text = "duration_s = 8.0\n[fault]\nkind = \"stuck\"\nstart_s = 3.0";
    let scenario = Scenario::parse(text).unwrap();
    let run = cosimulation::run(&bench.detector, &bench.plant, &scenario, 15.0).unwrap();
    // The actuator of this design has no lag: the wheel stands where it is commanded to be.
    let wheel = |sample: &Sample| sample.steering_angle + sample.fault;
    let (before, after): (Vec<&Sample>, Vec<&Sample>) =
        run.samples.iter().partition(|s| s.time < 3.0);
    assert!(before.iter().all(|sample| sample.fault == 0.0));
    let stuck_at = wheel(after[0]);
    assert!(stuck_at != 0.0 && after.iter().all(|sample| (wheel(sample) - stuck_at).abs() < 1e-15));
    assert!(after.last().unwrap().fault.abs() > 1e-3);
}
