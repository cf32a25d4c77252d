//! Drives of one vehicle, as far as they are used.

use steerguard_drives::Piece;

use crate::course::{Course, Limits};
use crate::model::Chassis;

/// Drives of one vehicle, and what of them is used.
pub(crate) struct Drives<'a> {
    pub(crate) chassis: &'a Chassis,
    pub(crate) pieces: &'a [Piece],
    /// Whether the lateral acceleration is compared.
    pub(crate) lateral: bool,
    /// Whether the yaw inertia is neither told nor shown.
    pub(crate) guesses_inertia: bool,
}

impl Drives<'_> {
    /// The pieces that say something, prepared, compared within `limits`.
    pub(crate) fn courses(&self, limits: Limits) -> Vec<Course> {
        let long_enough = |piece: &&Piece| piece.samples.len() as f64 * piece.period_s >= 1.0;
        let pieces = self.pieces.iter().filter(long_enough);
        pieces.map(|piece| Course::new(piece, limits, self.lateral)).collect()
    }

    /// The time of so many samples, s.
    pub(crate) fn time_s(&self, samples: usize) -> f64 {
        samples as f64 * self.pieces.first().map_or(0.0, |piece| piece.period_s)
    }

    /// The time of all samples, s.
    pub(crate) fn driven_s(&self) -> f64 {
        self.time_s(self.pieces.iter().map(|piece| piece.samples.len()).sum())
    }
}
