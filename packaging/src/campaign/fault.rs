//! Faults of the steering actuator, as the angle they add at the road wheel.
//!
//! # Conventions
//! - delta is the road-wheel angle of the healthy actuator, the command where it has neither lag nor
//!   dead time, delta_w the actual one, both in rad; the fault is `f = delta_w - delta`. delta is a
//!   function of time, so what sticks, lags or is lost is computed from it.

use std::f64::consts::TAU;

use super::drive::Drive;
pub use super::kind::FaultKind;

/// Angle in rad that the fault of `drive` adds at time `t` to the healthy actuator's `steering`.
pub fn angle_rad(drive: &Drive, t: f64, steering: impl Fn(f64) -> f64) -> f64 {
    let Some(onset_s) = drive.onset_s else { return 0.0 };
    let since_s = t - onset_s;
    if since_s < 0.0 {
        return 0.0;
    }
    let size_rad = drive.fault_deg.unwrap_or(0.0).to_radians();
    match drive.fault {
        FaultKind::None => 0.0,
        FaultKind::Bias => size_rad,
        FaultKind::Drift => size_rad * (since_s / drive.fault_rise_s.unwrap_or(1.0)).min(1.0),
        FaultKind::Stuck => steering(onset_s) - steering(t),
        FaultKind::LossOfEffectiveness => -drive.fault_loss.unwrap_or(0.0) * steering(t),
        FaultKind::Oscillation => {
            size_rad * libm::sin(TAU * drive.fault_hz.unwrap_or(0.0) * since_s)
        }
        FaultKind::Delay => {
            let delayed_s = (t - drive.fault_delay_s.unwrap_or(0.0)).max(onset_s);
            steering(delayed_s) - steering(t)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::campaign::settings::tests::{PAPER, SETTINGS};

    /// A drive with a fault of `kind` from 10 s on, of 1 degree, 2 s, 0.5 Hz, half the command, 0.1 s.
    fn drive(kind: FaultKind) -> Drive {
        Drive {
            fault: kind,
            onset_s: Some(10.0),
            fault_deg: Some(1.0),
            fault_rise_s: Some(2.0),
            fault_hz: Some(0.5),
            fault_loss: Some(0.5),
            fault_delay_s: Some(0.1),
            ..Drive::draw(&SETTINGS, &PAPER, 0)
        }
    }

    #[test]
    fn faults_are_what_their_names_say() {
        let steering = |t: f64| 0.01 * t;
        let one = 1_f64.to_radians();
        for (kind, [at_onset, after_1_s, after_20_s]) in [
            (FaultKind::Bias, [one, one, one]),
            (FaultKind::Drift, [0.0, 0.5 * one, one]),
            (FaultKind::Stuck, [0.0, -0.01, -0.2]),
            (FaultKind::LossOfEffectiveness, [-0.05, -0.055, -0.15]),
            (FaultKind::Oscillation, [0.0, 0.0, 0.0]),
            (FaultKind::Delay, [0.0, -0.001, -0.001]),
        ] {
            let at = |t| angle_rad(&drive(kind), t, steering);
            assert_eq!(at(9.99), 0.0);
            for (t, expected) in [(10.0, at_onset), (11.0, after_1_s), (30.0, after_20_s)] {
                assert!((at(t) - expected).abs() < 1e-12, "{kind:?} at {t} s: {}", at(t));
            }
        }
        let peak = angle_rad(&drive(FaultKind::Oscillation), 10.5, steering);
        assert!((peak - one).abs() < 1e-12);
    }

    #[test]
    fn faults_of_the_command_do_nothing_on_a_straight_road() {
        for kind in [FaultKind::Stuck, FaultKind::LossOfEffectiveness, FaultKind::Delay] {
            assert!((0..100).all(|t| angle_rad(&drive(kind), f64::from(t), |_| 0.0) == 0.0));
        }
    }
}
