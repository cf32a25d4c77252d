//! The check of a design: every inequality evaluated again from the gains as the detector holds
//! them, apart from the solver.
//!
//! # Conventions
//! Eigenvalues are computed in double precision, so each margin is held against the rounding that
//! its evaluation can have caused. Exact arithmetic is a further step that needs the same data.

use serde::{Deserialize, Serialize};
use steerguard_detector::RULES;

use crate::lmi::affine::Affine;
use crate::lmi::matrix::{Matrix, matrix, smallest_eigenvalue};
use crate::synthesis::gains::ObserverGains;
use crate::synthesis::solve::Lyapunov;
use crate::synthesis::theorem4::{Attenuation, Quantities, Theorem4, Units, VERTICES_OF_RHO};

/// Largest error accepted in the observer equation (13).
pub const OBSERVER_EQUATION_TOLERANCE: f64 = 1e-10;

/// The smallest eigenvalue of a family of matrices that shall all be positive definite.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Margin {
    /// Smallest eigenvalue found.
    pub smallest_eigenvalue: f64,
    /// What rounding can have changed it by.
    pub rounding_allowance: f64,
}

impl Margin {
    /// Whether all matrices are positive definite, rounding considered.
    pub fn holds(&self) -> bool {
        self.smallest_eigenvalue > self.rounding_allowance
    }

    /// The margin of `matrices`, made of factors and terms no larger than `magnitude`.
    ///
    /// Each element is a sum of some tens of products, and the eigenvalues of a matrix of order up
    /// to ten move by no more than their errors' norm: together below 1000 units of rounding.
    pub fn of(matrices: &[Affine], magnitude: f64) -> Self {
        let eigenvalues = matrices.iter().map(|x| smallest_eigenvalue(x.value()));
        Self {
            smallest_eigenvalue: eigenvalues.fold(f64::INFINITY, f64::min),
            rounding_allowance: 1000.0 * f64::EPSILON * magnitude,
        }
    }
}

/// Result of the check of (13) and (31)-(33).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Check {
    /// Largest element of `M A_i - N_i M - L_i C` (13).
    pub observer_equation_error: f64,
    /// (31), in units of gamma.
    pub disturbance_attenuation: Margin,
    /// (32), in units of beta.
    pub fault_sensitivity: Margin,
    /// (33).
    pub stability: Margin,
}

impl Check {
    /// Whether everything holds.
    pub fn holds(&self) -> bool {
        self.observer_equation_error < OBSERVER_EQUATION_TOLERANCE
            && self.disturbance_attenuation.holds()
            && self.fault_sensitivity.holds()
            && self.stability.holds()
    }
}

/// `N_i(rho) = N_i + M G rho` by rule and vertex of rho: `e+ = N_i(rho) e`.
pub type ErrorDynamics = [[Matrix; VERTICES_OF_RHO]; RULES];

/// The error dynamics of gains as the detector holds them.
pub fn error_dynamics(theorem: &Theorem4, gains: &ObserverGains) -> ErrorDynamics {
    let m = matrix(&gains.gains.m);
    gains.gains.n.map(|n| theorem.g_rho.each_ref().map(|g_rho| matrix(&n) + &m * g_rho))
}

/// Evaluates (13) and (31)-(33) for given numbers, gamma of each block among those of `lyapunov`.
///
/// The matrices of (31) and (32) are taken in units of gamma and beta: a congruence, after which
/// every block is of magnitude one.
pub fn check(theorem: &Theorem4, gains: &ObserverGains, lyapunov: &Lyapunov, beta: f64) -> Check {
    let gamma = lyapunov.attenuation.iter().map(|block| block.gamma).fold(0.0, f64::hypot);
    let dynamics = error_dynamics(theorem, gains);
    let theorem = theorem.in_units(Units { gamma, beta });
    let m = matrix(&gains.gains.m);
    let Lyapunov { p_s, attenuation, p_f, q_f, r } = lyapunov;
    let constant = |x: &Matrix| Affine::from(x.clone());
    let h = gains.h.each_ref().map(|h| r * matrix(h));
    let quantities = Quantities {
        p_s: p_s.each_ref().map(constant),
        attenuation: attenuation
            .iter()
            .map(|of_block| Attenuation {
                gamma_squared: Affine::number((of_block.gamma / gamma).powi(2)),
                p: of_block.p.each_ref().map(constant),
                q: constant(&of_block.q),
            })
            .collect(),
        p_f: p_f.each_ref().map(constant),
        q_f: constant(q_f),
        r: constant(r),
        rm: Affine::from(r * &m),
        s: Affine::from(r * matrix(&gains.gains.e)),
        w: h.each_ref().map(constant),
        rn: dynamics.each_ref().map(|n| n.each_ref().map(|n| Affine::from(r * n))),
        beta_squared: Affine::number(1.0),
    };

    let largest = |matrices: &mut dyn Iterator<Item = &Matrix>| {
        matrices.map(Matrix::norm).fold(0.0, f64::max)
    };
    let n = largest(&mut dynamics.iter().flatten());
    let products = |input: f64| r.norm() * (1.0 + n + m.norm() * input);
    let multiplier = |alpha: f64, v: f64| 2.0 * (2.0 + alpha.abs() + v);
    let p = |p: &mut dyn Iterator<Item = &Matrix>, q: f64| 1.0 + 2.0 * largest(p) + 4.0 * q;
    let q_d = largest(&mut attenuation.iter().map(|block| &block.q));
    let disturbances = theorem
        .disturbances
        .iter()
        .map(|channel| {
            let noise = largest(&mut h.iter()) + r.norm() * largest(&mut theorem.k.iter());
            channel.direction.norm() + (1.0 + noise) * channel.noise.norm()
        })
        .fold(0.0, f64::max);
    Check {
        observer_equation_error: gains.observer_equation_error(&theorem.a),
        disturbance_attenuation: Margin::of(
            &theorem.disturbance_attenuation(&quantities).concat(),
            p(&mut attenuation.iter().flat_map(|block| &block.p), q_d)
                + multiplier(theorem.alpha_d, 0.0) * products(disturbances),
        ),
        fault_sensitivity: Margin::of(
            &theorem.fault_sensitivity(&quantities),
            p(&mut p_f.iter(), q_f.norm())
                + multiplier(theorem.alpha_f, theorem.v.norm())
                    * products(theorem.fault.direction.norm()),
        ),
        stability: Margin::of(
            &theorem.stability(&quantities),
            p(&mut p_s.iter(), 0.0) + 2.0 * products(0.0),
        ),
    }
}
