//! The alarm comes, stays and goes: hard-overs and a wheel that turns further into a corner, with a driver
//! who lets it happen and one who corrects the yaw rate.
//!
//! # Conventions
//! The default design, its vehicle on linear tyres, its noise. The fault comes at 6 s and lasts for 5 s.

#![allow(clippy::unwrap_used)]

#[path = "common/designed.rs"]
mod designed;

use designed::designed;
use rayon::prelude::*;
use steerguard_designer::{Design, Spec};
use steerguard_detector::{Detector, Input, Measurement};
use steerguard_world::{
    Excitation, STEP_S, Sensor, Sensors, State, Steering, TrueVehicle, World, steady_angle,
};

const FAULT_S: [f64; 2] = [6.0, 11.0];
const END_S: f64 = 18.0;
/// When the driver notices.
const REACTION_S: f64 = 0.4;

/// A drive with a fault.
#[derive(Clone, Copy, Debug)]
struct Drive {
    v_x_m_per_s: f64,
    r_rad_per_s: f64,
    fault_deg: f64,
    debounce_samples: u32,
    corrects: bool,
}

/// What the alarm did.
#[derive(Clone, Copy, Debug, Default)]
struct Outcome {
    before: bool,
    /// From the fault's onset to the alarm, s.
    delay_s: Option<f64>,
    /// Samples without alarm between the first with one and the fault's end.
    gaps: u32,
    /// From where the fault is gone and the vehicle back inside the armed range to the alarm's end, s.
    over_s: Option<f64>,
}

fn run(design: &Design, drive: &Drive) -> Outcome {
    let configuration = &design.detector;
    let model = &configuration.model;
    let mut detector = Detector::new(configuration).unwrap();
    detector.set_debounce_samples(drive.debounce_samples).unwrap();
    let (vehicle, t_s) = (model.vehicle, model.sampling_period_s);
    let world = World::of(TrueVehicle::linear(vehicle), Steering::of(configuration.actuator));
    let white = |noise_std| Sensor { noise_std, ..Sensor::default() };
    let sensors = Sensors {
        sensors: design.spec.noise.white_std().map(white),
        period_s: t_s,
        held: false,
        seed: 1,
    };
    let armed = model.range.shrunk(configuration.hysteresis);
    let Drive { v_x_m_per_s: v, r_rad_per_s: wanted_r, .. } = *drive;
    let steady_rad = steady_angle(&vehicle, v, v * wanted_r);
    let wheelbase = vehicle.front_axle_distance_m + vehicle.rear_axle_distance_m;

    let mut state = State::new(&world, STEP_S, [v, 0.0, 0.0].into(), 0.0);
    let mut outcome = Outcome::default();
    let (mut correction, mut back_s, mut last_s) = (0.0_f64, None, 0.0);
    for k in 0..(END_S / t_s) as u64 {
        let t = k as f64 * t_s;
        let [v_x, r] = sensors.readings(k, state.motion.measured().vector());
        // The corner is entered within two seconds.
        let entered = (t / 2.0).min(1.0);
        if drive.corrects && t > FAULT_S[0] + REACTION_S {
            // Towards the wanted yaw rate with a time constant of half a second.
            let behind = wanted_r * entered - state.motion.r_rad_per_s;
            correction += t_s * (2.0 * wheelbase / v * behind).clamp(-0.3, 0.3);
        }
        let u = Input {
            t_eng_n_m: vehicle.cruise_torque(v)
                + vehicle.effective_longitudinal_inertia_kg_m * (v - v_x),
            delta_rad: steady_rad * entered + correction,
        };
        let y = Measurement { v_x_m_per_s: v_x, r_rad_per_s: r };
        let alarm = detector.sample(y, u).alarm;
        let acts = (FAULT_S[0]..FAULT_S[1]).contains(&t);
        if acts {
            match outcome.delay_s {
                None if alarm => outcome.delay_s = Some(t - FAULT_S[0]),
                Some(_) if !alarm => outcome.gaps += 1,
                _ => {}
            }
        } else if t < FAULT_S[0] {
            outcome.before |= alarm;
        } else {
            let [v_x, v_y, r] = state.motion.vector();
            let inside = armed.v_x.contains(v_x) && armed.v_y.contains(v_y) && armed.r.contains(r);
            back_s = if inside { back_s.or(Some(t)) } else { None };
            if alarm {
                last_s = t + t_s;
            }
        }
        let excitation = Excitation {
            drive_torque_n_m: u.t_eng_n_m,
            command_rad: u.delta_rad,
            fault_rad: if acts { drive.fault_deg.to_radians() } else { 0.0 },
            push: [0.0; 3],
        };
        for _ in 0..(t_s / STEP_S).round() as u32 {
            state.step(&world, &excitation, STEP_S);
        }
    }
    outcome.over_s = back_s.map(|back_s| last_s.max(back_s) - back_s);
    outcome
}

/// Holds `drives` to what is asked from 1 degree on, and prints what each did.
fn check(drives: Vec<Drive>) {
    let design = designed(&Spec::default()).unwrap();
    let t_s = design.detector.model.sampling_period_s;
    let hold_s = design.detector.evaluation.alarm_hold_s;
    let outcomes: Vec<Outcome> = drives.par_iter().map(|drive| run(&design, drive)).collect();
    for (drive, outcome) in drives.iter().zip(&outcomes) {
        println!("{drive:?}: {outcome:?}");
    }
    for (drive, outcome) in drives.iter().zip(&outcomes) {
        assert!(!outcome.before, "{drive:?}: {outcome:?}");
        let within_s = match drive.fault_deg {
            deg if deg >= 2.0 => 0.2,
            deg if deg >= 1.0 => 0.4,
            _ => continue,
        };
        let debounced_s = within_s + t_s * f64::from(drive.debounce_samples - 1);
        let delay_s = outcome.delay_s.unwrap_or(f64::INFINITY);
        assert!(delay_s <= debounced_s + 1e-9, "{drive:?}: {outcome:?}");
        assert_eq!(outcome.gaps, 0, "{drive:?}: {outcome:?}");
        let over_s = outcome.over_s.unwrap_or(f64::INFINITY);
        assert!(over_s <= hold_s + 1.0, "{drive:?}: {outcome:?}");
    }
}

/// Every combination.
fn drives(r_rad_per_s: f64, speeds: &[f64], faults_deg: &[f64]) -> Vec<Drive> {
    let mut drives = Vec::new();
    for &v_x_m_per_s in speeds {
        for &fault_deg in faults_deg {
            for debounce_samples in [1, 20] {
                for corrects in [false, true] {
                    drives.push(Drive {
                        v_x_m_per_s,
                        r_rad_per_s,
                        fault_deg,
                        debounce_samples,
                        corrects,
                    });
                }
            }
        }
    }
    drives
}

#[test]
fn a_wheel_that_turns_further_into_a_corner_is_an_alarm_that_stays() {
    let faults_deg = [0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 10.0, 20.0];
    check(drives(0.45, &[6.0, 7.0, 8.0, 9.0, 10.0], &faults_deg));
}

#[test]
fn a_hard_over_is_an_alarm_that_stays() {
    let faults_deg = [3.0, 5.0, 7.0, 10.0, 15.0, 20.0];
    check(drives(0.0, &[8.0, 12.0, 17.0, 22.0, 27.0], &faults_deg));
}
