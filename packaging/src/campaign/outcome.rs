//! What a drive showed: false alarms, whether and when its fault was detected, how close J came.
//!
//! # Conventions
//! - Times are sample times. An episode begins where the alarm goes on.
//! - A fault *acts* from the first sample on at which it changes the road-wheel angle: a wheel that
//!   sticks where it is commanded to be does not act yet. From then on until the end of the drive no
//!   alarm is false.
//! - A fault is *exposed* from the first sample on at which it acts, now or earlier, and the detector
//!   monitors. Delays count from there; `onset_delay_s` counts from the onset.
//! - It is *detected* if an episode begins once it is exposed, otherwise *missed*. Two kinds of faults
//!   are neither: those never exposed, and those *masked* by a false alarm that stood when they were
//!   exposed.
//! - The second test alone has raised an alarm where `alarm_cause` says so when an episode begins; without it the fault
//!   would have been detected at the first sample from exposure on at which J reaches J_th.
//! - The estimate of the fault is judged 0.2 s after exposure.
//! - An alarm counts as detection even if it would have come without the fault: where false alarms are
//!   frequent, small faults seem detected.

use steerguard_model_description::detector::{
    DetectorAlarmCause, DetectorState, DetectorStateCause,
};

use super::record::{named, record};
use crate::drive::cosimulation::Sample;
use crate::drive::detection::MONITORING;

named! {
    /// What became of the fault.
    pub enum Verdict {
        /// There was none.
        FaultFree = "fault-free",
        /// It never changed the road-wheel angle, or never while the detector monitored.
        NotExposed = "not exposed",
        /// A false alarm stood when it was exposed.
        Masked = "masked",
        /// An alarm followed.
        Detected = "detected",
        /// No alarm followed.
        Missed = "missed",
    }
}

record! {
    /// What a drive showed.
    pub struct Outcome {
        /// What became of the fault.
        pub verdict: Verdict,
        /// Episodes of the alarm that began before the fault acted.
        pub false_alarms: u32,
        /// Those of them that the second test alone raised.
        pub false_alarms_by_second: u32,
        /// Time that the detector monitored.
        pub monitored_s: f64,
        /// The same before the fault acted.
        pub monitored_fault_free_s: f64,
        /// Share of the samples at which the detector was out of range.
        pub out_of_range_share: f64,
        /// The same for the speed.
        pub out_of_range_v_x_share: f64,
        /// The same for the estimated lateral speed.
        pub out_of_range_v_y_share: f64,
        /// The same for the yaw rate.
        pub out_of_range_r_share: f64,
        /// Share of the samples at which its input was invalid.
        pub invalid_input_share: f64,
        /// Share of the time monitored at which the smallest fault of interest could not be seen.
        pub not_excited_share: f64,
        /// First sample at which the fault acted.
        pub acting_s: Option<f64>,
        /// First sample at which it was exposed.
        pub exposed_s: Option<f64>,
        /// First sample of the episode that detected it.
        pub alarm_s: Option<f64>,
        /// Time without alarm between the first alarm of an exposed fault and the end of the drive.
        pub interrupted_s: Option<f64>,
        /// From exposure to alarm.
        pub delay_s: Option<f64>,
        /// From onset to alarm.
        pub onset_delay_s: Option<f64>,
        /// From exposure to where J reaches J_th: the delay without the second test.
        pub residual_delay_s: Option<f64>,
        /// 1 if the second test alone raised the alarm that detected it, else 0.
        pub detected_by_second: Option<f64>,
        /// Largest angle that the fault added while the detector monitored.
        pub peak_fault_deg: Option<f64>,
        /// Largest J/J_th while the detector monitored before the fault acted.
        pub peak_ratio_before: Option<f64>,
        /// The same from then on.
        pub peak_ratio_after: Option<f64>,
        /// Largest statistic of the second test over its threshold while the detector monitored before the
        /// fault acted.
        pub peak_second_ratio_before: Option<f64>,
        /// The estimate of the fault less the fault, 0.2 s after exposure.
        pub estimate_error_deg: Option<f64>,
        /// The largest that this may be as the detector states it.
        pub estimate_bound_deg: Option<f64>,
    }
}

