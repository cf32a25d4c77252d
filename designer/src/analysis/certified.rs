//! Certified gains of given error dynamics: what the gains are worth, a posteriori (method 5.3).
//!
//! Where Theorem 4 ties its multiplier to the gains, here the gains are numbers and the multipliers
//! X_jk are free. For the error dynamics `e+ = N_i(rho) e + B_i w`, `W_r r = W_r C e + D_r w`, with w
//! the fault or the disturbances of one band, and every rule i, j of this sample, k of the next and
//! vertex of rho (and of K, where w holds sensor noise),
//!
//! ```text
//! L_k(i, j) = base(P_i, P_k, Q) + quadratic + He( X_jk [N_i(rho), B_i, -I] )   over (e, w, e+)
//!
//! L_k(i, i) < 0,   L_k(i, j) + L_k(j, i) < 0 for i < j,   Q > 0
//! ```
//!
//! with the base of Theorem 4 and `quadratic = +-([W_r C, D_r, 0]' [W_r C, D_r, 0] - diag(0, g^2, 0))`
//! for the gain g. Weighted by the membership functions of both samples these sum up to
//! `L(h, h+) < 0`; along the error's course X drops out, and the sum over all samples is
//! `||W_r r|| < gamma ||d||`, or `||W_r r|| > beta ||f||`. Disturbances of several bands are certified
//! one band after the other; by superposition their gains add up to the root of the sum of squares.
//!
//! # Conventions
//! - P_i are symmetric and have no sign; Q is common to all rules, and zero for the full band.
//! - With sensor noise e stands for `x - x^ - E D_y v`, B and D_r are those of
//!   [`crate::operating_point`].
//! - What is found here is a claim. `steerguard_verify` proves it, in exact arithmetic.

use clarabel::solver::{SolverError, SolverStatus};
use serde::{Deserialize, Serialize};
use steerguard_detector::RULES;

use crate::analysis::certificate::{ErrorDynamics, error_dynamics};
use crate::analysis::frequency::{Frozen, discrete_lyapunov};
use crate::analysis::operating_point::{spectral_radius, square};
use crate::lmi::affine::{Affine, Variables};
use crate::lmi::matrix::{Matrix, beside, matrix, rows, smallest_eigenvalue};
use crate::lmi::solve::{minimise, minimise_with_cuts};
use crate::problem::band::Band;
use crate::problem::channel::Channel;
use crate::problem::inputs::Inputs;
use crate::synthesis::gains::ObserverGains;
use crate::synthesis::theorem4::{Theorem4, for_all};

/// Strict inequalities are solved as `X >= MARGIN I`, in units in which residual and input are of
/// magnitude one: what the solver's own tolerance may violate them by is smaller.
const MARGIN: f64 = 1e-7;
/// Smallest eigenvalue, in the same units, that rounding cannot have made up.
const CONFIRMED: f64 = 1e-9;
/// Steps from the optimum, relative.
const BACK_OFF: [f64; 5] = [1e-4, 1e-3, 1e-2, 0.1, 0.3];
/// No larger margin is asked for.
const LARGEST_MARGIN: f64 = 1e-4;
/// Rounding of `2 cos(theta)`, of magnitude two, with theta's own.
const COSINE_ROUNDING: f64 = 16.0 * f64::EPSILON;
/// Rounding of gap and gamma.
const ROUNDING: f64 = 16.0 * f64::EPSILON;
/// Inequalities of the first vertices of rho and K that the solver begins with.
const FIRST_VERTICES: usize = 2;

/// Smallest margin of a decay certificate, in units of the largest P_i.
const DECAY_MARGIN: f64 = 1e-7;

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
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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
    /// Of gamma, for each band of the disturbances.
    pub gamma: Vec<GainCertificate>,
    /// Of gamma for all frequencies.
    pub gamma_full_band: GainCertificate,
}

/// The matrices that prove a gain.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GainCertificate {
    /// The gain, in the unit of the figures.
    pub gain: f64,
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
    /// The error has no basis of its own.
    #[error("the error's covariance is singular to working precision")]
    Basis,
    /// The solver refused the problem.
    #[error(transparent)]
    Solver(#[from] SolverError),
}

