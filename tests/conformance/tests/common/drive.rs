//! A drive of 60 s as seen at the communication points, and what the plain detector makes of it.
//!
//! # Conventions
//! - Inputs change at communication points only; row i holds from point i to point i + 1.
//! - A communication step is an exact fraction of the sample period, so that which samples fall into
//!   which step is decided in integers here.

use std::f64::consts::TAU;

use steerguard_detector::{Detector, Input, Measurement};
use steerguard_model_description::detector::DetectorState;

pub const DURATION_S: u64 = 60;

/// A communication step of `samples.0 / samples.1` sample periods.
#[derive(Clone, Copy)]
pub struct Step {
    /// Part of file names.
    pub name: &'static str,
    pub samples: (u64, u64),
}

/// The steps that importers are driven with; the last is 1/60 s for a sample period of 10 ms.
pub const STEPS: [Step; 5] = [
    Step { name: "one", samples: (1, 1) },
    Step { name: "two", samples: (2, 1) },
    Step { name: "eight", samples: (8, 1) },
    Step { name: "third", samples: (1, 3) },
    Step { name: "sixtieth", samples: (5, 3) },
];

impl Step {
    pub fn size_s(self, period_s: f64) -> f64 {
        let (numerator, denominator) = self.samples;
        numerator as f64 * period_s / denominator as f64
    }

    /// Number of steps in the drive.
    pub fn count(self, period_s: f64) -> u64 {
        let samples = (DURATION_S as f64 / period_s).round() as u64;
        samples * self.samples.1 / self.samples.0
    }

    /// The step that sample k falls into.
    fn of_sample(self, k: u64) -> u64 {
        k * self.samples.1 / self.samples.0
    }
}

/// v_x, r, T_eng and delta from time `t` s on: straight, then curves that the yaw rate follows badly,
/// past the end of the design range from 40 to 42 s, with no valid yaw rate from 50 to 50.5 s.
pub fn inputs(t: f64) -> [f64; 4] {
    let wave = |frequency_hz: f64| (TAU * frequency_hz * t).sin();
    let speed = if (40.0..42.0).contains(&t) { 33.0 } else { 15.0 + 3.0 * wave(0.03) };
    let angle = if t < 5.0 { 0.0 } else { 0.02 * wave(0.21) + 0.005 * wave(1.3) };
    let yaw_rate = if (50.0..50.5).contains(&t) { f64::NAN } else { 0.9 * 3.6 * angle };
    [speed, yaw_rate, 78.75, angle]
}

/// What an importer sees after a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shown {
    pub reals: [f64; 8],
    pub alarm: bool,
    pub alarm_latched: bool,
    pub state: i32,
}

/// Names of [`Shown::reals`].
pub const REALS: [&str; 8] = [
    "residual.v_x",
    "residual.r",
    "v_y_hat",
    "J_rms",
    "J_th",
    "J_ratio",
    "detectability",
    "first_alarm_time",
];

impl Shown {
    fn of(detector: &Detector, period_s: f64) -> Self {
        let output = detector.output();
        let [residual_v_x, residual_r] = output.residual.vector();
        let ratio = output.j_rms / output.j_th;
        let first_alarm = output.first_alarm.map_or(-1.0, |k| k as f64 * period_s);
        Self {
            reals: [
                residual_v_x,
                residual_r,
                output.v_y_hat,
                output.j_rms,
                output.j_th,
                ratio,
                output.detectability,
                first_alarm,
            ],
            alarm: output.alarm,
            alarm_latched: output.first_alarm.is_some(),
            state: steerguard_fmu::state(output.monitor).value(),
        }
    }
}

/// What the plain detector shows after each step.
pub fn plain(mut detector: Detector, step: Step, period_s: f64) -> Vec<Shown> {
    let size_s = step.size_s(period_s);
    let mut next_sample = 0;
    (0..step.count(period_s))
        .map(|i| {
            let [v_x_m_per_s, r_rad_per_s, t_eng_n_m, delta_rad] = inputs(i as f64 * size_s);
            let y = Measurement { v_x_m_per_s, r_rad_per_s };
            let u = Input { t_eng_n_m, delta_rad };
            while step.of_sample(next_sample) == i {
                detector.sample(y, u);
                next_sample += 1;
            }
            Shown::of(&detector, period_s)
        })
        .collect()
}

/// Checks that a record has something in it to be wrong.
pub fn assert_eventful(record: &[Shown]) {
    use DetectorState::{InvalidInput, Monitoring, OutOfRange};
    let occurs = |state: &&DetectorState| record.iter().any(|row| row.state == state.value());
    let states: Vec<_> = DetectorState::ALL.iter().filter(occurs).copied().collect();
    assert_eq!(states, [Monitoring, OutOfRange, InvalidInput]);
    assert!(record.iter().any(|row| row.alarm) && record.iter().any(|row| !row.alarm));
}
