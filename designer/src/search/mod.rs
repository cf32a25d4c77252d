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
//! - What is maximised is [`detection_ratio`] of the frozen error dynamics, beta, gamma and noise
//!   each at its worst operating point: that of a threshold common to all. The search takes a
//!   coarser grid of points and frequencies than the figures that are reported.
//! - Everything is deterministic, whatever the number of processors.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use argmin::core::{CostFunction, Executor, Gradient};
use argmin::solver::linesearch::MoreThuenteLineSearch;
use argmin::solver::neldermead::NelderMead;
use argmin::solver::quasinewton::LBFGS;
use nalgebra::Complex;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use steerguard_detector::{C, Gains, RULES, TsModel};

use crate::analysis::certified::decay_certificate;
use crate::analysis::frequency::{detection_ratio, noise_rms};
use crate::analysis::operating_point::{
    Column, FrozenError, OperatingPoint, extreme_gains, spectral_radius,
};
use crate::analysis::worth::Worth;
use crate::lmi::Matrix;
use crate::problem::band::Band;
use crate::problem::channel::Channel;
use crate::problem::inputs::Inputs;
use crate::progress::Step;
use crate::spec::Method;
use crate::synthesis::gains::ObserverGains;
use crate::synthesis::solve::{Goal, Synthesis, solve};
use crate::synthesis::theorem4::{Theorem4, matrix};

/// Magnitudes of alpha_d on the grid, in units of the given one.
const ALPHA_D: [f64; 2] = [1.0, 0.025];
/// Magnitudes of V on the grid, in units of the given one.
const V: [f64; 3] = [1.0, 30.0, 1000.0];
/// Size of the simplex: of alpha_d and V in natural logarithms, of alpha_f, and of V's direction.
const SIMPLEX: f64 = 0.7;
/// Exponents of the sums of powers that stand for minima and maxima, one refinement after the other.
const EXPONENTS: [f64; 3] = [12.0, 30.0, 80.0];
/// Quasi-Newton iterations of each.
const ITERATIONS: u64 = 80;
/// Pairs of steps that the quasi-Newton method remembers.
const MEMORY: usize = 12;
/// Relative step of the difference quotients.
const DIFFERENCE: f64 = 1e-7;
/// The frozen modes shall decay faster than asked for by this much: switching costs some of it. What
/// is tried one after the other.
const DECAY_RESERVE: [f64; 4] = [0.004, 0.015, 0.03, 0.06];
/// Price of a mode that decays too slowly.
const PENALTY: f64 = 1e3;
/// Price of a residual whose scale drifts, by the square of its logarithm.
const DRIFT_PRICE: f64 = 0.01;
/// Modes no slower than this keep their noise in the search.
const STABLE: f64 = 0.995;
/// Frequencies across a low band, and across others.
const LOW_FREQUENCIES: u32 = 3;
const OTHER_FREQUENCIES: u32 = 15;

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
        let gains = objective.refine(&of_synthesis, theorem, theorem.decay - reserve);
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

/// A synthesis and what its gains are worth.
struct Candidate {
    theorem: Theorem4,
    synthesis: Synthesis,
    ratio: f64,
}

/// The syntheses of a search.
struct Syntheses<'a> {
    theorem: &'a Theorem4,
    objective: &'a Objective<'a>,
    method: &'a Method,
}

/// Coordinates of the multipliers: logarithms of alpha_d and of V's magnitude in units of the given
/// ones, alpha_f less the given one, and V's direction as three numbers around the given one.
type Coordinates = Vec<f64>;