/// The figures that can be certified for `gains`, and their matrices; `frozen` gives the magnitudes.
///
/// # Errors
/// [`NoCertificate`] of the first figure that has none.
pub fn certified(
    theorem: &Theorem4,
    gains: &ObserverGains,
    frozen: &Frozen,
    inputs: &Inputs,
) -> Result<(CertifiedFigures, APosteriori), NoCertificate> {
    let error = |channel: &Channel| ErrorSystem::new(theorem, gains, channel);
    let largest =
        |channel: &Channel| certify(&error(channel), channel.band, Gain::Largest, frozen.gamma);
    let smallest =
        || certify(&error(&theorem.fault), theorem.fault.band, Gain::Smallest, frozen.beta);
    let (gamma, (beta, gamma_full_band)) = rayon::join(
        || theorem.disturbances.iter().map(largest).collect::<Result<Vec<_>, _>>(),
        || (smallest(), largest(&Channel::stacked(&theorem.disturbances))),
    );
    let (beta, gamma, gamma_full_band) = (beta?, gamma?, gamma_full_band?);
    let total = gamma.iter().map(|block| block.gain).fold(0.0, f64::hypot) * (1.0 + ROUNDING);
    let figures = CertifiedFigures {
        beta: beta.gain,
        gamma: total,
        gap: beta.gain * inputs.smallest_fault / (total * inputs.bound) * (1.0 - ROUNDING),
        gamma_full_band: gamma_full_band.gain,
        decay: theorem.decay,
    };
    Ok((figures, APosteriori { beta, gamma, gamma_full_band }))
}

/// P_i that prove the decay of the error: `P_i > 0`, `tau^2 P_i - N_i(rho)' P_k N_i(rho) > 0`, with the
/// largest margin for P_i below I. None where the solver finds none.
pub fn decay_certificate(theorem: &Theorem4, gains: &ObserverGains) -> Option<[Matrix; RULES]> {
    let error = ErrorSystem::new(theorem, gains, &theorem.fault);
    let basis = error.natural_basis();
    let inverse = basis.clone().try_inverse()?;
    let error = error.in_basis(&basis, &inverse);
    let mut variables = Variables::default();
    let p: [Affine; RULES] = std::array::from_fn(|_| variables.symmetric(3));
    let margin = variables.scalar();
    let margin_of = |order| margin.times_identity(order);
    let mut inequalities: Vec<Affine> =
        p.iter().map(|p| Affine::from(Matrix::identity(3, 3)) - p).collect();
    for_all(|i, k, j| {
        let n = error.courses[j][i].columns(0, 3).into_owned();
        let next = &p[k] * &n;
        let x = Affine::blocks([
            [theorem.decay * theorem.decay * &p[i], next.transpose()],
            [next, p[k].clone()],
        ]);
        inequalities.push(x - &margin_of(6));
    });
    let solution = minimise(&variables, &-&margin, &inequalities).ok()?;
    let holds = solution.is_candidate() && margin.at(&solution.x)[0] > DECAY_MARGIN;
    holds.then(|| p.map(|p| congruent(&inverse, &p.at(&solution.x))))
}

/// The error dynamics with the inputs of one band, at the vertices of rho and K.
pub struct ErrorSystem {
    /// `[N_i(rho), B_i, -I]`, which sends (e, w, e+) to zero along the error's course, by vertex and
    /// rule.
    pub(crate) courses: Vec<[Matrix; RULES]>,
    /// `[W_r C, D_r]`.
    pub(crate) output: Matrix,
}

impl ErrorSystem {
    /// The error dynamics of `gains` with the inputs `channel`.
    pub fn new(theorem: &Theorem4, gains: &ObserverGains, channel: &Channel) -> Self {
        let dynamics: ErrorDynamics = error_dynamics(theorem, gains);
        let [m, e] = [matrix(&gains.gains.m), matrix(&gains.gains.e)];
        let from_direction = &m * &channel.direction;
        let vertices = if channel.noise.ncols() == 0 { &theorem.k[..1] } else { &theorem.k };
        let minus_identity = -Matrix::identity(3, 3);
        let mut courses = Vec::new();
        for k in vertices {
            for (rho, g_rho) in theorem.g_rho.iter().enumerate() {
                courses.push(std::array::from_fn(|i| {
                    let l = matrix(&gains.gains.l[i]);
                    let from_noise = (&m * g_rho * &e - l - &m * k) * &channel.noise;
                    beside(&[&dynamics[i][rho], &from_direction, &from_noise, &minus_identity])
                }));
            }
        }
        let feedthrough = (Matrix::identity(2, 2) + &theorem.c * e) * &channel.noise;
        let direct = Matrix::zeros(2, channel.direction.ncols());
        let output = beside(&[&theorem.c, &direct, &feedthrough]);
        Self { courses, output: theorem.w_r() * output }
    }

    /// Number of inputs.
    fn inputs(&self) -> usize {
        self.output.ncols() - 3
    }

    /// The same with the inputs counted in units of `1 / unit`.
    pub(crate) fn in_unit(&self, unit: f64) -> Self {
        let inputs = self.inputs();
        let scaled = |x: &Matrix| {
            let mut x = x.clone();
            x.columns_mut(3, inputs).unscale_mut(unit);
            x
        };
        Self {
            courses: self.courses.iter().map(|course| course.each_ref().map(scaled)).collect(),
            output: scaled(&self.output),
        }
    }

