//! Output-error fit: several starts, a robust loss, standard errors that bear a residual that is not
//! white, and what changes when only part of the drive is asked (method 10).
//!
//! # Conventions
//! Standard errors and misfits are relative or in SI, as [`Parameter::scale`] says.

use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use rayon::prelude::*;

use crate::course::Course;
use crate::model::{Chassis, GRAVITY_M_PER_S2};
use crate::parameter::{Parameter, Parameter::*, Values};
use crate::problem::{Deviations, Problem, Row};

/// Standard deviations that the search starts with: sensors of production cars.
const START: Deviations = Deviations { yaw_rate: 0.005, lateral_acceleration: 0.1 };
/// Cornering stiffness of a tyre over its load that starts are taken about, 1/rad.
const STIFFNESS_PER_LOAD: f64 = 20.0;
/// Starts: factors of the stiffness, delays in s.
const STIFFNESSES: [f64; 3] = [0.5, 1.0, 2.0];
const DELAYS_S: [f64; 4] = [0.0, 0.1, 0.25, -0.05];
/// Rounds of the robust loss.
const ROUNDS: usize = 5;
/// Standard deviations from which on a row weighs less (Huber).
const HUBER: f64 = 2.0;
/// Rows of a signal at most: more say no more, at 100 Hz for the first quarter of an hour.
const SAMPLES: usize = 90_000;
/// Over what time a residual that is not white is taken as one, s.
const BLOCK_S: f64 = 2.0;
/// Information on a combination of parameters, of columns of length 1, that counts as none.
const LEAST_INFORMATION: f64 = 1e-14;

/// A fit of some parameters to some courses.
#[derive(Clone, Debug)]
pub(crate) struct Fit {
    pub(crate) values: Values,
    /// Of the fitted parameters, in the order of `free`.
    pub(crate) free: Vec<Parameter>,
    /// Of what the model computes with.
    pub(crate) covariance: DMatrix<f64>,
    pub(crate) deviations: Deviations,
    /// What is left over, in standard deviations.
    pub(crate) left_over: Vec<f64>,
    pub(crate) rows: Vec<Row>,
}

impl Fit {
    /// Standard error of a fitted parameter, by what is left over; none of any other.
    pub(crate) fn scatter(&self, parameter: Parameter) -> Option<f64> {
        let at = self.free.iter().position(|&free| free == parameter)?;
        Some(parameter.error(self.values[parameter], self.covariance[(at, at)].sqrt()))
    }

    /// The same with the model's own error.
    pub(crate) fn standard_error(&self, parameter: Parameter) -> Option<f64> {
        self.scatter(parameter).map(|scatter| scatter.hypot(parameter.model_error()))
    }

    /// Correlation of two fitted parameters.
    pub(crate) fn correlation(&self, of: Parameter, with: Parameter) -> Option<f64> {
        let at = |of| self.free.iter().position(|&free| free == of);
        let (i, j) = (at(of)?, at(with)?);
        let variance = self.covariance[(i, i)] * self.covariance[(j, j)];
        // The ratio is fitted as its inverse, which goes the other way.
        let turned = (of == SteeringRatio) != (with == SteeringRatio);
        let sign = if turned { -self.values[SteeringRatio].signum() } else { 1.0 };
        Some(sign * self.covariance[(i, j)] / variance.sqrt())
    }
}

/// How many of the samples are compared.
pub(crate) fn compared(courses: &[Course]) -> usize {
    courses.iter().flat_map(|course| &course.compared).filter(|&&compared| compared).count()
}

fn stride(courses: &[Course]) -> usize {
    compared(courses).div_ceil(SAMPLES).max(1)
}

/// The best fit of the `free` parameters from several starts; `values` holds the others. None where no
/// start led anywhere.
pub(crate) fn from_starts(
    chassis: &Chassis,
    courses: &[Course],
    free: &[Parameter],
    values: &Values,
    advance: &(dyn Fn() + Sync),
) -> Option<Fit> {
    let starts: Vec<(f64, f64)> = STIFFNESSES
        .into_iter()
        .flat_map(|stiffness| DELAYS_S.map(|delay_s| (stiffness, delay_s)))
        .collect();
    let found = starts.into_par_iter().filter_map(|(stiffness, delay_s)| {
        let start = start(chassis, courses, free, values, stiffness, delay_s);
        let problem = Problem {
            chassis,
            courses,
            free,
            values: start,
            deviations: START,
            weights: Vec::new(),
            // A search finds its way with fewer.
            stride: stride(courses) * compared(courses).div_ceil(10_000).clamp(1, 5),
        };
        let (problem, report) = LevenbergMarquardt::new().with_patience(30).minimize(problem);
        advance();
        report.objective_function.is_finite().then_some((report.objective_function, problem.values))
    });
    let (_, found) = found.min_by(|(a, _), (b, _)| a.total_cmp(b))?;
    refine(chassis, courses, free, &found)
}

