//! Certified gains of given error dynamics: what the gains are worth, a posteriori (METHOD.md 5.3).
//!
//! Where Theorem 4 ties its multiplier to the gains, here the gains are numbers and the multipliers
//! X_jk are free. For the error dynamics `e+ = N_i(rho) e + B w`, with w the disturbances or the
//! fault, and every rule i, j of this sample, k of the next and vertex of rho,
//!
//! ```text
//! L_k(i, j) = base(P_i, P_k, Q) + quadratic + He( X_jk [N_i(rho), B, -I] )     over (e, w, e+)
//!
//! L_k(i, i) < 0,   L_k(i, j) + L_k(j, i) < 0 for i < j,   Q > 0
//! ```
//!
//! with base and quadratic of Theorem 4. Weighted by the membership functions of both samples these
//! sum up to `L(h, h+) < 0`; along the error's course X drops out, and the sum over all samples is
//! `||r|| < gamma ||d||`, or `||r|| > beta ||f||`.
//!
//! # Conventions
//! - P_i are symmetric and have no sign; Q is common to all rules, and zero for the full band.
//! - What is found here is a claim. `steerguard_verify` proves it, in exact arithmetic.

use std::thread;

use clarabel::solver::{SolverError, SolverStatus};
use serde::{Deserialize, Serialize};
use steerguard_detector::{C, RULES};

use crate::certificate::{ErrorDynamics, error_dynamics};
use crate::frequency::Frozen;
use crate::gains::{ObserverGains, rows};
use crate::lmi::{self, Affine, Matrix, Variables, smallest_eigenvalue};
use crate::theorem4::{Band, Theorem4, VERTICES_OF_RHO, diagonal, matrix};

/// Strict inequalities are solved as `X >= MARGIN I`, in units in which residual and input are of
/// magnitude one: what the solver's own tolerance may violate them by is smaller.
const MARGIN: f64 = 1e-7;
/// Smallest eigenvalue, in the same units, that rounding cannot have made up.
const CONFIRMED: f64 = 1e-9;
/// Steps from the optimum, relative.
const BACK_OFF: [f64; 2] = [1e-3, 1e-2];
/// No larger margin is asked for.
const LARGEST_MARGIN: f64 = 1e-4;
/// Rounding of `2 cos(theta)`, of magnitude two, with theta's own.
const COSINE_ROUNDING: f64 = 16.0 * f64::EPSILON;
/// Rounding of the gap.
const GAP_ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Which gain is certified.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gain {
    /// gamma: the largest, `||r|| < gamma ||w||`.
    Largest,
    /// beta: the smallest, `||r|| > beta ||w||`.
    Smallest,
}

/// Certified figures.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CertifiedFigures {
    /// Smallest gain from the fault over its band, per rad or N m.
    pub beta: f64,
    /// Largest gain from the disturbances over their band, per unit of the first.
    pub gamma: f64,
    /// `beta / gamma`, each channel in units of its smallest fault and of its bound.
    pub gap: f64,
    /// gamma of all frequencies: holds without a condition on the error.
    pub gamma_full_band: f64,
    /// The error decays at least like decay^k.
    pub decay: f64,
}

/// The matrices behind the figures, beside P_s for the decay.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct APosteriori {
    /// Of beta.
    pub beta: GainCertificate,
    /// Of gamma.
    pub gamma: GainCertificate,
    /// Of gamma for all frequencies.
    pub gamma_full_band: GainCertificate,
}

/// The matrices that prove a gain.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GainCertificate {
    /// Null for the full band.
    pub band: Option<BandCertificate>,
    /// P_i, symmetric.
    #[serde(rename = "P")]
    pub p: [[[f64; 3]; 3]; RULES],
    /// X_jk by j and k, (6 + n_w) x 3: rows of e, of the input, of e+.
    #[serde(rename = "X")]
    pub x: [[Vec<[f64; 3]>; RULES]; RULES],
}

/// What makes a gain one over a band.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BandCertificate {
    /// `2 cos(theta)`, rounded down for a low band and up for a high one: to the safe side.
    pub two_cos_theta: f64,
    /// Q, symmetric.
    #[serde(rename = "Q")]
    pub q: [[f64; 3]; 3],
}

