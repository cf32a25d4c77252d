//! Theorem 4: stability (33), disturbance attenuation (31) and fault sensitivity (32) of the
//! observer's error as linear matrix inequalities, corrected and written as Finsler forms
//! (METHOD.md 4).
//!
//! The error `e = x - x^` of the observer obeys `e+ = N_i(rho) e + M D d + M F f`, `r = C e`, with
//! `N_i(rho) = N_i + M G rho` and rho the slope of phi between x and x^ (15). With a multiplier Y,
//! (31) and (32) are
//!
//! ```text
//! base + quadratic + He( Y [R N_i(rho), R M B, -R] ) < 0        over (e, input, e+)
//!
//! base = | P_i - 2 cos(theta) Q   0    Q   |   quadratic (31) = diag( C'C, -gamma^2 I, 0)
//!        |          0             0    0   |   quadratic (32) = diag(-C'C,   beta^2 I, 0)
//!        |          Q             0   -P_k |
//! ```
//!
//! and (33) is `[tau^2 P_i, (R N_i(rho))'; R N_i(rho), R + R' - P_k] > 0`, with decay rate tau.
//! Synthesis puts `R M = R + S C` and `R N_i = R M A_i - W_i C`, affine in R, S, W_i; the check puts
//! the numbers of given gains. The formulas are the same.
//!
//! # Conventions
//! - i: rule of this sample; k: rule of the next; j: vertex of rho.
//! - Indices and inputs may be measured in any [`Units`]: a congruence, which changes no definiteness
//!   and can bring all blocks to one magnitude.
//! - Every inequality is stated as `X >= 0` of its left-hand side or its negative.

use std::f64::consts::PI;

use steerguard_detector::{C, RULES, TsModel};

use crate::lmi::{Affine, Matrix, Variables};

/// Vertices of rho.
pub const VERTICES_OF_RHO: usize = 2;

/// A frequency range of an input, in radians a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Band {
    /// `|w| <= theta`.
    Low(f64),
    /// `|w| >= theta`.
    High(f64),
    /// All frequencies.
    Full,
}

impl Band {
    /// Lowest and highest frequency, in `[0, pi]`.
    pub fn limits(self) -> [f64; 2] {
        match self {
            Self::Low(theta) => [0.0, theta],
            Self::High(theta) => [theta, PI],
            Self::Full => [0.0, PI],
        }
    }

    /// `[P_i - 2 cos(theta) Q, 0, Q; 0, 0, 0; Q, 0, -P_k]` for `inputs` inputs; Q changes its sign
    /// for a high band and is absent for the full one.
    pub(crate) fn base(self, p_i: &Affine, p_k: &Affine, q: &Affine, inputs: usize) -> Affine {
        let (theta, q) = match self {
            Self::Low(theta) => (theta, q.clone()),
            Self::High(theta) => (theta, -q),
            Self::Full => (0.0, 0.0 * q),
        };
        let zero = |rows, columns| Affine::zeros(rows, columns);
        Affine::blocks([
            [p_i - &(2.0 * theta.cos() * &q), zero(3, inputs), q.clone()],
            [zero(inputs, 3), zero(inputs, inputs), zero(inputs, 3)],
            [q, zero(3, inputs), -p_k],
        ])
    }
}

/// Data of Theorem 4.
#[derive(Clone, Debug)]
pub struct Theorem4 {
    /// A_i, 3 x 3.
    pub a: [Matrix; RULES],
    /// `G rho [0 1 0]` at the vertices of rho, 3 x 3.
    pub g_rho: [Matrix; VERTICES_OF_RHO],
    /// C, 2 x 3.
    pub c: Matrix,
    /// D, 3 x n_d.
    pub d: Matrix,
    /// F, 3 x n_f.
    pub f: Matrix,
    /// Band of the disturbances.
    pub disturbance_band: Band,
    /// Band of the faults.
    pub fault_band: Band,
    /// alpha_d.
    pub alpha_d: f64,
    /// alpha_f.
    pub alpha_f: f64,
    /// V, n_f x 3.
    pub v: Matrix,
    /// tau: the error decays at least like tau^k, in (0, 1].
    pub decay: f64,
}

/// Units in which gamma and beta are measured: the inputs count in their inverse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Units {
    /// Unit of gamma.
    pub gamma: f64,
    /// Unit of beta.
    pub beta: f64,
}

