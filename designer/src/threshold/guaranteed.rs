//! Threshold kind "guaranteed": a bound on J for every fault-free behaviour whose disturbances and
//! sensor noise stay within their bounds at every sample (method 6).
//!
//! One input w at a time, `|w| <= 1` in units of its bound; by superposition the bounds of all add
//! up. For the error dynamics `e+ = S (e, w)`, `W_r r = W_r C e + D_r w` find P_i, V_i > 0 for every
//! rule with
//!
//! ```text
//! invariance    diag(lambda P_h, 1 - lambda) - S' P_k S > 0      at every vertex (h, S), every k
//! dissipation   diag(V_h, gain^2) - S' V_k S - [W_r C, D_r]' [W_r C, D_r] > 0        likewise
//! energy        energy P_i - V_i > 0
//! start         e_0' P_i e_0 < 1
//! ```
//!
//! with `P_h = sum h_i P_i`. Their left-hand sides are concave in (h, S) and affine in P_k, so they
//! hold for all courses of premise, rho and K. Invariance and start keep e in `e' P e <= 1`; the
//! dissipation, summed over the window of n samples, is then `n J^2 <= n gain^2 + energy`.
//!
//! # Conventions
//! - Noise v starts the observer with `e_0 = -M C' D_y v`: `z_0 = M C' y`, and e stands for
//!   `x - x^ - E D_y v`. The lateral speed at the start has a term of its own, [`crate::analysis::start_up`].
//! - K is a mean over speeds between the true and the measured one. Its vertices come with the
//!   membership functions of the same speed, widened by what v_x's noise may set them apart.
//! - What is found here is a claim. `steerguard_verify` proves it, in exact arithmetic.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use steerguard_detector::RULES;

use crate::analysis::certified::ErrorSystem;
use crate::analysis::operating_point::{spectral_radius, square};
use crate::lmi::affine::{Affine, Variables};
use crate::lmi::matrix::{Matrix, Rows3, matrix, rows, smallest_eigenvalue};
use crate::lmi::solve::minimise_with_cuts;
use crate::problem::channel::speed_memberships;
use crate::problem::inputs::{BoundedInput, bounded_inputs};
use crate::problem::model::model;
use crate::spec::{Noise, Spec, SpeedNoise, YawRateNoise};
use crate::synthesis::gains::ObserverGains;
use crate::synthesis::theorem4::{Theorem4, VERTICES_OF_RHO};
use crate::threshold::calibration::Level;

/// Values of lambda tried, from the square of the slowest mode towards one.
const RATES: u32 = 16;
/// `1 - lambda` shrinks by this from one to the next.
const RATE_STEP: f64 = 0.82;
/// Strict inequalities are solved as `X >= MARGIN I`, in units in which all is of magnitude one.
const MARGIN: f64 = 1e-6;
/// Smallest eigenvalue, in the same units, that rounding cannot have made up.
const CONFIRMED: f64 = 1e-9;
/// Makes up for rounding of what stands on the larger side.
const ROUNDED_UP: f64 = 1.0 + 1e-9;

/// Vertices whose inequalities the solver begins with: all without noise.
const FIRST_VERTICES: usize = VERTICES_OF_RHO * RULES;

/// The threshold's level and what it is made of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Guaranteed {
    /// J of the model (7) stays below, but for the start-up term: the sum over the inputs. Proven.
    pub bound: f64,
    /// Every disturbance, then every sensor's noise.
    pub inputs: Vec<InputBound>,
    /// Largest J, beyond the start-up term, of the vehicle in continuous time with neither
    /// disturbances nor noise: what the model's Euler steps leave out. Simulated, not proven.
    pub discretisation: Level,
}

impl Guaranteed {
    /// The bound of all `inputs`.
    pub fn new(inputs: Vec<InputBound>, discretisation: Level) -> Self {
        let bound = inputs.iter().map(|input| input.j).sum::<f64>() * ROUNDED_UP;
        Self { bound, inputs, discretisation }
    }

