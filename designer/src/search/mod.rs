//! Method "gap": gains with the largest detection ratio.
//!
//! First the multipliers (alpha_d, alpha_f, V) of Theorem 4 are searched, a synthesis for each: a grid
//! over the magnitudes of alpha_d and V, then Nelder and Mead's simplex from its best points over
//! all of them. Bounded sensor noise has no part in these syntheses, where the vertices of K multiply
//! (31) by sixteen, but in what they are judged by.
//!
//! Then the gains themselves, E and N_i, are refined by a quasi-Newton method, under the decay rate
//! asked for, for modes and for products of two vertices' error dynamics, and under a cap on what the
//! fault makes of e_2 = v_y - v_y^. The optimum found is a local one and the start decides which, so
//! there are several: the best synthesis, the gains of another car carried over, and, moved at random,
//! these and an observer without E. The refined gains no longer satisfy (31)-(33) with known
//! matrices; what they are worth is certified a posteriori. With the matrices of that certificate
//! held, its conditions are affine in E and H_i; alternating between the two raised the certified gap
//! of a trial by 0.2 % and was left out.
//!
//! # Conventions
//! - What is maximised is [`detection_ratio`](crate::analysis::frequency::detection_ratio) of the
//!   frozen error dynamics, beta, gamma and noise each at its worst operating point: that of a
//!   threshold common to all. The search takes a coarser grid of points and frequencies than the
//!   figures that are reported.
//! - Everything is deterministic, whatever the number of processors.

mod cost;
mod multipliers;
mod objective;
mod refine;
mod starts;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use steerguard_detector::{RULES, TsModel};

use crate::analysis::certified::decay_certificate;
use crate::analysis::estimate::EstimateFigures;
use crate::analysis::worth::Worth;
use crate::lmi::matrix::Matrix;
use crate::problem::channel::Channel;
use crate::problem::inputs::Inputs;
use crate::progress::Step;
use crate::search::multipliers::Syntheses;
use crate::search::objective::Objective;
use crate::search::refine::{STEPS, refine};
use crate::search::starts::starts;
use crate::spec::Method;
use crate::synthesis::gains::ObserverGains;
use crate::synthesis::solve::Synthesis;
use crate::synthesis::theorem4::Theorem4;

/// The refinement, where a price stands for the cap on e_2 and a coarser grid for the operating points,
/// is told a cap lower by this factor.
const INSIDE_CAP: f64 = 0.7;
/// Refined gains with a proof of their decay that are certified, the best ones, at most.
const CERTIFIED: usize = 3;
/// Modes and products shall decay faster than asked for by this much, since longer switching costs
/// more than products show: what is tried one after the other. The first raises certified figures by
/// some percent and costs frozen ones next to nothing.
const DECAY_RESERVE: [f64; 4] = [0.04, 0.06, 0.09, 0.14];
/// The same from the synthesis: where sensor noise is bounded, or the certificate far below the frozen
/// figures, its neighbourhood is worth more than the reserve.
const DECAY_RESERVE_OF_SYNTHESIS: [f64; 4] = [0.004, 0.015, 0.04, 0.08];
/// Gains refined from the synthesis are certified beside the others if their ratio is at least this
/// share of the best one's.
const OF_SYNTHESIS: f64 = 0.5;

/// Steps of refinements that stay near the synthesis.
const FEW_STEPS: [usize; 3] = [2, 5, 15];

/// What the search found on its way.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SearchRecord {
    /// Syntheses that were made.
    pub syntheses: usize,
    /// Those that had a solution.
    pub solved: usize,
    /// Detection ratio of the best one's gains.
    pub ratio_of_synthesis: f64,
}

/// The gains found.
pub struct Found {
    /// Refined gains, those of the synthesis, or the mean of both: of those that provably decay the
    /// ones with the largest product of frozen and certified detection ratio, those that hold the cap
    /// on e_2 first.
    pub gains: ObserverGains,
    /// P_s,i that prove their decay.
    pub p_s: [Matrix; RULES],
    /// Their figures.
    pub worth: Worth,
    /// The best synthesis.
    pub synthesis: Synthesis,
    /// With the multipliers of that synthesis.
    pub theorem: Theorem4,
    /// The search.
    pub record: SearchRecord,
    /// Product of frozen and certified detection ratio, less where the cap on e_2 is not held.
    pub merit: f64,
    /// Whether refined gains provably decay, are certified, and hold the cap on e_2: that another
    /// decay rate is not needed.
    pub is_refined: bool,
}

/// Gains that provably decay.
struct Choice {
    gains: ObserverGains,
    p_s: [Matrix; RULES],
    worth: Worth,
    /// By how much e_2 exceeds its cap, 1 where it does not.
    excess: f64,
}

impl Choice {
    fn merit(&self, inputs: &Inputs) -> f64 {
        let ratios = self.worth.detection_ratio(inputs) * self.worth.certified_ratio(inputs);
        ratios / (self.excess * self.excess)
    }
}

