//! What a run shows: the fault's onset, the alarm, and how far J stays from the threshold.
//!
//! # Conventions
//! - Times are sample times: an alarm belongs to the sample it was raised at, one communication step
//!   before the importer sees it.

use schemars::JsonSchema;
use serde::Serialize;
use steerguard_model_description::detector::DetectorState;

use crate::drive::cosimulation::{Run, Sample};

/// Start-up of the observer: fault-free J is also reported without it, s.
pub const START_UP_S: f64 = 2.0;

/// Item of `DetectorState` while residual, J and alarm are valid.
pub(crate) const MONITORING: i32 = DetectorState::Monitoring.value();

/// The figures of one run.
#[derive(Clone, Debug, PartialEq, JsonSchema, Serialize)]
pub struct Detection {
    /// v_x(0), m/s.
    pub initial_speed_m_per_s: f64,
    /// Time of the first sample with a fault, s.
    pub fault_onset_s: Option<f64>,
    /// Time of the first sample with an alarm from then on, s.
    pub alarm_s: Option<f64>,
    /// From fault to alarm, s.
    pub delay_s: Option<f64>,
    /// Alarms raised before the fault.
    pub false_alarms: usize,
    /// Largest J before the fault.
    pub largest_fault_free_j: f64,
    /// The same without the first [`START_UP_S`].
    pub largest_fault_free_j_after_start_up: f64,
    /// Largest J/J_th before the fault while the detector was monitoring; null where it never was.
    pub largest_fault_free_ratio: Option<f64>,
    /// J_th of the last sample before the fault.
    pub threshold: f64,
    /// Largest J from the fault on.
    pub largest_faulty_j: f64,
    /// Share of the samples at which the detector was monitoring, 0 to 1.
    pub monitored_share: f64,
    /// Whether it was monitoring at the fault's onset.
    pub monitored_at_onset: bool,
}

impl Detection {
    /// Evaluates a run.
    pub fn of(run: &Run) -> Self {
        let samples = run.samples.as_slice();
        let onset = samples.iter().position(|sample| sample.fault != 0.0);
        let (before, after) = samples.split_at(onset.unwrap_or(samples.len()));
        let fault_onset_s = after.first().map(|sample| sample.time);
        let alarm_s = after.iter().find(|sample| sample.alarm).map(|sample| sample.time);
        let started = before.iter().filter(|sample| sample.time >= START_UP_S);
        let monitored = samples.iter().filter(|sample| sample.state == MONITORING).count();
        Self {
            initial_speed_m_per_s: run.initial_speed_m_per_s,
            fault_onset_s,
            alarm_s,
            delay_s: fault_onset_s.zip(alarm_s).map(|(onset, alarm)| alarm - onset),
            false_alarms: alarms_raised(before),
            largest_fault_free_j: largest_j(before.iter()),
            largest_fault_free_ratio: before
                .iter()
                .filter(|sample| sample.state == MONITORING)
                .map(|sample| sample.j_rms / sample.j_th)
                .reduce(f64::max),
            largest_fault_free_j_after_start_up: largest_j(started),
            threshold: before.last().or(samples.last()).map_or(0.0, |sample| sample.j_th),
            largest_faulty_j: largest_j(after.iter()),
            monitored_share: monitored as f64 / samples.len().max(1) as f64,
            monitored_at_onset: after.first().is_some_and(|sample| sample.state == MONITORING),
        }
    }

    /// Whether the run went as a detector owes it: no false alarm, and no fault missed whose onset
    /// it was monitoring.
    pub fn is_right(&self) -> bool {
        self.false_alarms == 0 && (self.alarm_s.is_some() || !self.monitored_at_onset)
    }
}

fn largest_j<'a>(samples: impl Iterator<Item = &'a Sample>) -> f64 {
    samples.map(|sample| sample.j_rms).fold(0.0, f64::max)
}

/// Number of times the alarm went on.
fn alarms_raised(samples: &[Sample]) -> usize {
    let raised = samples.windows(2).filter(|pair| matches!(pair, [a, b] if !a.alarm && b.alarm));
    raised.count() + usize::from(samples.first().is_some_and(|sample| sample.alarm))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(samples: &[(f64, bool, f64)]) -> Run {
        let sample = |(k, &(fault, alarm, j_rms)): (usize, &(f64, bool, f64))| Sample {
            time: k as f64,
            v_x: 10.0,
            r: 0.0,
            drive_torque: 0.0,
            steering_angle: 0.0,
            fault,
            side_force: 0.0,
            yaw_moment: 0.0,
            lateral_speed: 0.0,
            residual_v_x: 0.0,
            residual_r: 0.0,
            j_rms,
            j_th: 1.0,
            v_y_hat: 0.0,
            alarm,
            excited: true,
            state: MONITORING,
            state_cause: 1,
            ..Sample::default()
        };
        let samples = samples.iter().enumerate().map(sample).collect();
        Run { initial_speed_m_per_s: 10.0, step_s: 1.0, samples }
    }

    #[test]
    fn delay_counts_from_the_first_faulty_sample() {
        let detection = Detection::of(&run(&[
            (0.0, false, 0.9),
            (0.0, false, 0.1),
            (0.0, false, 0.2),
            (0.5, false, 0.5),
            (0.5, false, 0.9),
            (0.5, true, 3.0),
        ]));
        assert_eq!(detection.fault_onset_s, Some(3.0));
        assert_eq!(detection.delay_s, Some(2.0));
        assert_eq!(detection.false_alarms, 0);
        assert_eq!(detection.largest_fault_free_j, 0.9);
        assert_eq!(detection.largest_fault_free_ratio, Some(0.9));
        assert_eq!(detection.largest_fault_free_j_after_start_up, 0.2);
        assert_eq!(detection.largest_faulty_j, 3.0);
        assert!(detection.is_right());
    }

    #[test]
    fn false_alarms_count_as_episodes() {
        let detection = Detection::of(&run(&[
            (0.0, true, 2.0),
            (0.0, true, 2.0),
            (0.0, false, 0.0),
            (0.0, true, 2.0),
        ]));
        assert_eq!((detection.false_alarms, detection.fault_onset_s), (2, None));
        assert!(!detection.is_right());
    }

    #[test]
    fn a_missed_fault_counts_unless_the_detector_was_out_of_range() {
        let mut run = run(&[(0.0, false, 0.0), (0.5, false, 0.5)]);
        assert!(!Detection::of(&run).is_right());
        for sample in &mut run.samples {
            sample.state = DetectorState::OutOfRange.value();
        }
        assert!(Detection::of(&run).is_right());
    }
}
