//! Why Theorem 4 has no solution: its conditions tried one by one.

use crate::problem::band::Band;
use crate::problem::channel::Channel;
use crate::synthesis::solve::{Goal, solve};
use crate::synthesis::theorem4::Theorem4;

/// Halvings of the interval that holds the smallest decay rate.
const BISECTIONS: u32 = 6;
/// Multipliers alpha_d tried where the given one leaves no gamma.
const ALPHA_D: [f64; 7] = [1.0, 0.5, 0.2, 0.1, 0.05, 0.02, 0.0];
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
        "disturbance attenuation (31): {} is out of reach even with no fault sensitivity asked \
         for; {}",
        gamma.map_or("any gamma".into(), |gamma| format!("gamma = {gamma}")),
        match (smallest, possible_alpha_d) {
            (Some(smallest), _) => format!(
                "the smallest is {smallest:.3e} with alpha_d = {alpha_d}: raise design.gamma, or \
                 try another design.alpha_d"
            ),
            (None, Some(possible)) => format!(
                "{channels} leave none with alpha_d = {alpha_d}, but one with design.alpha_d = \
                 {possible}"
            ),
            (None, None) => format!(
                "{channels} leave none with alpha_d = {alpha_d} or any other tried: raise \
                 design.decay, or narrow their band"
            ),
        }
    )]
    Disturbance {
        /// gamma asked for, if any was.
        gamma: Option<f64>,
        /// Smallest gamma under (31) and (33), if there is one.
        smallest: Option<f64>,
        /// The multiplier it depends on.
        alpha_d: f64,
        /// The inputs that have no gamma, in words; all of them where it takes them together.
        channels: String,
        /// A multiplier with which there is a gamma, if one was found.
        possible_alpha_d: Option<f64>,
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
        "disturbance attenuation (31) against fault sensitivity (32): {} leaves no beta > 0{}",
        gamma.map_or("no gamma".into(), |gamma| format!("gamma = {gamma}")),
        match gamma_at_bound {
            Some(needed) => format!("; beta = {beta:.6} needs design.gamma = {needed:.3e}"),
            None => "; disturbance and fault may act along one direction".into(),
        }
    )]
    Conflict {
        /// gamma asked for, if any was.
        gamma: Option<f64>,
        /// A beta near its bound.
        beta: f64,
        /// The gamma that this beta needs, if there is one.
        gamma_at_bound: Option<f64>,
    },
}

/// Finds the obstacle to a design, under `gamma` if one is given.
pub fn diagnose(theorem: &Theorem4, gamma: Option<f64>, beta_fraction: f64) -> Obstacle {
    if solve(theorem, Goal::Stability).is_err() {
        let smallest = smallest_decay(theorem, gamma, beta_fraction);
        return Obstacle::Stability { decay: theorem.decay, smallest };
    }
    let smallest = smallest_gamma(theorem);
    if smallest.is_none_or(|smallest| gamma.is_some_and(|gamma| smallest > gamma)) {
        let alone =
            |channel: &Channel| Theorem4 { disturbances: vec![channel.clone()], ..theorem.clone() };
        let mut impossible = theorem
            .disturbances
            .iter()
            .filter(|channel| smallest.is_none() && smallest_gamma(&alone(channel)).is_none());
        let with =
            |&alpha_d: &f64| smallest_gamma(&Theorem4 { alpha_d, ..theorem.clone() }).is_some();
        return Obstacle::Disturbance {
            gamma,
            smallest,
            alpha_d: theorem.alpha_d,
            channels: impossible.next().map_or("the inputs of all bands together".into(), words),
            possible_alpha_d: match smallest {
                Some(_) => None,
                None => ALPHA_D.iter().copied().find(with),
            },
        };
    }
    let bound = theorem.beta_bound();
    if solve(theorem, Goal::LargestBeta { gamma: None }).is_err() {
        return Obstacle::Fault { alpha_f: theorem.alpha_f, bound };
    }
    let beta = beta_fraction * bound;
    let needed = solve(theorem, Goal::SmallestGamma { beta: Some(beta) });
    Obstacle::Conflict { gamma, beta, gamma_at_bound: needed.ok().map(|x| x.gamma) }
}

/// The smallest gamma under (31) and (33).
fn smallest_gamma(theorem: &Theorem4) -> Option<f64> {
    solve(theorem, Goal::SmallestGamma { beta: None }).ok().map(|x| x.gamma)
}

/// The inputs of a band in words.
fn words(channel: &Channel) -> String {
    let band = match channel.band {
        Band::Low(theta) => format!("up to {theta:.4} rad a sample"),
        Band::High(theta) => format!("from {theta:.4} rad a sample on"),
        Band::Full => "of all frequencies".into(),
    };
    let inputs = match (channel.direction.ncols(), channel.noise.ncols()) {
        (_, 0) => "the disturbances",
        (0, _) => "bounds of the sensor noise",
        _ => "the disturbances with the sensor noise",
    };
    format!("{inputs} {band}")
}

/// A decay rate, near the smallest, with which all conditions can be met.
fn smallest_decay(theorem: &Theorem4, gamma: Option<f64>, beta_fraction: f64) -> Option<f64> {
    let goal = match gamma {
        Some(_) => Goal::LargestBeta { gamma },
        None => Goal::SmallestGamma { beta: Some(beta_fraction * theorem.beta_bound()) },
    };
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
