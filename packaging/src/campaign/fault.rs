//! Faults of the steering actuator, as the angle they add at the road wheel.
//!
//! # Conventions
//! - delta is the commanded, delta_w the actual road-wheel angle, both in rad; the fault is
//!   `f = delta_w - delta`. The command is a function of time, so what sticks, lags or is lost is
//!   computed from it.

use std::f64::consts::TAU;

use super::drive::Drive;
use super::record::named;

named! {
    /// Kind of a fault.
    pub enum FaultKind {
        /// None.
        None = "none",
        /// A constant angle from the onset on.
        Bias = "bias",
        /// An angle that grows in proportion to time up to its size.
        Drift = "drift",
        /// The wheel stays where it was commanded to be at the onset.
        Stuck = "stuck",
        /// The wheel follows a share of the command.
        LossOfEffectiveness = "loss of effectiveness",
        /// A sine is added.
        Oscillation = "oscillation",
        /// The wheel follows the command late; it stands still first.
        Delay = "delay",
    }
}

impl FaultKind {
    /// Kinds whose effect depends on the command: without steering they cannot be told from none.
    pub const fn depends_on_command(self) -> bool {
        matches!(self, Self::Stuck | Self::LossOfEffectiveness | Self::Delay)
    }
}

/// Angle in rad that the fault of `drive` adds at time `t` under the command `steering`.
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
