//! The steering: what becomes of a commanded angle before it stands at the road wheel.
//!
//! # Conventions
//! - Command, held over a step; dead time first, in whole steps; then a lag whose speed is limited,
//!   `dx/dt = (command - x) / lag`, at most the limit either way; the end stops limit what can be
//!   reached.
//! - Solved exactly: towards a held command the angle runs along a ramp, then along an exponential.

use steerguard_detector::Actuator;

/// Longest dead time, steps.
pub const MAX_DEAD_TIME_STEPS: usize = 1500;

/// What turns the road wheel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Steering {
    /// Lag, dead time, rate limit and end stops. The dead time is rounded to whole steps, at most
    /// [`MAX_DEAD_TIME_STEPS`].
    pub actuator: Actuator,
    /// Angle of the road wheel per commanded angle, positive: 1 where the steering ratio is right.
    pub ratio: f64,
    /// What the steering's sensor shows at zero, rad: the road wheel stands this far to the right of
    /// where it is commanded to be.
    pub offset_rad: f64,
}

impl Steering {
    /// The road wheel stands where it is commanded to be, at once.
    pub const DIRECT: Self = Self::of(Actuator::NONE);

    /// An `actuator` whose ratio is right, without offset.
    pub const fn of(actuator: Actuator) -> Self {
        Self { actuator, ratio: 1.0, offset_rad: 0.0 }
    }

    /// The angle at which the road wheel settles under a command, rad.
    pub fn settled_rad(&self, command_rad: f64) -> f64 {
        self.actuator.settled_rad(self.ratio * command_rad - self.offset_rad)
    }

    /// The angle `duration_s` after it stood at `from`, under a held `target`; rad.
    fn turned(&self, from: f64, target: f64, duration_s: f64) -> f64 {
        let Actuator { lag_s, rate_limit_rad_per_s, .. } = self.actuator;
        let (mut angle, mut left_s) = (from, duration_s);
        let behind = target - from;
        if let Some(limit) = rate_limit_rad_per_s {
            let ramp_s = (behind.abs() / limit - lag_s).max(0.0).min(duration_s);
            angle += ramp_s * limit.copysign(behind);
            left_s -= ramp_s;
        }
        if left_s <= 0.0 {
            angle
        } else if lag_s > 0.0 {
            target - (target - angle) * libm::exp(-left_s / lag_s)
        } else {
            target
        }
    }
}

/// Where the steering stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SteeringState {
    /// Angle of the road wheel before the fault, rad.
    pub angle_rad: f64,
    /// Commanded angles still to act, rad: the first `dead_time_steps` entries are a ring.
    pub commands_rad: [f64; MAX_DEAD_TIME_STEPS],
    /// Place of the oldest one.
    pub oldest: usize,
    /// Dead time, steps.
    pub dead_time_steps: usize,
}

impl SteeringState {
    /// `steering` that has settled at `command_rad` and will go on by steps of `step_s`.
    pub fn new(steering: &Steering, step_s: f64, command_rad: f64) -> Self {
        let steps = libm::round(steering.actuator.delay_s / step_s) as usize;
        Self {
            angle_rad: steering.settled_rad(command_rad),
            commands_rad: [command_rad; MAX_DEAD_TIME_STEPS],
            oldest: 0,
            dead_time_steps: steps.min(MAX_DEAD_TIME_STEPS),
        }
    }

    /// Takes the command of a step of `step_s` and returns the angle at its beginning, in its middle
    /// and at its end, rad.
    pub fn step(&mut self, steering: &Steering, step_s: f64, command_rad: f64) -> [f64; 3] {
        let target = steering.settled_rad(self.delayed(command_rad));
        let Actuator { lag_s, rate_limit_rad_per_s, .. } = steering.actuator;
        if lag_s <= 0.0 && rate_limit_rad_per_s.is_none() {
            self.angle_rad = target;
            return [target; 3];
        }
        let begin = self.angle_rad;
        let middle = steering.turned(begin, target, 0.5 * step_s);
        self.angle_rad = steering.turned(middle, target, 0.5 * step_s);
        [begin, middle, self.angle_rad]
    }

