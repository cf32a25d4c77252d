//! What a run showed: time by state, alarms, how close J came.
//!
//! # Conventions
//! - Times are sample times, from the drive's first sample. An alarm is an episode: it begins where the alarm
//!   goes on. A gap ends it.
//! - Sizes are J/J_th, of an alarm of the second test that test's statistic over its threshold.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;
use steerguard_model_description::EnumerationType;
use steerguard_model_description::detector::{
    DetectorAlarmCause, DetectorState, DetectorStateCause,
};

use super::trace::TraceRow;
use crate::drive::detection::MONITORING;

/// An alarm.
#[derive(Clone, Debug, PartialEq, JsonSchema, Serialize)]
pub struct Alarm {
    /// When it was raised, s.
    pub time_s: f64,
    /// How long it stayed, s.
    pub duration_s: f64,
    /// The test that raised it.
    pub cause: &'static str,
    /// Its size when it was raised.
    pub size: f64,
    /// Its largest size.
    pub largest_size: f64,
    /// Speed when it was raised, m/s.
    pub v_x_m_per_s: f64,
}

/// Time in a state.
#[derive(Clone, Debug, PartialEq, JsonSchema, Serialize)]
pub struct StateTime {
    /// The state.
    pub state: &'static str,
    /// Which variable or limit held it.
    pub cause: &'static str,
    /// How long, s.
    pub time_s: f64,
}

/// What a run showed.
#[derive(Clone, Debug, PartialEq, JsonSchema, Serialize)]
pub struct Outcome {
    /// Time of all samples, s.
    pub driven_s: f64,
    /// Time monitored, s.
    pub monitored_s: f64,
    /// Its share, 0 to 1.
    pub monitored_share: f64,
    /// Share of the time monitored at which the smallest fault of interest could not be seen.
    pub not_excited_share: f64,
    /// Time by state and cause, longest first.
    pub states: Vec<StateTime>,
    /// The alarms.
    pub alarms: Vec<Alarm>,
    /// Largest J/J_th while it was monitoring; none where it never was.
    pub largest_ratio: Option<f64>,
    /// When that was, s.
    pub largest_ratio_s: Option<f64>,
    /// Largest statistic of the second test over its threshold; none where it does not run.
    pub largest_second_ratio: Option<f64>,
}

/// Gathers the outcome of a run.
#[derive(Clone, Debug, Default)]
pub(super) struct Tally {
    samples: u64,
    monitored: u64,
    not_excited: u64,
    states: BTreeMap<(i32, i32), u64>,
    alarms: Vec<Alarm>,
    /// Samples for which the alarm has stood; 0 where none stands.
    standing: u64,
    largest: Option<(f64, f64)>,
    largest_second: f64,
}

/// Item of `alarm_cause` of the second test.
const SECOND_TEST: i32 = DetectorAlarmCause::SecondTest.value();

impl Tally {
    /// Takes the next sample, of `period_s`.
    pub fn add(&mut self, row: &TraceRow, starts: bool, period_s: f64) {
        self.samples += 1;
        *self.states.entry((row.state, row.state_cause)).or_default() += 1;
        let ratio = row.j_rms / row.j_th;
        if row.state == MONITORING {
            self.monitored += 1;
            self.not_excited += u64::from(!row.excited);
            if self.largest.is_none_or(|(largest, _)| ratio > largest) {
                self.largest = Some((ratio, row.time));
            }
            self.largest_second = self.largest_second.max(row.second_ratio);
        }
        let size = if row.alarm_cause == SECOND_TEST { row.second_ratio } else { ratio };
        self.standing = match (row.alarm, starts) {
            (false, _) => 0,
            (true, true) => 1,
            (true, false) => self.standing + 1,
        };
        if self.standing == 1 {
            self.alarms.push(Alarm {
                time_s: row.time,
                duration_s: 0.0,
                cause: item(&DetectorAlarmCause::TYPE, row.alarm_cause),
                size,
                largest_size: size,
                v_x_m_per_s: row.v_x,
            });
        }
        if row.alarm
            && let Some(alarm) = self.alarms.last_mut()
        {
            alarm.duration_s = self.standing as f64 * period_s;
            alarm.largest_size = alarm.largest_size.max(size);
        }
    }

    /// The outcome, of samples every `period_s`.
    pub fn outcome(self, period_s: f64) -> Outcome {
        let time_s = |samples: u64| samples as f64 * period_s;
        let share = |part: u64, of: u64| part as f64 / of.max(1) as f64;
        let mut states: Vec<_> = self.states.iter().collect();
        states.sort_by_key(|(_, samples)| std::cmp::Reverse(**samples));
        let states = states.into_iter().map(|(&(state, cause), &samples)| StateTime {
            state: item(&DetectorState::TYPE, state),
            cause: item(&DetectorStateCause::TYPE, cause),
            time_s: time_s(samples),
        });
        Outcome {
            driven_s: time_s(self.samples),
            monitored_s: time_s(self.monitored),
            monitored_share: share(self.monitored, self.samples),
            not_excited_share: share(self.not_excited, self.monitored),
            states: states.collect(),
            alarms: self.alarms,
            largest_ratio: self.largest.map(|(ratio, _)| ratio),
            largest_ratio_s: self.largest.map(|(_, time_s)| time_s),
            largest_second_ratio: (self.largest_second > 0.0).then_some(self.largest_second),
        }
    }
}

/// Name of an item of an enumeration, from 1.
fn item(of: &EnumerationType, value: i32) -> &'static str {
    let place = usize::try_from(value - 1).ok();
    place.and_then(|place| of.items.get(place)).map_or("?", |item| item.name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn alarms_are_episodes_and_gaps_end_them() {
        let mut tally = Tally::default();
        let alarms = [0, 1, 1, 0, 1, 1, 1];
        for (k, alarm) in alarms.into_iter().enumerate() {
            let row = TraceRow {
                time: k as f64,
                alarm: alarm == 1,
                j_rms: k as f64,
                j_th: 2.0,
                state: if k == 0 { DetectorState::OutOfRange.value() } else { MONITORING },
                state_cause: if k == 0 { DetectorStateCause::SpeedX.value() } else { 1 },
                alarm_cause: DetectorAlarmCause::Residual.value(),
                ..TraceRow::default()
            };
            tally.add(&row, k == 0 || k == 6, 1.0);
        }
        let outcome = tally.outcome(1.0);
        let found: Vec<_> = outcome.alarms.iter().map(|a| (a.time_s, a.duration_s)).collect();
        assert_eq!(found, [(1.0, 2.0), (4.0, 2.0), (6.0, 1.0)]);
        assert_eq!(outcome.alarms[1].cause, "Residual");
        assert_eq!((outcome.alarms[1].size, outcome.alarms[1].largest_size), (2.0, 2.5));
        assert_eq!((outcome.largest_ratio, outcome.largest_ratio_s), (Some(3.0), Some(6.0)));
        assert_eq!((outcome.driven_s, outcome.monitored_s), (7.0, 6.0));
        let state = &outcome.states[1];
        assert_eq!((state.state, state.cause, state.time_s), ("OutOfRange", "SpeedX", 1.0));
        assert_eq!(outcome.largest_second_ratio, None);
    }
}
