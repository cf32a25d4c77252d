//! Residual evaluation: windowed RMS, and the threshold's start-up term (method 6).

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::Measurement;
use crate::algebra::all_finite;

/// Longest window, samples.
pub const MAX_WINDOW: usize = 256;

/// An alarm ends where J stays below this share of J_th.
pub const RELEASE: f64 = 0.8;

/// How the residual is evaluated.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize), serde(deny_unknown_fields))]
pub struct Evaluation {
    /// Window of the RMS, samples, `1..=MAX_WINDOW`.
    pub window: usize,
    /// Diagonal of W_r, for the residuals of v_x (per m/s) and r (per rad/s); not negative.
    pub weights: [f64; 2],
    /// Threshold on J, in the unit that the weights give it, once the start-up has passed, where nothing
    /// is uncertain; positive.
    pub threshold: f64,
    /// Share of the uncertainties' bound that is added to the threshold, not negative.
    pub uncertainty_share: f64,
    /// Bound on the start-up residual: `||W_r r_j|| <= amplitude decay^j`, not negative.
    pub start_up_amplitude: f64,
    /// Decay rate of the start-up residual for each sample, in `[0, 1)`.
    pub start_up_decay: f64,
    /// Consecutive samples with `J >= J_th` that raise the alarm, at least 1.
    pub debounce_samples: u32,
    /// Time of monitoring with J below [`RELEASE`] of J_th that ends an alarm, s, not negative.
    pub alarm_hold_s: f64,
}

impl Evaluation {
    /// `||W_r r||^2` of a residual.
    pub fn square(&self, residual: Measurement) -> f64 {
        let [w_v_x, w_r] = self.weights;
        let weighted = [w_v_x * residual.v_x_m_per_s, w_r * residual.r_rad_per_s];
        weighted[0] * weighted[0] + weighted[1] * weighted[1]
    }
}

/// RMS over the last samples: `J(k) = sqrt(1/window sum ||W_r r||^2)`.
///
/// Samples before the start count zero and the divisor stays the window. The sum is that of the squares
/// of this round through the ring and that of those left of the round before, each added up from nothing:
/// a running sum, which subtracts what leaves, would drift by rounding. A sample costs two additions
/// whatever the window, and the last of a round one more for each place of the ring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rms {
    /// The first `window` entries are a ring: before `next` the squares of this round, from there on the
    /// sums of the last round's squares from that place to the end.
    pub ring: [f64; MAX_WINDOW],
    /// Place of the next square, below the window.
    pub next: usize,
    /// Sum of the squares of this round.
    pub newer: f64,
}

impl Rms {
    /// An empty window.
    pub const EMPTY: Self = Self { ring: [0.0; MAX_WINDOW], next: 0, newer: 0.0 };

    /// Whether pushing to a window of `window` samples can have led here.
    pub(crate) fn is_possible(&self, window: usize) -> bool {
        let ring = self.ring.get(..window).unwrap_or(&self.ring);
        self.next < window && all_finite(ring) && self.newer.is_finite()
    }

    /// Takes a sample's `square` and returns the RMS over the last `window` samples.
    pub fn push(&mut self, square: f64, window: usize) -> f64 {
        if let Some(place) = self.ring.get_mut(self.next) {
            *place = square;
        }
        self.next += 1;
        self.newer += square;
        let sum = if self.next < window {
            self.newer + self.ring.get(self.next).copied().unwrap_or(0.0)
        } else {
            self.begin_round(window)
        };
        libm::sqrt(sum / window as f64)
    }

    /// Turns the squares of the round that ends into sums, and returns that of all.
    #[cold]
    fn begin_round(&mut self, window: usize) -> f64 {
        let mut older = 0.0;
        for place in self.ring.iter_mut().take(window).rev() {
            older += *place;
            *place = older;
        }
        self.next = 0;
        core::mem::replace(&mut self.newer, 0.0)
    }
}

/// Start-up term of the threshold: the RMS that `amplitude decay^j`, j counted from the observer's
/// start, would have in the same window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StartUp {
    /// `decay^(2 j)` of the sample to come.
    pub power: f64,
    /// `sum decay^(2 i)` over the window that ends at the last sample.
    pub sum: f64,
    /// Samples in that window.
    pub samples: usize,
}

impl StartUp {
    /// Before the first sample after a start.
    pub const RESTARTED: Self = Self { power: 1.0, sum: 0.0, samples: 0 };

    /// The term at the next sample.
    pub fn next(&mut self, evaluation: &Evaluation) -> f64 {
        let decay_squared = evaluation.start_up_decay * evaluation.start_up_decay;
        if self.samples < evaluation.window {
            self.sum += self.power;
            self.power *= decay_squared;
            self.samples += 1;
        } else {
            // The window has left the start: each of its terms shrinks by the same factor.
            self.sum *= decay_squared;
        }
        self.term(evaluation)
    }

    /// The term at the last sample.
    pub fn term(&self, evaluation: &Evaluation) -> f64 {
        evaluation.start_up_amplitude * libm::sqrt(self.sum / evaluation.window as f64)
    }
}
