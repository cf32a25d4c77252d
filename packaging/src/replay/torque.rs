//! The drive torque where no column has it: the one that the model needs for the measured speed's course,
//! `I_e a + C_x v_x^2`, with a the slope of the straight line that fits the speed best within 0.25 s either
//! way. Fewer samples are there at the ends of a piece.

use std::collections::VecDeque;

use steerguard_detector::Vehicle;
use steerguard_drives::{DriveError, Resampled};

/// The slope is that of the speed so long before and after, s.
const HALF_WINDOW_S: f64 = 0.25;

/// A sample with its torque.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Driven {
    /// Whether it is the first one of a piece.
    pub starts: bool,
    /// The sample.
    pub resampled: Resampled,
    /// Drive torque, N m.
    pub drive_torque_n_m: f64,
}

/// Adds torques to samples.
pub(super) struct Torques<I> {
    samples: I,
    vehicle: Vehicle,
    period_s: f64,
    half_window: usize,
    /// Samples about the next one.
    window: VecDeque<Resampled>,
    /// Place of the next one in the window.
    next: usize,
    last_piece: Option<u64>,
    ended: bool,
}

impl<I: Iterator<Item = Result<Resampled, DriveError>>> Torques<I> {
    /// Torques of `vehicle` for samples of a period.
    pub fn new(samples: I, vehicle: Vehicle, period_s: f64) -> Self {
        Self {
            samples,
            vehicle,
            period_s,
            half_window: (HALF_WINDOW_S / period_s).round().max(1.0) as usize,
            window: VecDeque::new(),
            next: 0,
            last_piece: None,
            ended: false,
        }
    }

    /// Slope of the speed at the next sample, m/s^2.
    fn slope(&self, piece: u64) -> f64 {
        let begin = self.next.saturating_sub(self.half_window);
        let near = self.window.iter().enumerate().skip(begin);
        let near = near.take_while(|(place, _)| *place <= self.next + self.half_window);
        let (mut n, mut t, mut v, mut tt, mut tv) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for (place, other) in near.filter(|(_, other)| other.piece == piece) {
            let at = place as f64 - self.next as f64;
            let speed = other.sample.speed_m_per_s;
            (n, t, v, tt, tv) = (n + 1.0, t + at, v + speed, tt + at * at, tv + at * speed);
        }
        let spread = n * tt - t * t;
        if spread > 0.0 { (n * tv - t * v) / (spread * self.period_s) } else { 0.0 }
    }
}

impl<I: Iterator<Item = Result<Resampled, DriveError>>> Iterator for Torques<I> {
    type Item = Result<Driven, DriveError>;

    fn next(&mut self) -> Option<Self::Item> {
        while !self.ended && self.window.len() <= self.next + self.half_window {
            match self.samples.next() {
                Some(Ok(sample)) => self.window.push_back(sample),
                Some(Err(error)) => {
                    self.ended = true;
                    self.window.clear();
                    return Some(Err(error));
                }
                None => self.ended = true,
            }
        }
        let resampled = *self.window.get(self.next)?;
        let Vehicle { effective_longitudinal_inertia_kg_m, .. } = self.vehicle;
        let drive_torque_n_m = resampled.sample.drive_torque_n_m.unwrap_or_else(|| {
            self.vehicle.cruise_torque(resampled.sample.speed_m_per_s)
                + effective_longitudinal_inertia_kg_m * self.slope(resampled.piece)
        });
        let starts = self.last_piece.replace(resampled.piece) != Some(resampled.piece);
        self.next += 1;
        if self.next > self.half_window {
            self.window.pop_front();
            self.next -= 1;
        }
        Some(Ok(Driven { starts, resampled, drive_torque_n_m }))
    }
}

#[cfg(test)]
mod tests {
    use steerguard_drives::Sample;

    use super::*;

    fn torques(samples: impl Iterator<Item = (u64, f64, Option<f64>)>) -> Vec<Driven> {
        let samples = samples.map(|(piece, speed_m_per_s, drive_torque_n_m)| {
            Ok(Resampled {
                piece,
                sample: Sample {
                    time_s: 0.0,
                    speed_m_per_s,
                    yaw_rate_rad_per_s: 0.0,
                    steering_rad: 0.0,
                    lateral_acceleration_m_per_s2: None,
                    drive_torque_n_m,
                },
            })
        });
        Torques::new(samples, Vehicle::PAPER, 0.01).map(Result::unwrap).collect()
    }

    #[test]
    fn a_steady_acceleration_needs_its_torque_from_end_to_end() {
        let speed = |k: u64| if k < 100 { 10.0 + 0.02 * k as f64 } else { 20.0 - 0.01 * k as f64 };
        let found = torques((0..180).map(|k| (u64::from(k >= 100), speed(k), None)));
        assert_eq!(found.len(), 180);
        for (k, driven) in found.iter().enumerate() {
            let acceleration = if k < 100 { 2.0 } else { -1.0 };
            let expected = 442.8 * acceleration + 0.35 * speed(k as u64).powi(2);
            let error = driven.drive_torque_n_m - expected;
            assert!(error.abs() < 1e-6, "{k}: {error}");
            assert_eq!(driven.starts, k == 0 || k == 100);
        }
    }

    #[test]
    fn a_recorded_torque_stays_what_it_is() {
        let found = torques((0..60).map(|k| (0, k as f64, (k % 2 == 0).then_some(7.0))));
        assert!(found.iter().step_by(2).all(|driven| driven.drive_torque_n_m == 7.0));
        assert!(found.iter().skip(1).step_by(2).all(|driven| driven.drive_torque_n_m > 4e4));
    }
}
