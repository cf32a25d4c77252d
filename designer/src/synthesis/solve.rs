//! Theorem 4 solved: largest beta for a gamma, smallest gamma for a beta.

use clarabel::solver::{SolverError, SolverStatus};
use steerguard_detector::RULES;

use crate::lmi::affine::{Affine, Variables};
use crate::lmi::matrix::Matrix;
use crate::lmi::solve::minimise_with_cuts;
use crate::problem::channel::Channel;
use crate::synthesis::gains::ObserverGains;
use crate::synthesis::theorem4::{Attenuation, Quantities, Theorem4, Units};

/// Strict inequalities are solved as `X >= MARGIN I`, in units in which the blocks are of magnitude
/// one: large against rounding, small against what it costs in beta and gamma.
pub const MARGIN: f64 = 1e-6;

/// What to ask of Theorem 4.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Goal {
    /// (33) alone.
    Stability,
    /// The largest beta under (32), (33), and under (31) where a gamma is given.
    LargestBeta {
        /// Disturbance attenuation to hold, if any.
        gamma: Option<f64>,
    },
    /// The smallest gamma under (31), (33), and under (32) where a beta is given.
    SmallestGamma {
        /// Fault sensitivity to hold, if any.
        beta: Option<f64>,
    },
}

impl Goal {
    /// A given index counts one; a sought one is measured by the magnitude of D or F.
    fn units(self, theorem: &Theorem4) -> Units {
        let (gamma, beta) = match self {
            Self::LargestBeta { gamma } => (gamma, None),
            Self::SmallestGamma { beta } => (None, beta),
            Self::Stability => (None, None),
        };
        Units {
            gamma: gamma.unwrap_or_else(|| {
                theorem.disturbances.iter().map(Channel::norm).fold(0.0, f64::hypot)
            }),
            beta: beta.unwrap_or_else(|| theorem.fault.norm()),
        }
    }
}

/// A solution of Theorem 4, by the solver's account: gains and the matrices that go with them.
#[derive(Clone, Debug)]
pub struct Synthesis {
    /// The solver's verdict: Solved or AlmostSolved, neither a proof.
    pub status: SolverStatus,
    /// Its iterations.
    pub iterations: u32,
    /// beta, physical: per rad or N m of fault.
    pub beta: f64,
    /// gamma, physical: per unit of disturbance.
    pub gamma: f64,
    /// Gains, Table 2.
    pub gains: ObserverGains,
    /// The matrices by which the gains satisfy (31)-(33).
    pub lyapunov: Lyapunov,
}

/// Matrices of (31)-(33) other than the gains.
#[derive(Clone, Debug, PartialEq)]
pub struct Lyapunov {
    /// P_s,i.
    pub p_s: [Matrix; RULES],
    /// Of (31), by block of disturbances.
    pub attenuation: Vec<AttenuationMatrices>,
    /// P_f,i.
    pub p_f: [Matrix; RULES],
    /// Q_f.
    pub q_f: Matrix,
    /// R.
    pub r: Matrix,
}

/// Matrices of (31) of a block of disturbances.
#[derive(Clone, Debug, PartialEq)]
pub struct AttenuationMatrices {
    /// gamma of the block, physical.
    pub gamma: f64,
    /// P_d,i.
    pub p: [Matrix; RULES],
    /// Q_d.
    pub q: Matrix,
}

/// Why Theorem 4 gave no gains.
#[derive(Debug, thiserror::Error)]
pub enum NoSolution {
    /// The solver found no point that satisfies the inequalities.
    #[error("no solution: {0:?} after {1} iterations")]
    Status(SolverStatus, u32),
    /// R is singular.
    #[error("R is singular to working precision")]
    SingularR,
    /// The solver refused the problem.
    #[error(transparent)]
    Solver(#[from] SolverError),
}

/// Solves Theorem 4.
///
/// # Errors
/// [`NoSolution`], which says what the solver found instead.
pub fn solve(theorem: &Theorem4, goal: Goal) -> Result<Synthesis, NoSolution> {
    let units = goal.units(theorem);
    let theorem = theorem.in_units(units);
    let mut variables = Variables::default();
    let blocks = theorem.disturbances.len();
    let gamma_squared: Vec<Affine> = match goal {
        // All of gamma for the one block there is.
        Goal::LargestBeta { gamma: Some(_) } if blocks == 1 => vec![Affine::number(1.0)],
        _ => (0..blocks).map(|_| variables.scalar()).collect(),
    };
    let beta_squared = match goal {
        Goal::SmallestGamma { beta: Some(_) } => Affine::number(1.0),
        _ => variables.scalar(),
    };
    let sum = |of: &[Affine]| of.iter().fold(Affine::number(0.0), |sum, x| sum + x);
    let total = sum(&gamma_squared);
    let x = &theorem.unknowns(gamma_squared, beta_squared, &mut variables);

    let mut inequalities = theorem.stability(x);
    let mut further = Vec::new();
    let mut attenuate = |inequalities: &mut Vec<Affine>| {
        let [first, others] = theorem.disturbance_attenuation(x);
        inequalities.extend(first);
        further = others;
    };
    let objective = match goal {
        Goal::Stability => Affine::number(0.0),
        Goal::LargestBeta { gamma } => {
            inequalities.extend(theorem.fault_sensitivity(x));
            if gamma.is_some() {
                attenuate(&mut inequalities);
                if blocks > 1 {
                    inequalities.push(Affine::number(1.0) - &total);
                }
            }
            -&x.beta_squared
        }
        Goal::SmallestGamma { beta } => {
            attenuate(&mut inequalities);
            if beta.is_some() {
                inequalities.extend(theorem.fault_sensitivity(x));
            }
            total.clone()
        }
    };
    for inequality in inequalities.iter_mut().chain(&mut further) {
        let order = inequality.order();
        *inequality = &*inequality - &(Matrix::identity(order, order) * MARGIN).into();
    }

    let solution = minimise_with_cuts(&variables, &objective, inequalities, further, MARGIN / 2.0)?;
    if !solution.is_candidate() {
        return Err(NoSolution::Status(solution.status, solution.iterations));
    }
    let at = |expression: &Affine| expression.at(&solution.x);
    let Quantities { p_s, attenuation, p_f, q_f, r, s, w, beta_squared, .. } = x;
    let r = at(r);
    let w = w.each_ref().map(at);
    let gains = ObserverGains::table_2(&r, &at(s), &w, &theorem.a).ok_or(NoSolution::SingularR)?;
    let root = |squared: &Affine| at(squared)[0].max(0.0).sqrt();
    Ok(Synthesis {
        status: solution.status,
        iterations: solution.iterations,
        beta: root(beta_squared) * units.beta,
        gamma: root(&total) * units.gamma,
        gains,
        lyapunov: Lyapunov {
            p_s: p_s.each_ref().map(at),
            attenuation: attenuation
                .iter()
                .map(|Attenuation { gamma_squared, p, q }| AttenuationMatrices {
                    gamma: root(gamma_squared) * units.gamma,
                    p: p.each_ref().map(at),
                    q: at(q),
                })
                .collect(),
            p_f: p_f.each_ref().map(at),
            q_f: at(q_f),
            r,
        },
    })
}