    /// A basis in which the error that the inputs cause is of magnitude one in all directions:
    /// the root of its covariance under white inputs, at the mean of the vertices. The solver's
    /// numbers are then of one magnitude, whatever the gains.
    fn natural_basis(&self) -> Matrix {
        let mean = self.mean(Matrix::clone);
        let b = mean.columns(3, self.inputs());
        self.basis_of(&(b * b.transpose()))
    }

    /// The mean of `f` over the vertices.
    pub(crate) fn mean(&self, f: impl Fn(&Matrix) -> Matrix) -> Matrix {
        let count = (self.courses.len() * RULES) as f64;
        let sum = self.courses.iter().flatten().map(f).reduce(|sum, x| sum + x);
        sum.unwrap_or_default() / count
    }

    /// The root of the error's covariance where its steps are `driven` by a covariance.
    pub(crate) fn basis_of(&self, driven: &Matrix) -> Matrix {
        let n = square(&self.mean(|course| course.columns(0, 3).into_owned()));
        let n = n * f64::min(1.0, 0.99 / spectral_radius(&n));
        let driven = square(driven);
        let mut covariance = discrete_lyapunov(&n, &driven).unwrap_or_default();
        for k in 0..3 {
            covariance[(k, k)] = 1.01 * covariance[(k, k)] + 1e-4;
        }
        match covariance.cholesky() {
            Some(root) => Matrix::from_iterator(3, 3, root.l().iter().copied()),
            None => Matrix::identity(3, 3),
        }
    }

    /// The same with e counted in a basis.
    pub(crate) fn in_basis(&self, basis: &Matrix, inverse: &Matrix) -> Self {
        let next = 3 + self.inputs();
        let of_course = |x: &Matrix| {
            // e+ stays [.., -I]: inverse (-I) basis.
            let mut x = inverse * x;
            for of_error in [0, next] {
                let block = x.columns(of_error, 3) * basis;
                x.columns_mut(of_error, 3).copy_from(&block);
            }
            x
        };
        let mut output = self.output.clone();
        let of_error = output.columns(0, 3) * basis;
        output.columns_mut(0, 3).copy_from(&of_error);
        Self {
            courses: self.courses.iter().map(|course| course.each_ref().map(of_course)).collect(),
            output,
        }
    }
}

/// The best `gain` that can be certified over `band`, and its matrices; `expected` gives its
/// magnitude.
///
/// # Errors
/// [`NoCertificate`], which says what the solver found instead.
pub fn certify(
    error: &ErrorSystem,
    band: Band,
    gain: Gain,
    expected: f64,
) -> Result<GainCertificate, NoCertificate> {
    let unit = if expected.is_normal() { expected } else { error.output.norm() };
    let scaled = error.in_unit(unit);
    let basis = scaled.natural_basis();
    let inverse = basis.clone().try_inverse().ok_or(NoCertificate::Basis)?;
    let problem = Problem { error: scaled.in_basis(&basis, &inverse), band, gain };
    let point = problem.best()?;

    // Back to the input's own unit and the error's own basis: congruences.
    let symmetric = |x: &Matrix| rows(&congruent(&inverse, x));
    let rows_of_x = |x: &Matrix| {
        let mut x = x * &inverse;
        x.rows_mut(3, error.inputs()).scale_mut(unit);
        for of_error in [0, 3 + error.inputs()] {
            let block = inverse.transpose() * x.rows(of_error, 3);
            x.rows_mut(of_error, 3).copy_from(&block);
        }
        x.row_iter().map(|row| [row[0], row[1], row[2]]).collect()
    };
    let in_band = |two_cos_theta| BandCertificate { two_cos_theta, q: symmetric(&point.q) };
    Ok(GainCertificate {
        gain: point.squared.sqrt() * unit,
        band: match band {
            Band::Low(theta) => Some(in_band(2.0 * theta.cos() - COSINE_ROUNDING)),
            Band::High(theta) => Some(in_band(2.0 * theta.cos() + COSINE_ROUNDING)),
            Band::Full => None,
        },
        p: point.p.each_ref().map(symmetric),
        x: point.x.each_ref().map(|x| x.each_ref().map(rows_of_x)),
    })
}

/// `T' X T`, exactly symmetric.
fn congruent(t: &Matrix, x: &Matrix) -> Matrix {
    let x = t.transpose() * x * t;
    (&x + x.transpose()) / 2.0
}