impl Syntheses<'_> {
    /// All syntheses that have a solution, and how many were made.
    fn search(&self, progress: &mut dyn FnMut(Step)) -> (Vec<Candidate>, usize) {
        let of = self.method.search_budget;
        let grid: Vec<Coordinates> = ALPHA_D
            .into_iter()
            .flat_map(|alpha_d| V.map(|v| vec![f64::ln(alpha_d), f64::ln(v), 0.0, 0.0, 0.0, 0.0]))
            .take(of)
            .collect();
        let made = grid.len();
        progress(Step::Search { done: 0, of });
        let mut found: Vec<(Coordinates, Candidate)> = grid
            .into_par_iter()
            .filter_map(|x| self.candidate(&x).map(|candidate| (x, candidate)))
            .collect();
        progress(Step::Search { done: made, of });

        // A simplex from each of the two best, with half of what is left of the budget.
        found.sort_by(|a, b| b.1.ratio.total_cmp(&a.1.ratio));
        let starts: Vec<Coordinates> = found.iter().take(2).map(|(x, _)| x.clone()).collect();
        let budget = (of - made) / starts.len().max(1);
        let mut candidates: Vec<Candidate> = found.into_iter().map(|(_, x)| x).collect();
        candidates.par_extend(starts.par_iter().flat_map_iter(|start| self.simplex(start, budget)));
        let made = made + budget * starts.len();
        progress(Step::Search { done: made, of });
        (candidates, made)
    }

    /// Nelder and Mead's search from `start`: the candidates of at most `budget` syntheses.
    fn simplex(&self, start: &Coordinates, budget: usize) -> Vec<Candidate> {
        let tried = Tried { syntheses: self, budget, found: Mutex::default(), made: 0.into() };
        let mut corners = vec![start.clone()];
        for axis in 0..start.len() {
            let mut corner = start.clone();
            corner[axis] += SIMPLEX;
            corners.push(corner);
        }
        let solver = NelderMead::new(corners);
        // What comes out of it stands in `tried`.
        let _ =
            Executor::new(&tried, solver).configure(|state| state.max_iters(budget as u64)).run();
        tried.found.into_inner().unwrap_or_else(PoisonError::into_inner)
    }

    /// The synthesis with the multipliers `x`.
    fn candidate(&self, x: &[f64]) -> Option<Candidate> {
        let given = self.theorem;
        let [ln_alpha_d, ln_v, alpha_f, turn @ ..] = x else { return None };
        let size = given.v.norm();
        let direction =
            Matrix::from_fn(given.v.nrows(), 3, |row, k| given.v[(row, k)] / size + turn[k] * 0.3);
        let theorem = Theorem4 {
            alpha_d: ln_alpha_d.exp() * if given.alpha_d > 0.0 { given.alpha_d } else { 1.0 },
            alpha_f: given.alpha_f + alpha_f * 0.5,
            v: &direction * (ln_v.exp() * size / direction.norm()),
            ..given.clone()
        };
        let beta = self.method.beta_fraction * theorem.beta_bound();
        let synthesis = solve(&theorem, Goal::SmallestGamma { beta: Some(beta) }).ok()?;
        let ratio = self.objective.worst(&synthesis.gains.gains).ratio(self.objective.inputs);
        ratio.is_finite().then_some(Candidate { theorem, synthesis, ratio })
    }
}

/// The cost of multipliers, and a record of what was tried.
struct Tried<'a> {
    syntheses: &'a Syntheses<'a>,
    budget: usize,
    found: Mutex<Vec<Candidate>>,
    made: AtomicUsize,
}

impl CostFunction for &Tried<'_> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, x: &Vec<f64>) -> Result<f64, argmin::core::Error> {
        /// Worse than any synthesis, and finite.
        const NONE: f64 = 1e9;
        // The start's synthesis is made again: the budget counts it.
        if self.made.fetch_add(1, Ordering::Relaxed) >= self.budget {
            return Ok(NONE);
        }
        let Some(candidate) = self.syntheses.candidate(x) else { return Ok(NONE) };
        let cost = -candidate.ratio.ln();
        self.found.lock().unwrap_or_else(PoisonError::into_inner).push(candidate);
        Ok(cost)
    }
}

/// beta, gamma and noise, each at its worst operating point.
#[derive(Clone, Copy, Debug)]
struct Worst {
    beta: f64,
    gamma: f64,
    noise_rms: f64,
}

impl Worst {
    fn ratio(self, inputs: &Inputs) -> f64 {
        detection_ratio(self.beta, self.gamma, self.noise_rms, inputs)
    }
}

/// What the search maximises.
struct Objective<'a> {
    points: Vec<OperatingPoint>,
    inputs: &'a Inputs,
    /// The beta that refined gains are held near: the ratio does not change with the residual's
    /// scale.
    scale: f64,
    fault_frequencies: Vec<f64>,
    disturbance_frequencies: Vec<Vec<f64>>,
}

impl<'a> Objective<'a> {
    fn new(model: &TsModel, inputs: &'a Inputs, scale: f64) -> Self {
        let frequencies = |band: Band| match band {
            Band::Low(_) => band.grid(LOW_FREQUENCIES).collect(),
            _ => band.grid(OTHER_FREQUENCIES).collect(),
        };
        Self {
            points: OperatingPoint::coarse_grid(model),
            inputs,
            scale,
            fault_frequencies: frequencies(inputs.fault.band),
            disturbance_frequencies: inputs
                .disturbances
                .iter()
                .map(|channel| frequencies(channel.band))
                .collect(),
        }
    }

