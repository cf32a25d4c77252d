//! Kinds of faults and manoeuvres, by the names they have in results.

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
        /// The wheel stays where it was at the onset.
        Stuck = "stuck",
        /// The wheel follows a share of the command.
        LossOfEffectiveness = "loss of effectiveness",
        /// A sine is added.
        Oscillation = "oscillation",
        /// The wheel follows the command late; it stands still first.
        Delay = "delay",
    }
}

named! {
    /// Course of steering and speed.
    pub enum Manoeuvre {
        /// ISO 3888-1, by an open-loop substitute.
        DoubleLaneChange = "double lane change",
        /// ISO 13674-1: a sine of 0.2 Hz.
        Weave = "weave",
        /// ISO 7401: a fast ramp, held.
        StepSteer = "step steer",
        /// ISO 19365: 0.7 Hz, 0.5 s dwell at the second peak.
        SineWithDwell = "sine with dwell",
        /// No steering.
        Straight = "straight",
        /// Right, three quarters around to the left, right; or mirrored.
        Roundabout = "roundabout",
        /// Down to and below the design's range, and up again, steering gently.
        StopAndGo = "stop and go",
    }
}