    /// What the threshold's margin multiplies.
    pub fn level(&self) -> f64 {
        self.bound + self.discretisation.level
    }
}

/// What one input can do.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InputBound {
    /// Name in reports.
    pub name: String,
    /// Its bound, in its unit.
    pub bound: f64,
    /// Its unit.
    pub unit: String,
    /// J stays below under this input alone.
    pub j: f64,
}

/// The numbers that prove a [`InputBound`], see the module's head.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PeakCertificate {
    /// lambda.
    pub lambda: f64,
    /// J per sample that the input keeps up.
    pub gain: f64,
    /// What the error may have stored when a window begins.
    pub energy: f64,
    /// P_i.
    #[serde(rename = "P")]
    pub p: [Rows3; RULES],
    /// V_i.
    #[serde(rename = "V")]
    pub v: [Rows3; RULES],
}

impl PeakCertificate {
    /// J stays below, for a window of so many samples.
    pub fn j(&self, window: usize) -> f64 {
        (self.gain * self.gain + self.energy / window as f64).sqrt() * ROUNDED_UP
    }
}

/// The bounds of all inputs of `spec`, in their order, with their proofs; the name of the first
/// input that has none is the error.
///
/// # Errors
/// The name of an input without a bound.
pub fn peak_bounds(
    spec: &Spec,
    theorem: &Theorem4,
    gains: &ObserverGains,
) -> Result<Vec<(InputBound, PeakCertificate)>, String> {
    let window = spec.evaluation.window(spec.sampling.period_s);
    let v_x_noise = spec.noise.bounds()[0].unwrap_or(0.0);
    let memberships = speed_memberships(&model(spec), v_x_noise);
    let inputs = bounded_inputs(spec);
    let bounds = inputs.into_par_iter().map(|BoundedInput { name, bound, unit, channel }| {
        let error = ErrorSystem::new(theorem, gains, &channel);
        let from_start = matrix(&gains.gains.m) * theorem.c.transpose() * &channel.noise;
        match peak_bound(&error, &memberships, &from_start, window) {
            Some(certificate) => {
                let j = certificate.j(window);
                Ok((InputBound { name, bound, unit: unit.into(), j }, certificate))
            }
            None => Err(name),
        }
    });
    bounds.collect()
}

/// What is left of `spec` where only the model's Euler steps depart from the vehicle.
pub fn without_inputs(spec: &Spec) -> Spec {
    let mut spec = spec.clone();
    spec.disturbance.clear();
    spec.noise = Noise {
        v_x: SpeedNoise { white_std_m_per_s: 0.0, bound_m_per_s: None, band_hz: None },
        r: YawRateNoise { white_std_rad_per_s: 0.0, bound_rad_per_s: None, band_hz: None },
    };
    spec.evaluation.calibration.disturbance_frequencies = 1;
    spec.evaluation.calibration.disturbance_phases = 1;
    spec
}