/// Why no gain was found.
#[derive(Debug, thiserror::Error)]
pub enum NoCertificate {
    /// The solver found no point that satisfies the inequalities.
    #[error("no solution: {0:?} after {1} iterations")]
    Status(SolverStatus, u32),
    /// The solver's points do not satisfy them.
    #[error("the solver's best point misses an inequality: smallest eigenvalue {0:.1e}")]
    Margin(f64),
    /// The solver refused the problem.
    #[error(transparent)]
    Solver(#[from] SolverError),
}

/// The figures that can be certified for `gains`, and their matrices. `frozen` gives the
/// magnitudes, `smallest_fault` and `bound` the units of the gap.
///
/// # Errors
/// [`NoCertificate`] of the first figure that has none.
pub fn certified(
    theorem: &Theorem4,
    gains: &ObserverGains,
    frozen: &Frozen,
    smallest_fault: f64,
    bound: f64,
) -> Result<(CertifiedFigures, APosteriori), NoCertificate> {
    let dynamics = &error_dynamics(theorem, gains);
    let m = matrix(&gains.gains.m);
    let [from_fault, from_disturbances] = &[&m * &theorem.f, &m * &theorem.d];
    let (beta, gamma, full) = thread::scope(|scope| {
        let beta = scope.spawn(move || {
            certify(dynamics, from_fault, theorem.fault_band, Gain::Smallest, frozen.beta)
        });
        let largest =
            |band| certify(dynamics, from_disturbances, band, Gain::Largest, frozen.gamma);
        let (gamma, full) = (largest(theorem.disturbance_band), largest(Band::Full));
        (beta.join(), gamma, full)
    });
    let (beta, beta_certificate) = beta.unwrap_or_else(|panic| std::panic::resume_unwind(panic))?;
    let ((gamma, gamma_certificate), (gamma_full_band, full_certificate)) = (gamma?, full?);
    let figures = CertifiedFigures {
        beta,
        gamma,
        gap: beta * smallest_fault / (gamma * bound) * (1.0 - GAP_ROUNDING),
        gamma_full_band,
        decay: theorem.decay,
    };
    let matrices = APosteriori {
        beta: beta_certificate,
        gamma: gamma_certificate,
        gamma_full_band: full_certificate,
    };
    Ok((figures, matrices))
}

/// The best `gain` that can be certified from an input of direction `input` (`M D` or `M F`,
/// 3 x n_w) in `band`, and its matrices; `expected` gives its magnitude.
///
/// # Errors
/// [`NoCertificate`], which says what the solver found instead.
pub fn certify(
    dynamics: &ErrorDynamics,
    input: &Matrix,
    band: Band,
    gain: Gain,
    expected: f64,
) -> Result<(f64, GainCertificate), NoCertificate> {
    let unit = if expected.is_normal() { expected } else { input.norm() };
    let problem = Problem { dynamics, input: input / unit, band, gain };
    let point = problem.best()?;

    // Back to the input's own unit: a congruence, which scales the input's rows of X.
    let rows_of_x = |x: &Matrix| {
        let mut x = x.clone();
        x.rows_mut(3, input.ncols()).scale_mut(unit);
        x.row_iter().map(|row| [row[0], row[1], row[2]]).collect()
    };
    let in_band = |two_cos_theta| BandCertificate { two_cos_theta, q: rows(&point.q) };
    let certificate = GainCertificate {
        band: match band {
            Band::Low(theta) => Some(in_band(2.0 * theta.cos() - COSINE_ROUNDING)),
            Band::High(theta) => Some(in_band(2.0 * theta.cos() + COSINE_ROUNDING)),
            Band::Full => None,
        },
        p: point.p.each_ref().map(rows),
        x: point.x.each_ref().map(|x| x.each_ref().map(rows_of_x)),
    };
    Ok((point.squared.sqrt() * unit, certificate))
}

/// The conditions of one gain, in a unit in which it is near one.
struct Problem<'a> {
    dynamics: &'a ErrorDynamics,
    input: Matrix,
    band: Band,
    gain: Gain,
}

/// The decision variables other than the gain.
struct Unknowns {
    p: [Affine; RULES],
    q: Affine,
    x: [[Affine; RULES]; RULES],
}

/// Numbers for them, the gain squared, and the smallest eigenvalue of the conditions.
struct Point {
    squared: f64,
    p: [Matrix; RULES],
    q: Matrix,
    x: [[Matrix; RULES]; RULES],
    margin: f64,
}

