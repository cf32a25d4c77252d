//! What J reaches over simulated fault-free drives.
//!
//! The nonlinear vehicle (1)-(2), integrated by Runge-Kutta steps of at most 1 ms, drives a detector
//! with the gains under design; samples count while it monitors. The vehicle is the specified one, on
//! a flat road in still air; or an uncertain one, drawn anew for each drive, as are bank and gusts.
//!
//! # Conventions
//! Inputs are held from sample to sample; of a specification with an actuator the steering is its
//! command. The actuator's angle and the disturbances are held for an integration step; the sensors'
//! noise is that of the specification. Random numbers come from generators seeded with the drive's
//! number. The drive torque is that of a speed control: cruise torque and I_e times the speed error a
//! second.

use chacha20::ChaCha8Rng;
use chacha20::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal, Uniform};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};
use steerguard_detector::{
    Actuator, ActuatorState, Configuration, ConfigurationError, Detector, Evaluation, Gust, Input,
    Measurement, Monitor, Output, StateVector, Vehicle, rk4,
};

use crate::spec::{Manoeuvre, Noise, Spec, UncertaintyTable};
use crate::threshold::gust::Gusts;

/// Longest integration step, s.
const INTEGRATION_STEP_S: f64 = 1e-3;
/// Drives between two reports of progress.
const DRIVES_AT_A_TIME: usize = 128;
/// When the manoeuvres that are not periodic begin, s.
const MANOEUVRE_START_S: f64 = 1.0;
/// Length of a gust, and time between two, s.
const GUST_S: [f64; 2] = [0.5, 3.0];
const CALM_S: f64 = 1.0;
/// Confidence of [`Level::exceeded_at_most`].
const CONFIDENCE: f64 = 0.95;

/// One fault-free drive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Drive {
    /// Initial speed, held by the drive torque.
    pub v_x_m_per_s: f64,
    /// Initial lateral speed.
    pub v_y_m_per_s: f64,
    /// Course of the steering.
    pub manoeuvre: Manoeuvre,
    /// Steady-state lateral acceleration that the steering amplitude corresponds to.
    pub lateral_acceleration_m_per_s2: f64,
    /// What the disturbances do meanwhile.
    pub disturbance: Wave,
}

/// A cosine of every disturbance, each at its bound.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Wave {
    /// Frequency.
    pub hz: f64,
    /// Phase at the start.
    pub phase_rad: f64,
    /// Sign of each disturbance.
    pub signs: Vec<f64>,
}

impl Wave {
    /// Its value at time `t`, in [-1, 1].
    fn at(&self, t: f64) -> f64 {
        (TAU * self.hz * t + self.phase_rad).cos()
    }
}

/// Which vehicles are driven.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Population {
    /// The specified one, on a flat road in still air. The statistic is J less the start-up term.
    Specified,
    /// Vehicles, banks and gusts drawn evenly from what is uncertain. The statistic is J over J_th,
    /// each less the start-up term.
    Uncertain,
}

/// The largest statistic, and where it was met.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Level {
    /// Largest statistic of its [`Population`] at a monitored sample.
    pub level: f64,
    /// The drive that gave it.
    pub worst: Drive,
    /// Number of drives.
    pub drives: usize,
    /// Share of the samples at which the detector monitored.
    pub monitored: f64,
    /// With 95 % confidence, the probability that a further drive, picked from these and its random
    /// numbers drawn anew, exceeds the level is at most this: `1 - 0.05^(1/n)`, from the largest of n
    /// independent drives (Wilks 1941). Of drives that differ in their probability p_i, none exceeds it
    /// with probability `prod (1 - p_i) <= (1 - mean p_i)^n`, so it holds for their mean.
    pub exceeded_at_most: f64,
}

/// All drives that the specification asks for, in a fixed order.
pub fn drives(spec: &Spec) -> Vec<Drive> {
    let c = &spec.evaluation.calibration;
    let armed = spec.operating_range.range().shrunk(spec.operating_range.hysteresis()).v_x;
    let waves = waves(spec);

    let mut drives = Vec::new();
    for v_x_m_per_s in spread(armed.min, armed.max, c.speeds) {
        for (manoeuvre, lateral_acceleration_m_per_s2) in c.courses() {
            for disturbance in &waves {
                for &v_y_m_per_s in &c.initial_v_y_m_per_s {
                    drives.push(Drive {
                        v_x_m_per_s,
                        v_y_m_per_s,
                        manoeuvre,
                        lateral_acceleration_m_per_s2,
                        disturbance: disturbance.clone(),
                    });
                }
            }
        }
    }
    drives
}

