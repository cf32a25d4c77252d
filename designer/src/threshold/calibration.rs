//! What J reaches over simulated fault-free drives.
//!
//! A vehicle of the simulated [world](steerguard_world) drives a detector with the gains under design;
//! samples count while it monitors. The vehicle is the specified one, on a flat road in still air; or an
//! uncertain one, drawn anew for each drive, as are bank and gusts.
//!
//! # Conventions
//! Those of [`crate::simulation`]. Random numbers are those of the drive's number as seed.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use steerguard_detector::{
    Actuator, Configuration, ConfigurationError, Detector, Evaluation, Monitor, Output,
    StateVector, Vehicle, VehicleState,
};
use steerguard_world::{
    CALM_S, Course, GUST_S, Gusts, Plan, Steering, Stream, TrueVehicle, Tyres, Wind, World,
};

use crate::simulation::{Acting, Sampled, Simulation, Surroundings, plus};
use crate::spec::{Manoeuvre, Spec, UncertaintyTable};

/// Drives between two reports of progress.
const DRIVES_AT_A_TIME: usize = 128;
/// When manoeuvres begin, and time between two runs of one, s.
const MANOEUVRE_START_S: f64 = 1.0;
const MANOEUVRE_PAUSE_S: f64 = 2.0;
/// Stream of the random numbers of vehicle, road and air; those before are the sensors'.
const SURROUNDINGS_STREAM: u64 = 2;
/// Share of the seconds in which an estimate of the second test would stay within its bound.
const SHARE_BELOW: f64 = 0.99;
/// Confidence of [`exceeded_at_most`].
const CONFIDENCE: f64 = 0.95;

/// One fault-free drive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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
        libm::cos(TAU * self.hz * t + self.phase_rad)
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

/// The largest statistics over drives.
#[derive(Clone, Debug, PartialEq)]
pub struct Levels {
    /// Of J: see [`Population`].
    pub j: Level,
    /// Of the second test, over its threshold, where it runs, and what it stays below in 99 of 100 seconds.
    pub second: Option<(Level, f64)>,
}