/// How many starts there are.
pub(crate) const STARTS: u64 = (STIFFNESSES.len() * DELAYS_S.len()) as u64;

/// `values` with the free ones where a search may start.
fn start(
    chassis: &Chassis,
    courses: &[Course],
    free: &[Parameter],
    values: &Values,
    stiffness: f64,
    delay_s: f64,
) -> Values {
    let mut start = *values;
    let [ratio, offset, bias] = rolling(chassis, courses, delay_s);
    let load_of_tyre =
        |other_m| chassis.mass_kg * GRAVITY_M_PER_S2 * other_m / chassis.wheelbase_m() / 2.0;
    for &parameter in free {
        start[parameter] = match parameter {
            SteeringRatio => ratio,
            SteeringOffset => offset,
            YawRateBias => bias,
            Delay => delay_s,
            FrontStiffness => {
                let load = load_of_tyre(chassis.rear_axle_distance_m);
                (stiffness * STIFFNESS_PER_LOAD * load).ln()
            }
            RearStiffness => {
                let load = load_of_tyre(chassis.front_axle_distance_m);
                (stiffness * STIFFNESS_PER_LOAD * load).ln()
            }
            Lag | YawInertia | Height | LateralBias | LateralScale | LateralDelay => {
                start[parameter]
            }
        };
    }
    start
}

/// Inverse ratio as if tyres did not slip, and the correlation of v times steering with yaw rate.
pub(crate) fn against_steering(chassis: &Chassis, courses: &[Course]) -> (f64, f64) {
    let (mut both, mut of_steering, mut of_yaw_rate) = (0.0, 0.0, 0.0);
    let (mut n, mut sum_steering, mut sum_yaw_rate) = (0.0, 0.0, 0.0);
    for course in courses {
        for k in (0..course.len()).filter(|&k| course.compared[k]) {
            let (x, r) = (course.speed[k].max(0.0) * course.steering[k], course.yaw_rate[k]);
            n += 1.0;
            sum_steering += x;
            sum_yaw_rate += r;
            both += x * r;
            of_steering += x * x;
            of_yaw_rate += r * r;
        }
    }
    let both = both - sum_steering * sum_yaw_rate / n;
    let of_steering = of_steering - sum_steering * sum_steering / n;
    let of_yaw_rate = of_yaw_rate - sum_yaw_rate * sum_yaw_rate / n;
    let slope = both / of_steering;
    (slope * chassis.wheelbase_m(), both / (of_steering * of_yaw_rate).sqrt())
}

/// Inverse ratio, offset and bias as if tyres did not slip: r = v (s / i - delta_0) / L + b.
fn rolling(chassis: &Chassis, courses: &[Course], delay_s: f64) -> [f64; 3] {
    let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for course in courses {
        let delay = delay_s / course.period_s;
        for k in (0..course.len()).filter(|&k| course.compared[k]) {
            let (v, r) = (course.speed[k].max(0.0), course.yaw_rate[k]);
            let by_angle = v / chassis.wheelbase_m();
            let row = Vector3::new(by_angle * course.steering_at(k as f64 - delay), -by_angle, 1.0);
            // Slow samples are nearer to rolling.
            let weight = 1.0 / (1.0 + (v / 8.0).powi(4));
            normal += weight * row * row.transpose();
            right += weight * r * row;
        }
    }
    // What the drive does not show stays near zero.
    let x = normal.pseudo_inverse(1e-9 * normal.norm()).map(|inverse| inverse * right);
    match x {
        Ok(x) if x.iter().all(|x| x.is_finite()) && x[0].abs() > 1e-3 => [x[0], x[1], x[2]],
        _ => [0.1, 0.0, 0.0],
    }
}

/// What the standard errors of `fit` would be on other courses, were its values true there.
pub(crate) fn elsewhere(chassis: &Chassis, courses: &[Course], fit: &Fit) -> Option<Fit> {
    let problem = Problem {
        chassis,
        courses,
        free: &fit.free,
        values: fit.values,
        deviations: fit.deviations,
        weights: Vec::new(),
        stride: stride(courses),
    };
    let rows = problem.rows();
    let left_over = problem.left_over(&fit.values);
    let covariance = covariance(&problem, &rows)?;
    Some(Fit { covariance, left_over, rows, ..fit.clone() })
}

