//! Why drives give no answer.

use crate::course::Limits;
use crate::identified::{Identified, Refused};

/// Ratios that steering systems have.
pub(crate) const RATIOS: [f64; 2] = [0.5, 40.0];
/// Shortest time that is compared, s.
pub(crate) const SHORTEST_S: f64 = 10.0;

/// Why there is no answer.
#[derive(Clone, Debug, thiserror::Error)]
pub enum IdentificationError {
    /// Too little is left.
    #[error(
        "only {compared_s:.1} s of {driven_s:.1} s can be compared with the model: forwards, below {} m/s^2 \
         of lateral and {} m/s^2 of longitudinal acceleration; at least {SHORTEST_S} s are needed",
        Limits::LINEAR.lateral_m_per_s2, Limits::LINEAR.longitudinal_m_per_s2
    )]
    TooShort {
        /// Time that can be compared, s.
        compared_s: f64,
        /// Time driven, s.
        driven_s: f64,
    },
    /// Nothing moves.
    #[error("the {0} does not change")]
    NoExcitation(&'static str),
    /// The yaw rate goes against the steering.
    #[error(
        "yaw rate and steering go against each other (correlation {correlation:.2}): one of the two axes is \
         turned"
    )]
    TurnedAxis {
        /// Of steering times speed with yaw rate.
        correlation: f64,
    },
    /// No steering system has it, or not the one that is told.
    #[error(
        "steering over yaw rate gives a steering ratio of about {ratio:.3}, where {expected}: {}",
        unit_of(*ratio)
    )]
    ImpossibleRatio {
        /// The ratio found.
        ratio: f64,
        /// What it should be.
        expected: String,
    },
    /// The steering follows the yaw rate.
    #[error("the steering is recorded {:.0} ms late: yaw rate answers it before it is there", 1e3 * late_s)]
    LateSteering {
        /// By how much, s.
        late_s: f64,
    },
    /// No start of the search led to an answer.
    #[error("the model does not fit the drives from any start: are these drives of this car?")]
    NoFit,
    /// What the drives do not show.
    #[error("the drives do not show {}", names(.0))]
    NotShown(Vec<Refused>, Box<Identified>),
}

/// What a ratio that is none may come from.
fn unit_of(ratio: f64) -> &'static str {
    let degrees = 180.0 / std::f64::consts::PI;
    let plausible = |ratio: f64| (RATIOS[0]..=RATIOS[1]).contains(&ratio);
    match ratio {
        _ if plausible(ratio / degrees) => {
            "degrees were read as radians in the steering, or radians as degrees in the yaw rate"
        }
        _ if plausible(ratio * degrees) => {
            "radians were read as degrees in the steering, or degrees as radians in the yaw rate"
        }
        _ => "is the column the steering angle?",
    }
}

fn names(refused: &[Refused]) -> String {
    let names: Vec<&str> = refused.iter().map(|refused| refused.parameter.name()).collect();
    names.join(", ")
}
