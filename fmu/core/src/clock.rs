//! Communication points and the sample grid.
//!
//! Sample k is at `start + k period`, k an integer: no time is ever summed up here.

use crate::{Archive, Text};

/// Samples this close to the end of a step, in sample periods, belong to the next step.
const SAMPLE_TOLERANCE: f64 = 1e-6;
/// Relative error of a time that the importer has summed up step by step.
const TIME_TOLERANCE: f64 = 1e-9;
/// Relative error that rounding makes in a sample's time and in the end of a step together.
const ROUNDING: f64 = 4.0 * f64::EPSILON;
/// Coarsest floating-point numbers that samples can be told apart with, in sample periods.
const COARSEST: f64 = 1e-3;
/// Most samples in a step: three hours at 10 ms.
const MOST_SAMPLES: u64 = 1_000_000;
/// Largest distance from the start in sample periods: 348 years at 10 ms. Beyond it the floating-
/// point numbers of the grid come too close to each other.
const LONGEST_RUN: u64 = 1 << 40;

/// Why there can be no such run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RunRefusal {
    /// A time is not finite, or the end lies before the start.
    NotASpan,
    /// At the start, floating-point numbers are too far apart to count samples by: how far, s.
    TooCoarse(f64),
}

impl RunRefusal {
    /// Says why a run from `start` to `stop`, s, of samples `period` s apart is refused.
    pub fn describe(self, start: f64, stop: Option<f64>, period: f64, text: &mut Text) {
        match self {
            Self::NotASpan => {
                text.str("no run can last from ").real(start).str(" s to ");
                text.real(stop.unwrap_or(f64::INFINITY)).str(" s");
            }
            Self::TooCoarse(apart) => {
                text.str("time cannot advance from ").real(start).str(" s: numbers there are ");
                text.real(apart).str(" s apart, samples ").real(period).str(" s");
            }
        }
    }
}

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
    /// More than a million samples fall into the step.
    TooManySamples,
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
            Self::TooManySamples => text
                .str("would run more than ")
                .integer(MOST_SAMPLES as i64)
                .str(" samples: take shorter ones"),
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
    /// A run from 0 s on that has not begun.
    pub const ZERO: Self = Self { start: 0.0, stop: None, point: 0.0, next_sample: 0 };

    /// A run from `start` to `stop`, s, of samples `period` s apart that has not begun. A run that
    /// would end where it starts has no end: importers without a stop time are known to say so.
    ///
    /// # Errors
    /// Why there can be no such run.
    pub fn new(start: f64, stop: Option<f64>, period: f64) -> Result<Self, RunRefusal> {
        if !start.is_finite() || stop.is_some_and(|stop| !(stop.is_finite() && stop >= start)) {
            return Err(RunRefusal::NotASpan);
        }
        let apart = spacing(start);
        if apart > COARSEST * period {
            return Err(RunRefusal::TooCoarse(apart));
        }
        let stop = stop.filter(|&stop| stop != start);
        Ok(Self { start, stop, point: start, next_sample: 0 })
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
        let tolerance = |time: f64| {
            (SAMPLE_TOLERANCE * period).max((TIME_TOLERANCE * time.abs()).min(period / 2.0))
        };
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
        if self.falls_before(self.next_sample.saturating_add(MOST_SAMPLES), end, period) {
            return Err(StepRefusal::TooManySamples);
        }
        Ok(Step { point, end, displaced: displacement > tolerance(point) })
    }

    /// Time of the next sample, if it falls before `end`; s.
    pub fn sample_before(&self, end: f64, period: f64) -> Option<f64> {
        self.falls_before(self.next_sample, end, period)
            .then(|| self.sample_time(self.next_sample, period))
    }

    fn sample_time(&self, sample: u64, period: f64) -> f64 {
        self.start + sample as f64 * period
    }

    /// Whether a sample falls into a step to `end` or an earlier one.
    fn falls_before(&self, sample: u64, end: f64, period: f64) -> bool {
        let tolerance = (SAMPLE_TOLERANCE * period).max(ROUNDING * end.abs());
        self.sample_time(sample, period) < end - tolerance
    }

    /// All fields, for saving and restoring a run of samples `period` s apart.
    pub fn archive(&mut self, period: f64, archive: &mut Archive<'_>) {
        archive.finite(&mut self.start);
        archive.optional(&mut self.stop, |archive, stop| archive.finite(stop));
        archive.finite(&mut self.point);
        archive.u64(&mut self.next_sample);
        archive.require(Self::new(self.start, self.stop, period).is_ok());
        archive.require(self.next_sample <= LONGEST_RUN + 1);
        // Or the next step would make up for them all.
        archive.require(!self.falls_before(self.next_sample, self.point, period));
    }
}

