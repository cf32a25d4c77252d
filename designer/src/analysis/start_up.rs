//! Start-up of the residual: a bound `||W_r r_j|| <= amplitude tau^j` for given gains
//! (method 6).
//!
//! The observer starts at `z_0 = M [v_x, 0, r]`, so the error starts at `e_0 = [0, v_y, 0]` and obeys
//! `e+ = N_i(rho) e`. Matrices P_i with
//!
//! ```text
//! tau^2 P_i - N_i(rho)' P_k N_i(rho) >= 0,   P_i - C' W_r^2 C >= 0
//! ```
//!
//! give `||W_r r_j||^2 <= e_j' P e_j <= tau^(2 j) v_y^2 max_i [0 1 0] P_i [0 1 0]'`. The smallest such
//! bound for a given tau is a semidefinite programme.
//!
//! It speaks of the vehicle as specified. Another one answers v_y with other forces, and where the yaw rate
//! of the specified one does not depend on v_y at all (neutral steer), its bound is next to nothing while that
//! of the others is not. The term therefore is at least J of the vehicles that are possible, until that is
//! negligible: P and the amplitude's square are multiplied by one factor, which leaves the inequalities true.
//!
//! # Conventions
//! - Programme and check measure e_2 in units of s, with which N is balanced: `N' = T^-1 N T`,
//!   `P' = T P T`, T = diag(1, s, 1), a congruence of the inequalities. Gains with large E_22 would
//!   otherwise make rounding larger than any margin. P_i are stored in SI.

use nalgebra::{Matrix3, Vector3};
use steerguard_detector::{C, Evaluation, Gains, RULES, StartUp, TsModel, Vehicle, VehicleState};

use crate::analysis::certificate::{ErrorDynamics, Margin};
use crate::analysis::operating_point::{
    self, FrozenError, OperatingPoint, fixed, spectral_radius, square,
};
use crate::lmi::affine::{Affine, Variables};
use crate::lmi::matrix::{Matrix, matrix};
use crate::lmi::solve::minimise;
use crate::synthesis::theorem4::for_all;

/// Decay rates tried between the slowest mode's and the design's.
const DECAY_RATES: u32 = 12;
/// Margin of the inequalities, in units of the larger weight squared.
const MARGIN: f64 = 1e-7;
/// Units of e_2 tried, in those that balance the dynamics.
const UNITS: [f64; 5] = [1.0, 0.125, 8.0, 0.015625, 64.0];
/// More than what P_i have to be multiplied by.
const MULTIPLIED: f64 = 1.001;
/// Makes up for the rounding of the amplitude.
const ROUNDED_UP: f64 = 1.0 + 16.0 * f64::EPSILON;
/// Longest start-up considered, samples.
const LONGEST: u32 = 100_000;
/// Windows for which J of other vehicles is followed: what lasts longer is no matter of the start.
const WINDOWS: usize = 10;

/// A bound on the start-up residual, checked apart from the solver.
#[derive(Clone, Debug, PartialEq)]
pub struct StartUpBound {
    /// Factor of `tau^j`.
    pub amplitude: f64,
    /// tau, in (0, 1).
    pub decay: f64,
    /// P_i.
    pub p: [Matrix; RULES],
    /// Margin of the inequalities at P_i.
    pub margin: Margin,
}

/// The largest J of `vehicles` at the samples after a start at the lateral speed `v_y`, straight ahead at
/// constant speeds over the model's range.
pub fn of_vehicles(
    vehicles: &[Vehicle],
    model: &TsModel,
    gains: &Gains,
    evaluation: &Evaluation,
    v_y: f64,
) -> Vec<f64> {
    let mut largest = vec![0.0_f64; WINDOWS * evaluation.window];
    for point in OperatingPoint::straight(model) {
        let error = FrozenError::new(&point, gains, evaluation.weights);
        for vehicle in vehicles {
            let jacobian = fixed(&vehicle.jacobian(VehicleState::from(point.state)));
            let step: Matrix3<f64> = (jacobian * model.sampling_period_s).exp();
            let mut x = Vector3::new(0.0, v_y, 0.0);
            let mut e = x;
            let mut squares = Vec::with_capacity(largest.len());
            for largest in &mut largest {
                squares.push((error.output * e).norm_squared());
                let first = squares.len().saturating_sub(evaluation.window);
                let mean = squares[first..].iter().sum::<f64>() / evaluation.window as f64;
                *largest = largest.max(mean.sqrt());
                let next = step * x;
                e = error.n * e + error.m * (next - point.a * x);
                x = next;
            }
        }
    }
    largest
}

