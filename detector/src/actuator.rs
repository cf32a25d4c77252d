//! Steering actuator: what becomes of a commanded angle before it stands at the road wheel
//! (method 2).
//!
//! # Conventions
//! - Command u, held from sample to sample; angle x: dead time first, then a lag whose speed is
//!   limited, `dx/dt = (u(t - delay) - x) / lag`, at most the limit either way; the end stops limit what
//!   can be reached.
//! - Solved exactly, whatever part of a sample the dead time is: over a sample the delayed command
//!   has two values at most, and for a held command x runs along a ramp, then along an exponential.
//! - Inside: times in sampling periods, rates in rad a sampling period.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

/// Longest dead time, sampling periods.
pub const MAX_DELAY_SAMPLES: usize = 256;

/// An actuator's numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize), serde(deny_unknown_fields))]
pub struct Actuator {
    /// Time constant of the first-order lag, s; not negative.
    pub lag_s: f64,
    /// Dead time, s, from 0 to [`MAX_DELAY_SAMPLES`] sampling periods.
    pub delay_s: f64,
    /// Fastest turn of the road wheel, rad/s, positive; without it there is no limit.
    pub rate_limit_rad_per_s: Option<f64>,
    /// Largest angle of the road wheel to either side, rad, positive: its end stops; without it there is no
    /// limit.
    pub angle_limit_rad: Option<f64>,
}

impl Actuator {
    /// No actuator: the command is the angle.
    pub const NONE: Self =
        Self { lag_s: 0.0, delay_s: 0.0, rate_limit_rad_per_s: None, angle_limit_rad: None };

    /// The angle in rad at which the road wheel comes to rest under a command in rad.
    pub fn settled_rad(&self, command_rad: f64) -> f64 {
        self.angle_limit_rad.map_or(command_rad, |limit| command_rad.max(-limit).min(limit))
    }

    /// Number of whole sampling periods in the dead time.
    pub fn delay_samples(&self, period_s: f64) -> usize {
        ((self.delay_s / period_s) as usize).min(MAX_DELAY_SAMPLES)
    }
}

/// What an actuator remembers from sample to sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ActuatorState {
    /// Commands, rad: the last one and those still to act; the first
    /// [`delay_samples`](Actuator::delay_samples)` + 1` entries are a ring.
    pub commands: [f64; MAX_DELAY_SAMPLES + 1],
    /// Place of the oldest command, where the next one goes.
    pub oldest: usize,
    /// The last command, rad; none before the first.
    pub command: Option<f64>,
    /// Angle at the beginning of the sample to come, rad.
    pub angle: f64,
}

impl ActuatorState {
    /// Before the first command: the actuator will have settled there.
    pub const START: Self =
        Self { commands: [0.0; MAX_DELAY_SAMPLES + 1], oldest: 0, command: None, angle: 0.0 };

    /// Whether samples of an actuator whose dead time has `delay` whole periods can have led here.
    pub(crate) fn is_possible(&self, delay: usize) -> bool {
        self.oldest <= delay
            && self.commands.iter().take(delay + 1).all(|x| x.is_finite())
            && self.command.is_none_or(f64::is_finite)
            && self.angle.is_finite()
    }

    /// Takes the `command` of a sample of length `period_s` and returns the average of the angle over
    /// that sample; both in rad.
    pub fn sample(&mut self, actuator: &Actuator, period_s: f64, command: f64) -> f64 {
        if *actuator == Actuator::NONE {
            self.command = Some(command);
            return command;
        }
        let command = actuator.settled_rad(command);
        if self.command.is_none() {
            self.commands = [command; MAX_DELAY_SAMPLES + 1];
            self.angle = command;
        }
        self.command = Some(command);

        let whole = actuator.delay_samples(period_s);
        let fraction = (actuator.delay_s / period_s - whole as f64).clamp(0.0, 1.0);
        let earlier = match self.commands.get_mut(self.oldest) {
            Some(place) => core::mem::replace(place, command),
            None => command,
        };
        self.oldest = if self.oldest < whole { self.oldest + 1 } else { 0 };
        let later = self.commands.get(self.oldest).copied().unwrap_or(command);

        let servo = Servo {
            lag: actuator.lag_s / period_s,
            rate_limit: actuator.rate_limit_rad_per_s.map(|limit| limit * period_s),
        };
        self.turn(&servo, earlier, fraction) + self.turn(&servo, later, 1.0 - fraction)
    }

    /// Turns towards `command` for `duration` and returns the integral of the angle.
    fn turn(&mut self, servo: &Servo, command: f64, mut duration: f64) -> f64 {
        let mut integral = 0.0;
        let behind = command - self.angle;
        let rate = if behind < 0.0 { servo.rate_limit.map(|r| -r) } else { servo.rate_limit };
        if let Some(rate) = rate {
            let ramp = (behind / rate - servo.lag).max(0.0).min(duration);
            integral = ramp * (self.angle + 0.5 * rate * ramp);
            self.angle += rate * ramp;
            duration -= ramp;
        }
        if duration > 0.0 {
            let behind = command - self.angle;
            let left = if servo.lag > 0.0 { exp_of_minus(duration / servo.lag) } else { 0.0 };
            integral += command * duration - behind * servo.lag * (1.0 - left);
            self.angle = command - behind * left;
        }
        integral
    }
}

/// An actuator's lag and rate limit, in units of the sampling period.
struct Servo {
    lag: f64,
    rate_limit: Option<f64>,
}

/// `exp(-s)` for `s >= 0`, to 1e-13: Taylor's series at `s / 128`, squared seven times.
fn exp_of_minus(s: f64) -> f64 {
    if s > 64.0 {
        return 0.0; // below 2e-28
    }
    let scaled = s / 128.0;
    let mut exponential = 1.0;
    for n in (1..=14_u8).rev() {
        exponential = 1.0 - scaled / f64::from(n) * exponential;
    }
    for _ in 0..7 {
        exponential *= exponential;
    }
    exponential
}
