//! Theorem 4: stability (33), disturbance attenuation (31) and fault sensitivity (32) of the
//! observer's error as linear matrix inequalities, corrected and written as Finsler forms
//! (method 4).
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
//! the numbers of given gains. The formulas are the same. C'C stands for the weighted residual's
//! `C' W_r^2 C`.
//!
//! Bounded sensor noise v extends (31), whose inputs become `(d, v, v+)`, after method 5:
//! `e+ = N_i(rho) e + M D d - (H_i + M K) D_y v + E D_y v+`, `r = C e + D_y v`. Both v and v+ count
//! half in gamma^2, which adds up to `gamma^2 ||v||^2`. Disturbances of several bands have a (31)
//! each, with a gamma of its own; gamma^2 of all is the sum.
//!
//! # Conventions
//! - i: rule of this sample; k: rule of the next; j: vertex of rho.
//! - Indices and inputs may be measured in any [`Units`]: a congruence, which changes no definiteness
//!   and can bring all blocks to one magnitude.
//! - Every inequality is stated as `X >= 0` of its left-hand side or its negative.

use steerguard_detector::{C, RULES, TsModel};

use crate::lmi::affine::{Affine, Variables};
use crate::lmi::matrix::{Matrix, beside, matrix};
use crate::problem::channel::{Channel, premise_sensitivity_vertices};
use crate::problem::inputs::Inputs;
use crate::problem::model::{f, model};
use crate::spec::{MultiplierV, Spec, VName};

/// Vertices of rho.
pub const VERTICES_OF_RHO: usize = 2;

/// Data of Theorem 4.
#[derive(Clone, Debug)]
pub struct Theorem4 {
    /// A_i, 3 x 3.
    pub a: [Matrix; RULES],
    /// `G rho [0 1 0]` at the vertices of rho, 3 x 3.
    pub g_rho: [Matrix; VERTICES_OF_RHO],
    /// C, 2 x 3.
    pub c: Matrix,
    /// Diagonal of W_r.
    pub weights: [f64; 2],
    /// Disturbances and bounded noise, one block for each band.
    pub disturbances: Vec<Channel>,
    /// The fault.
    pub fault: Channel,
    /// Vertices of K, 3 x 2 each.
    pub k: Vec<Matrix>,
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

impl Multipliers {
    /// Those that `spec` gives.
    pub fn of(spec: &Spec) -> Self {
        Self {
            alpha_d: spec.design.alpha_d,
            alpha_f: spec.design.alpha_f,
            v: match spec.design.v {
                MultiplierV::Name(VName::FTransposed) => f(spec).columns(0, 1).transpose(),
                MultiplierV::Given(v) => Matrix::from_row_slice(1, 3, &v),
            },
        }
    }
}

impl Theorem4 {
    /// The theorem's data for the model, method and `inputs` of `spec`, with a decay rate.
    pub fn of(spec: &Spec, inputs: &Inputs, decay: f64) -> Self {
        Self::new(
            &model(spec),
            &inputs.disturbances,
            &inputs.fault,
            inputs.weights,
            &Multipliers::of(spec),
            decay,
        )
    }

    /// The theorem's data for a model, its inputs, multipliers and decay rate.
    pub fn new(
        model: &TsModel,
        disturbances: &[Channel],
        fault: &Channel,
        weights: [f64; 2],
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
            weights,
            disturbances: disturbances.to_vec(),
            fault: fault.clone(),
            k: premise_sensitivity_vertices(model),
            alpha_d: multipliers.alpha_d,
            alpha_f: multipliers.alpha_f,
            v: multipliers.v.clone(),
            decay,
        }
    }

    /// The same theorem with gamma and beta measured in `units`.
    pub fn in_units(&self, units: Units) -> Self {
        Self {
            disturbances: self.disturbances.iter().map(|d| d.in_unit(units.gamma)).collect(),
            fault: self.fault.in_unit(units.beta),
            v: &self.v / units.beta,
            ..self.clone()
        }
    }

    /// `W_r`, 2 x 2.
    pub fn w_r(&self) -> Matrix {
        Matrix::from_diagonal(&nalgebra::DVector::from_row_slice(&self.weights))
    }

    /// The largest beta that (32) can ever attain, whatever the vehicle, D or gamma:
    /// `min over the fault band of sigma_min(W_r C V') / |alpha_f + exp(jw)|` (method 4).
    pub fn beta_bound(&self) -> f64 {
        let sensitivity = (self.w_r() * &self.c * self.v.transpose()).singular_values().min();
        // |alpha + exp(jw)|^2 = alpha^2 + 2 alpha cos(w) + 1 is monotonic over the band.
        let largest = self
            .fault
            .band
            .limits()
            .map(|w| (self.alpha_f * self.alpha_f + 2.0 * self.alpha_f * w.cos() + 1.0).sqrt());
        sensitivity / largest[0].max(largest[1])
    }