/// The bound whose term of the threshold sinks below `negligible` soonest, among decay rates up to
/// `slowest`; `evaluation` gives window and weights, `v_y` the largest lateral speed at the start. The term
/// is no less than `at_least`, J at the samples after a start, where that is not negligible.
///
/// Where the programme has no solution that passes its check, the P_i that prove the decay `slowest` of the error, in
/// SI, are multiplied until they bound the residual too: a bound as well, though not the smallest.
/// None where these do not pass either.
pub fn bound(
    dynamics: &ErrorDynamics,
    slowest: f64,
    p_s: &[Matrix; RULES],
    evaluation: &Evaluation,
    v_y: f64,
    at_least: &[f64],
    negligible: f64,
) -> Option<StartUpBound> {
    let radius = dynamics.iter().flatten().map(|n| spectral_radius(&square(n))).fold(0.0, f64::max);
    let rates = (1..=DECAY_RATES)
        .map(|step| radius + (slowest - radius) * f64::from(step) / f64::from(DECAY_RATES));
    // Where the balanced unit has no bound that passes its check, another may.
    let s = balance(dynamics);
    let raised = |bound: StartUpBound| bound.raised_to(at_least, negligible, evaluation);
    let programmes = |decay| {
        let in_units_of =
            move |factor| Programme::new(dynamics, decay, evaluation.weights, v_y, factor * s);
        UNITS.into_iter().map(in_units_of)
    };
    let smallest =
        rates.filter_map(|decay| programmes(decay).find_map(|x| x.smallest()).map(raised));
    smallest
        .min_by_key(|bound| samples_until(negligible, bound, evaluation))
        .or_else(|| programmes(slowest).find_map(|x| x.multiplied(p_s)).map(raised))
}

impl StartUpBound {
    /// The bound with a term of at least J = `at_least` at the samples after a start, where that is not
    /// negligible.
    fn raised_to(self, at_least: &[f64], negligible: f64, evaluation: &Evaluation) -> Self {
        let unit =
            Evaluation { start_up_amplitude: 1.0, start_up_decay: self.decay, ..*evaluation };
        let mut term = StartUp::RESTARTED;
        let of_term = at_least.iter().map(|&j| {
            let term = term.next(&unit);
            if j > negligible { j / term } else { 0.0 }
        });
        let amplitude = of_term.fold(self.amplitude, f64::max);
        if amplitude == self.amplitude {
            return self;
        }
        let factor = amplitude / self.amplitude;
        Self { amplitude: amplitude * ROUNDED_UP, p: self.p.map(|p| p * (factor * factor)), ..self }
    }
}

/// Samples until the start-up term stays below `negligible`.
fn samples_until(negligible: f64, bound: &StartUpBound, evaluation: &Evaluation) -> u32 {
    let evaluation = Evaluation {
        start_up_amplitude: bound.amplitude,
        start_up_decay: bound.decay,
        ..*evaluation
    };
    let mut term = StartUp::RESTARTED;
    // The term rises while the window fills and sinks from then on.
    let mut last_above = 0;
    for sample in 0..LONGEST {
        if term.next(&evaluation) > negligible {
            last_above = sample;
        } else if sample as usize > evaluation.window {
            break;
        }
    }
    last_above
}

/// What a bound of one decay rate has to satisfy, with e_2 in units of s.
struct Programme {
    dynamics: ErrorDynamics,
    decay: f64,
    /// `C' W_r^2 C`, in units of the larger weight squared.
    output: Matrix,
    /// The larger weight.
    unit: f64,
    v_y: f64,
    s: f64,
}

impl Programme {
    fn new(dynamics: &ErrorDynamics, decay: f64, weights: [f64; 2], v_y: f64, s: f64) -> Self {
        let unit = weights[0].max(weights[1]);
        let c = matrix(&C);
        let w_c = Matrix::from_fn(2, 3, |row, column| weights[row] / unit * c[(row, column)]);
        let output = w_c.transpose() * w_c;
        Self { dynamics: scaled(dynamics, s), decay, output, unit, v_y, s }
    }

