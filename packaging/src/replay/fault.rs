//! Faults that are injected into a recorded drive.
//!
//! # Conventions
//! - f is the actual angle at the road wheel less the commanded one, left positive. The recording has the
//!   actual angle; the detector is told the command, `recorded - f`.
//! - Kinds and names are those of campaigns and scenarios, as far as a recording can have them: a wheel that
//!   sticks or comes late moves the car otherwise than was recorded.
//! - An angle is injected to both sides, in a run each.

use std::str::FromStr;

use schemars::JsonSchema;
use serde::Serialize;
use steerguard_world::{Fault, FaultKind};

use crate::campaign::names::{FaultName, FaultNumbers};

/// A fault to be injected, to both sides where it has any.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FaultRequest {
    kind: FaultName,
    /// Degrees at the road wheel; of a loss of effectiveness the share, 0 to 1.
    size: f64,
    onset_s: f64,
    rise_s: f64,
    frequency_hz: f64,
}

/// A fault as a run has it.
#[derive(Clone, Copy, Debug, PartialEq, JsonSchema, Serialize)]
pub struct Injection {
    /// Its kind.
    pub kind: FaultName,
    /// Largest angle, deg at the road wheel, left positive; none of a loss of effectiveness.
    pub angle_deg: Option<f64>,
    /// Share of the command that is lost, of a loss of effectiveness.
    pub lost_share: Option<f64>,
    /// Time that a drift takes to its size, s.
    pub rise_s: Option<f64>,
    /// Frequency of an oscillation, Hz.
    pub frequency_hz: Option<f64>,
    /// When it begins, s from the drive's first sample.
    pub onset_s: f64,
    #[serde(skip)]
    fault: Option<Fault>,
}

/// Largest angle, deg.
const LARGEST_DEG: f64 = 90.0;
/// Kinds that a recording can have, as they are written.
const KINDS: [(&str, FaultName); 4] = [
    ("bias", FaultName::Bias),
    ("drift", FaultName::Drift),
    ("oscillation", FaultName::Oscillation),
    ("loss", FaultName::LossOfEffectiveness),
];

impl FromStr for FaultRequest {
    type Err = String;

    /// `KIND=SIZE[,KEY=VALUE]@TIME`, such as `bias=0.5@30s`.
    fn from_str(text: &str) -> Result<Self, String> {
        let form = "expected KIND=SIZE@TIME, such as bias=0.5@30s or drift=1,rise_s=5@30s";
        let (what, when) = text.split_once('@').ok_or(form)?;
        let mut parts = what.split(',');
        let (kind, size) = parts.next().and_then(|first| first.split_once('=')).ok_or(form)?;
        let kind = kind.trim();
        let kind = KINDS.iter().find(|(name, _)| *name == kind).ok_or_else(|| {
            let known = KINDS.map(|(name, _)| name).join(", ");
            format!("`{kind}` cannot be injected into a recorded drive; what can are {known}")
        })?;
        let number = |text: &str, largest: f64| match text.trim().parse::<f64>() {
            Ok(number) if number >= 0.0 && number <= largest => Ok(number),
            _ => Err(format!("`{}` is no number from 0 to {largest}; {form}", text.trim())),
        };
        let unit = |text: &str, unit: &str| text.trim().trim_end_matches(unit).to_owned();
        let is_share = kind.1 == FaultName::LossOfEffectiveness;
        let size = match is_share {
            // What is left of the command is divided by.
            true => number(size, 0.99)?,
            false => number(&unit(size, "deg"), LARGEST_DEG)?,
        };
        let mut request = Self {
            kind: kind.1,
            size,
            onset_s: number(&unit(when, "s"), 1e9)?,
            rise_s: 5.0,
            frequency_hz: 1.0,
        };
        for part in parts {
            let (key, value) = part.split_once('=').ok_or(form)?;
            let value = number(value, 1e6)?;
            match (key.trim(), request.kind) {
                ("rise_s", FaultName::Drift) if value > 0.0 => request.rise_s = value,
                ("frequency_hz", FaultName::Oscillation) => request.frequency_hz = value,
                (key, kind) => return Err(format!("`{key}` is nothing of a {}", kind.name())),
            }
        }
        Ok(request)
    }
}

