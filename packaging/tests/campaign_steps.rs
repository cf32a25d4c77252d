//! Drives of a campaign from inside the process.

#![allow(clippy::unwrap_used)]

mod common;
#[path = "common/fmu.rs"]
mod fmu;
#[path = "common/subject.rs"]
mod subject;

use steerguard::campaign::drive::Drive;
use steerguard::campaign::settings::{FaultMix, Mix, Sensors, Settings, Subject, Uncertainty};
use steerguard::campaign::simulation::TestBench;
use steerguard::drive::cosimulation::Sample;
use steerguard::drive::scenario::SensorNoise;
use steerguard::fmu::package::{detector_fmu, plant_fmu};
use steerguard::fmu::runtime::Runtimes;
use steerguard::report::design_summary::Record;
use steerguard_designer::spec::UncertaintyTable;
use steerguard_detector::Actuator;
use steerguard_world::{FaultKind, Manoeuvre, Plan};

use fmu::open;
use subject::SUBJECT;

const SETTINGS: Settings = Settings {
    seed: 1,
    drives: 30,
    duration_s: 10.0,
    mix: Mix::Standard,
    faults: FaultMix::Mixed,
    fault_deg: [0.1, 2.0],
    large_fault_deg: None,
    uncertainty: Uncertainty { bounds: UncertaintyTable::DEFAULT, saturation: true },
    sensors: Sensors {
        v_x_noise_m_per_s: 0.02,
        r_noise_rad_per_s: 0.002,
        v_x_bias_m_per_s: 0.01,
        r_bias_rad_per_s: 0.001,
    },
};

fn bench() -> TestBench {
    TestBench {
        detector: open(
            &detector_fmu(&common::design(), &Record::default(), &Runtimes::detector()).unwrap(),
        ),
        plant: open(&plant_fmu(&Runtimes::plant()).unwrap()),
        subject: SUBJECT,
    }
}

/// A drive allocates to set up, and where the detector logs an event: nothing a step.
#[test]
fn steps_allocate_nothing() {
    let bench = bench();
    let settings = Settings {
        faults: FaultMix::None,
        uncertainty: Uncertainty::NOMINAL,
        sensors: Sensors { v_x_noise_m_per_s: 1e-5, r_noise_rad_per_s: 1e-6, ..SETTINGS.sensors },
        ..SETTINGS
    };
    let mut quiet_drives = 0;
    for index in 0..SETTINGS.drives {
        let run = |duration_s| {
            let drive = Drive { duration_s, ..Drive::draw(&settings, &SUBJECT, index) };
            let (mut steps, mut events, mut last) = (0, 0, (false, 2));
            let allocated = allocation_counter::measure(|| {
                let record = |sample: &Sample| {
                    steps += 1;
                    events += u32::from((sample.alarm, sample.state) != last);
                    last = (sample.alarm, sample.state);
                };
                bench.run(&drive, record).unwrap();
            });
            (steps, events, allocated.count_total)
        };
        let (few, _, set_up) = run(0.01);
        let (many, events, all) = run(10.0);
        assert_eq!((few, many), (1, 1000));
        if events == 0 {
            quiet_drives += 1;
            assert_eq!(all, set_up, "drive {index}");
        }
    }
    assert!(quiet_drives >= 3, "{quiet_drives}");
}

/// The plant has the actuator of the drive: one that the detector does not know of shows.
#[test]
fn drives_are_driven_through_their_actuator() {
    let actuator =
        Actuator { lag_s: 0.1, delay_s: 0.05, rate_limit_rad_per_s: Some(0.2), ..Actuator::NONE };
    let (mut knowing, unaware) = (common::design(), bench());
    knowing.configuration.actuator = actuator;
    let knowing = TestBench {
        detector: open(&detector_fmu(&knowing, &Record::default(), &Runtimes::detector()).unwrap()),
        plant: open(&plant_fmu(&Runtimes::plant()).unwrap()),
        subject: Subject { actuator, ..SUBJECT },
    };
    let unaware = TestBench { subject: knowing.subject, ..unaware };
    let settings =
        Settings { faults: FaultMix::None, uncertainty: Uncertainty::NOMINAL, ..SETTINGS };
    let drawn = Drive::draw(&settings, &knowing.subject, 0);
    let manoeuvre = Manoeuvre::DoubleLaneChange;
    let drive = Drive {
        plan: Plan { manoeuvre, speed_m_per_s: 10.0, ..drawn.plan },
        noise: SensorNoise::default(),
        sensor_bias: [0.0; 2],
        ..drawn
    };
    assert_eq!(drive.steering.actuator, actuator);
    let [by_knowing, by_unaware] = [&knowing, &unaware].map(|bench| {
        let mut largest = 0.0_f64;
        bench.run(&drive, |sample| largest = largest.max(sample.j_rms)).unwrap();
        largest
    });
    assert!(by_unaware > 5.0 * by_knowing, "{by_knowing}, {by_unaware}");
}

/// What the detector is given is what the drive says.
#[test]
fn samples_carry_what_the_drive_describes() {
    let bench = bench();
    let drives = (0..200).map(|index| Drive::draw(&SETTINGS, &SUBJECT, index));
    let sized = drives.filter_map(|drive| {
        let fault = drive.fault?;
        match fault.kind {
            FaultKind::Bias { angle_rad }
            | FaultKind::Drift { angle_rad, .. }
            | FaultKind::Oscillation { angle_rad, .. } => Some((drive, fault.onset_s, angle_rad)),
            _ => None,
        }
    });
    for (drive, onset_s, angle_rad) in sized.take(20) {
        let quiet = Drive { noise: SensorNoise::default(), sensor_bias: [0.5, -0.01], ..drive };
        let mut samples = Vec::new();
        bench.run(&quiet, |sample| samples.push(*sample)).unwrap();
        let first = samples[0];
        assert!((first.v_x - quiet.plan.speed_m_per_s - 0.5).abs() < 1e-12);
        assert!((first.r + 0.01).abs() < 1e-12);
        for sample in samples {
            if sample.time < onset_s {
                assert_eq!(sample.fault, 0.0);
            }
            assert!(sample.fault.abs() <= angle_rad.abs() + 1e-15);
            let wind = sample.side_force.abs();
            assert!(wind <= 0.5 * 1.2 * 4.4 * 10.0 * (sample.v_x.powi(2) + 100.0).sqrt() + 1e-9);
        }
    }
}