/// An input of the error dynamics.
#[derive(Clone, Debug)]
pub struct Channel {
    /// D or F, 3 x n.
    pub direction: Matrix,
    /// Its frequency range.
    pub band: Band,
}

/// The multipliers that Theorem 4 leaves to the designer.
#[derive(Clone, Debug)]
pub struct Multipliers {
    /// alpha_d.
    pub alpha_d: f64,
    /// alpha_f.
    pub alpha_f: f64,
    /// V, n_f x 3, in the unit of F'.
    pub v: Matrix,
}

impl Theorem4 {
    /// The theorem's data for a model, its inputs, multipliers and decay rate.
    pub fn new(
        model: &TsModel,
        disturbance: &Channel,
        fault: &Channel,
        multipliers: &Multipliers,
        decay: f64,
    ) -> Self {
        // (15): phi' = 2 v_y, so rho lies between twice the ends of the lateral speed's range as
        // long as x and x^ stay in S_x.
        let rho = [2.0 * model.range.v_y.min, 2.0 * model.range.v_y.max];
        Self {
            a: model.vertices().map(|a| matrix(&a)),
            g_rho: rho.map(|rho| g_rho(model, rho)),
            c: matrix(&C),
            d: disturbance.direction.clone(),
            f: fault.direction.clone(),
            disturbance_band: disturbance.band,
            fault_band: fault.band,
            alpha_d: multipliers.alpha_d,
            alpha_f: multipliers.alpha_f,
            v: multipliers.v.clone(),
            decay,
        }
    }

    /// The same theorem with gamma and beta measured in `units`.
    pub fn in_units(&self, units: Units) -> Self {
        Self {
            d: &self.d / units.gamma,
            f: &self.f / units.beta,
            v: &self.v / units.beta,
            ..self.clone()
        }
    }

    /// The largest beta that (32) can ever attain, whatever the vehicle, D or gamma:
    /// `min over the fault band of sigma_min(C V') / |alpha_f + exp(jw)|` (METHOD.md 4).
    pub fn beta_bound(&self) -> f64 {
        let sensitivity = (&self.c * self.v.transpose()).singular_values().min();
        // |alpha + exp(jw)|^2 = alpha^2 + 2 alpha cos(w) + 1 is monotonic over the band.
        let largest = self
            .fault_band
            .limits()
            .map(|w| (self.alpha_f * self.alpha_f + 2.0 * self.alpha_f * w.cos() + 1.0).sqrt());
        sensitivity / largest[0].max(largest[1])
    }

    /// All that the conditions are made of, with R, S, W_i, P and Q as decision variables.
    pub fn unknowns(
        &self,
        gamma_squared: Affine,
        beta_squared: Affine,
        v: &mut Variables,
    ) -> Unknowns {
        let r = v.full(3, 3);
        let s = v.full(3, 2);
        let w: [Affine; RULES] = std::array::from_fn(|_| v.full(3, 2));
        let rm = &r + &(&s * &self.c);
        let quantities = Quantities {
            p_s: std::array::from_fn(|_| v.symmetric(3)),
            p_d: std::array::from_fn(|_| v.symmetric(3)),
            p_f: std::array::from_fn(|_| v.symmetric(3)),
            q_d: v.symmetric(3),
            q_f: v.symmetric(3),
            rn: std::array::from_fn(|i| {
                self.g_rho.each_ref().map(|g_rho| &rm * &(&self.a[i] + g_rho) - &w[i] * &self.c)
            }),
            rd: &rm * &self.d,
            rf: &rm * &self.f,
            r,
            gamma_squared,
            beta_squared,
        };
        Unknowns { quantities, s, w }
    }

    /// (31) of every rule, successor and vertex of rho, and `Q_d > 0`.
    pub fn disturbance_attenuation(&self, x: &Quantities) -> Vec<Affine> {
        let n_d = self.d.ncols();
        let y = stack(&[
            &(Matrix::identity(3, 3) * self.alpha_d),
            &Matrix::zeros(n_d, 3),
            &Matrix::identity(3, 3),
        ]);
        let residual = Affine::from(self.c.transpose() * &self.c);
        let quadratic = diagonal(&residual, &-x.gamma_squared.times_identity(n_d));
        let mut inequalities = vec![x.q_d.clone()];
        for_all(|i, k, j| {
            let base = self.disturbance_band.base(&x.p_d[i], &x.p_d[k], &x.q_d, n_d);
            let finsler = (&y * &Affine::blocks([[x.rn[i][j].clone(), x.rd.clone(), -&x.r]])).he();
            inequalities.push(-(base + &quadratic + finsler));
        });
        inequalities
    }