/// Frequencies and phases of the disturbances; of several, every pattern of signs relative to the
/// first.
fn waves(spec: &Spec) -> Vec<Wave> {
    let c = &spec.evaluation.calibration;
    let band_hz = spec.disturbance.first().map_or([0.0, 0.0], |disturbance| disturbance.band_hz());
    let further = spec.disturbance.len().saturating_sub(1);
    let mut waves = Vec::new();
    for hz in spread(band_hz[0], band_hz[1], c.disturbance_frequencies) {
        for phase in 0..c.disturbance_phases {
            for pattern in 0..1_usize << further {
                let negative = |j: usize| (pattern >> j) & 1 == 1;
                let others = (0..further).map(|j| if negative(j) { -1.0 } else { 1.0 });
                waves.push(Wave {
                    hz,
                    phase_rad: TAU * phase as f64 / c.disturbance_phases as f64,
                    signs: std::iter::once(1.0).chain(others).collect(),
                });
            }
        }
    }
    waves
}

/// `count` values evenly spread from `min` to `max`; `min` alone for one.
fn spread(min: f64, max: f64, count: usize) -> impl Iterator<Item = f64> {
    let step = if count > 1 { (max - min) / (count - 1) as f64 } else { 0.0 };
    (0..count).map(move |k| min + step * k as f64)
}

/// Runs `drives` with a `population` of vehicles on all processors and returns the largest statistic;
/// `progress` hears how many are done. The result does not depend on the number of processors. None
/// without a monitored sample.
///
/// # Errors
/// [`ConfigurationError`] where the detector cannot run with `configuration`.
pub fn calibrate(
    spec: &Spec,
    configuration: &Configuration,
    drives: &[Drive],
    population: Population,
    progress: &mut dyn FnMut(usize),
) -> Result<Option<Level>, ConfigurationError> {
    let detector = Detector::new(configuration)?;
    let evaluation = &configuration.evaluation;
    let mut outcomes = Vec::with_capacity(drives.len());
    for part in drives.chunks(DRIVES_AT_A_TIME) {
        let done = outcomes.len();
        let drives = part.par_iter().enumerate();
        outcomes.par_extend(
            drives.map(|(k, drive)| run(spec, evaluation, detector, drive, done + k, population)),
        );
        progress(outcomes.len());
    }
    // Of equal levels the first drive's.
    let largest = outcomes.iter().zip(drives).fold(
        None,
        |largest: Option<(f64, &Drive)>, (x, drive)| match (x.level, largest) {
            (Some(level), Some((most, _))) if level <= most => largest,
            (Some(level), _) => Some((level, drive)),
            (None, _) => largest,
        },
    );
    let sum = |of: fn(&Outcome) -> u64| outcomes.iter().map(of).sum::<u64>() as f64;
    Ok(largest.map(|(level, worst)| Level {
        level,
        worst: worst.clone(),
        drives: drives.len(),
        monitored: sum(|x| x.monitored) / sum(|x| x.samples),
        exceeded_at_most: 1.0 - (1.0 - CONFIDENCE).powf(1.0 / drives.len() as f64),
    }))
}

/// What one drive gave.
struct Outcome {
    /// Largest statistic at a monitored sample.
    level: Option<f64>,
    monitored: u64,
    samples: u64,
}