/// Distance from the magnitude of a time to the next larger number.
fn spacing(time: f64) -> f64 {
    let magnitude = time.abs();
    magnitude.next_up() - magnitude
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Samples that each of `steps` steps of `size` runs, with communication points as a master
    /// gets them that multiplies and one that sums up.
    fn samples(start: f64, size: f64, steps: usize, summed: bool) -> Vec<u64> {
        let period = 0.01;
        let mut clock = Clock::new(start, None, period).unwrap();
        let mut point = start;
        let mut runs = Vec::new();
        for i in 0..steps {
            let t = if summed { point } else { start + i as f64 * size };
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
        // The last one: seconds since 1970, where numbers are 0.24 us apart.
        for (start, summed) in [(0.5, false), (0.5, true), (1.7e9, false)] {
            assert_eq!(samples(start, 0.01, 1000, summed), [1; 1000]);
            assert_eq!(samples(start, 0.02, 500, summed), [2; 500]);
            assert_eq!(samples(start, 0.08, 125, summed), [8; 125]);
            let thirds = samples(start, 0.01 / 3.0, 3000, summed);
            assert!(thirds.chunks(3).all(|runs| runs == [1, 0, 0]));
            let sixtieths = samples(start, 1.0 / 60.0, 3600, summed);
            assert!(sixtieths.chunks(3).all(|runs| runs == [2, 2, 1]));
        }
    }

    #[test]
    fn steps_are_refused_with_the_reason() {
        let clock = Clock { point: 1.0, stop: Some(2.0), ..Clock::ZERO };
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
        let endless = Clock::ZERO;
        assert_eq!(endless.step(0.0, 1e300, 0.01), Err(StepRefusal::TooFar));
        assert!(endless.step(0.0, 10_000.0, 0.01).is_ok());
        assert_eq!(endless.step(0.0, 10_000.001, 0.01), Err(StepRefusal::TooManySamples));
        let later = Clock { point: 0.5, next_sample: 50, ..Clock::ZERO };
        assert!(later.step(0.5, 10_000.0, 0.01).is_ok());
        assert_eq!(later.step(0.5, 10_000.01, 0.01), Err(StepRefusal::TooManySamples));
    }

    #[test]
    fn a_run_begins_where_samples_can_be_told_apart() {
        // Seconds since 1970 are well within, nanoseconds are not.
        for start in [0.0, -0.0, 5e-324, -1e9, 1.7e9, 4e10] {
            assert!(Clock::new(start, None, 0.01).is_ok(), "{start}");
        }
        for start in [1e11, -1e12, 1.7e18, 1e300, f64::MAX, f64::MIN] {
            let refusal = Clock::new(start, None, 0.01);
            assert!(matches!(refusal, Err(RunRefusal::TooCoarse(_))), "{start}: {refusal:?}");
        }
        for (start, stop) in [
            (f64::NAN, None),
            (f64::INFINITY, None),
            (0.0, Some(f64::NAN)),
            (0.0, Some(f64::INFINITY)),
            (0.0, Some(-1.0)),
        ] {
            assert_eq!(Clock::new(start, stop, 0.01), Err(RunRefusal::NotASpan));
        }
    }

    #[test]
    fn a_run_that_ends_where_it_starts_has_no_end() {
        for start in [0.0, -5.0, 1.7e9] {
            let clock = Clock::new(start, Some(start), 0.01).unwrap();
            assert_eq!(clock.stop, None);
            assert!(clock.step(start, 1.0, 0.01).is_ok());
        }
    }
}