    /// beta and gamma squared at a point. None where a frequency is an eigenvalue.
    fn at(&self, error: &FrozenError) -> Option<[f64; 2]> {
        let output = error.output.map(Complex::from);
        let extremes = |columns: &[Column], w| {
            let to_residual = output * error.resolvent(w)?;
            Some(extreme_gains(columns.iter().map(|(b, d)| to_residual * b + d)))
        };
        let mut beta = f64::INFINITY;
        let fault = error.columns(&self.inputs.fault);
        for &w in &self.fault_frequencies {
            beta = beta.min(extremes(&fault, w)?[1]);
        }
        let mut gamma_squared = 0.0;
        for (channel, frequencies) in
            self.inputs.disturbances.iter().zip(&self.disturbance_frequencies)
        {
            let columns = error.columns(channel);
            let mut gamma = 0.0_f64;
            for &w in frequencies {
                gamma = gamma.max(extremes(&columns, w)?[0]);
            }
            gamma_squared += gamma * gamma;
        }
        Some([beta, gamma_squared])
    }

    /// The worst figures of `gains`.
    fn worst(&self, gains: &Gains) -> Worst {
        let none = Worst { beta: 0.0, gamma: f64::INFINITY, noise_rms: f64::INFINITY };
        let mut worst = Worst { beta: f64::INFINITY, gamma: 0.0, noise_rms: 0.0 };
        for point in &self.points {
            let error = FrozenError::new(point, gains, self.inputs.weights);
            let Some([beta, gamma_squared]) = self.at(&error) else { return none };
            worst.beta = worst.beta.min(beta);
            worst.gamma = worst.gamma.max(gamma_squared.sqrt());
            worst.noise_rms = worst.noise_rms.max(noise_rms(&error, self.inputs.white_std));
        }
        worst
    }

    /// A smooth cost near `-ln` of the detection ratio: sums of powers in place of extremes, and a
    /// price on modes slower than `slowest`.
    fn cost(&self, gains: &Gains, exponent: f64, slowest: f64) -> f64 {
        let (mut ln_beta, mut ln_gamma, mut ln_noise) = (vec![], vec![], vec![]);
        let mut penalty = 0.0;
        for point in &self.points {
            let error = FrozenError::new(point, gains, self.inputs.weights);
            let radius = spectral_radius(&error.n);
            penalty += PENALTY * (radius - slowest).max(0.0).powi(2);
            // Beyond stability the noise goes on growing with the gains, not to infinity: the line
            // search can turn back.
            let contracted = FrozenError { n: error.n * f64::min(1.0, STABLE / radius), ..error };
            let Some([beta, gamma_squared]) = self.at(&error) else {
                return f64::INFINITY;
            };
            let variance = noise_rms(&contracted, self.inputs.white_std).powi(2);
            ln_beta.push(beta.ln());
            ln_gamma.push(gamma_squared.ln());
            ln_noise.push(variance.ln());
        }
        let smallest = -soft_maximum(ln_beta.iter().map(|x| -x), exponent);
        let largest = |x: &[f64]| soft_maximum(x.iter().copied(), exponent / 2.0).exp();
        let bound = self.inputs.bound;
        let background = largest(&ln_gamma) * bound * bound + largest(&ln_noise);
        let ratio = smallest + self.inputs.smallest_fault.ln() - background.ln() / 2.0;
        let scale = smallest - self.scale.ln();
        penalty + DRIFT_PRICE * scale * scale - ratio
    }

    /// Gains near `start` with the smallest cost found.
    fn refine(&self, start: &ObserverGains, theorem: &Theorem4, slowest: f64) -> ObserverGains {
        let mut best = coordinates(&self.to_scale(start, theorem).gains);
        for exponent in EXPONENTS {
            let refinement = Refinement {
                objective: self,
                theorem,
                exponent,
                slowest,
                best: Mutex::new((f64::INFINITY, best.clone())),
            };
            let line_search = MoreThuenteLineSearch::new();
            // What comes out of it, whatever the reason to end, stands in `refinement`.
            let _ = Executor::new(&refinement, LBFGS::new(line_search, MEMORY))
                .configure(|state| state.param(best.clone()).max_iters(ITERATIONS))
                .run();
            best = refinement.best.into_inner().unwrap_or_else(PoisonError::into_inner).1;
        }
        self.to_scale(&gains_at(&best, theorem), theorem)
    }
}

