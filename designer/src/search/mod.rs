//! Method "gap": gains with the largest detection ratio.
//!
//! First the multipliers (alpha_d, alpha_f, V) of Theorem 4 are searched, a synthesis for each: a grid
//! over the magnitudes of alpha_d and V, then Nelder and Mead's simplex from its best points over
//! all of them. Bounded sensor noise has no part in these syntheses, where the vertices of K multiply
//! (31) by sixteen, but in what they are judged by.
//!
//! Then the gains themselves, E and N_i, are refined from the best synthesis by a quasi-Newton
//! method, under the decay rate asked for. The refined gains no longer satisfy (31)-(33) with known
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

mod multipliers;
mod objective;
mod refine;

use serde::{Deserialize, Serialize};
use steerguard_detector::{RULES, TsModel};

use crate::analysis::certified::decay_certificate;
use crate::analysis::worth::Worth;
use crate::lmi::matrix::Matrix;
use crate::problem::channel::Channel;
use crate::problem::inputs::Inputs;
use crate::progress::Step;
use crate::search::multipliers::Syntheses;
use crate::search::objective::Objective;
use crate::search::refine::{mean, refine};
use crate::spec::Method;
use crate::synthesis::gains::ObserverGains;
use crate::synthesis::solve::Synthesis;
use crate::synthesis::theorem4::Theorem4;

/// The frozen modes shall decay faster than asked for by this much: switching costs some of it. What
/// is tried one after the other.
const DECAY_RESERVE: [f64; 4] = [0.004, 0.015, 0.03, 0.06];

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
    /// ones with the largest product of frozen and certified detection ratio.
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
}

/// Searches gains for `inputs`; `theorem` gives the multipliers that the grid is spread around. None
/// where no synthesis has a solution.
pub fn search(
    theorem: &Theorem4,
    model: &TsModel,
    inputs: &Inputs,
    method: &Method,
    progress: &mut dyn FnMut(Step),
) -> Option<Found> {
    let objective = Objective::new(model, inputs, theorem.beta_bound());
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
    let refined = DECAY_RESERVE.iter().find_map(|reserve| {
        let gains = refine(&objective, &of_synthesis, theorem, theorem.decay - reserve);
        Some((gains, decay_certificate(theorem, &gains)?))
    });
    let worth = |(gains, p_s): (ObserverGains, [Matrix; RULES])| {
        let worth = Worth::of(&gains, theorem, model, inputs);
        (gains, p_s, worth)
    };
    progress(Step::Certify);
    let mut choices: Vec<_> = refined.map(worth).into_iter().collect();
    // Where the synthesis has nearly the ratio of the refined gains, it or the mean of both may be
    // certified for more.
    if choices.first().is_none_or(|(.., x)| x.certified_ratio(inputs) < best.ratio) {
        let mean = choices.first().map(|(refined, ..)| mean(&of_synthesis, refined, theorem));
        let others = mean.into_iter().chain([of_synthesis]);
        choices.extend(others.filter_map(|gains| {
            let p_s = decay_certificate(theorem, &gains)?;
            Some(worth((gains, p_s)))
        }));
    }
    if choices.is_empty() {
        let Synthesis { gains, lyapunov, .. } = &best.synthesis;
        choices.push(worth((*gains, lyapunov.p_s.clone())));
    }
    let merit = |x: &Worth| x.detection_ratio(inputs) * x.certified_ratio(inputs);
    let (gains, p_s, worth) =
        choices.into_iter().max_by(|(.., a), (.., b)| merit(a).total_cmp(&merit(b)))?;
    Some(Found {
        gains,
        p_s,
        worth,
        record: SearchRecord { syntheses: made, solved, ratio_of_synthesis: best.ratio },
        synthesis: best.synthesis,
        theorem: best.theorem,
    })
}
