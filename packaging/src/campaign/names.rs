//! Names of manoeuvres and faults in results, reports and scenarios.

use steerguard_world::{Fault, FaultKind, Manoeuvre};

use super::record::named;

named! {
    /// A manoeuvre without its numbers.
    pub enum ManoeuvreName {
        /// [`Manoeuvre::DoubleLaneChange`].
        DoubleLaneChange = "double lane change",
        /// [`Manoeuvre::Weave`].
        Weave = "weave",
        /// [`Manoeuvre::StepSteer`].
        StepSteer = "step steer",
        /// [`Manoeuvre::SineWithDwell`].
        SineWithDwell = "sine with dwell",
        /// [`Manoeuvre::Straight`].
        Straight = "straight",
        /// [`Manoeuvre::Roundabout`].
        Roundabout = "roundabout",
        /// [`Manoeuvre::StopAndGo`].
        StopAndGo = "stop and go",
        /// [`Manoeuvre::BrakingInTurn`].
        BrakingInTurn = "braking in a turn",
        /// [`Manoeuvre::Sine`].
        Sine = "sine",
        /// [`Manoeuvre::LaneChange`].
        LaneChange = "lane change",
        /// [`Manoeuvre::SteadyTurn`].
        SteadyTurn = "steady turn",
    }
}

/// Numbers that only some manoeuvres have.
#[derive(Clone, Copy, Debug)]
pub struct ManoeuvreNumbers {
    /// Of a roundabout.
    pub radius_m: f64,
    /// Of what brakes.
    pub lowest_speed_m_per_s: f64,
    /// Of what brakes.
    pub longitudinal_acceleration_m_per_s2: f64,
}

impl ManoeuvreName {
    /// The manoeuvre, with those of the numbers that it has.
    pub const fn with(self, numbers: ManoeuvreNumbers) -> Manoeuvre {
        let ManoeuvreNumbers { radius_m, lowest_speed_m_per_s, longitudinal_acceleration_m_per_s2 } =
            numbers;
        match self {
            Self::Straight => Manoeuvre::Straight,
            Self::Sine => Manoeuvre::Sine,
            Self::Weave => Manoeuvre::Weave,
            Self::StepSteer => Manoeuvre::StepSteer,
            Self::LaneChange => Manoeuvre::LaneChange,
            Self::SteadyTurn => Manoeuvre::SteadyTurn,
            Self::DoubleLaneChange => Manoeuvre::DoubleLaneChange,
            Self::SineWithDwell => Manoeuvre::SineWithDwell,
            Self::Roundabout => Manoeuvre::Roundabout { radius_m },
            Self::StopAndGo => {
                Manoeuvre::StopAndGo { lowest_speed_m_per_s, longitudinal_acceleration_m_per_s2 }
            }
            Self::BrakingInTurn => Manoeuvre::BrakingInTurn {
                lowest_speed_m_per_s,
                longitudinal_acceleration_m_per_s2,
            },
        }
    }

    /// The name of `manoeuvre`.
    pub const fn of(manoeuvre: &Manoeuvre) -> Self {
        match manoeuvre {
            Manoeuvre::Straight => Self::Straight,
            Manoeuvre::Sine => Self::Sine,
            Manoeuvre::Weave => Self::Weave,
            Manoeuvre::StepSteer => Self::StepSteer,
            Manoeuvre::LaneChange => Self::LaneChange,
            Manoeuvre::SteadyTurn => Self::SteadyTurn,
            Manoeuvre::DoubleLaneChange => Self::DoubleLaneChange,
            Manoeuvre::SineWithDwell => Self::SineWithDwell,
            Manoeuvre::Roundabout { .. } => Self::Roundabout,
            Manoeuvre::StopAndGo { .. } => Self::StopAndGo,
            Manoeuvre::BrakingInTurn { .. } => Self::BrakingInTurn,
        }
    }
}

named! {
    /// A fault without its numbers.
    pub enum FaultName {
        /// No fault.
        None = "none",
        /// [`FaultKind::Bias`].
        Bias = "bias",
        /// [`FaultKind::Drift`].
        Drift = "drift",
        /// [`FaultKind::Stuck`].
        Stuck = "stuck",
        /// [`FaultKind::LossOfEffectiveness`].
        LossOfEffectiveness = "loss of effectiveness",
        /// [`FaultKind::Oscillation`].
        Oscillation = "oscillation",
        /// [`FaultKind::Delay`].
        Delay = "delay",
    }
}

/// Numbers that only some faults have: all of them, or those that one has.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FaultNumbers<Number = f64> {
    /// Of a bias, drift or oscillation.
    pub angle_rad: Number,
    /// Of a drift.
    pub rise_s: Number,
    /// Of an oscillation.
    pub hz: Number,
    /// Of a loss of effectiveness, 0 to 1.
    pub lost: Number,
    /// Of a delay.
    pub delay_s: Number,
}

impl FaultNumbers<Option<f64>> {
    /// Those that `fault` has.
    pub fn of(fault: Option<&Fault>) -> Self {
        let none = Self::default();
        match fault.map(|fault| fault.kind) {
            None | Some(FaultKind::Stuck) => none,
            Some(FaultKind::Bias { angle_rad }) => Self { angle_rad: Some(angle_rad), ..none },
            Some(FaultKind::Drift { angle_rad, rise_s }) => {
                Self { angle_rad: Some(angle_rad), rise_s: Some(rise_s), ..none }
            }
            Some(FaultKind::LossOfEffectiveness { lost }) => Self { lost: Some(lost), ..none },
            Some(FaultKind::Oscillation { angle_rad, hz }) => {
                Self { angle_rad: Some(angle_rad), hz: Some(hz), ..none }
            }
            Some(FaultKind::Delay { delay_s }) => Self { delay_s: Some(delay_s), ..none },
        }
    }
}

impl FaultName {
    /// The fault, with those of the numbers that it has.
    pub const fn with(self, onset_s: f64, numbers: FaultNumbers) -> Option<Fault> {
        let FaultNumbers { angle_rad, rise_s, hz, lost, delay_s } = numbers;
        let kind = match self {
            Self::None => return None,
            Self::Bias => FaultKind::Bias { angle_rad },
            Self::Drift => FaultKind::Drift { angle_rad, rise_s },
            Self::Stuck => FaultKind::Stuck,
            Self::LossOfEffectiveness => FaultKind::LossOfEffectiveness { lost },
            Self::Oscillation => FaultKind::Oscillation { angle_rad, hz },
            Self::Delay => FaultKind::Delay { delay_s },
        };
        Some(Fault { onset_s, kind })
    }

    /// Names of the faults that have a number.
    pub fn having(number: fn(&FaultNumbers<Option<f64>>) -> Option<f64>) -> Vec<&'static str> {
        let has = |name: &&Self| {
            let any = name.with(0.0, FaultNumbers::default());
            number(&FaultNumbers::of(any.as_ref())).is_some()
        };
        Self::ALL.iter().filter(has).map(|name| name.name()).collect()
    }

    /// The name of `fault`.
    pub const fn of(fault: Option<&Fault>) -> Self {
        let Some(fault) = fault else { return Self::None };
        match fault.kind {
            FaultKind::Bias { .. } => Self::Bias,
            FaultKind::Drift { .. } => Self::Drift,
            FaultKind::Stuck => Self::Stuck,
            FaultKind::LossOfEffectiveness { .. } => Self::LossOfEffectiveness,
            FaultKind::Oscillation { .. } => Self::Oscillation,
            FaultKind::Delay { .. } => Self::Delay,
        }
    }
}