    /// Takes the command of a step and gives the one that acts in it.
    fn delayed(&mut self, command_rad: f64) -> f64 {
        let ring = self.commands_rad.get_mut(..self.dead_time_steps).unwrap_or_default();
        let Some(place) = ring.get_mut(self.oldest) else {
            return command_rad;
        };
        self.oldest = if self.oldest + 1 < self.dead_time_steps { self.oldest + 1 } else { 0 };
        core::mem::replace(place, command_rad)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP_S: f64 = 1e-3;

    /// The angle after `steps` steps under a command of `command_rad` from rest at zero.
    fn angle(steering: &Steering, command_rad: f64, steps: u32) -> f64 {
        let mut state = SteeringState::new(steering, STEP_S, 0.0);
        state.angle_rad = 0.0;
        for _ in 0..steps {
            state.step(steering, STEP_S, command_rad);
        }
        state.angle_rad
    }

    fn lag(lag_s: f64, limit: Option<f64>) -> Steering {
        Steering::of(Actuator { lag_s, rate_limit_rad_per_s: limit, ..Actuator::NONE })
    }

    #[test]
    fn a_lag_is_first_order() {
        for lag_s in [1e-9, 1e-4, 1e-3, 0.1, 5.0] {
            for steps in [1, 20, 100, 1000] {
                let left = libm::exp(-f64::from(steps) * STEP_S / lag_s);
                let found = angle(&lag(lag_s, None), 0.02, steps);
                // Rounding: an ulp of the angle a half step.
                let tolerance = f64::from(2 * steps) * 2.0 * f64::EPSILON * 0.02;
                assert!((found - 0.02 * (1.0 - left)).abs() <= tolerance, "{lag_s} {steps}");
            }
        }
    }

    #[test]
    fn a_limited_rate_ramps_then_lags() {
        for side in [1.0, -1.0] {
            let after = |lag_s, steps| side * angle(&lag(lag_s, Some(0.2)), side * 0.05, steps);
            assert!((after(0.0, 100) - 0.02).abs() < 1e-14);
            assert!((after(0.0, 250) - 0.05).abs() < 1e-14);
            assert!((after(0.0, 1000) - 0.05).abs() < 1e-14);
            // Behind by more than 0.1 s x 0.2 rad/s for 0.15 s, then by that times exp(-t / 0.1 s).
            assert!((after(0.1, 150) - 0.03).abs() < 1e-14);
            assert!((after(0.1, 250) - (0.05 - 0.02 * libm::exp(-1.0))).abs() < 1e-14);
        }
    }

    #[test]
    fn dead_time_delays_by_whole_steps() {
        for steps in [0_u16, 1, 7, 1500] {
            let delay_s = f64::from(steps) * STEP_S;
            let steering = Steering::of(Actuator { delay_s, ..Actuator::NONE });
            let mut state = SteeringState::new(&steering, STEP_S, -1.0);
            for k in 0..3600 {
                let expected = if k < steps { -1.0 } else { f64::from(k - steps) };
                assert_eq!(state.step(&steering, STEP_S, f64::from(k)), [expected; 3]);
            }
        }
    }

    #[test]
    fn the_wheel_stays_between_its_end_stops() {
        let lag = lag(0.02, Some(2.0)).actuator;
        let steering = Steering::of(Actuator { angle_limit_rad: Some(0.5), ..lag });
        for command in [0.4, 0.5, 0.6, 1e6] {
            for side in [1.0, -1.0] {
                let found = angle(&steering, side * command, 2000);
                assert!((found - side * command.min(0.5)).abs() < 1e-14, "{command}: {found}");
            }
        }
        // It comes off the stop at once: nothing has wound up.
        let mut state = SteeringState::new(&steering, STEP_S, 10.0);
        assert_eq!(state.angle_rad, 0.5);
        state.step(&steering, STEP_S, 0.0);
        assert!((state.angle_rad - (0.5 - 2.0 * STEP_S)).abs() < 1e-14);
    }

    #[test]
    fn a_ratio_turns_the_wheel_by_more_than_commanded() {
        let steering = Steering { ratio: 1.1, offset_rad: 0.01, ..Steering::DIRECT };
        assert_eq!(angle(&steering, 0.03, 1), 1.1 * 0.03 - 0.01);
    }

    #[test]
    fn an_offset_turns_the_wheel_to_the_right() {
        let steering = Steering { offset_rad: 0.01, ..Steering::DIRECT };
        assert_eq!(angle(&steering, 0.03, 1), 0.03 - 0.01);
    }
}