    /// The smallest bound.
    fn smallest(&self) -> Option<StartUpBound> {
        let e_2 = Matrix::from_column_slice(3, 1, &[0.0, 1.0, 0.0]);
        let mut variables = Variables::default();
        let p: [Affine; RULES] = std::array::from_fn(|_| variables.symmetric(3));
        let largest = variables.scalar();
        let mut inequalities = conditions(&self.dynamics, self.decay, &self.output, &p);
        for inequality in &mut inequalities {
            *inequality = &*inequality - &(Matrix::identity(3, 3) * MARGIN).into();
        }
        inequalities.extend(p.iter().map(|p| &largest - &(&e_2.transpose() * &(p * &e_2))));
        let solution = minimise(&variables, &largest, &inequalities).ok()?;
        if !solution.is_candidate() {
            return None;
        }
        self.checked(p.map(|p| p.at(&solution.x)))
    }

    /// The bound by P_i, in SI, that prove the decay, times the least factor with which they are no less than the
    /// output.
    fn multiplied(&self, p_s: &[Matrix; RULES]) -> Option<StartUpBound> {
        let p = p_s.each_ref().map(|p| in_units(p, self.s, self.s));
        let mut factor = 0.0_f64;
        for p in &p {
            let inverse = p.clone().cholesky()?.l().try_inverse()?;
            let relative = &inverse * &self.output * inverse.transpose();
            factor = factor.max(relative.symmetric_eigenvalues().max());
        }
        self.checked(p.map(|p| p * (factor * MULTIPLIED)))
    }

    /// The bound by P_i, if they pass their check. Numbers only: the solver's account is not used.
    fn checked(&self, p: [Matrix; RULES]) -> Option<StartUpBound> {
        let Self { dynamics, decay, output, unit, v_y, s } = self;
        let largest = p.iter().map(|p| p[(1, 1)]).fold(0.0, f64::max);
        let constant = p.each_ref().map(|p| Affine::from(p.clone()));
        let p_norm = p.iter().map(Matrix::norm).fold(0.0, f64::max);
        let n_norm = dynamics.iter().flatten().map(Matrix::norm).fold(1.0, f64::max);
        let margin = Margin::of(
            &conditions(dynamics, *decay, output, &constant),
            1.0 + p_norm * (1.0 + n_norm * n_norm),
        );
        margin.holds().then(|| StartUpBound {
            amplitude: unit * largest.sqrt() / s * v_y * ROUNDED_UP,
            decay: *decay,
            p: p.map(|p| in_units(&p, 1.0 / s, 1.0 / s) * (unit * unit)),
            margin,
        })
    }
}

/// The unit of e_2 in which what N sends from the measured errors to e_2 is as large as what it sends
/// back: a power of two, so that scaling rounds nothing.
fn balance(dynamics: &ErrorDynamics) -> f64 {
    let largest = |of: fn(&Matrix) -> [f64; 2]| {
        dynamics.iter().flatten().flat_map(of).map(f64::abs).fold(0.0, f64::max)
    };
    let to_e_2 = largest(|n| [n[(1, 0)], n[(1, 2)]]);
    let from_e_2 = largest(|n| [n[(0, 1)], n[(2, 1)]]);
    operating_point::balance(to_e_2, from_e_2)
}

/// `T^-1 N T`.
fn scaled(dynamics: &ErrorDynamics, s: f64) -> ErrorDynamics {
    dynamics.each_ref().map(|of_rule| of_rule.each_ref().map(|n| in_units(n, 1.0 / s, s)))
}

/// The second row times `row`, the second column times `column`.
fn in_units(x: &Matrix, row: f64, column: f64) -> Matrix {
    let of = |k: usize, factor: f64| if k == 1 { factor } else { 1.0 };
    Matrix::from_fn(3, 3, |i, j| of(i, row) * x[(i, j)] * of(j, column))
}

/// The inequalities at the head of this module.
fn conditions(
    dynamics: &ErrorDynamics,
    decay: f64,
    output: &Matrix,
    p: &[Affine; RULES],
) -> Vec<Affine> {
    let mut inequalities: Vec<Affine> =
        p.iter().map(|p| p - &Affine::from(output.clone())).collect();
    for_all(|i, k, j| {
        let n = &dynamics[i][j];
        inequalities.push(decay * decay * &p[i] - &n.transpose() * &(&p[k] * n));
    });
    inequalities
}