impl Objective<'_> {
    /// Gains with the same ratio whose beta is that of the scale: with T = diag(s, 1, s) in place of
    /// the error e stands T e, N_i becomes T N_i T^-1 and M becomes T M, which keeps its second
    /// column, and N_i's that of M A_i; the residual becomes s r. G rho acts on v_y alone, which T
    /// leaves as it is.
    fn to_scale(&self, gains: &ObserverGains, theorem: &Theorem4) -> ObserverGains {
        let s = self.scale / self.worst(&gains.gains).beta;
        if !s.is_normal() {
            return *gains;
        }
        let t = |k: usize| if k == 1 { 1.0 } else { s };
        let c = matrix(&C);
        let m = matrix(&gains.gains.m);
        let scaled_m = Matrix::from_fn(3, 3, |row, k| t(row) * m[(row, k)]);
        let e = (&scaled_m - Matrix::identity(3, 3)) * c.transpose();
        let h: [Matrix; RULES] = std::array::from_fn(|i| {
            let n = matrix(&gains.gains.n[i]);
            let n = Matrix::from_fn(3, 3, |row, k| t(row) * n[(row, k)] / t(k));
            (&scaled_m * &theorem.a[i] - n) * c.transpose() // (35)
        });
        ObserverGains::new(&e, &h, &theorem.a)
    }
}

/// `ln (sum exp(k x))^(1/k)`, near the largest x.
fn soft_maximum(x: impl Iterator<Item = f64> + Clone, k: f64) -> f64 {
    let largest = x.clone().fold(f64::NEG_INFINITY, f64::max);
    if !largest.is_finite() {
        return largest;
    }
    largest + x.map(|x| (k * (x - largest)).exp()).sum::<f64>().ln() / k
}

/// Coordinates of gains: E, then the first and third column of each N_i; the second is that of M A_i.
fn coordinates(gains: &Gains) -> Vec<f64> {
    let e = gains.e.iter().flatten().copied();
    let n = gains.n.iter().flat_map(|n| n.iter().flat_map(|row| [row[0], row[2]]));
    e.chain(n).collect()
}

/// The gains with the given coordinates.
fn gains_at(x: &[f64], theorem: &Theorem4) -> ObserverGains {
    let (of_e, of_n) = x.split_at(6);
    let e = Matrix::from_row_slice(3, 2, of_e);
    let c = matrix(&C);
    let m = Matrix::identity(3, 3) + &e * &c; // (11)
    let h: [Matrix; RULES] = std::array::from_fn(|i| {
        let of_rule = Matrix::from_row_slice(3, 2, &of_n[6 * i..6 * i + 6]);
        (&m * &theorem.a[i]) * c.transpose() - of_rule // (35)
    });
    ObserverGains::new(&e, &h, &theorem.a)
}

/// The gains halfway between two.
fn mean(a: &ObserverGains, b: &ObserverGains, theorem: &Theorem4) -> ObserverGains {
    let [a, b] = [a, b].map(|x| coordinates(&x.gains));
    let middle: Vec<f64> = a.iter().zip(&b).map(|(a, b)| (a + b) / 2.0).collect();
    gains_at(&middle, theorem)
}

/// The cost of gains for the quasi-Newton method, and the best seen.
struct Refinement<'a> {
    objective: &'a Objective<'a>,
    theorem: &'a Theorem4,
    exponent: f64,
    slowest: f64,
    best: Mutex<(f64, Vec<f64>)>,
}

impl Refinement<'_> {
    fn cost_at(&self, x: &[f64]) -> f64 {
        let gains = gains_at(x, self.theorem).gains;
        self.objective.cost(&gains, self.exponent, self.slowest)
    }
}

impl CostFunction for &Refinement<'_> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, x: &Vec<f64>) -> Result<f64, argmin::core::Error> {
        let cost = self.cost_at(x);
        let mut best = self.best.lock().unwrap_or_else(PoisonError::into_inner);
        if cost < best.0 {
            *best = (cost, x.clone());
        }
        Ok(cost)
    }
}

impl Gradient for &Refinement<'_> {
    type Param = Vec<f64>;
    type Gradient = Vec<f64>;

    fn gradient(&self, x: &Vec<f64>) -> Result<Vec<f64>, argmin::core::Error> {
        let slope = |axis: usize| {
            let step = DIFFERENCE * x[axis].abs().max(1e-2);
            let at = |shift: f64| {
                let mut x = x.clone();
                x[axis] += shift;
                self.cost_at(&x)
            };
            (at(step) - at(-step)) / (2.0 * step)
        };
        Ok((0..x.len()).into_par_iter().map(slope).collect())
    }
}