/// The smallest bound on J that is found for the one input of `error`, `from_start` being what it
/// starts the error with. None without a solution.
pub fn peak_bound(
    error: &ErrorSystem,
    memberships: &SpeedMemberships,
    from_start: &Matrix,
    window: usize,
) -> Option<PeakCertificate> {
    let unit = magnitude(error);
    let scaled = error.in_unit(unit);
    // K moves the noise's column about: its mean is small in directions that its vertices are not.
    let driven = scaled.mean(|course| course.column(3) * course.column(3).transpose());
    let basis = scaled.basis_of(&driven);
    let inverse = basis.clone().try_inverse()?;
    let scaled = scaled.in_basis(&basis, &inverse);
    let problem = Problem {
        vertices: vertices(&scaled, memberships),
        output: scaled.output.clone(),
        from_start: &inverse * from_start / unit,
        window: window as f64,
    };

    let of = |n: &Matrix| spectral_radius(&square(&n.columns(0, 3).into_owned()));
    let slowest = scaled.courses.iter().flatten().map(of).fold(0.0, f64::max);
    let squared = |point: &Point| point.gain_squared + point.energy / problem.window;
    let mut best: Option<(f64, Point)> = None;
    let mut past_the_best = 0;
    for rate in 0..RATES {
        let lambda = 1.0 - (1.0 - slowest * slowest) * RATE_STEP.powi(rate as i32 + 1);
        let Some(point) = problem.solve(lambda) else { continue };
        match &best {
            Some((_, least)) if squared(&point) >= squared(least) => past_the_best += 1,
            _ => best = Some((lambda, point)),
        }
        if past_the_best == 2 {
            break;
        }
    }

    // Back to the input's own unit and the error's own basis: congruences. P in units of its level.
    let (lambda, point) = best?;
    let original = |x: &Matrix| {
        let x = inverse.transpose() * x * &inverse;
        (&x + x.transpose()) / 2.0
    };
    let energy = unit * unit * point.energy;
    Some(PeakCertificate {
        lambda,
        gain: point.gain_squared.sqrt() * unit * ROUNDED_UP,
        energy: energy * ROUNDED_UP,
        p: point.p.each_ref().map(|p| rows(&(original(p) / energy))),
        v: point.v.each_ref().map(|v| rows(&original(v))),
    })
}

/// Magnitude of what the input does: the largest gain to a constant input at a vertex.
fn magnitude(error: &ErrorSystem) -> f64 {
    let columns = error.output.ncols();
    let constant = |course: &Matrix| {
        let (n, b) = (course.columns(0, 3), course.columns(3, columns - 3));
        let e = (Matrix::identity(3, 3) - n).try_inverse()? * b;
        Some((error.output.columns(0, 3) * e + error.output.columns(3, columns - 3)).norm())
    };
    let largest = error.courses.iter().flatten().filter_map(constant).fold(0.0, f64::max);
    if largest.is_normal() { largest } else { error.output.norm() }
}

/// At every control point of the speed (see [`crate::channel`]), the ends of the share that the rules
/// of the lowest speed have.
pub type SpeedMemberships = [[f64; 2]; 4];

/// A vertex of the membership functions and of the error dynamics.
struct Vertex {
    /// h, the sum of which is one.
    membership: [f64; RULES],
    /// `S = [N, B]`, 3 x 4.
    step: Matrix,
}

/// All vertices. Where the input is noise, K and h are tied by the speed.
fn vertices(error: &ErrorSystem, memberships: &SpeedMemberships) -> Vec<Vertex> {
    let columns = error.output.ncols();
    let has_noise = error.courses.len() > VERTICES_OF_RHO;
    let of_each_speed = error.courses.len() / memberships.len();
    let mut vertices: Vec<Vertex> = Vec::new();
    for (index, course) in error.courses.iter().enumerate() {
        let shares: Vec<[f64; RULES]> = if has_noise {
            let of_speed = memberships[index / of_each_speed];
            of_speed
                .iter()
                .flat_map(|&slow| [[1.0, 0.0], [0.0, 1.0]].map(|r| bilinear(slow, r)))
                .collect()
        } else {
            (0..RULES).map(|i| std::array::from_fn(|k| f64::from(u8::from(i == k)))).collect()
        };
        for membership in shares {
            let step = course
                .iter()
                .zip(membership)
                .fold(Matrix::zeros(3, columns), |step, (course, h)| {
                    step + course.columns(0, columns) * h
                });
            let same = |x: &Vertex| x.membership == membership && x.step == step;
            if !vertices.iter().any(same) {
                vertices.push(Vertex { membership, step });
            }
        }
    }
    vertices
}

/// h of the rules, from their share of the lowest speed and of both ends of r.
fn bilinear(slow: f64, [right, left]: [f64; 2]) -> [f64; RULES] {
    [slow * right, slow * left, (1.0 - slow) * right, (1.0 - slow) * left]
}