    /// (32) of every rule, successor and vertex of rho, and `Q_f > 0`.
    pub fn fault_sensitivity(&self, x: &Quantities) -> Vec<Affine> {
        let n_f = self.f.ncols();
        let y =
            stack(&[&(Matrix::identity(3, 3) * self.alpha_f), &self.v, &Matrix::identity(3, 3)]);
        let residual = Affine::from(self.c.transpose() * &self.c);
        let quadratic = diagonal(&-&residual, &x.beta_squared.times_identity(n_f));
        let mut inequalities = vec![x.q_f.clone()];
        for_all(|i, k, j| {
            let base = self.fault_band.base(&x.p_f[i], &x.p_f[k], &x.q_f, n_f);
            let finsler = (&y * &Affine::blocks([[x.rn[i][j].clone(), x.rf.clone(), -&x.r]])).he();
            inequalities.push(-(base + &quadratic + finsler));
        });
        inequalities
    }

    /// (33) of every rule, successor and vertex of rho, with the decay rate.
    pub fn stability(&self, x: &Quantities) -> Vec<Affine> {
        let mut inequalities = Vec::new();
        for_all(|i, k, j| {
            let rn = &x.rn[i][j];
            inequalities.push(Affine::blocks([
                [self.decay * self.decay * &x.p_s[i], rn.transpose()],
                [rn.clone(), x.r.he() - &x.p_s[k]],
            ]));
        });
        inequalities
    }
}

/// What the conditions of Theorem 4 are made of: affine in the unknowns for synthesis, numbers for
/// a check.
#[derive(Clone, Debug)]
pub struct Quantities {
    /// P_s,i of (33).
    pub p_s: [Affine; RULES],
    /// P_d,i of (31): no sign.
    pub p_d: [Affine; RULES],
    /// P_f,i of (32): no sign.
    pub p_f: [Affine; RULES],
    /// Q_d of (31).
    pub q_d: Affine,
    /// Q_f of (32).
    pub q_f: Affine,
    /// R.
    pub r: Affine,
    /// `R N_i(rho)` by rule and vertex of rho.
    pub rn: [[Affine; VERTICES_OF_RHO]; RULES],
    /// `R M D`.
    pub rd: Affine,
    /// `R M F`.
    pub rf: Affine,
    /// gamma^2.
    pub gamma_squared: Affine,
    /// beta^2.
    pub beta_squared: Affine,
}

/// The quantities of a synthesis, and the unknowns that the gains come from.
#[derive(Clone, Debug)]
pub struct Unknowns {
    /// All that the conditions are made of.
    pub quantities: Quantities,
    /// S (36).
    pub s: Affine,
    /// W_i (37).
    pub w: [Affine; RULES],
}

/// `G rho [0 1 0]`: phi(x) - phi(x^) = rho e_2 (15).
pub fn g_rho(model: &TsModel, rho: f64) -> Matrix {
    let g = model.g_phi();
    Matrix::from_fn(3, 3, |row, column| if column == 1 { g[row] * rho } else { 0.0 })
}

/// Visits every rule i, successor k and vertex j of rho.
pub(crate) fn for_all(mut visit: impl FnMut(usize, usize, usize)) {
    for i in 0..RULES {
        for k in 0..RULES {
            for j in 0..VERTICES_OF_RHO {
                visit(i, k, j);
            }
        }
    }
}

/// `diag(residual, input, 0)` over (e, input, e+).
pub(crate) fn diagonal(residual: &Affine, input: &Affine) -> Affine {
    let m = input.order();
    let zero = Affine::zeros;
    Affine::blocks([
        [residual.clone(), zero(3, m), zero(3, 3)],
        [zero(m, 3), input.clone(), zero(m, 3)],
        [zero(3, 3), zero(3, m), zero(3, 3)],
    ])
}

/// The given blocks on top of each other.
fn stack(blocks: &[&Matrix]) -> Matrix {
    let rows: Vec<_> = blocks.iter().flat_map(|block| block.row_iter()).collect();
    Matrix::from_rows(&rows)
}

/// A matrix of rows as a [`Matrix`].
pub fn matrix<const R: usize, const K: usize>(rows: &[[f64; K]; R]) -> Matrix {
    Matrix::from_fn(R, K, |row, column| rows[row][column])
}
