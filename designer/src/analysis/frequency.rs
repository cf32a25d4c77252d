//! Frozen analysis: what the gains, and any residual generator at all, can do at constant operating
//! points.
//!
//! # Conventions
//! - Figures are those of the weighted residual W_r r, worst over the operating points and over a
//!   grid of each input's band.
//! - gamma is the gain from the stacked inputs of a band in the 2-norm, inputs in units of the first
//!   disturbance; of several bands it is the square root of the sum of squares.
//! - Between grid frequencies `||G(z) - G(z_0)|| <= d ||C R|| ||R B|| / (1 - d ||R||)`, with
//!   `R = (z_0 I - N)^-1` and d the largest distance of z from a grid point z_0: the figures
//!   `at_least` and `at_most` include it and hold for the whole band.

use nalgebra::{Complex, DMatrix, Matrix2, Matrix3, SMatrix, SVector, Vector2, Vector3};
use serde::{Deserialize, Serialize};
use steerguard_detector::{C, Gains};

use crate::analysis::operating_point::{FrozenError, OperatingPoint, extreme_gains, fixed};
use crate::problem::channel::Channel;
use crate::problem::inputs::Inputs;

/// Frequencies across a band.
const FREQUENCIES: u32 = 1000;
/// Frequencies at which the limit is taken.
const FREQUENCIES_OF_LIMIT: u32 = 100;
/// What is below this share of a squared gain counts as zero.
const SINGULAR: f64 = 1e-13;

/// What the frozen error dynamics do to fault and disturbance, the worst over the operating points.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Frozen {
    /// Smallest gain from the fault over its band, per rad or N m.
    pub beta: f64,
    /// What lies between grid frequencies included.
    pub beta_at_least: f64,
    /// Largest gain from the disturbances over their bands, per unit of the first.
    pub gamma: f64,
    /// What lies between grid frequencies included.
    pub gamma_at_most: f64,
}

/// The figures at one operating point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PointFigures {
    /// Longitudinal speed.
    pub v_x_m_per_s: f64,
    /// Lateral speed.
    pub v_y_m_per_s: f64,
    /// Yaw rate.
    pub r_rad_per_s: f64,
    /// Smallest gain from the fault over its band, per rad or N m.
    pub beta: f64,
    /// Largest gain from the disturbances over their bands, per unit of the first.
    pub gamma: f64,
    /// RMS of the weighted residual under white sensor noise.
    pub noise_rms: f64,
    /// [`detection_ratio`].
    pub detection_ratio: f64,
    /// [`limit`] of the gap; null: unbounded.
    pub limit: Option<f64>,
}

/// The figures at an operating point.
pub fn at_point(point: &OperatingPoint, gains: &Gains, inputs: &Inputs) -> PointFigures {
    let error = FrozenError::new(point, gains, inputs.weights);
    let [beta, gamma] =
        [gain(&error, &inputs.fault).smallest, total(&error, inputs, |x| x.largest)];
    let noise_rms = noise_rms(&error, inputs.white_std);
    let [v_x_m_per_s, v_y_m_per_s, r_rad_per_s] = point.state;
    PointFigures {
        v_x_m_per_s,
        v_y_m_per_s,
        r_rad_per_s,
        beta,
        gamma,
        noise_rms,
        detection_ratio: detection_ratio(beta, gamma, noise_rms, inputs),
        limit: limit(point, inputs),
    }
}

/// Worst gains over `points`.
pub fn frozen(points: &[OperatingPoint], gains: &Gains, inputs: &Inputs) -> Frozen {
    let mut result = Frozen {
        beta: f64::INFINITY,
        beta_at_least: f64::INFINITY,
        gamma: 0.0,
        gamma_at_most: 0.0,
    };
    let mut largest = vec![[0.0_f64; 2]; inputs.disturbances.len()];
    for point in points {
        let error = FrozenError::new(point, gains, inputs.weights);
        let from_fault = gain(&error, &inputs.fault);
        result.beta = result.beta.min(from_fault.smallest);
        result.beta_at_least = result.beta_at_least.min(from_fault.at_least);
        for (channel, [grid, at_most]) in inputs.disturbances.iter().zip(&mut largest) {
            let from_disturbances = gain(&error, channel);
            *grid = grid.max(from_disturbances.largest);
            *at_most = at_most.max(from_disturbances.at_most);
        }
    }
    for [grid, at_most] in largest {
        result.gamma = result.gamma.hypot(grid);
        result.gamma_at_most = result.gamma_at_most.hypot(at_most);
    }
    result
}