/// Searches gains for `inputs`; `theorem` gives the multipliers that the grid is spread around and the
/// decay rate, `cap` what a unit step of the fault may make of e_2, if it is held. None where no
/// synthesis has a solution.
pub fn search(
    theorem: &Theorem4,
    model: &TsModel,
    inputs: &Inputs,
    method: &Method,
    cap: Option<f64>,
    progress: &mut dyn FnMut(Step),
) -> Option<Found> {
    let objective =
        Objective::new(model, inputs, theorem.beta_bound(), cap.map(|cap| INSIDE_CAP * cap));
    let without_noise = Theorem4 {
        disturbances: theorem.disturbances.iter().filter_map(Channel::without_noise).collect(),
        ..theorem.clone()
    };
    let syntheses = Syntheses { theorem: &without_noise, objective: &objective, method };
    let (candidates, made) = syntheses.search(progress);
    let solved = candidates.len();
    let best =
        candidates.into_iter().reduce(|best, x| if x.ratio > best.ratio { x } else { best })?;

    progress(Step::Refine);
    let of_synthesis = objective.to_scale(&best.synthesis.gains, theorem);
    let others = starts(theorem);
    let refined = refined(&objective, &of_synthesis, &others, theorem);

    progress(Step::Certify);
    let excess = |gains: &ObserverGains| {
        let estimate = cap.map(|cap| EstimateFigures::of(model, &gains.gains, &inputs.fault, cap));
        estimate.map_or(1.0, |x| (x.peak_m_per_s_per_deg / x.cap_m_per_s_per_deg).max(1.0))
    };
    let choice = |(gains, p_s): (ObserverGains, [Matrix; RULES])| Choice {
        worth: Worth::of(&gains, theorem, model, inputs),
        excess: excess(&gains),
        gains,
        p_s,
    };
    let mut choices: Vec<Choice> = refined.into_par_iter().map(choice).collect();
    let holds = |x: &Choice| x.worth.certified.is_some() && x.excess <= 1.0;
    let is_refined = choices.iter().any(holds);
    // Where the synthesis has nearly the ratio of the refined gains, it or what lies near it may be
    // certified for more.
    if choices.iter().all(|x| x.worth.certified_ratio(inputs) < best.ratio) {
        let held = objective.with_least_e_2(&of_synthesis, theorem);
        let slowest = theorem.decay - DECAY_RESERVE_OF_SYNTHESIS[0];
        let near = FEW_STEPS.map(|steps| refine(&objective, &held, theorem, slowest, steps));
        let others = near.into_iter().chain([held]);
        choices.extend(others.filter_map(|gains| {
            let p_s = decay_certificate(theorem, &gains)?;
            Some(choice((gains, p_s)))
        }));
    }
    if choices.is_empty() {
        let Synthesis { gains, lyapunov, .. } = &best.synthesis;
        choices.push(choice((*gains, lyapunov.p_s.clone())));
    }
    if is_refined {
        choices.retain(holds);
    }
    let chosen = choices.into_iter().max_by(|a, b| a.merit(inputs).total_cmp(&b.merit(inputs)))?;
    Some(Found {
        merit: chosen.merit(inputs),
        is_refined,
        gains: chosen.gains,
        p_s: chosen.p_s,
        worth: chosen.worth,
        record: SearchRecord { syntheses: made, solved, ratio_of_synthesis: best.ratio },
        synthesis: best.synthesis,
        theorem: best.theorem,
    })
}

/// The gains refined from the synthesis and from the best of other starts, with P_s,i that prove their
/// decay.
fn refined(
    objective: &Objective<'_>,
    of_synthesis: &ObserverGains,
    others: &[ObserverGains],
    theorem: &Theorem4,
) -> Vec<(ObserverGains, [Matrix; RULES])> {
    let ratio = |gains: &ObserverGains| {
        let worst = objective.worst(&gains.gains);
        worst.ratio(objective.inputs) / worst.excess(objective.cap)
    };
    let at = |start: &ObserverGains, reserve: f64| {
        let gains = refine(objective, start, theorem, theorem.decay - reserve, STEPS);
        let gains = objective.with_least_e_2(&gains, theorem);
        (ratio(&gains), gains)
    };
    let proven = |mut gains: ObserverGains, further: &[f64]| {
        for reserve in further {
            if let Some(p_s) = decay_certificate(theorem, &gains) {
                return Some((gains, p_s));
            }
            gains = at(&gains, *reserve).1;
        }
        decay_certificate(theorem, &gains).map(|p_s| (gains, p_s))
    };
    let (near_synthesis, first) = rayon::join(
        || at(of_synthesis, DECAY_RESERVE_OF_SYNTHESIS[0]),
        || -> Vec<(f64, ObserverGains)> {
            let starts = others.par_iter().chain([of_synthesis]);
            starts.map(|start| at(start, DECAY_RESERVE[0])).collect()
        },
    );
    let best = first.iter().map(|(ratio, _)| *ratio).fold(0.0, f64::max);

    let proven_of = |(_, x): &(f64, ObserverGains)| proven(*x, &DECAY_RESERVE[1..]);
    let mut found: Vec<_> = first.par_iter().filter_map(proven_of).collect();
    found.sort_by(|(a, _), (b, _)| ratio(b).total_cmp(&ratio(a)));
    found.truncate(CERTIFIED);
    if near_synthesis.0 >= OF_SYNTHESIS * best {
        found.extend(proven(near_synthesis.1, &DECAY_RESERVE_OF_SYNTHESIS[1..]));
    }
    found
}
