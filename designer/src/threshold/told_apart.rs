//! What the second test names the fault that it finds: the table of method 9.

#![allow(clippy::unwrap_used)]

use rayon::prelude::*;
use steerguard_detector::{Detector, FaultHypothesis, VehicleState};
use steerguard_world::{Course, Manoeuvre, Plan, Stream, Wind};

use crate::simulation::{Acting, Sampled, Simulation};
use crate::threshold::calibration::drawn;
use crate::{Design, Spec};

/// Onsets lie in the second from here on, and faults are looked at for so long, s.
const ONSET_S: f64 = 4.0;
const FAULT_S: f64 = 1.5;
const SPEEDS_M_PER_S: [f64; 5] = [7.0, 10.0, 15.0, 20.0, 27.0];
/// Stream of what is drawn beside vehicle, road and wind.
const DRIVE_STREAM: u64 = 77;

/// What steps, and by how much.
#[derive(Clone, Copy, Debug)]
enum Faulty {
    SteeringDeg(f64),
    YawRateSensorDegPerS(f64),
    SpeedSensorPercent(f64),
}

/// Those of the table.
fn faults() -> impl Iterator<Item = Faulty> {
    let steering = [0.5, 1.0, 2.0, 5.0, 20.0].map(Faulty::SteeringDeg);
    let yaw_rate = [1.0, 2.0, 5.0, 20.0].map(Faulty::YawRateSensorDegPerS);
    let speed = [5.0, 10.0, 20.0].map(Faulty::SpeedSensorPercent);
    steering.into_iter().chain(yaw_rate).chain(speed)
}

/// A step in the wind.
struct Step {
    faulty: Faulty,
    sign: f64,
    onset_s: f64,
    /// The speed that a share is of.
    speed_m_per_s: f64,
    wind: Wind,
}

impl Acting for Step {
    fn on_body(&self, t: f64, v_x: f64) -> [f64; 2] {
        self.wind.side_force_and_yaw_moment(t, v_x)
    }

    fn on_measurement(&self, t: f64) -> [f64; 2] {
        let sign = if t < self.onset_s { 0.0 } else { self.sign };
        match self.faulty {
            Faulty::SteeringDeg(_) => [0.0; 2],
            Faulty::YawRateSensorDegPerS(size) => [0.0, sign * size.to_radians()],
            Faulty::SpeedSensorPercent(size) => [sign * size / 100.0 * self.speed_m_per_s, 0.0],
        }
    }

    fn fault_rad(&self, t: f64) -> f64 {
        match self.faulty {
            Faulty::SteeringDeg(size) if t >= self.onset_s => self.sign * size.to_radians(),
            _ => 0.0,
        }
    }
}

/// What the second test names the fault of drive `number`; none where it finds nothing.
fn named(
    spec: &Spec,
    mut detector: Detector,
    faulty: Faulty,
    speed_m_per_s: f64,
    number: u64,
) -> Option<FaultHypothesis> {
    let random = Stream::new(number, DRIVE_STREAM);
    let period_s = spec.sampling.period_s;
    let (surroundings, wind) = drawn(spec, number as usize);
    let manoeuvres = [Manoeuvre::Straight, Manoeuvre::Weave, Manoeuvre::StepSteer];
    let plan = Plan {
        manoeuvre: random.choose(0, &manoeuvres).unwrap(),
        speed_m_per_s,
        lateral_acceleration_m_per_s2: random.within(1, 2.0),
        start_s: 1.0,
        pause_s: 1.0,
    };
    let step = Step {
        faulty,
        sign: random.sign(2),
        onset_s: ONSET_S + random.unit(3),
        speed_m_per_s,
        wind,
    };
    let steering_rate_rad_per_s = spec.evaluation.calibration.steering_rate_rad_per_s;
    let simulation = Simulation {
        sensors: surroundings.sensors(&spec.noise, period_s, number),
        surroundings,
        course: Course::new(&plan, &spec.vehicle, steering_rate_rad_per_s),
        start: VehicleState { v_x_m_per_s: speed_m_per_s, v_y_m_per_s: 0.0, r_rad_per_s: 0.0 },
        period_s,
        samples: ((step.onset_s + FAULT_S) / period_s) as u64,
    };
    let mut named = None;
    simulation.run(&mut detector, &step, |&Sampled { detector, .. }| {
        let now = detector.output().estimate.map(|x| x.hypothesis);
        if named.is_none_or(|x| x == FaultHypothesis::Undecided) {
            named = now.or(named);
        }
    });
    named
}

/// How many of so many drives found nothing, and named the steering, the yaw-rate sensor, the speed sensor, nothing.
fn counts(design: &Design, faulty: Faulty, speed_m_per_s: f64, drives: u64) -> [usize; 5] {
    let detector = Detector::new(&design.configuration()).unwrap();
    let said: Vec<_> = (0..drives)
        .into_par_iter()
        .map(|number| named(&design.spec, detector, faulty, speed_m_per_s, number))
        .collect();
    [
        None,
        Some(FaultHypothesis::Steering),
        Some(FaultHypothesis::YawRateSensor),
        Some(FaultHypothesis::SpeedSensor),
        Some(FaultHypothesis::Undecided),
    ]
    .map(|name| said.iter().filter(|x| **x == name).count())
}

/// The default design with its second test.
fn design() -> Design {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/verify/tests/fixtures/gap.json");
    Design::from_json(&std::fs::read_to_string(file).unwrap()).unwrap()
}

#[test]
fn what_is_named_is_what_has_stepped() {
    let design = design();
    for faulty in faults() {
        for speed in SPEEDS_M_PER_S {
            let [_, steering, yaw_rate, speed_sensor, undecided] =
                counts(&design, faulty, speed, 8);
            let wrong = match faulty {
                Faulty::SteeringDeg(size) => {
                    // Slow cars follow at once, as the sensor would.
                    let told = size >= 1.0 && speed >= 10.0;
                    assert!(!told || undecided == 0, "{faulty:?} at {speed} m/s");
                    yaw_rate + speed_sensor
                }
                Faulty::YawRateSensorDegPerS(_) => steering + speed_sensor,
                Faulty::SpeedSensorPercent(_) => steering + yaw_rate,
            };
            assert_eq!(wrong, 0, "{faulty:?} at {speed} m/s");
        }
    }
}

#[test]
#[ignore = "minutes: prints the table of method 9"]
fn table() {
    const DRIVES: u64 = 400;
    println!("of {DRIVES}: nothing found, steering, yaw-rate sensor, speed sensor, undecided");
    let design = design();
    for faulty in faults() {
        for speed in SPEEDS_M_PER_S {
            println!("{faulty:?} at {speed} m/s: {:?}", counts(&design, faulty, speed, DRIVES));
        }
    }
}
