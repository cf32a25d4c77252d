//! Rows of any times to samples on a grid.
//!
//! # Conventions
//! - The grid is t_0 + k T: t_0 is the first time at which every needed signal has a value, T the period, k an
//!   integer; a gap leaves out some k.
//! - Between its rows a signal runs straight. Its rows belong to the time stamp less its delay. Of rows with
//!   the same time the last one counts.
//! - Where two rows of a needed signal are farther apart than the longest gap, the samples between belong to
//!   no piece. A missing torque or lateral acceleration is left out of the sample.
//! - Memory is bounded by the rows within the longest gap and the delays.

use std::collections::VecDeque;

use crate::columns::MAX_DELAY_S;
use crate::error::{Cause, DriveError};
use crate::reader::{Layout, MEASURED, Reader, Row};
use crate::sample::{Piece, Sample};
use crate::signal::Signal;

/// A grid, and what ends a piece of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spacing {
    /// From a sample to the next, s.
    pub period_s: f64,
    /// Rows that are farther apart end a piece, s.
    pub gap_s: f64,
}

impl Spacing {
    /// The grid of `period_s`, on which gaps of 0.25 s or five periods are bridged.
    pub fn of_period(period_s: f64) -> Self {
        Self { period_s, gap_s: (5.0 * period_s).max(0.25) }
    }
}

/// A sample on the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resampled {
    /// Number of the piece that it belongs to, from 0.
    pub piece: u64,
    /// The sample.
    pub sample: Sample,
}

/// What a signal is at a time.
enum At {
    /// Its value.
    Value(f64),
    /// Not known yet.
    Later,
    /// In a gap that ends at this time, as far as is known.
    Gap(f64),
}

/// The rows of a signal that are still of use.
struct Track {
    delay_s: f64,
    needed: bool,
    points: VecDeque<(f64, f64)>,
    /// No row will come before this time.
    known_s: f64,
}

impl Track {
    fn push(&mut self, time_s: f64, value: f64) {
        self.known_s = time_s - self.delay_s;
        if value.is_nan() {
            return;
        }
        match self.points.back_mut() {
            Some(last) if last.0 == self.known_s => last.1 = value,
            _ => self.points.push_back((self.known_s, value)),
        }
    }

    /// The signal at `t`, which never is before the last one asked for. Times closer than `eps` are one.
    fn at(&mut self, t: f64, gap_s: f64, eps: f64, ended: bool) -> At {
        while self.points.get(1).is_some_and(|next| next.0 <= t + eps) {
            self.points.pop_front();
        }
        let Some(&(t_0, v_0)) = self.points.front() else {
            return if ended {
                At::Gap(f64::INFINITY)
            } else {
                self.unless_gap(t, gap_s, f64::NEG_INFINITY)
            };
        };
        if t_0 > t + eps {
            return At::Gap(t_0);
        }
        // Of rows at t itself the last one counts, which is known when a later one has come.
        let Some(&(t_1, v_1)) = self.points.get(1) else {
            if (t - t_0).abs() <= eps && (ended || self.known_s > t + eps) {
                return At::Value(v_0);
            }
            return if ended { At::Gap(f64::INFINITY) } else { self.unless_gap(t, gap_s, t_0) };
        };
        if (t - t_0).abs() <= eps {
            At::Value(v_0)
        } else if t_1 - t_0 > gap_s + eps {
            At::Gap(t_1)
        } else {
            At::Value(v_0 + (v_1 - v_0) * ((t - t_0) / (t_1 - t_0)))
        }
    }

    /// A gap once its next row is too far from `from`.
    fn unless_gap(&self, t: f64, gap_s: f64, from: f64) -> At {
        if self.known_s > t && self.known_s > from + gap_s {
            At::Gap(self.known_s)
        } else {
            At::Later
        }
    }
}

/// Samples on a grid from rows.
pub struct Resampler<I> {
    rows: I,
    spacing: Spacing,
    tracks: [Option<Track>; MEASURED],
    ended: bool,
    /// t_0, s.
    origin_s: Option<f64>,
    k: u64,
    piece: u64,
    /// Whether the piece has samples.
    begun: bool,
}

impl<I: Iterator<Item = Result<Row, DriveError>>> Resampler<I> {
    /// Samples of `rows`, which have the signals of `layout`.
    pub fn new(rows: I, layout: Layout, spacing: Spacing) -> Self {
        let track = |signal: Signal| {
            let place = signal.index() - 1;
            layout.present[place].then(|| Track {
                delay_s: layout.delays_s[place],
                needed: signal.is_needed(),
                points: VecDeque::new(),
                known_s: f64::NEG_INFINITY,
            })
        };
        Self {
            rows,
            spacing,
            tracks: Signal::MEASURED.map(track),
            ended: false,
            origin_s: None,
            k: 0,
            piece: 0,
            begun: false,
        }
    }

