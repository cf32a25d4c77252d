//! Communication points and the sample grid.
//!
//! Sample k is at `start + k period`, k an integer: no time is ever summed up here.

use crate::{Archive, Text};

/// Samples this close to the end of a step, in sample periods, belong to the next step.
const SAMPLE_TOLERANCE: f64 = 1e-6;
/// Relative error of a time that the importer has summed up step by step.
const TIME_TOLERANCE: f64 = 1e-9;
/// Largest distance from the start in sample periods: 348 years at 10 ms. Beyond it the floating-
/// point numbers of the grid come too close to each other.
const LONGEST_RUN: u64 = 1 << 40;

/// Why a communication step is refused.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StepRefusal {
    /// The step size is not positive, or a time is not finite.
    NotASpan,
    /// The step does not begin where the last one ended: that time, s.
    WrongPoint(f64),
    /// The step ends after the stop time: that time, s.
    PastStopTime(f64),
    /// The step ends further from the start than the grid reaches.
    TooFar,
}

impl StepRefusal {
    /// Says why a step of `size` s from `point` is refused.
    pub fn describe(self, point: f64, size: f64, text: &mut Text) {
        text.str("a step of ").real(size).str(" s from ").real(point).str(" s ");
        match self {
            Self::NotASpan => text.str("is not a positive, finite span of time"),
            Self::WrongPoint(expected) => {
                text.str("does not begin where the last one ended, at ").real(expected).str(" s")
            }
            Self::PastStopTime(stop) => text.str("ends after the stop time ").real(stop).str(" s"),
            Self::TooFar => text.str("ends too far from the start time"),
        };
    }
}

/// An accepted communication step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Where it begins, s.
    pub point: f64,
    /// Where it ends, s.
    pub end: f64,
    /// It begins noticeably, but by less than half a sample period, beside the end of the last one.
    pub displaced: bool,
}

/// Where a run stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clock {
    /// Start time, s: sample 0.
    pub start: f64,
    /// Stop time, s.
    pub stop: Option<f64>,
    /// Time up to which steps have succeeded, s.
    pub point: f64,
    /// Index of the next sample.
    pub next_sample: u64,
}

impl Clock {
    /// A run from `start` to `stop`, s, that has not begun.
    pub fn new(start: f64, stop: Option<f64>) -> Self {
        Self { start, stop, point: start, next_sample: 0 }
    }

    /// Judges a communication step of `size` s from `point`, of samples `period` s apart.
    ///
    /// # Errors
    /// Why it is refused.
    pub fn step(&self, point: f64, size: f64, period: f64) -> Result<Step, StepRefusal> {
        let end = point + size;
        if !(size > 0.0 && end.is_finite()) {
            return Err(StepRefusal::NotASpan);
        }
        let tolerance = |time: f64| (SAMPLE_TOLERANCE * period).max(TIME_TOLERANCE * time.abs());
        let displacement = (point - self.point).abs();
        if displacement > period / 2.0 {
            return Err(StepRefusal::WrongPoint(self.point));
        }
        if let Some(stop) = self.stop.filter(|stop| end > stop + tolerance(*stop)) {
            return Err(StepRefusal::PastStopTime(stop));
        }
        if end - self.start > LONGEST_RUN as f64 * period {
            return Err(StepRefusal::TooFar);
        }
        Ok(Step { point, end, displaced: displacement > tolerance(point) })
    }

    /// Time of the next sample, if it falls before `end`; s.
    pub fn sample_before(&self, end: f64, period: f64) -> Option<f64> {
        let time = self.start + self.next_sample as f64 * period;
        (time < end - SAMPLE_TOLERANCE * period).then_some(time)
    }

    /// All fields, for saving and restoring.
    pub fn archive(&mut self, archive: &mut Archive<'_>) {
        archive.finite(&mut self.start);
        archive.optional(&mut self.stop, |archive, stop| archive.finite(stop));
        archive.finite(&mut self.point);
        archive.u64(&mut self.next_sample);
        archive.require(self.next_sample <= LONGEST_RUN + 1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Samples that each of `steps` steps of `size` runs, with communication points as a master
    /// gets them that multiplies and one that sums up.
    fn samples(size: f64, steps: usize, period: f64, summed: bool) -> Vec<u64> {
        let mut clock = Clock::new(0.5, None);
        let mut point = 0.5;
        let mut runs = Vec::new();
        for i in 0..steps {
            let t = if summed { point } else { 0.5 + i as f64 * size };
            let step = clock.step(t, size, period).unwrap();
            assert!(!step.displaced);
            let before = clock.next_sample;
            while clock.sample_before(step.end, period).is_some() {
                clock.next_sample += 1;
            }
            runs.push(clock.next_sample - before);
            clock.point = step.end;
            point += size;
        }
        runs
    }

    #[test]
    fn every_sample_runs_once_in_the_step_it_falls_into() {
        for summed in [false, true] {
            assert_eq!(samples(0.01, 1000, 0.01, summed), [1; 1000]);
            assert_eq!(samples(0.02, 500, 0.01, summed), [2; 500]);
            assert_eq!(samples(0.08, 125, 0.01, summed), [8; 125]);
            let thirds = samples(0.01 / 3.0, 3000, 0.01, summed);
            assert!(thirds.chunks(3).all(|runs| runs == [1, 0, 0]));
            let sixtieths = samples(1.0 / 60.0, 3600, 0.01, summed);
            assert!(sixtieths.chunks(3).all(|runs| runs == [2, 2, 1]));
        }
    }

    #[test]
    fn steps_are_refused_with_the_reason() {
        let clock = Clock { point: 1.0, ..Clock::new(0.0, Some(2.0)) };
        let step = |point, size| clock.step(point, size, 0.01);
        for (point, size, refusal) in [
            (1.0, 0.0, StepRefusal::NotASpan),
            (1.0, -0.01, StepRefusal::NotASpan),
            (1.0, f64::NAN, StepRefusal::NotASpan),
            (1.0, f64::INFINITY, StepRefusal::NotASpan),
            (f64::NAN, 0.01, StepRefusal::NotASpan),
            (1.0051, 0.01, StepRefusal::WrongPoint(1.0)),
            (0.0, 0.01, StepRefusal::WrongPoint(1.0)),
            (1.0, 1.001, StepRefusal::PastStopTime(2.0)),
        ] {
            assert_eq!(step(point, size), Err(refusal));
        }
        assert!(step(1.0, 1.0 + 1e-10).is_ok());
        assert!(step(1.004, 0.01).unwrap().displaced);
        assert!(!step(1.0 + 1e-9, 0.01).unwrap().displaced);
        let endless = Clock::new(0.0, None);
        assert_eq!(endless.step(0.0, 1e300, 0.01), Err(StepRefusal::TooFar));
        assert!(endless.step(0.0, 1e9, 0.01).is_ok());
    }
}