/// Age of a fault at which its estimate is judged, s.
const ESTIMATED_AFTER_S: f64 = 0.2;
/// What times may lack by rounding, s.
const ROUNDING_S: f64 = 1e-6;
/// Item of the enumeration `DetectorAlarmCause` of the second test.
const SECOND_TEST: i32 = DetectorAlarmCause::SecondTest.value();

/// Items of the enumeration `DetectorState` without valid results.
const OUT_OF_RANGE: i32 = DetectorState::OutOfRange.value();
const INVALID_INPUT: i32 = DetectorState::InvalidInput.value();
/// Items of the enumeration `DetectorStateCause`.
const SPEED: i32 = DetectorStateCause::SpeedX.value();
const LATERAL_SPEED: i32 = DetectorStateCause::LateralSpeed.value();
const YAW_RATE: i32 = DetectorStateCause::YawRate.value();

/// Gathers the outcome of a drive, sample by sample.
#[derive(Clone, Copy, Debug, Default)]
pub struct Observation {
    samples: u32,
    monitored: u32,
    monitored_fault_free: u32,
    not_excited: u32,
    out_of_range: u32,
    out_of_range_v_x: u32,
    out_of_range_v_y: u32,
    out_of_range_r: u32,
    invalid_input: u32,
    false_alarms: u32,
    /// The alarm of the last sample.
    alarm: bool,
    acting_s: Option<f64>,
    exposed_s: Option<f64>,
    masked: bool,
    alarm_s: Option<f64>,
    false_alarms_by_second: u32,
    detected_by_second: bool,
    residual_s: Option<f64>,
    peak_second_ratio_before: Option<f64>,
    /// Estimate less fault, and its bound, rad.
    estimate_rad: Option<[f64; 2]>,
    /// Samples without alarm since then.
    interrupted: u32,
    peak_fault_rad: f64,
    peak_ratio_before: Option<f64>,
    peak_ratio_after: Option<f64>,
}

impl Observation {
    /// Takes the next sample.
    pub fn add(&mut self, sample: &Sample) {
        self.samples += 1;
        if sample.fault != 0.0 {
            self.acting_s = self.acting_s.or(Some(sample.time));
        }
        match sample.state {
            MONITORING => self.add_monitored(sample),
            OUT_OF_RANGE => {
                self.out_of_range += 1;
                match sample.state_cause {
                    SPEED => self.out_of_range_v_x += 1,
                    LATERAL_SPEED => self.out_of_range_v_y += 1,
                    YAW_RATE => self.out_of_range_r += 1,
                    _ => {}
                }
            }
            INVALID_INPUT => self.invalid_input += 1,
            _ => {}
        }
        let begins = sample.alarm && !self.alarm;
        let by_second = sample.alarm_cause == SECOND_TEST;
        self.alarm = sample.alarm;
        if begins && self.acting_s.is_none() {
            self.false_alarms += 1;
            self.false_alarms_by_second += u32::from(by_second);
        } else if begins && self.exposed_s.is_some() && !self.masked && self.alarm_s.is_none() {
            self.alarm_s = Some(sample.time);
            self.detected_by_second = by_second;
        }
        if self.estimate_rad.is_none()
            && sample.fault_estimate_bound > 0.0
            && self.exposed_s.is_some_and(|s| sample.time >= s + ESTIMATED_AFTER_S - ROUNDING_S)
        {
            let error = sample.fault_estimate - sample.fault;
            self.estimate_rad = Some([error, sample.fault_estimate_bound]);
        }
        self.interrupted += u32::from(self.alarm_s.is_some() && !sample.alarm);
    }

