//! What a design sees: its detector driven with faults in the one world.
//!
//! A certificate is not sight: a fault may move the estimate out of its range, or drown in what the
//! threshold must bear. So every design drives itself, the vehicle as specified under the stated noise,
//! straight ahead and in a steady turn, and a bias of the road wheel begins once the observer has
//! settled.
//!
//! # Conventions
//! - A fault is *seen* where, for either sign, no alarm stands when it begins, one comes, and stays to the
//!   end of the drive. Delays are those of the later sign.
//! - A design is *blind* where the smallest fault of interest is missed straight ahead, at any speed.
//!   Turns are reported, not judged.
//! - Where the first fault is one of the drive torque nothing is driven.

pub mod equivalent;
mod hidden;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use steerguard_detector::{Configuration, ConfigurationError, Detector, Monitor, VehicleState};
use steerguard_world::{Course, Fault, FaultKind, Manoeuvre, Plan, TrueVehicle, Tyres};

use crate::sight::equivalent::bank_and_wind_rad;
pub use crate::sight::hidden::HiddenBy;
use crate::sight::hidden::{Missed, hidden_by};
use crate::simulation::{Acting, Sampled, Simulation, Surroundings};
use crate::spec::{self, Spec};
use crate::threshold::{Threshold, steady_points};

/// Sizes that are driven between the smallest of interest and the largest, deg.
const SIZES_DEG: [f64; 2] = [2.0, 5.0];
/// When the turn begins, and the fault, and for how long that lasts, s; all but the first longer where
/// the window is longer than [`WINDOW_S`].
const TURN_S: f64 = 1.0;
const ONSET_S: f64 = 4.0;
const FAULT_S: f64 = 3.0;
const WINDOW_S: f64 = 0.4;
/// The size from which faults are seen is looked for down to this share of the smallest of interest.
const FINEST: f64 = 0.01;
/// Halvings of its interval, on a logarithmic scale.
const HALVINGS: u32 = 10;

/// What a design sees.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Sight {
    /// When the faults begin.
    pub onset_s: f64,
    /// When the drives end.
    pub end_s: f64,
    /// Every course that was driven.
    pub courses: Vec<CourseSight>,
    /// F: the angle that bank and gust at their bounds look like together, see [`equivalent`]. Between two
    /// vehicles it counts twice.
    pub bank_and_wind_deg: f64,
    /// Why the design is blind; null where it is not.
    pub blind: Option<Blindness>,
}

/// What is seen on one course.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct CourseSight {
    /// Speed.
    pub v_x_m_per_s: f64,
    /// Lateral acceleration; 0 straight ahead.
    pub lateral_acceleration_m_per_s2: f64,
    /// Smallest size that is seen, looked for below the smallest of `faults` that is; null where none is.
    pub seen_from_deg: Option<f64>,
    /// Every fault that was driven, the smallest of interest first.
    pub faults: Vec<FaultSight>,
}

impl CourseSight {
    /// Whether the verdict rests on it.
    pub fn is_judged(&self) -> bool {
        self.lateral_acceleration_m_per_s2 == 0.0
    }
}

/// What becomes of one fault on one course, of the worse sign.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct FaultSight {
    /// Its size.
    pub fault_deg: f64,
    /// Whether it is seen.
    pub seen: bool,
    /// From the onset to the alarm; null where there was none.
    pub delay_s: Option<f64>,
    /// Whether there was an alarm before the onset.
    pub false_alarm: bool,
    /// Share of the samples from the onset on at which the detector monitored.
    pub monitored: f64,
}

/// Why a design is blind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Blindness {
    /// The size from which on faults are seen straight ahead at every speed; null where none is.
    pub seen_from_deg: Option<f64>,
    /// What raises the threshold most where the smallest fault is missed; null where it is not the threshold
    /// that hides it.
    pub hidden_by: Option<HiddenBy>,
}

impl Sight {
    /// Smallest size of a fault that can be told from bank and wind between any two vehicles and roads
    /// within their bounds, if that is more than `smallest_deg`.
    pub fn told_from_deg(&self, smallest_deg: f64) -> Option<f64> {
        Some(2.0 * self.bank_and_wind_deg).filter(|&told_deg| told_deg > smallest_deg)
    }
}