    /// All that the conditions are made of, with R, S, W_i, P and Q as decision variables;
    /// `gamma_squared` has a number for each block of disturbances.
    pub fn unknowns(
        &self,
        gamma_squared: Vec<Affine>,
        beta_squared: Affine,
        v: &mut Variables,
    ) -> Quantities {
        let r = v.full(3, 3);
        let s = v.full(3, 2);
        let w: [Affine; RULES] = std::array::from_fn(|_| v.full(3, 2));
        let rm = &r + &(&s * &self.c);
        Quantities {
            p_s: std::array::from_fn(|_| v.symmetric(3)),
            attenuation: gamma_squared
                .into_iter()
                .map(|gamma_squared| Attenuation {
                    gamma_squared,
                    p: std::array::from_fn(|_| v.symmetric(3)),
                    q: v.symmetric(3),
                })
                .collect(),
            p_f: std::array::from_fn(|_| v.symmetric(3)),
            q_f: v.symmetric(3),
            rn: std::array::from_fn(|i| {
                self.g_rho.each_ref().map(|g_rho| &rm * &(&self.a[i] + g_rho) - &w[i] * &self.c)
            }),
            r,
            rm,
            s,
            w,
            beta_squared,
        }
    }

    /// (31) of every block, rule, successor and vertex of rho, and `Q_d > 0`: those of the first
    /// vertex of K, then those of the further ones.
    pub fn disturbance_attenuation(&self, x: &Quantities) -> [Vec<Affine>; 2] {
        let mut inequalities = [Vec::new(), Vec::new()];
        for (channel, attenuation) in self.disturbances.iter().zip(&x.attenuation) {
            inequalities[0].push(attenuation.q.clone());
            let vertices = if channel.noise.ncols() == 0 { &self.k[..1] } else { &self.k };
            for (vertex, k) in vertices.iter().enumerate() {
                inequalities[vertex.min(1)].extend(self.attenuation(x, channel, attenuation, k));
            }
        }
        inequalities
    }

    /// (31) of one block at a value of K.
    fn attenuation(
        &self,
        x: &Quantities,
        channel: &Channel,
        attenuation: &Attenuation,
        k: &Matrix,
    ) -> Vec<Affine> {
        let Channel { direction, noise, band } = channel;
        let (n_d, n_y) = (direction.ncols(), noise.ncols());
        let inputs = n_d + 2 * n_y;
        let y = stack(&[
            &(Matrix::identity(3, 3) * self.alpha_d),
            &Matrix::zeros(inputs, 3),
            &Matrix::identity(3, 3),
        ]);
        // r = W_r (C e + D_y v), over (e, d, v, v+).
        let zeros = |columns| Matrix::zeros(2, columns);
        let output = self.w_r() * beside(&[&self.c, &zeros(n_d), noise, &zeros(n_y)]);
        let output = Affine::from(output.transpose() * output);
        let share = Matrix::from_fn(inputs, inputs, |row, column| match row == column {
            true if row < n_d => 1.0,
            true => 0.5,
            false => 0.0,
        });
        let zero = Affine::zeros;
        let quadratic = Affine::blocks([
            [
                output
                    - &Affine::blocks([
                        [zero(3, 3), zero(3, inputs)],
                        [zero(inputs, 3), attenuation.gamma_squared.times(&share)],
                    ]),
                zero(3 + inputs, 3),
            ],
            [zero(3, 3 + inputs), zero(3, 3)],
        ]);
        let from_d = &x.rm * direction;
        let from_next = &x.s * noise;
        let mut inequalities = Vec::new();
        for_all(|i, next, j| {
            let base = band.base(&attenuation.p[i], &attenuation.p[next], &attenuation.q, inputs);
            let from_noise = -(&x.w[i] * noise + &x.rm * &(k * noise));
            let course = Affine::blocks([[
                x.rn[i][j].clone(),
                from_d.clone(),
                from_noise,
                from_next.clone(),
                -&x.r,
            ]]);
            inequalities.push(-(base + &quadratic + (&y * &course).he()));
        });
        inequalities
    }

    /// (32) of every rule, successor and vertex of rho, and `Q_f > 0`.
    pub fn fault_sensitivity(&self, x: &Quantities) -> Vec<Affine> {
        let f = &self.fault.direction;
        let n_f = f.ncols();
        let y =
            stack(&[&(Matrix::identity(3, 3) * self.alpha_f), &self.v, &Matrix::identity(3, 3)]);
        let output = self.w_r() * &self.c;
        let residual = Affine::from(output.transpose() * output);
        let quadratic = diagonal(&-&residual, &x.beta_squared.times_identity(n_f));
        let rf = &x.rm * f;
        let mut inequalities = vec![x.q_f.clone()];
        for_all(|i, k, j| {
            let base = self.fault.band.base(&x.p_f[i], &x.p_f[k], &x.q_f, n_f);
            let finsler = (&y * &Affine::blocks([[x.rn[i][j].clone(), rf.clone(), -&x.r]])).he();
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
    /// What (31) of each block of disturbances holds of its own.
    pub attenuation: Vec<Attenuation>,
    /// P_f,i of (32): no sign.
    pub p_f: [Affine; RULES],
    /// Q_f of (32).
    pub q_f: Affine,
    /// R.
    pub r: Affine,
    /// `R M`.
    pub rm: Affine,
    /// `S = R E` (36).
    pub s: Affine,
    /// `W_i = R H_i` (37).
    pub w: [Affine; RULES],
    /// `R N_i(rho)` by rule and vertex of rho.
    pub rn: [[Affine; VERTICES_OF_RHO]; RULES],
    /// beta^2.
    pub beta_squared: Affine,
}

/// What (31) of a block of disturbances holds of its own.
#[derive(Clone, Debug)]
pub struct Attenuation {
    /// gamma^2 of the block.
    pub gamma_squared: Affine,
    /// P_d,i: no sign.
    pub p: [Affine; RULES],
    /// Q_d.
    pub q: Affine,
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
