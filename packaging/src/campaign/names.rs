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
        /// [`Manoeuvre::Sine`].
        Sine = "sine",
        /// [`Manoeuvre::LaneChange`].
        LaneChange = "lane change",
    }
}

impl ManoeuvreName {
    /// The name of `manoeuvre`.
    pub const fn of(manoeuvre: &Manoeuvre) -> Self {
        match manoeuvre {
            Manoeuvre::Straight => Self::Straight,
            Manoeuvre::Sine => Self::Sine,
            Manoeuvre::Weave => Self::Weave,
            Manoeuvre::StepSteer => Self::StepSteer,
            Manoeuvre::LaneChange => Self::LaneChange,
            Manoeuvre::DoubleLaneChange => Self::DoubleLaneChange,
            Manoeuvre::SineWithDwell => Self::SineWithDwell,
            Manoeuvre::Roundabout { .. } => Self::Roundabout,
            Manoeuvre::StopAndGo { .. } => Self::StopAndGo,
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

impl FaultName {
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
