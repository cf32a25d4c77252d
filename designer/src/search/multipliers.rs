//! The search for the multipliers (alpha_d, alpha_f, V) of Theorem 4.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use argmin::core::{CostFunction, Executor};
use argmin::solver::neldermead::NelderMead;
use rayon::prelude::*;

use crate::lmi::matrix::Matrix;
use crate::progress::Step;
use crate::search::objective::Objective;
use crate::spec::Method;
use crate::synthesis::solve::{Goal, Synthesis, solve};
use crate::synthesis::theorem4::Theorem4;

/// Magnitudes of alpha_d on the grid, in units of the given one.
const ALPHA_D: [f64; 2] = [1.0, 0.025];
/// Magnitudes of V on the grid, in units of the given one.
const V: [f64; 3] = [1.0, 30.0, 1000.0];
/// Size of the simplex: of alpha_d and V in natural logarithms, of alpha_f, and of V's direction.
const SIMPLEX: f64 = 0.7;

/// A synthesis and what its gains are worth.
pub(super) struct Candidate {
    pub(super) theorem: Theorem4,
    pub(super) synthesis: Synthesis,
    pub(super) ratio: f64,
}

/// The syntheses of a search.
pub(super) struct Syntheses<'a> {
    pub(super) theorem: &'a Theorem4,
    pub(super) objective: &'a Objective<'a>,
    pub(super) method: &'a Method,
}

/// Coordinates of the multipliers: logarithms of alpha_d and of V's magnitude in units of the given
/// ones, alpha_f less the given one, and V's direction as three numbers around the given one.
type Coordinates = Vec<f64>;

impl Syntheses<'_> {
    /// All syntheses that have a solution, and how many were made.
    pub(super) fn search(&self, progress: &mut dyn FnMut(Step)) -> (Vec<Candidate>, usize) {
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