/// Gains of the weighted residual at the frequency `w` in radians a sample, the worst over `points`: the smallest from
/// the fault, per rad or N m, and the largest from the disturbances whose bands hold `w`, per unit of the first.
/// None where exp(jw) is an eigenvalue.
pub fn at_frequency(
    points: &[OperatingPoint],
    gains: &Gains,
    inputs: &Inputs,
    w: f64,
) -> Option<[f64; 2]> {
    let mut worst = [f64::INFINITY, 0.0_f64];
    for point in points {
        let error = FrozenError::new(point, gains, inputs.weights);
        let c_r = error.output.map(Complex::from) * error.resolvent(w)?;
        let extremes = |channel: &Channel| {
            let columns = error.columns(channel);
            extreme_gains(columns.iter().map(|(b, d)| c_r * b + d))
        };
        let [_, of_fault] = extremes(&inputs.fault);
        let acting = inputs.disturbances.iter().filter(|channel| channel.band.holds(w));
        let of_disturbances =
            acting.fold(0.0, |sum, channel| f64::hypot(sum, extremes(channel)[0]));
        worst = [worst[0].min(of_fault), worst[1].max(of_disturbances)];
    }
    Some(worst)
}

/// The fault's residual against that of disturbances and noise together:
/// `beta x smallest fault / sqrt((gamma x bound)^2 + noise_rms^2)` (method 5).
pub fn detection_ratio(beta: f64, gamma: f64, noise_rms: f64, inputs: &Inputs) -> f64 {
    beta * inputs.smallest_fault / (gamma * inputs.bound).hypot(noise_rms)
}

/// RMS of the weighted residual under white sensor noise with the given standard deviations of
/// [v_x, r]: the H2 norm of the error dynamics, scaled. Infinite where they are not stable.
pub fn noise_rms(error: &FrozenError, white_std: [f64; 2]) -> f64 {
    let d_y = Matrix2::from_diagonal(&Vector2::from(white_std));
    let b = error.from_noise * d_y;
    let feedthrough = error.feedthrough * d_y;
    // Covariance of the error: P = N P N' + B B'.
    let Some(covariance) = discrete_lyapunov(&error.n, &(b * b.transpose())) else {
        return f64::INFINITY;
    };
    let variance =
        (error.output * covariance * error.output.transpose()).trace() + feedthrough.norm_squared();
    if variance >= 0.0 { variance.sqrt() } else { f64::INFINITY }
}

/// X of `X = N X N' + Y`; none where it has no unique solution.
pub(crate) fn discrete_lyapunov(n: &Matrix3<f64>, y: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let map = SMatrix::<f64, 9, 9>::identity() - n.kronecker(n);
    let x = map.lu().solve(&SVector::<f64, 9>::from_iterator(y.iter().copied()))?;
    Some(Matrix3::from_iterator(x.iter().copied()))
}