    fn add_monitored(&mut self, sample: &Sample) {
        self.monitored += 1;
        self.not_excited += u32::from(!sample.excited);
        let ratio = sample.j_rms / sample.j_th;
        let peak = if self.acting_s.is_some() {
            if self.exposed_s.is_none() {
                self.exposed_s = Some(sample.time);
                self.masked = self.alarm && sample.alarm;
            }
            self.peak_fault_rad = self.peak_fault_rad.max(sample.fault.abs());
            if ratio >= 1.0 {
                self.residual_s = self.residual_s.or(Some(sample.time));
            }
            &mut self.peak_ratio_after
        } else {
            self.monitored_fault_free += 1;
            let second = sample.second_ratio;
            let peak = &mut self.peak_second_ratio_before;
            *peak = Some(peak.map_or(second, |peak| peak.max(second)));
            &mut self.peak_ratio_before
        };
        *peak = Some(peak.map_or(ratio, |peak| peak.max(ratio)));
    }

    /// The outcome of a drive sampled every `period_s` whose fault, if any, began at `onset_s`.
    pub fn outcome(&self, period_s: f64, onset_s: Option<f64>) -> Outcome {
        let share = |part: u32, of: u32| f64::from(part) / f64::from(of.max(1));
        let since = |begin_s: Option<f64>| Some(self.alarm_s? - begin_s?);
        let [error, bound] = [0, 1].map(|k| self.estimate_rad.map(|x| x[k].to_degrees()));
        Outcome {
            verdict: match (onset_s, self.exposed_s, self.alarm_s) {
                (None, ..) => Verdict::FaultFree,
                (_, None, _) => Verdict::NotExposed,
                _ if self.masked => Verdict::Masked,
                (.., Some(_)) => Verdict::Detected,
                (.., None) => Verdict::Missed,
            },
            false_alarms: self.false_alarms,
            false_alarms_by_second: self.false_alarms_by_second,
            monitored_s: f64::from(self.monitored) * period_s,
            monitored_fault_free_s: f64::from(self.monitored_fault_free) * period_s,
            out_of_range_share: share(self.out_of_range, self.samples),
            out_of_range_v_x_share: share(self.out_of_range_v_x, self.samples),
            out_of_range_v_y_share: share(self.out_of_range_v_y, self.samples),
            out_of_range_r_share: share(self.out_of_range_r, self.samples),
            invalid_input_share: share(self.invalid_input, self.samples),
            not_excited_share: share(self.not_excited, self.monitored),
            acting_s: self.acting_s,
            exposed_s: self.exposed_s,
            alarm_s: self.alarm_s,
            interrupted_s: self.alarm_s.map(|_| f64::from(self.interrupted) * period_s),
            delay_s: since(self.exposed_s),
            onset_delay_s: since(onset_s),
            residual_delay_s: self.residual_s.zip(self.exposed_s).map(|(s, begin_s)| s - begin_s),
            detected_by_second: self.alarm_s.map(|_| f64::from(u8::from(self.detected_by_second))),
            peak_fault_deg: self.exposed_s.map(|_| self.peak_fault_rad.to_degrees()),
            peak_ratio_before: self.peak_ratio_before,
            peak_ratio_after: self.peak_ratio_after,
            peak_second_ratio_before: self.peak_second_ratio_before,
            estimate_error_deg: error,
            estimate_bound_deg: bound,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The outcome of samples (fault in rad, alarm, state), one a second.
    fn outcome(samples: &[(f64, bool, i32)], onset_s: Option<f64>) -> Outcome {
        let mut observation = Observation::default();
        for (k, &(fault, alarm, state)) in samples.iter().enumerate() {
            let time = k as f64;
            let j_rms = if alarm { 2.0 } else { 0.5 };
            observation.add(&Sample {
                time,
                fault,
                alarm,
                state,
                j_rms,
                j_th: 1.0,
                ..Sample::default()
            });
        }
        observation.outcome(1.0, onset_s)
    }

    #[test]
    fn false_alarms_are_episodes_before_the_fault_acts() {
        let outcome = outcome(
            &[
                (0.0, true, 2),
                (0.0, true, 2),
                (0.0, false, 3),
                (0.0, true, 2),
                (0.1, false, 2),
                (0.1, true, 2),
            ],
            Some(2.0),
        );
        assert_eq!((outcome.false_alarms, outcome.verdict), (2, Verdict::Detected));
        assert_eq!((outcome.acting_s, outcome.delay_s), (Some(4.0), Some(1.0)));
        assert_eq!((outcome.onset_delay_s, outcome.monitored_fault_free_s), (Some(3.0), 3.0));
        assert_eq!((outcome.peak_ratio_before, outcome.peak_ratio_after), (Some(2.0), Some(2.0)));
        assert_eq!(outcome.out_of_range_share, 1.0 / 6.0);
    }

    #[test]
    fn a_standing_alarm_detects_nothing() {
        for last in [(0.1, true, 2), (0.1, false, 2)] {
            let samples = [(0.0, true, 2), (0.1, true, 2), last, (0.1, true, 2)];
            let outcome = outcome(&samples, Some(1.0));
            assert_eq!((outcome.false_alarms, outcome.verdict), (1, Verdict::Masked));
            assert_eq!((outcome.exposed_s, outcome.delay_s), (Some(1.0), None));
        }
    }

    #[test]
    fn an_alarm_that_goes_while_the_fault_stays_is_interrupted() {
        let samples = [(0.0, true, 2), (0.1, true, 2), (0.1, false, 3), (0.1, true, 2)];
        assert_eq!(outcome(&samples, Some(1.0)).interrupted_s, None, "masked");
        let samples = [(0.1, false, 2), (0.1, true, 2), (0.1, false, 2), (0.1, true, 3)];
        assert_eq!(outcome(&samples, Some(0.0)).interrupted_s, Some(1.0));
    }

    #[test]
    fn time_out_of_range_is_told_by_cause() {
        let mut observation = Observation::default();
        for state_cause in [SPEED, YAW_RATE, YAW_RATE, LATERAL_SPEED] {
            observation.add(&Sample { state: OUT_OF_RANGE, state_cause, ..Sample::default() });
        }
        let outcome = observation.outcome(1.0, None);
        let shares = [
            outcome.out_of_range_v_x_share,
            outcome.out_of_range_v_y_share,
            outcome.out_of_range_r_share,
        ];
        assert_eq!(shares, [0.25, 0.25, 0.5]);
    }

    #[test]
    fn without_an_alarm_a_fault_is_missed() {
        let samples = [(0.0, true, 2), (0.0, false, 2), (0.1, false, 2), (0.1, false, 3)];
        let outcome = outcome(&samples, Some(1.0));
        assert_eq!((outcome.false_alarms, outcome.verdict), (1, Verdict::Missed));
        assert_eq!(outcome.peak_fault_deg, Some(0.1_f64.to_degrees()));
    }

    #[test]
    fn a_fault_that_does_nothing_or_is_not_monitored_is_not_exposed() {
        for samples in [[(0.0, false, 2); 3], [(0.1, false, 3); 3]] {
            assert_eq!(outcome(&samples, Some(0.0)).verdict, Verdict::NotExposed);
        }
        let late = outcome(&[(0.1, false, 3), (0.0, false, 2), (0.0, true, 2)], Some(0.0));
        assert_eq!(
            (late.verdict, late.exposed_s, late.delay_s),
            (Verdict::Detected, Some(1.0), Some(1.0))
        );
    }

    #[test]
    fn what_is_not_excited_is_a_share_of_what_is_monitored() {
        let mut observation = Observation::default();
        assert_eq!(observation.outcome(1.0, None).not_excited_share, 0.0);
        for (excited, state) in
            [(false, 1), (false, 3), (false, 2), (true, 2), (true, 2), (true, 2)]
        {
            observation.add(&Sample { excited, state, ..Sample::default() });
        }
        assert_eq!(observation.outcome(1.0, None).not_excited_share, 0.25);
    }

    #[test]
    fn without_a_fault_there_is_no_delay() {
        let outcome = outcome(&[(0.0, false, 2)], None);
        assert_eq!((outcome.verdict, outcome.delay_s), (Verdict::FaultFree, None));
    }
}