    /// What gives the rows.
    pub fn rows(&self) -> &I {
        &self.rows
    }

    /// Reads a row; false at the end.
    fn read(&mut self) -> Result<bool, DriveError> {
        let Some(row) = self.rows.next().transpose()? else {
            self.ended = true;
            return Ok(false);
        };
        for (track, value) in self.tracks.iter_mut().zip(row.values) {
            if let Some(track) = track {
                track.push(row.time_s, value);
            }
        }
        Ok(true)
    }

    /// t_0, once every needed signal has a row.
    fn origin_s(&mut self) -> Option<f64> {
        if self.origin_s.is_none() {
            let needed = self.tracks.iter().flatten().filter(|track| track.needed);
            let first = needed.map(|track| track.points.front().map(|point| point.0));
            self.origin_s = first.collect::<Option<Vec<_>>>()?.into_iter().reduce(f64::max);
        }
        self.origin_s
    }

    /// Forgets what no grid will need while a signal has not begun.
    fn forget_old(&mut self) {
        let keep_s = self.spacing.gap_s + 2.0 * MAX_DELAY_S;
        for track in self.tracks.iter_mut().flatten() {
            let oldest_s = track.known_s - keep_s;
            while track.points.front().is_some_and(|point| point.0 < oldest_s) {
                track.points.pop_front();
            }
        }
    }

    /// The next sample, if enough rows have come.
    fn sample(&mut self, origin_s: f64) -> Option<Sample> {
        let Spacing { period_s, gap_s } = self.spacing;
        let eps = 1e-6 * period_s;
        loop {
            let time_s = origin_s + self.k as f64 * period_s;
            let mut values = [None; MEASURED];
            let mut gap_until_s: Option<f64> = None;
            for (value, track) in values.iter_mut().zip(&mut self.tracks) {
                let Some(track) = track else { continue };
                match track.at(time_s, gap_s, eps, self.ended) {
                    At::Value(found) => *value = Some(found),
                    At::Later => return None,
                    At::Gap(until_s) if track.needed => {
                        gap_until_s = Some(gap_until_s.map_or(until_s, |other| other.max(until_s)));
                    }
                    At::Gap(_) => {}
                }
            }
            if let Some(until_s) = gap_until_s {
                if self.begun {
                    (self.piece, self.begun) = (self.piece + 1, false);
                }
                if until_s == f64::INFINITY {
                    return None;
                }
                let k = ((until_s - origin_s) / period_s - 1e-6).ceil();
                self.k = (self.k + 1).max(k as u64);
                continue;
            }
            let [Some(speed), Some(yaw_rate), Some(steering), acceleration, torque] = values else {
                return None;
            };
            self.k += 1;
            self.begun = true;
            return Some(Sample {
                time_s,
                speed_m_per_s: speed,
                yaw_rate_rad_per_s: yaw_rate,
                steering_rad: steering,
                lateral_acceleration_m_per_s2: acceleration,
                drive_torque_n_m: torque,
            });
        }
    }
}

impl<I: Iterator<Item = Result<Row, DriveError>>> Iterator for Resampler<I> {
    type Item = Result<Resampled, DriveError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            if let Some(origin_s) = self.origin_s() {
                if let Some(sample) = self.sample(origin_s) {
                    return Some(Ok(Resampled { piece: self.piece, sample }));
                }
            } else {
                self.forget_old();
            }
            if self.ended {
                return None;
            }
            if let Err(error) = self.read() {
                self.ended = true;
                self.tracks = [const { None }; MEASURED];
                return Some(Err(error));
            }
        }
    }
}

/// The pieces of a whole drive of at most `longest_s` seconds, for callers that need all of it at once.
///
/// # Errors
/// [`DriveError`] of the reader, where there is more, and where there is no piece at all.
pub fn pieces(
    reader: &mut Reader,
    spacing: Spacing,
    longest_s: f64,
) -> Result<Vec<Piece>, DriveError> {
    let mut left = longest_s / spacing.period_s;
    let mut pieces: Vec<Piece> = Vec::new();
    let layout = reader.layout();
    let mut last = None;
    for resampled in Resampler::new(reader.by_ref(), layout, spacing) {
        let Resampled { piece, sample } = resampled?;
        left -= 1.0;
        if left < 0.0 {
            return Err(reader.error(None, Cause::TooLong { longest_s }));
        }
        if last.replace(piece) != Some(piece) {
            let (start_s, period_s) = (sample.time_s, spacing.period_s);
            pieces.push(Piece { start_s, period_s, samples: Vec::new() });
        }
        if let Some(piece) = pieces.last_mut() {
            piece.samples.push(sample);
        }
    }
    if pieces.is_empty() {
        return Err(reader.error(None, Cause::NoPiece { gap_s: spacing.gap_s }));
    }
    Ok(pieces)
}