/// The inequalities at the head of this module with `energy P_i` in place of P_i.
struct Problem {
    vertices: Vec<Vertex>,
    output: Matrix,
    from_start: Matrix,
    window: f64,
}

/// A solution.
struct Point {
    energy: f64,
    gain_squared: f64,
    p: [Matrix; RULES],
    v: [Matrix; RULES],
}

impl Problem {
    fn solve(&self, lambda: f64) -> Option<Point> {
        let mut variables = Variables::default();
        let p: [Affine; RULES] = std::array::from_fn(|_| variables.symmetric(3));
        let v: [Affine; RULES] = std::array::from_fn(|_| variables.symmetric(3));
        let [energy, gain_squared] = [variables.scalar(), variables.scalar()];
        let [few, further] = self.conditions(lambda, [&p, &v], &energy, &gain_squared);
        let with_margin = |conditions: &[Affine]| -> Vec<Affine> {
            let margin =
                |x: &Affine| x - &Affine::from(Matrix::identity(x.order(), x.order()) * MARGIN);
            conditions.iter().map(margin).collect()
        };
        let objective = (1.0 / self.window) * &energy + &gain_squared;
        let solution = minimise_with_cuts(
            &variables,
            &objective,
            with_margin(&few),
            with_margin(&further),
            MARGIN / 2.0,
        )
        .ok()?;
        let at = |expression: &Affine| expression.at(&solution.x);
        let confirmed = |x: &Affine| smallest_eigenvalue(&at(x)) > CONFIRMED;
        let holds = solution.is_candidate() && few.iter().chain(&further).all(confirmed);
        holds.then(|| Point {
            energy: at(&energy)[0],
            gain_squared: at(&gain_squared)[0],
            p: p.each_ref().map(at),
            v: v.each_ref().map(at),
        })
    }

    /// Those of the first vertices, then those of the further ones.
    fn conditions(
        &self,
        lambda: f64,
        [p, v]: [&[Affine; RULES]; 2],
        energy: &Affine,
        gain_squared: &Affine,
    ) -> [Vec<Affine>; 2] {
        let order = self.output.ncols();
        let of_error = Matrix::identity(order, 3);
        let mut of_input = Matrix::zeros(order, order);
        of_input[(3, 3)] = 1.0;
        let blend = |x: &[Affine; RULES], h: &[f64; RULES]| {
            let sum = x
                .iter()
                .zip(h)
                .fold(Affine::zeros(3, 3), |sum, (x, &h)| if h == 0.0 { sum } else { sum + h * x });
            &of_error * &(&sum * &of_error.transpose())
        };
        let squared = Affine::from(self.output.transpose() * &self.output);
        let from_invariance = (1.0 - lambda) * &energy.times(&of_input);
        let from_dissipation = gain_squared.times(&of_input) - &squared;

        let mut few: Vec<Affine> = p.iter().chain(v).cloned().collect();
        few.extend(p.iter().zip(v).map(|(p, v)| p - v));
        if self.from_start.ncols() > 0 {
            let at_start = |p: &Affine| &self.from_start.transpose() * &(p * &self.from_start);
            few.extend(p.iter().map(|p| energy - &at_start(p)));
        }
        let mut inequalities = [few, Vec::new()];
        for (index, Vertex { membership, step }) in self.vertices.iter().enumerate() {
            let inequalities = &mut inequalities[usize::from(index >= FIRST_VERTICES)];
            let now_p = lambda * &blend(p, membership) + &from_invariance;
            let now_v = blend(v, membership) + &from_dissipation;
            for (p, v) in p.iter().zip(v) {
                let next = |x: &Affine| &step.transpose() * &(x * step);
                inequalities.push(&now_p - &next(p));
                inequalities.push(&now_v - &next(v));
            }
        }
        inequalities
    }
}
