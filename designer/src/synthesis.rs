//! Theorem 4 solved: largest beta for a gamma, smallest gamma for a beta.

use clarabel::solver::{SolverError, SolverStatus};
use steerguard_detector::RULES;

use crate::gains::ObserverGains;
use crate::lmi::{self, Affine, Matrix, Variables};
use crate::theorem4::{Quantities, Theorem4, Units};

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
            gamma: gamma.unwrap_or_else(|| theorem.d.norm()),
            beta: beta.unwrap_or_else(|| theorem.f.norm()),
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
    /// P_d,i.
    pub p_d: [Matrix; RULES],
    /// P_f,i.
    pub p_f: [Matrix; RULES],
    /// Q_d.
    pub q_d: Matrix,
    /// Q_f.
    pub q_f: Matrix,
    /// R.
    pub r: Matrix,
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
    let gamma_squared = match goal {
        Goal::LargestBeta { gamma: Some(_) } => Affine::number(1.0),
        _ => variables.scalar(),
    };
    let beta_squared = match goal {
        Goal::SmallestGamma { beta: Some(_) } => Affine::number(1.0),
        _ => variables.scalar(),
    };
    let unknowns = theorem.unknowns(gamma_squared, beta_squared, &mut variables);
    let x = &unknowns.quantities;

    let mut inequalities = theorem.stability(x);
    let objective = match goal {
        Goal::Stability => Affine::number(0.0),
        Goal::LargestBeta { gamma } => {
            inequalities.extend(theorem.fault_sensitivity(x));
            if gamma.is_some() {
                inequalities.extend(theorem.disturbance_attenuation(x));
            }
            -&x.beta_squared
        }
        Goal::SmallestGamma { beta } => {
            inequalities.extend(theorem.disturbance_attenuation(x));
            if beta.is_some() {
                inequalities.extend(theorem.fault_sensitivity(x));
            }
            x.gamma_squared.clone()
        }
    };
    for inequality in &mut inequalities {
        let order = inequality.order();
        *inequality = &*inequality - &(Matrix::identity(order, order) * MARGIN).into();
    }

    let solution = lmi::minimise(&variables, &objective, &inequalities)?;
    if !solution.is_candidate() {
        return Err(NoSolution::Status(solution.status, solution.iterations));
    }
    let at = |expression: &Affine| expression.at(&solution.x);
    let Quantities { p_s, p_d, p_f, q_d, q_f, r, beta_squared, gamma_squared, .. } = x;
    let r = at(r);
    let s = at(&unknowns.s);
    let w = unknowns.w.each_ref().map(at);
    let gains = ObserverGains::table_2(&r, &s, &w, &theorem.a).ok_or(NoSolution::SingularR)?;
    Ok(Synthesis {
        status: solution.status,
        iterations: solution.iterations,
        beta: at(beta_squared)[0].sqrt() * units.beta,
        gamma: at(gamma_squared)[0].sqrt() * units.gamma,
        gains,
        lyapunov: Lyapunov {
            p_s: p_s.each_ref().map(at),
            p_d: p_d.each_ref().map(at),
            p_f: p_f.each_ref().map(at),
            q_d: at(q_d),
            q_f: at(q_f),
            r,
        },
    })
}
