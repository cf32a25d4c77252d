//! Gains refined by a quasi-Newton method.

use std::sync::{Mutex, PoisonError};

use argmin::core::{CostFunction, Executor, Gradient};
use argmin::solver::linesearch::MoreThuenteLineSearch;
use argmin::solver::quasinewton::LBFGS;
use rayon::prelude::*;
use steerguard_detector::{C, Gains, RULES};

use crate::lmi::matrix::{Matrix, matrix};
use crate::search::objective::Objective;
use crate::synthesis::gains::ObserverGains;
use crate::synthesis::theorem4::Theorem4;

/// Exponents of the sums of powers that stand for minima and maxima, one refinement after the other.
const EXPONENTS: [f64; 3] = [12.0, 30.0, 80.0];
/// Quasi-Newton iterations of each.
const ITERATIONS: u64 = 80;
/// Pairs of steps that the quasi-Newton method remembers.
const MEMORY: usize = 12;
/// Relative step of the difference quotients.
const DIFFERENCE: f64 = 1e-7;

/// Gains near `start` with the smallest cost found.
pub(super) fn refine(
    objective: &Objective<'_>,
    start: &ObserverGains,
    theorem: &Theorem4,
    slowest: f64,
) -> ObserverGains {
    let mut best = coordinates(&objective.to_scale(start, theorem).gains);
    for exponent in EXPONENTS {
        let refinement = Refinement {
            objective,
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
    objective.to_scale(&gains_at(&best, theorem), theorem)
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
pub(super) fn mean(a: &ObserverGains, b: &ObserverGains, theorem: &Theorem4) -> ObserverGains {
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
