//! Faults of the steering actuator, as the angle they add at the road wheel.
//!
//! # Conventions
//! - delta is the road-wheel angle of the healthy actuator, the command where it has neither lag nor
//!   dead time, delta_w the actual one, both in rad; the fault is `f = delta_w - delta`. delta is a
//!   function of time, so what sticks, lags or is lost is computed from it.

use core::f64::consts::TAU;

/// A fault and when it begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fault {
    /// When it begins, s.
    pub onset_s: f64,
    /// What it is.
    pub kind: FaultKind,
}

/// What a fault is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FaultKind {
    /// A constant angle from the onset on.
    Bias {
        /// The angle.
        angle_rad: f64,
    },
    /// An angle that grows in proportion to time up to its size.
    Drift {
        /// Its size.
        angle_rad: f64,
        /// Time to its size, positive.
        rise_s: f64,
    },
    /// The wheel stays where it was at the onset.
    Stuck,
    /// The wheel follows a share of the command.
    LossOfEffectiveness {
        /// The share that is lost, 0 to 1.
        lost: f64,
    },
    /// A sine is added.
    Oscillation {
        /// Its amplitude.
        angle_rad: f64,
        /// Its frequency.
        hz: f64,
    },
    /// The wheel follows the command late; it stands still first.
    Delay {
        /// How late, not negative.
        delay_s: f64,
    },
}

impl Fault {
    /// Angle in rad that it adds at time `t` to the healthy actuator's `steering` in rad, a function
    /// of time.
    pub fn angle_rad(&self, t: f64, steering: impl Fn(f64) -> f64) -> f64 {
        let since_s = t - self.onset_s;
        if since_s < 0.0 {
            return 0.0;
        }
        match self.kind {
            FaultKind::Bias { angle_rad } => angle_rad,
            FaultKind::Drift { angle_rad, rise_s } => angle_rad * (since_s / rise_s).min(1.0),
            FaultKind::Stuck => steering(self.onset_s) - steering(t),
            FaultKind::LossOfEffectiveness { lost } => -lost * steering(t),
            FaultKind::Oscillation { angle_rad, hz } => angle_rad * libm::sin(TAU * hz * since_s),
            FaultKind::Delay { delay_s } => steering((t - delay_s).max(self.onset_s)) - steering(t),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ONE: f64 = 1.0_f64.to_radians();

    #[test]
    fn faults_are_what_their_names_say() {
        let steering = |t: f64| 0.01 * t;
        for (kind, expected) in [
            (FaultKind::Bias { angle_rad: ONE }, [ONE, ONE, ONE]),
            (FaultKind::Drift { angle_rad: ONE, rise_s: 2.0 }, [0.0, 0.5 * ONE, ONE]),
            (FaultKind::Stuck, [0.0, -0.01, -0.2]),
            (FaultKind::LossOfEffectiveness { lost: 0.5 }, [-0.05, -0.055, -0.15]),
            (FaultKind::Oscillation { angle_rad: ONE, hz: 0.25 }, [0.0, ONE, 0.0]),
            (FaultKind::Delay { delay_s: 0.1 }, [0.0, -0.001, -0.001]),
        ] {
            let at = |t| Fault { onset_s: 10.0, kind }.angle_rad(t, steering);
            assert_eq!(at(9.99), 0.0);
            for (t, expected) in [10.0, 11.0, 30.0].into_iter().zip(expected) {
                assert!((at(t) - expected).abs() < 1e-12, "{kind:?} at {t} s: {}", at(t));
            }
        }
    }

    #[test]
    fn faults_of_the_command_do_nothing_on_a_straight_road() {
        for kind in [
            FaultKind::Stuck,
            FaultKind::LossOfEffectiveness { lost: 0.5 },
            FaultKind::Delay { delay_s: 0.1 },
        ] {
            let fault = Fault { onset_s: 10.0, kind };
            assert!((0..100).all(|t| fault.angle_rad(f64::from(t), |_| 0.0) == 0.0));
        }
    }
}