/// What the detector with `configuration` and `threshold` that is designed for `spec` sees; none for a
/// fault of the drive torque.
///
/// # Errors
/// [`ConfigurationError`] where the detector cannot run with `configuration`.
pub fn sight(
    spec: &Spec,
    configuration: &Configuration,
    threshold: &Threshold,
) -> Result<Option<Sight>, ConfigurationError> {
    let spec::Fault::Steering { smallest_deg, largest_deg, .. } = spec.fault[0] else {
        return Ok(None);
    };
    let test = Test::new(spec, configuration)?;
    let mut sizes_deg = vec![smallest_deg];
    let between = |size_deg: &f64| smallest_deg < *size_deg && *size_deg < largest_deg;
    sizes_deg.extend(SIZES_DEG.into_iter().filter(between));
    sizes_deg.extend(Some(largest_deg).filter(|&largest_deg| largest_deg > smallest_deg));
    let courses: Vec<CourseSight> = steady_points(configuration)
        .into_par_iter()
        .enumerate()
        .map(|(number, point)| test.course(point, number, &sizes_deg))
        .collect();

    let judged = || courses.iter().filter(|course| course.is_judged());
    let missed: Vec<&CourseSight> = judged().filter(|course| !course.faults[0].seen).collect();
    let blind = if missed.is_empty() {
        None
    } else {
        let missed_at: Vec<Missed> = missed
            .iter()
            .map(|course| Missed {
                v_x_m_per_s: course.v_x_m_per_s,
                false_alarm: course.faults[0].false_alarm,
            })
            .collect();
        let sees = |spec: &Spec, configuration: &Configuration| {
            Ok(Test::new(spec, configuration)?.sees_the_smallest(configuration))
        };
        let largest = |most: f64, course: &CourseSight| Some(most.max(course.seen_from_deg?));
        Some(Blindness {
            seen_from_deg: judged().try_fold(0.0, largest),
            hidden_by: hidden_by(spec, configuration, threshold, &missed_at, sees)?,
        })
    };
    Ok(Some(Sight {
        onset_s: test.onset_s,
        end_s: test.onset_s + test.fault_s,
        courses,
        bank_and_wind_deg: bank_and_wind_rad(configuration).to_degrees(),
        blind,
    }))
}

/// A sample of a drive of the verdict.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Time from the start, s.
    pub time_s: f64,
    /// J.
    pub j_rms: f64,
    /// J_th.
    pub j_th: f64,
    /// Whether the alarm is on.
    pub alarm: bool,
}

/// What the detector with `configuration` gives, sample by sample, on course `number` of [`steady_points`] as the
/// verdict drives it: the fault of `fault_deg` begins at [`Sight::onset_s`].
///
/// # Errors
/// [`ConfigurationError`] where the detector cannot run with `configuration`.
pub fn course(
    spec: &Spec,
    configuration: &Configuration,
    number: usize,
    fault_deg: f64,
) -> Result<Vec<Moment>, ConfigurationError> {
    let test = Test::new(spec, configuration)?;
    let mut moments = Vec::new();
    let points = steady_points(configuration);
    let Some(&point) = points.get(number) else {
        return Ok(moments);
    };
    test.run(point, number, fault_deg, |sampled| {
        let output = sampled.detector.output();
        moments.push(Moment {
            time_s: sampled.number as f64 * spec.sampling.period_s,
            j_rms: output.j_rms,
            j_th: output.j_th,
            alarm: output.alarm,
        });
    });
    Ok(moments)
}

/// Drives with faults.
struct Test<'a> {
    spec: &'a Spec,
    detector: Detector,
    onset_s: f64,
    fault_s: f64,
}

impl Acting for Fault {
    fn fault_rad(&self, t: f64) -> f64 {
        // A bias does not ask for the healthy angle.
        self.angle_rad(t, |_| 0.0)
    }
}

impl<'a> Test<'a> {
    fn new(spec: &'a Spec, configuration: &Configuration) -> Result<Self, ConfigurationError> {
        let period_s = configuration.model.sampling_period_s;
        let evaluation = &configuration.evaluation;
        let longer = (evaluation.window as f64 * period_s / WINDOW_S).max(1.0);
        let debounce_s = f64::from(evaluation.debounce_samples) * period_s;
        Ok(Self {
            spec,
            detector: Detector::new(configuration)?,
            onset_s: longer * ONSET_S,
            fault_s: longer * FAULT_S + debounce_s,
        })
    }

    /// Whether the smallest fault of interest is seen straight ahead at every speed.
    fn sees_the_smallest(&self, configuration: &Configuration) -> bool {
        let smallest_deg = self.spec.fault[0].smallest().to_degrees();
        let points = steady_points(configuration).into_iter().enumerate();
        let mut straight = points.filter(|(_, [_, a_y])| *a_y == 0.0);
        straight.all(|(number, point)| self.fault(point, number, smallest_deg).seen)
    }

    /// What is seen on course `number`, at speed and lateral acceleration `point`, of faults of
    /// `sizes_deg`, the smallest of interest first.
    fn course(&self, point: [f64; 2], number: usize, sizes_deg: &[f64]) -> CourseSight {
        let faults: Vec<FaultSight> =
            sizes_deg.iter().map(|&size_deg| self.fault(point, number, size_deg)).collect();
        let seen = |size_deg: f64| self.fault(point, number, size_deg).seen;
        let [v_x_m_per_s, lateral_acceleration_m_per_s2] = point;
        CourseSight {
            v_x_m_per_s,
            lateral_acceleration_m_per_s2,
            seen_from_deg: seen_from(&faults, seen),
            faults,
        }
    }