/// Simulates drive number `index`, which seeds its sensor noise and its vehicle.
fn run(
    spec: &Spec,
    evaluation: &Evaluation,
    mut detector: Detector,
    drive: &Drive,
    index: usize,
    population: Population,
) -> Outcome {
    let world = match population {
        Population::Specified => World::specified(spec),
        Population::Uncertain => World::drawn(spec, index),
    };
    let t_s = spec.sampling.period_s;
    let steps = (t_s / INTEGRATION_STEP_S).ceil().max(1.0);
    let step = t_s / steps;
    let samples = (spec.evaluation.calibration.duration_s / t_s) as u64;
    let mut noise = SensorNoise::new(&spec.noise, index);
    let mut wheel = Wheel::new(&world.actuator, t_s, step);

    let mut x = [drive.v_x_m_per_s, drive.v_y_m_per_s, 0.0];
    let mut outcome = Outcome { level: None, monitored: 0, samples };
    for k in 0..samples {
        let t = k as f64 * t_s;
        let t_eng = spec.vehicle.cruise_torque(drive.v_x_m_per_s)
            + spec.vehicle.effective_longitudinal_inertia_kg_m * (drive.v_x_m_per_s - x[0]);
        let command = |k: u64| steering(spec, drive, k as f64 * t_s);

        let wave = drive.disturbance.at(t);
        let measured = Measurement {
            v_x_m_per_s: x[0] + noise.next(0, wave),
            r_rad_per_s: x[2] + noise.next(1, wave),
        };
        let output = detector.sample(measured, Input { t_eng_n_m: t_eng, delta_rad: command(k) });
        if output.monitor == Monitor::Monitoring {
            outcome.monitored += 1;
            let Output { j_rms, j_th, .. } = *output;
            let start_up_term = detector.state().start_up.term(evaluation);
            let level = match population {
                Population::Specified => j_rms - start_up_term,
                Population::Uncertain => (j_rms - start_up_term) / (j_th - start_up_term),
            };
            outcome.level = Some(outcome.level.map_or(level, |largest| largest.max(level)));
        }
        let delayed = command(k.saturating_sub(wheel.whole_samples));
        for inner in 0..steps as u32 {
            let delta = wheel.angle(delayed);
            let t = t + f64::from(inner) * step;
            let push = plus(disturbance(spec, drive, t), world.slope(t, x[0]));
            let u = Input { t_eng_n_m: t_eng, delta_rad: delta };
            x = rk4(|x| plus(world.vehicle.derivative(x.into(), u), push), x, step);
        }
    }
    outcome
}

/// Vehicle, road and air of one drive.
struct World {
    vehicle: Vehicle,
    actuator: Actuator,
    bank_m_per_s2: f64,
    /// How gusts act.
    gust: Gust,
    gusts: Gusts,
}

impl World {
    fn specified(spec: &Spec) -> Self {
        Self {
            vehicle: spec.vehicle,
            actuator: spec.actuator.actuator(),
            bank_m_per_s2: 0.0,
            gust: spec.uncertainty.gust(),
            gusts: Gusts::NONE,
        }
    }

    /// Draws those of drive number `index`.
    fn drawn(spec: &Spec, index: usize) -> Self {
        let mut generator = ChaCha8Rng::seed_from_u64(index as u64);
        // Stream 0 is the sensor noise.
        generator.set_stream(1);
        let mut between = |[min, max]: [f64; 2]| {
            // Evenly spread, ends included; of an interval without width, its only value.
            Uniform::new_inclusive(min, max).map_or(min, |range| range.sample(&mut generator))
        };
        let uncertainty = &spec.uncertainty;
        let [mass, yaw_inertia, front, rear] =
            uncertainty.intervals_percent().map(|interval| 1.0 + between(interval) / 100.0);
        let v = &spec.vehicle;
        let (bank_deg, gust) = (uncertainty.bank_deg, uncertainty.gust());
        let fastest = gust.speed_m_per_s;
        let actuator = spec.actuator.actuator();
        Self {
            vehicle: Vehicle {
                mass_kg: mass * v.mass_kg,
                effective_longitudinal_inertia_kg_m: mass * v.effective_longitudinal_inertia_kg_m,
                yaw_inertia_kg_m2: yaw_inertia * v.yaw_inertia_kg_m2,
                front_cornering_stiffness_n_per_rad: front * v.front_cornering_stiffness_n_per_rad,
                rear_cornering_stiffness_n_per_rad: rear * v.rear_cornering_stiffness_n_per_rad,
                ..*v
            },
            actuator: Actuator {
                lag_s: actuator.lag_s + between([0.0, uncertainty.actuator_lag_s]),
                delay_s: actuator.delay_s + between([0.0, uncertainty.actuator_delay_s]),
                ..actuator
            },
            bank_m_per_s2: UncertaintyTable::bank_m_per_s2(between([-bank_deg, bank_deg])),
            gust,
            gusts: Gusts {
                speed_m_per_s: between([-fastest, fastest]),
                duration_s: between(GUST_S),
                start_s: between([0.0, GUST_S[1]]),
                pause_s: CALM_S,
            },
        }
    }