/// The fit from `values` on with the robust loss; none where the search ends without an answer.
pub(crate) fn refine(
    chassis: &Chassis,
    courses: &[Course],
    free: &[Parameter],
    values: &Values,
) -> Option<Fit> {
    let mut problem = Problem {
        chassis,
        courses,
        free,
        values: *values,
        deviations: START,
        weights: Vec::new(),
        stride: stride(courses),
    };
    let rows = problem.rows();
    for _ in 0..ROUNDS {
        let left = problem.left_over(&problem.values);
        let before = problem.deviations;
        let scale = |lateral: bool| {
            let of: Vec<f64> = rows
                .iter()
                .zip(&left)
                .filter(|(row, _)| row.lateral == lateral)
                .map(|(_, x)| *x)
                .collect();
            // Exact data leave nothing over.
            spread(of).max(1e-6)
        };
        let (yaw_rate, lateral) = (scale(false), scale(true));
        problem.deviations = Deviations {
            yaw_rate: before.yaw_rate * yaw_rate,
            lateral_acceleration: before.lateral_acceleration * lateral,
        };
        problem.weights = rows
            .iter()
            .zip(&left)
            .map(|(row, x)| {
                let x = x.abs() / if row.lateral { lateral } else { yaw_rate };
                let half =
                    std::env::var("HALF").ok().and_then(|x| x.parse().ok()).unwrap_or(0.25_f64);
                let n = if row.lateral { 2.0 * half / 0.01 + 1.0 } else { 1.0 };
                (HUBER / x).min(1.0) / n
            })
            .collect();
        let (solved, report) = LevenbergMarquardt::new().with_patience(30).minimize(problem);
        problem = solved;
        if !report.objective_function.is_finite() {
            return None;
        }
    }
    let left_over = problem.left_over(&problem.values);
    let covariance = covariance(&problem, &rows)?;
    Some(Fit {
        values: problem.values,
        free: free.to_vec(),
        covariance,
        deviations: problem.deviations,
        left_over,
        rows,
    })
}

/// Robust standard deviation: the median of what is left over, scaled to a normal distribution's.
fn spread(mut values: Vec<f64>) -> f64 {
    if values.is_empty() {
        return 1.0;
    }
    values.iter_mut().for_each(|x| *x = x.abs());
    let middle = values.len() / 2;
    let (_, median, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    1.4826 * *median
}

/// Covariance of the free parameters: (J' J)^-1, raised where the scores of
/// blocks of [`BLOCK_S`] scatter more than white noise would let them.
fn covariance(problem: &Problem, rows: &[Row]) -> Option<DMatrix<f64>> {
    let jacobian = problem.jacobian()?;
    let left = problem.residuals()?;
    let n = jacobian.ncols();
    // Columns of one length: parameters differ by powers of ten.
    let norms: Vec<f64> = jacobian.column_iter().map(|column| column.norm()).collect();
    let largest = norms.iter().copied().fold(0.0, f64::max);
    let norms: Vec<f64> = norms.into_iter().map(|norm| norm.max(1e-12 * largest)).collect();
    let mut scaled = jacobian;
    for (mut column, norm) in scaled.column_iter_mut().zip(norms.iter()) {
        column /= *norm;
    }
    let information = scaled.transpose() * &scaled;
    if !information.iter().all(|x| x.is_finite()) {
        return None;
    }
    // What the drives say nothing of has an error without bound: here, one that nothing accepts.
    let eigen = information.symmetric_eigen();
    let variances = eigen.eigenvalues.map(|value| 1.0 / value.max(LEAST_INFORMATION));
    let inverse =
        &eigen.eigenvectors * DMatrix::from_diagonal(&variances) * eigen.eigenvectors.transpose();
    // Rows are in standard deviations.
    let white = &inverse;

    let mut scatter = DMatrix::zeros(n, n);
    let mut score = DVector::zeros(n);
    let mut block = None;
    for (k, row) in rows.iter().enumerate() {
        let of = (row.time_s / BLOCK_S) as u64;
        if block.is_some_and(|block| block != of) {
            scatter += &score * score.transpose();
            score.fill(0.0);
        }
        block = Some(of);
        score += scaled.row(k).transpose() * left[k];
    }
    scatter += &score * score.transpose();
    let blocks = &inverse * scatter * &inverse;
    let inflation = DVector::from_fn(n, |i, _| (blocks[(i, i)] / white[(i, i)]).max(1.0).sqrt());
    let covariance = DMatrix::from_fn(n, n, |i, j| {
        white[(i, j)] * inflation[i] * inflation[j] / (norms[i] * norms[j])
    });
    covariance.iter().all(|x| x.is_finite()).then_some(covariance)
}