impl Problem<'_> {
    /// The optimum, or what lies a little beside it where the solver, on the boundary of the
    /// feasible set, ends outside.
    fn best(&self) -> Result<Point, NoCertificate> {
        let optimum = self.optimum()?;
        if optimum.margin > CONFIRMED {
            return Ok(optimum);
        }
        let mut margin = optimum.margin;
        for step in BACK_OFF {
            let factor = match self.gain {
                Gain::Largest => 1.0 + step,
                Gain::Smallest => 1.0 - step,
            };
            let inside = self.inside(optimum.squared * factor * factor)?;
            if inside.margin > CONFIRMED {
                return Ok(inside);
            }
            margin = inside.margin;
        }
        Err(NoCertificate::Margin(margin))
    }

    /// The best gain, with a small margin.
    fn optimum(&self) -> Result<Point, NoCertificate> {
        let mut variables = Variables::default();
        let squared = variables.scalar();
        let objective = match self.gain {
            Gain::Largest => squared.clone(),
            Gain::Smallest => -&squared,
        };
        self.solve(variables, squared, Affine::number(MARGIN), objective)
    }

    /// The largest margin for a gain.
    fn inside(&self, squared: f64) -> Result<Point, NoCertificate> {
        let mut variables = Variables::default();
        let margin = variables.scalar();
        let objective = -&margin;
        self.solve(variables, Affine::number(squared), margin, objective)
    }

    fn solve(
        &self,
        mut variables: Variables,
        squared: Affine,
        margin: Affine,
        objective: Affine,
    ) -> Result<Point, NoCertificate> {
        let unknowns = Unknowns {
            p: std::array::from_fn(|_| variables.symmetric(3)),
            q: variables.symmetric(3),
            x: std::array::from_fn(|_| {
                std::array::from_fn(|_| variables.full(6 + self.input.ncols(), 3))
            }),
        };
        let conditions = self.conditions(&squared, &unknowns);
        let mut inequalities: Vec<Affine> = conditions
            .iter()
            .map(|condition| condition - &margin.times_identity(condition.order()))
            .collect();
        inequalities.push(Affine::number(LARGEST_MARGIN) - &margin);
        let solution = lmi::minimise(&variables, &objective, &inequalities)?;
        let at = |expression: &Affine| expression.at(&solution.x);
        if !solution.is_candidate() || at(&squared)[0] <= 0.0 {
            return Err(NoCertificate::Status(solution.status, solution.iterations));
        }
        let eigenvalues = conditions.iter().map(|condition| smallest_eigenvalue(&at(condition)));
        Ok(Point {
            squared: at(&squared)[0],
            margin: eigenvalues.fold(f64::INFINITY, f64::min),
            p: unknowns.p.each_ref().map(at),
            q: at(&unknowns.q),
            x: unknowns.x.each_ref().map(|x| x.each_ref().map(at)),
        })
    }

    /// The inequalities at the head of this module.
    fn conditions(&self, squared: &Affine, unknowns: &Unknowns) -> Vec<Affine> {
        let Self { dynamics, input, band, gain } = self;
        let Unknowns { p, q, x } = unknowns;
        let inputs = input.ncols();
        let c = matrix(&C);
        let residual = Affine::from(c.transpose() * &c);
        let square = squared.times_identity(inputs);
        let quadratic = match gain {
            Gain::Largest => diagonal(&residual, &-square),
            Gain::Smallest => diagonal(&-residual, &square),
        };
        let course: [[Matrix; RULES]; VERTICES_OF_RHO] =
            std::array::from_fn(|vertex| dynamics.each_ref().map(|n| row(&n[vertex], input)));
        let mut inequalities = vec![q.clone()];
        for k in 0..RULES {
            for course in &course {
                let l = |i: usize, j: usize| {
                    let finsler = (&x[j][k] * &course[i]).he();
                    band.base(&p[i], &p[k], q, inputs) + &quadratic + finsler
                };
                for i in 0..RULES {
                    inequalities.push(-l(i, i));
                    inequalities.extend((i + 1..RULES).map(|j| -(l(i, j) + l(j, i))));
                }
            }
        }
        inequalities
    }
}

/// `[N, B, -I]`, which sends (e, w, e+) to zero along the error's course.
fn row(n: &Matrix, input: &Matrix) -> Matrix {
    let minus_identity = -Matrix::identity(3, 3);
    let columns: Vec<_> =
        n.column_iter().chain(input.column_iter()).chain(minus_identity.column_iter()).collect();
    Matrix::from_columns(&columns)
}