/// The largest statistic, and where it was met.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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
    let initial_v_y_m_per_s = c.initial_v_y_in(spec.operating_range.v_y_m_per_s);

    let mut drives = Vec::new();
    for v_x_m_per_s in spread(armed.min, armed.max, c.speeds) {
        for (manoeuvre, lateral_acceleration_m_per_s2) in c.courses() {
            for disturbance in &waves {
                for &v_y_m_per_s in &initial_v_y_m_per_s {
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
) -> Result<Option<Levels>, ConfigurationError> {
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
    let sum = |of: fn(&Outcome) -> u64| outcomes.iter().map(of).sum::<u64>() as f64;
    let largest = |statistic: fn(&Outcome) -> Option<f64>| {
        // Of equal levels the first drive's.
        let largest =
            outcomes.iter().zip(drives).fold(None, |largest: Option<(f64, &Drive)>, (x, drive)| {
                match (statistic(x), largest) {
                    (Some(level), Some((most, _))) if level <= most => largest,
                    (Some(level), _) => Some((level, drive)),
                    (None, _) => largest,
                }
            });
        largest.map(|(level, worst)| Level {
            level,
            worst: worst.clone(),
            drives: drives.len(),
            monitored: sum(|x| x.largest.monitored) / sum(|x| x.samples),
            exceeded_at_most: exceeded_at_most(drives.len()),
        })
    };
    let second = largest(|x| x.largest.second).filter(|_| configuration.estimator.is_some());
    let by_second = || outcomes.iter().flat_map(|x| x.second_by_second.iter().copied());
    let second = second.map(|level| (level, quantile(by_second())));
    Ok(largest(|x| x.largest.level).map(|j| Levels { j, second }))
}

/// [`Level::exceeded_at_most`] of the largest of so many drives.
pub fn exceeded_at_most(drives: usize) -> f64 {
    1.0 - (1.0 - CONFIDENCE).powf(1.0 / drives as f64)
}

/// What [`SHARE_BELOW`] of `values` are at most, the least that is.
fn quantile(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let rank = (SHARE_BELOW * values.len() as f64).ceil() as usize;
    values.get(rank.saturating_sub(1)).copied().unwrap_or_default()
}

/// The statistic of the worst drive behind `level`, of the specified vehicle, driven once more with what
/// `spec` says of disturbances and noise. None without a monitored sample.
///
/// # Errors
/// As [`calibrate`].
pub fn worst_again(
    spec: &Spec,
    configuration: &Configuration,
    level: &Level,
) -> Result<Option<f64>, ConfigurationError> {
    let detector = Detector::new(configuration)?;
    let index = drives(spec).iter().position(|drive| *drive == level.worst).unwrap_or_default();
    let population = Population::Specified;
    Ok(run(spec, &configuration.evaluation, detector, &level.worst, index, population)
        .largest
        .level)
}

/// What one drive gave.
struct Outcome {
    largest: Largest,
    /// The second test's largest statistic over its threshold in each second with a monitored sample.
    second_by_second: Vec<f64>,
    samples: u64,
}

/// The largest statistics of a drive so far.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Largest {
    /// Of its [`Population`], at a monitored sample.
    pub level: Option<f64>,
    /// Of the second test.
    pub second: Option<f64>,
    /// Monitored samples.
    pub monitored: u64,
}

impl Largest {
    /// Counts the sample that `detector` took last, evaluated as `evaluation` says.
    pub fn add(&mut self, detector: &Detector, evaluation: &Evaluation, population: Population) {
        let Output { monitor, j_rms, j_th, second_ratio, .. } = *detector.output();
        if monitor == Monitor::Monitoring {
            self.monitored += 1;
            let start_up_term = detector.state().start_up.term(evaluation);
            let level = match population {
                Population::Specified => j_rms - start_up_term,
                Population::Uncertain => (j_rms - start_up_term) / (j_th - start_up_term),
            };
            let larger = |largest: Option<f64>, x| Some(largest.map_or(x, |y: f64| y.max(x)));
            self.level = larger(self.level, level);
            self.second = larger(self.second, second_ratio);
        }
    }
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
    let (surroundings, wind) = match population {
        Population::Specified => (Surroundings::specified(spec), None),
        Population::Uncertain => {
            let (surroundings, wind) = drawn(spec, index);
            (surroundings, Some(wind))
        }
    };
    let t_s = spec.sampling.period_s;
    let samples = (spec.evaluation.calibration.duration_s / t_s) as u64;
    let simulation = Simulation {
        sensors: surroundings.sensors(&spec.noise, t_s, index as u64),
        surroundings,
        course: course(spec, drive),
        start: VehicleState {
            v_x_m_per_s: drive.v_x_m_per_s,
            v_y_m_per_s: drive.v_y_m_per_s,
            r_rad_per_s: 0.0,
        },
        period_s: t_s,
        samples,
    };
    let mut largest = Largest::default();
    let mut second_by_second = Vec::new();
    let mut of_this_second = Largest::default();
    let a_second = ((1.0 / t_s) as u64).max(1);
    let mut taken = 0;
    simulation.run(
        &mut detector,
        &Disturbed { spec, drive, wind },
        |&Sampled { detector, .. }| {
            largest.add(detector, evaluation, population);
            of_this_second.add(detector, evaluation, population);
            taken += 1;
            if taken % a_second == 0 {
                second_by_second.extend(std::mem::take(&mut of_this_second).second);
            }
        },
    );
    Outcome { largest, second_by_second, samples }
}

/// Draws surroundings and wind of drive number `index`.
pub(super) fn drawn(spec: &Spec, index: usize) -> (Surroundings, Wind) {
    let stream = Stream::new(index as u64, SURROUNDINGS_STREAM);
    let mut numbers = 0..;
    let mut between = |interval| stream.uniform(numbers.next().unwrap_or_default(), interval);
    let uncertainty = &spec.uncertainty;
    let factors = uncertainty.intervals_percent().map(|interval| 1.0 + between(interval) / 100.0);
    let vehicle = UncertaintyTable::vehicle(&spec.vehicle, factors);
    let (bank_deg, action) = (uncertainty.bank_deg, uncertainty.gust());
    let fastest = action.speed_m_per_s;
    let actuator = spec.actuator.actuator();
    let actuator = Actuator {
        lag_s: actuator.lag_s + between([0.0, uncertainty.actuator_lag_s]),
        delay_s: actuator.delay_s + between([0.0, uncertainty.actuator_delay_s]),
        ..actuator
    };
    let bank_rad = between([-bank_deg, bank_deg]).to_radians();
    let gusts = Gusts {
        speed_m_per_s: between([-fastest, fastest]),
        duration_s: between(GUST_S),
        start_s: between(CALM_S),
        pause_s: between(CALM_S),
    };
    let either = |most: f64| [-most, most];
    let zero = spec.sensors.zero();
    let steering = Steering {
        actuator,
        ratio: 1.0 / (1.0 + between(uncertainty.steering_ratio_percent) / 100.0),
        offset_rad: zero.steering_offset_rad
            + between(either(uncertainty.steering_offset_deg)).to_radians(),
    };
    let yaw_rate_bias_rad_per_s = zero.yaw_rate_bias_rad_per_s
        + between(either(uncertainty.yaw_rate_bias_deg_per_s)).to_radians();
    let v_x_scale = between(either(uncertainty.v_x_scale_percent)) / 100.0;
    let transfer = 1.0 + between(either(uncertainty.load_transfer_percent)) / 100.0;
    let friction = between(uncertainty.friction);
    let tyres =
        if uncertainty.tyres_end() { Tyres::Saturating { friction } } else { Tyres::Linear };
    let data = Vehicle {
        centre_of_gravity_height_m: transfer * vehicle.centre_of_gravity_height_m,
        ..vehicle
    };
    let surroundings = Surroundings {
        world: World { bank_rad, ..World::of(TrueVehicle { data, tyres }, steering) },
        v_x_scale,
        yaw_rate_bias_rad_per_s,
    };
    (surroundings, Wind { gusts, action })
}

/// What acts in a drive: every disturbance and every bounded noise at its bound, along the same wave; and
/// wind.
struct Disturbed<'a> {
    spec: &'a Spec,
    drive: &'a Drive,
    wind: Option<Wind>,
}

impl Acting for Disturbed<'_> {
    fn on_body(&self, t: f64, v_x: f64) -> [f64; 2] {
        self.wind.map_or([0.0; 2], |wind| wind.side_force_and_yaw_moment(t, v_x))
    }

    fn on_measurement(&self, t: f64) -> [f64; 2] {
        let wave = self.drive.disturbance.at(t);
        self.spec.noise.bounds().map(|bound| bound.unwrap_or(0.0) * wave)
    }

    fn on_vehicle(&self, t: f64) -> StateVector {
        let Self { spec, drive, .. } = self;
        let wave = drive.disturbance.at(t);
        let channels = spec.disturbance.iter().zip(&drive.disturbance.signs);
        channels.fold([0.0; 3], |sum, (disturbance, sign)| {
            let amplitude = sign * disturbance.bound() * wave;
            plus(sum, disturbance.direction(&spec.vehicle).map(|x| amplitude * x))
        })
    }
}

/// Steering and speed of `drive`.
fn course(spec: &Spec, drive: &Drive) -> Course {
    let plan = Plan {
        manoeuvre: match drive.manoeuvre {
            Manoeuvre::Straight => steerguard_world::Manoeuvre::Straight,
            Manoeuvre::Sine => steerguard_world::Manoeuvre::Sine,
            Manoeuvre::Weave => steerguard_world::Manoeuvre::Weave,
            Manoeuvre::StepSteer => steerguard_world::Manoeuvre::StepSteer,
            Manoeuvre::LaneChange => steerguard_world::Manoeuvre::LaneChange,
        },
        speed_m_per_s: drive.v_x_m_per_s,
        lateral_acceleration_m_per_s2: drive.lateral_acceleration_m_per_s2,
        start_s: MANOEUVRE_START_S,
        pause_s: MANOEUVRE_PAUSE_S,
    };
    Course::new(&plan, &spec.vehicle, spec.evaluation.calibration.steering_rate_rad_per_s)
}