/// The conditions of one gain, in a unit in which it is near one.
struct Problem {
    error: ErrorSystem,
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

impl Problem {
    /// The optimum, or what lies a little beside it where the solver, on the boundary of the
    /// feasible set, ends outside.
    fn best(&self) -> Result<Point, NoCertificate> {
        // Where the solver fails on the way to the optimum, the search begins at the gain expected.
        let (squared, mut margin) = match self.optimum() {
            Ok(optimum) if optimum.margin > CONFIRMED => return Ok(optimum),
            Ok(optimum) => (optimum.squared, optimum.margin),
            Err(_) => (1.0, f64::NEG_INFINITY),
        };
        for step in BACK_OFF {
            let factor = match self.gain {
                Gain::Largest => 1.0 + step,
                Gain::Smallest => 1.0 - step,
            };
            let Ok(inside) = self.inside(squared * factor * factor) else { continue };
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
            x: self.multipliers(&mut variables),
        };
        let conditions = self.conditions(&squared, &unknowns);
        let with_margin = |conditions: &[Affine]| -> Vec<Affine> {
            let margin = |x: &Affine| self.mixed(x - &margin.times_identity(x.order()));
            conditions.iter().map(margin).collect()
        };
        let mut inequalities = with_margin(&conditions[0]);
        inequalities.push(Affine::number(LARGEST_MARGIN) - &margin);
        let further = with_margin(&conditions[1]);
        let solution =
            minimise_with_cuts(&variables, &objective, inequalities, further, MARGIN / 2.0)?;
        let at = |expression: &Affine| expression.at(&solution.x);
        if !solution.is_candidate() || at(&squared)[0] <= 0.0 {
            return Err(NoCertificate::Status(solution.status, solution.iterations));
        }
        let eigenvalues =
            conditions.iter().flatten().map(|condition| smallest_eigenvalue(&at(condition)));
        Ok(Point {
            squared: at(&squared)[0],
            margin: eigenvalues.fold(f64::INFINITY, f64::min),
            p: unknowns.p.each_ref().map(at),
            q: at(&unknowns.q),
            x: unknowns.x.each_ref().map(|x| x.each_ref().map(at)),
        })
    }

    /// Whether all X_jk are one: with sensor noise, where the vertices of K multiply the inequalities
    /// by sixteen. Those of i < j are then sums of those of i = j.
    fn has_common_multiplier(&self) -> bool {
        self.error.courses.len() > FIRST_VERTICES
    }

    /// X_jk.
    fn multipliers(&self, variables: &mut Variables) -> [[Affine; RULES]; RULES] {
        let mut x = || variables.full(6 + self.error.inputs(), 3);
        if self.has_common_multiplier() {
            let x = x();
            return std::array::from_fn(|_| std::array::from_fn(|_| x.clone()));
        }
        std::array::from_fn(|_| std::array::from_fn(|_| x()))
    }

    /// The same inequality after an orthogonal congruence, for the solver's sake. As they stand the
    /// inequalities are sparse in X, and its minimum degree ordering then eliminates X before the
    /// cones and couples them all. Mixed, each cone is dense and goes by itself: measured with two
    /// inputs half the time; with one input, where X is smaller, it would be twice.
    fn mixed(&self, x: Affine) -> Affine {
        let order = x.order();
        if self.error.inputs() == 1 || order < 3 {
            return x;
        }
        let reflection = Matrix::from_fn(order, order, |row, column| {
            f64::from(u8::from(row == column)) - 2.0 / order as f64
        });
        &reflection * &(x * &reflection)
    }

    /// The inequalities at the head of this module: those of the first vertices of rho and K, then
    /// those of the further ones.
    fn conditions(&self, squared: &Affine, unknowns: &Unknowns) -> [Vec<Affine>; 2] {
        let Self { error, band, gain } = self;
        let Unknowns { p, q, x } = unknowns;
        let inputs = error.inputs();
        let mut square = Matrix::zeros(3 + inputs, 3 + inputs);
        square.view_mut((3, 3), (inputs, inputs)).fill_with_identity();
        let weighted =
            Affine::from(error.output.transpose() * &error.output) - squared.times(&square);
        let weighted = match gain {
            Gain::Largest => weighted,
            Gain::Smallest => -weighted,
        };
        let zero = Affine::zeros;
        let quadratic =
            Affine::blocks([[weighted, zero(3 + inputs, 3)], [zero(3, 3 + inputs), zero(3, 3)]]);
        let mut inequalities = [vec![q.clone()], Vec::new()];
        for (vertex, course) in error.courses.iter().enumerate() {
            let inequalities = &mut inequalities[usize::from(vertex >= FIRST_VERTICES)];
            for k in 0..RULES {
                let l = |i: usize, j: usize| {
                    let finsler = (&x[j][k] * &course[i]).he();
                    band.base(&p[i], &p[k], q, inputs) + &quadratic + finsler
                };
                for i in 0..RULES {
                    inequalities.push(-l(i, i));
                    if !self.has_common_multiplier() {
                        inequalities.extend((i + 1..RULES).map(|j| -(l(i, j) + l(j, i))));
                    }
                }
            }
        }
        inequalities
    }
}