    /// What road and air add to the state's derivative at time `t` and speed `v_x`.
    fn slope(&self, t: f64, v_x: f64) -> StateVector {
        let wind = Gust { speed_m_per_s: self.gusts.wind_m_per_s(t), ..self.gust };
        let force = wind.side_force(v_x);
        let v = &self.vehicle;
        [
            0.0,
            self.bank_m_per_s2 + force / v.mass_kg,
            wind.acting_ahead_m * force / v.yaw_inertia_kg_m2,
        ]
    }
}

/// The vehicle's actuator, an integration step at a time.
struct Wheel {
    /// Dead time in whole samples: the rest is left to the actuator.
    whole_samples: u64,
    actuator: Actuator,
    step_s: f64,
    state: ActuatorState,
}

impl Wheel {
    fn new(actuator: &Actuator, sampling_period_s: f64, step_s: f64) -> Self {
        let whole_samples = actuator.delay_samples(sampling_period_s);
        let rest_s = actuator.delay_s - whole_samples as f64 * sampling_period_s;
        Self {
            whole_samples: whole_samples as u64,
            actuator: Actuator { delay_s: rest_s.max(0.0), ..*actuator },
            step_s,
            state: ActuatorState::START,
        }
    }

    /// The average angle over the next step, under a command whole samples old.
    fn angle(&mut self, command: f64) -> f64 {
        self.state.sample(&self.actuator, self.step_s, command)
    }
}

/// Sensor noise of one drive: white, and what is bounded at its bound along the disturbances' wave.
struct SensorNoise {
    generator: ChaCha8Rng,
    white_std: [f64; 2],
    bounds: [f64; 2],
}

impl SensorNoise {
    fn new(noise: &Noise, drive: usize) -> Self {
        Self {
            generator: ChaCha8Rng::seed_from_u64(drive as u64),
            white_std: noise.white_std(),
            bounds: noise.bounds().map(|bound| bound.unwrap_or(0.0)),
        }
    }

    /// Noise of the next sample of a signal.
    fn next(&mut self, signal: usize, wave: f64) -> f64 {
        let white: f64 = StandardNormal.sample(&mut self.generator);
        self.white_std[signal] * white + self.bounds[signal] * wave
    }
}

fn plus(a: StateVector, b: StateVector) -> StateVector {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// Effect of the disturbances on the state's derivative at time `t`, every one at its bound.
fn disturbance(spec: &Spec, drive: &Drive, t: f64) -> StateVector {
    let wave = drive.disturbance.at(t);
    let channels = spec.disturbance.iter().zip(&drive.disturbance.signs);
    channels.fold([0.0; 3], |sum, (disturbance, sign)| {
        let amplitude = sign * disturbance.bound() * wave;
        plus(sum, disturbance.direction(&spec.vehicle).map(|x| amplitude * x))
    })
}

/// Road-wheel angle at time `t`, rad.
fn steering(spec: &Spec, drive: &Drive, t: f64) -> f64 {
    let rate = spec.evaluation.calibration.steering_rate_rad_per_s;
    let full = steady_angle(&spec.vehicle, drive.v_x_m_per_s, drive.lateral_acceleration_m_per_s2);
    let sine = |omega: f64, t: f64| full.min(rate / omega) * (omega * t).sin();
    let since = t - MANOEUVRE_START_S;
    match drive.manoeuvre {
        Manoeuvre::Straight => 0.0,
        Manoeuvre::Sine => sine(0.5, t),
        Manoeuvre::Weave => sine(TAU * 0.2, t),
        Manoeuvre::StepSteer => (rate * since).clamp(0.0, full),
        Manoeuvre::LaneChange => sine(PI, since.clamp(0.0, 2.0)),
    }
}

/// Road-wheel angle of a steady turn at speed `v_x` and lateral acceleration `a_y` of the linear
/// single-track model, rad, without sign: Rajamani (2012), 3.3.
pub fn steady_angle(vehicle: &Vehicle, v_x: f64, a_y: f64) -> f64 {
    let (l_f, l_r) = (vehicle.front_axle_distance_m, vehicle.rear_axle_distance_m);
    let (c_f, c_r) =
        (vehicle.front_cornering_stiffness_n_per_rad, vehicle.rear_cornering_stiffness_n_per_rad);
    let wheelbase = l_f + l_r;
    let understeer = vehicle.mass_kg * (c_r * l_r - c_f * l_f) / (2.0 * c_f * c_r * wheelbase);
    (a_y * (wheelbase / (v_x * v_x) + understeer)).abs()
}