/// The gap that no residual generator exceeds at this operating point:
/// `sqrt(Gf* (Gd Gd*)^-1 Gf)`, the smallest over the fault's band, Gd of the disturbances and
/// bounded noise active at that frequency, every channel in units of smallest fault and bound
/// (method 5.1), its pseudo-inverse where it is singular. None: unbounded, at every frequency the
/// fault reaches a direction of the residual that no disturbance reaches.
pub fn limit(point: &OperatingPoint, inputs: &Inputs) -> Option<f64> {
    // All residual generators have the same limit, so any does to take it by. That of an observer
    // with L = A C' has, with 0 < a_22 < 1, no mode on the unit circle, where A has some.
    let c = fixed(&C);
    let l = point.a * c.transpose();
    let n = (point.a - l * c).map(Complex::from);
    // Where another disturbance's band begins, the limit drops.
    let ends = inputs.disturbances.iter().flat_map(|channel| channel.band.limits());
    let frequencies = inputs
        .fault
        .band
        .grid(FREQUENCIES_OF_LIMIT)
        .chain(ends.filter(|&w| inputs.fault.band.holds(w)));
    let at = |w: f64| {
        let z = Complex::from_polar(1.0, w);
        let to_residual =
            c.map(Complex::from) * (Matrix3::from_diagonal_element(z) - n).try_inverse()?;

        let mut gd_gd = Matrix2::<Complex<f64>>::zeros();
        for channel in inputs.disturbances.iter().filter(|channel| channel.band.holds(w)) {
            for d in channel.direction.column_iter() {
                let d = Vector3::from_iterator(d.iter().map(|&x| Complex::from(x * inputs.bound)));
                let g = to_residual * d;
                gd_gd += g * g.adjoint();
            }
            for d_y in channel.noise.column_iter() {
                let d_y = Vector2::from_iterator(d_y.iter().map(|&x| x * inputs.bound));
                let g = to_residual * (-(l + point.k) * d_y).map(Complex::from)
                    + d_y.map(Complex::from);
                gd_gd += g * g.adjoint();
            }
        }
        let f = Vector3::from_iterator(
            inputs.fault.direction.iter().map(|&x| Complex::from(x * inputs.smallest_fault)),
        );
        let g_f = to_residual * f;
        // In a direction of the residual that no disturbance reaches, any fault at all stands out.
        let of_disturbances = gd_gd.symmetric_eigen();
        let negligible = SINGULAR * of_disturbances.eigenvalues.max();
        let mut squared = 0.0;
        for (k, u) in of_disturbances.eigenvectors.column_iter().enumerate() {
            let along = u.dotc(&g_f).norm_sqr();
            match of_disturbances.eigenvalues[k] {
                reached if reached > negligible => squared += along / reached,
                _ if along > SINGULAR * g_f.norm_squared() => return None,
                _ => {}
            }
        }
        Some(squared.sqrt())
    };
    frequencies.filter_map(at).reduce(f64::min)
}

/// Root of the sum of squares of a gain over the disturbances' bands.
fn total(error: &FrozenError, inputs: &Inputs, of: impl Fn(&Gain) -> f64) -> f64 {
    inputs.disturbances.iter().fold(0.0, |sum, channel| f64::hypot(sum, of(&gain(error, channel))))
}

/// Extremes of a gain over a band: on the grid, and with what lies between.
struct Gain {
    smallest: f64,
    largest: f64,
    at_least: f64,
    at_most: f64,
}

/// The gain from `input` over its band.
fn gain(error: &FrozenError, input: &Channel) -> Gain {
    let [from, to] = input.band.limits();
    // A chord is shorter than its arc.
    let distance = (to - from) / f64::from(FREQUENCIES) / 2.0;
    let error = error.balanced();
    let output = error.output.map(Complex::from);
    let columns = error.columns(input);
    let b = DMatrix::from_fn(3, columns.len(), |row, column| columns[column].0[row]);

    let unknown =
        Gain { smallest: 0.0, largest: f64::INFINITY, at_least: 0.0, at_most: f64::INFINITY };
    let mut gain =
        Gain { smallest: f64::INFINITY, largest: 0.0, at_least: f64::INFINITY, at_most: 0.0 };
    for w in input.band.grid(FREQUENCIES) {
        let Some(resolvent) = error.resolvent(w) else {
            return unknown;
        };
        let c_r = output * resolvent;
        let [largest, smallest] = extreme_gains(columns.iter().map(|(b, d)| c_r * b + d));
        let near = distance * resolvent.norm();
        let between = if near < 1.0 {
            distance * c_r.norm() * (resolvent * &b).norm() / (1.0 - near)
        } else {
            f64::INFINITY
        };
        gain.smallest = gain.smallest.min(smallest);
        gain.largest = gain.largest.max(largest);
        gain.at_least = gain.at_least.min((smallest - between).max(0.0));
        gain.at_most = gain.at_most.max(largest + between);
    }
    gain
}
