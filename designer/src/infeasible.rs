//! Why Theorem 4 has no solution: its conditions tried one by one.

use crate::synthesis::{Goal, solve};
use crate::theorem4::Theorem4;

/// Halvings of the interval that holds the smallest decay rate.
const BISECTIONS: u32 = 6;
/// Slowest decay rate worth naming.
const SLOWEST_DECAY: f64 = 0.999;

/// Which condition stands in the way of a design.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Obstacle {
    /// (33) alone.
    #[error(
        "stability (33): no observer's error decays by {decay} a sample over the whole operating \
         range; {}",
        match smallest {
            Some(smallest) => format!("all conditions can be met with design.decay = {smallest:.3}"),
            None => "no decay rate below 1 leaves a design: narrow operating_range, or shorten \
                     sampling.period_s".into(),
        }
    )]
    Stability {
        /// Decay rate asked for.
        decay: f64,
        /// A decay rate, near the smallest, with which all conditions can be met, if there is one.
        smallest: Option<f64>,
    },
    /// (31) with (33).
    #[error(
        "disturbance attenuation (31): gamma = {gamma} is out of reach even with no fault \
         sensitivity asked for; {}",
        match smallest {
            Some(smallest) => format!(
                "the smallest is {smallest:.3e} with alpha_d = {alpha_d}: raise design.gamma, or \
                 try another design.alpha_d"
            ),
            None => format!(
                "none is possible with alpha_d = {alpha_d}: try another design.alpha_d, or raise \
                 design.decay"
            ),
        }
    )]
    Disturbance {
        /// gamma asked for.
        gamma: f64,
        /// Smallest gamma under (31) and (33), if there is one.
        smallest: Option<f64>,
        /// The multiplier it depends on.
        alpha_d: f64,
    },
    /// (32) with (33).
    #[error(
        "fault sensitivity (32): no beta > 0 with alpha_f = {alpha_f} and this V, even with the \
         disturbances left out; their bound on beta is {bound:.6}: try another design.V or \
         design.alpha_f"
    )]
    Fault {
        /// The multiplier it depends on.
        alpha_f: f64,
        /// What beta cannot exceed.
        bound: f64,
    },
    /// (31), (32) and (33) together, though each pair is possible.
    #[error(
        "disturbance attenuation (31) against fault sensitivity (32): gamma = {gamma} leaves no \
         beta > 0{}",
        match gamma_at_bound {
            Some(needed) => format!("; beta = {beta:.6} needs design.gamma = {needed:.3e}"),
            None => "; disturbance and fault may act along one direction".into(),
        }
    )]
    Conflict {
        /// gamma asked for.
        gamma: f64,
        /// A beta near its bound.
        beta: f64,
        /// The gamma that this beta needs, if there is one.
        gamma_at_bound: Option<f64>,
    },
}

/// Finds the obstacle to the largest beta under `gamma`.
pub fn diagnose(theorem: &Theorem4, gamma: f64, beta_fraction: f64) -> Obstacle {
    if solve(theorem, Goal::Stability).is_err() {
        let smallest = smallest_decay(theorem, gamma);
        return Obstacle::Stability { decay: theorem.decay, smallest };
    }
    let smallest = solve(theorem, Goal::SmallestGamma { beta: None }).ok().map(|x| x.gamma);
    if smallest.is_none_or(|smallest| smallest > gamma) {
        return Obstacle::Disturbance { gamma, smallest, alpha_d: theorem.alpha_d };
    }
    let bound = theorem.beta_bound();
    if solve(theorem, Goal::LargestBeta { gamma: None }).is_err() {
        return Obstacle::Fault { alpha_f: theorem.alpha_f, bound };
    }
    let beta = beta_fraction * bound;
    let needed = solve(theorem, Goal::SmallestGamma { beta: Some(beta) });
    Obstacle::Conflict { gamma, beta, gamma_at_bound: needed.ok().map(|x| x.gamma) }
}

/// A decay rate, near the smallest, with which all conditions can be met.
fn smallest_decay(theorem: &Theorem4, gamma: f64) -> Option<f64> {
    let goal = Goal::LargestBeta { gamma: Some(gamma) };
    let possible = |decay| solve(&Theorem4 { decay, ..theorem.clone() }, goal).is_ok();
    let (mut no, mut yes) = (theorem.decay, SLOWEST_DECAY);
    if !possible(yes) {
        return None;
    }
    for _ in 0..BISECTIONS {
        let middle = (no + yes) / 2.0;
        if possible(middle) { yes = middle } else { no = middle }
    }
    // On the very edge the solver may fail: a step away from it.
    Some(yes + (SLOWEST_DECAY - yes) / 10.0)
}
