//! Start-up of the residual: a bound `||W_r r_j|| <= amplitude tau^j` for given gains
//! (METHOD.md 6).
//!
//! The observer starts at `z_0 = M [v_x, 0, r]`, so the error starts at `e_0 = [0, v_y, 0]` and obeys
//! `e+ = N_i(rho) e`. Matrices P_i with
//!
//! ```text
//! tau^2 P_i - N_i(rho)' P_k N_i(rho) >= 0,   P_i - C' W_r^2 C >= 0
//! ```
//!
//! give `||W_r r_j||^2 <= e_j' P e_j <= tau^(2 j) v_y^2 max_i [0 1 0] P_i [0 1 0]'`. The smallest such
//! bound is a semidefinite programme for each tau.

use steerguard_detector::{C, RULES};

use crate::certificate::{ErrorDynamics, Margin};
use crate::lmi::{self, Affine, Matrix, Variables};
use crate::theorem4::{matrix, VERTICES_OF_RHO};

/// Decay rates tried between the slowest rule's and the design's.
const DECAY_RATES: usize = 12;
/// Margin of the inequalities, relative to W_r^2.
const MARGIN: f64 = 1e-7;

/// A bound on the start-up residual, checked.
#[derive(Clone, Debug, PartialEq)]
pub struct StartUpBound {
    /// Bound on `||W_r r_0||`, extrapolated: the factor of `tau^j`.
    pub amplitude: f64,
    /// tau, in (0, 1).
    pub decay: f64,
    /// P_i.
    pub p: [Matrix; RULES],
    /// Smallest eigenvalue of the inequalities at P_i, and the rounding it must exceed.
    pub margin: Margin,
}