    /// What becomes of a fault of either sign on course `number`, which seeds the sensors' noise.
    fn fault(&self, point: [f64; 2], number: usize, fault_deg: f64) -> FaultSight {
        let [left, right] = [1.0, -1.0].map(|sign| self.drive(point, number, sign * fault_deg));
        FaultSight {
            fault_deg,
            seen: left.seen && right.seen,
            delay_s: left.delay_s.zip(right.delay_s).map(|(a, b)| f64::max(a, b)),
            false_alarm: left.false_alarm || right.false_alarm,
            monitored: left.monitored.min(right.monitored),
        }
    }

    fn drive(&self, point: [f64; 2], number: usize, fault_deg: f64) -> FaultSight {
        let period_s = self.spec.sampling.period_s;
        let [onset, samples] = self.onset_and_end();
        let mut false_alarm = false;
        let (mut raised, mut monitored) = (None, 0);
        let (mut stands, mut lasts) = (false, true);
        self.run(point, number, fault_deg, |&Sampled { number: k, detector, .. }| {
            let alarm = detector.output().alarm;
            // The sample at the onset does not know of the fault yet.
            if k <= onset {
                false_alarm |= alarm;
                stands = alarm;
                return;
            }
            monitored += u64::from(detector.output().monitor == Monitor::Monitoring);
            match (alarm, raised) {
                (true, None) => raised = Some(k - onset),
                (false, Some(_)) => lasts = false,
                _ => {}
            }
        });
        FaultSight {
            fault_deg,
            seen: !stands && lasts && raised.is_some(),
            delay_s: raised.filter(|_| !stands).map(|samples| samples as f64 * period_s),
            false_alarm,
            monitored: monitored as f64 / (samples - onset - 1).max(1) as f64,
        }
    }

    /// The sample at which the fault begins, and their number.
    fn onset_and_end(&self) -> [u64; 2] {
        let in_samples = |time_s: f64| (time_s / self.spec.sampling.period_s).ceil() as u64;
        let onset = in_samples(self.onset_s);
        [onset, onset + in_samples(self.fault_s)]
    }

    /// Drives course `number`, which seeds the sensors' noise, with a fault.
    fn run(
        &self,
        [v_x, a_y]: [f64; 2],
        number: usize,
        fault_deg: f64,
        sampled: impl FnMut(&Sampled<'_>),
    ) {
        let spec = self.spec;
        let period_s = spec.sampling.period_s;
        let plan = Plan {
            manoeuvre: if a_y == 0.0 { Manoeuvre::Straight } else { Manoeuvre::SteadyTurn },
            speed_m_per_s: v_x,
            lateral_acceleration_m_per_s2: a_y,
            start_s: TURN_S,
            pause_s: 0.0,
        };
        let mut surroundings = Surroundings::specified(spec);
        surroundings.world.vehicle = TrueVehicle { data: spec.vehicle, tyres: tyres(spec) };
        let [onset, samples] = self.onset_and_end();
        let simulation = Simulation {
            sensors: surroundings.sensors(&spec.noise, period_s, number as u64),
            surroundings,
            course: Course::new(
                &plan,
                &spec.vehicle,
                spec.evaluation.calibration.steering_rate_rad_per_s,
            ),
            start: VehicleState { v_x_m_per_s: v_x, v_y_m_per_s: 0.0, r_rad_per_s: 0.0 },
            period_s,
            samples,
        };
        let onset_s = onset as f64 * period_s;
        let fault = Fault { onset_s, kind: FaultKind::Bias { angle_rad: fault_deg.to_radians() } };
        let mut detector = self.detector;
        simulation.run(&mut detector, &fault, sampled);
    }
}

/// Those of the specified vehicle: friction is in the middle of its interval.
fn tyres(spec: &Spec) -> Tyres {
    let [least, most] = spec.uncertainty.friction;
    if spec.uncertainty.tyres_end() {
        Tyres::Saturating { friction: 0.5 * (least + most) }
    } else {
        Tyres::Linear
    }
}

/// The smallest size that is `seen`, between the first of `faults` that is and the one before, or nothing.
fn seen_from(faults: &[FaultSight], seen: impl Fn(f64) -> bool) -> Option<f64> {
    let first = faults.iter().position(|fault| fault.seen)?;
    let mut most = faults[first].fault_deg;
    let mut least = if first > 0 { faults[first - 1].fault_deg } else { FINEST * most };
    for _ in 0..HALVINGS {
        let middle = (least * most).sqrt();
        if seen(middle) {
            most = middle;
        } else {
            least = middle;
        }
    }
    Some(most)
}