impl FaultRequest {
    /// The runs: to the left, and to the right where it has sides.
    pub fn injections(&self) -> Vec<Injection> {
        let Self { kind, size, onset_s, rise_s, frequency_hz } = *self;
        let one = |side: f64| {
            let angle_deg = side * size;
            let numbers = FaultNumbers {
                angle_rad: angle_deg.to_radians(),
                rise_s,
                hz: frequency_hz,
                lost: size,
                delay_s: 0.0,
            };
            let fault = kind.with(onset_s, numbers);
            let own = FaultNumbers::of(fault.as_ref());
            Injection {
                kind,
                angle_deg: own.angle_rad.map(|_| angle_deg),
                lost_share: own.lost,
                rise_s: own.rise_s,
                frequency_hz: own.hz,
                onset_s,
                fault,
            }
        };
        match kind {
            FaultName::LossOfEffectiveness => vec![one(1.0)],
            _ => vec![one(1.0), one(-1.0)],
        }
    }
}

impl Injection {
    /// f at time `t` in s at which the road wheel stands at `actual_rad`, rad.
    pub fn angle_rad(&self, t: f64, actual_rad: f64) -> f64 {
        let Some(fault) = &self.fault else { return 0.0 };
        // Of a loss the command is what the wheel has followed a share of.
        let command_rad = match fault.kind {
            FaultKind::LossOfEffectiveness { lost } => actual_rad / (1.0 - lost),
            _ => 0.0,
        };
        fault.angle_rad(t, |_| command_rad)
    }

    /// A short name, which files bear.
    pub fn label(&self) -> String {
        let kind = KINDS.iter().find(|(_, kind)| *kind == self.kind).map_or("", |(name, _)| name);
        let size = match (self.angle_deg, self.lost_share) {
            (Some(angle_deg), _) => format!("{angle_deg:+}deg"),
            (None, share) => share.unwrap_or_default().to_string(),
        };
        let rise = self.rise_s.map_or(String::new(), |rise_s| format!("-in{rise_s}s"));
        let frequency = self.frequency_hz.map_or(String::new(), |hz| format!("-{hz}Hz"));
        format!("{kind}{size}{rise}{frequency}-from{}s", self.onset_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn angles(text: &str, t: f64, actual_rad: f64) -> Vec<f64> {
        let request: FaultRequest = text.parse().unwrap();
        let degrees = |i: &Injection| i.angle_rad(t, actual_rad).to_degrees();
        request.injections().iter().map(degrees).collect()
    }

    #[test]
    fn faults_begin_at_their_time_and_go_to_both_sides() {
        let close = |found: Vec<f64>, expected: &[f64]| {
            assert_eq!(found.len(), expected.len());
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
        };
        close(angles("bias=0.5@30s", 29.99, 0.0), &[0.0, 0.0]);
        close(angles("bias=0.5deg@30", 30.0, 0.0), &[0.5, -0.5]);
        close(angles("drift=1,rise_s=10@30s", 35.0, 0.0), &[0.5, -0.5]);
        close(angles("oscillation=2,frequency_hz=0.25@0", 1.0, 0.0), &[2.0, -2.0]);
        // The wheel stands at 3 degrees, three quarters of 4.
        close(angles("loss=0.25@0", 1.0, 3.0_f64.to_radians()), &[-1.0]);
    }

    #[test]
    fn what_makes_no_sense_is_refused() {
        for (text, part) in [
            ("bias=0.5", "expected KIND=SIZE@TIME"),
            ("bias@3", "expected KIND=SIZE@TIME"),
            ("stuck=1@3", "what can are bias, drift"),
            ("bias=x@3", "`x` is no number from 0 to 90"),
            ("bias=0.5@-1", "`-1` is no number"),
            ("bias=-0.5@1", "`-0.5` is no number from 0 to 90"),
            ("loss=1@1", "from 0 to 0.99"),
            ("bias=1,rise_s=3@1", "`rise_s` is nothing of a bias"),
        ] {
            let error = text.parse::<FaultRequest>().unwrap_err();
            assert!(error.contains(part), "{text}: {error}");
        }
    }

    #[test]
    fn labels_tell_runs_apart() {
        let request: FaultRequest = "bias=0.5@30s".parse().unwrap();
        let labels: Vec<_> = request.injections().iter().map(Injection::label).collect();
        assert_eq!(labels, ["bias+0.5deg-from30s", "bias-0.5deg-from30s"]);
        let drift: FaultRequest = "drift=1,rise_s=2@30s".parse().unwrap();
        assert_eq!(drift.injections()[0].label(), "drift+1deg-in2s-from30s");
    }
}
