//! The error dynamics at constant operating points.
//!
//! At constant v_x, v_y, r, with sensor noise v, the error `e' = x - x^ - E D_y v` obeys
//! (method 5)
//!
//! ```text
//! e'+ = N e' + M D d + M F f + (-L + M G rho E - M K) D_y v,   N = N(h) + M G rho [0 1 0]
//! W_r r = W_r C e' + W_r (I + C E) D_y v,                        rho = 2 v_y
//! ```
//!
//! # Conventions
//! - A signal's transfer matrix is that to the weighted residual W_r r, whose norm J averages.
//! - The operating points are a grid over S_x, its corners included.

use nalgebra::{Complex, Matrix2, Matrix2x3, Matrix3, Matrix3x2, SMatrix, Schur, Vector2, Vector3};
use steerguard_detector::{C, Gains, Interval, RULES, TsModel, VehicleState};

use crate::lmi::matrix::Matrix;
use crate::problem::channel::{Channel, premise_sensitivity};
use crate::synthesis::theorem4::g_rho;

/// Speeds, yaw rates and lateral speeds across the operating range.
const SPEEDS: u32 = 6;
const YAW_RATES: u32 = 3;
const LATERAL_SPEEDS: u32 = 3;

/// QR iterations of an eigenvalue problem of order three, which takes some ten.
const QR_ITERATIONS: usize = 1000;

/// What the model is at an operating point.
#[derive(Clone, Copy, Debug)]
pub struct OperatingPoint {
    /// `[v_x, v_y, r]`, m/s, m/s, rad/s.
    pub state: [f64; 3],
    /// h, membership of the rules.
    pub membership: [f64; RULES],
    /// `A(xi) + G rho [0 1 0]`.
    pub a: Matrix3<f64>,
    /// `G rho [0 1 0]`.
    pub g_rho: Matrix3<f64>,
    /// K.
    pub k: Matrix3x2<f64>,
}

impl OperatingPoint {
    /// The model at `[v_x, v_y, r]`.
    pub fn new(model: &TsModel, state: [f64; 3]) -> Self {
        let [v_x, v_y, r] = state;
        let x = VehicleState::from(state);
        let g_rho = square(&g_rho(model, 2.0 * v_y));
        let k = premise_sensitivity(model, state);
        Self {
            state,
            membership: model.membership(x.measured()),
            a: fixed(&model.a(1.0 / v_x, r)) + g_rho,
            g_rho,
            k: Matrix3x2::from_iterator(k.iter().copied()),
        }
    }

    /// The grid over S_x.
    pub fn grid(model: &TsModel) -> Vec<Self> {
        Self::at_speeds(model, spread(model.range.v_x, SPEEDS))
    }

    /// Straight ahead at speeds over S_x.
    pub fn straight(model: &TsModel) -> impl Iterator<Item = Self> {
        spread(model.range.v_x, SPEEDS).map(|v_x| Self::new(model, [v_x, 0.0, 0.0]))
    }

    /// A coarser one, its corners included: lowest and highest speed and that of the mean 1/v_x.
    pub fn coarse_grid(model: &TsModel) -> Vec<Self> {
        let Interval { min, max } = model.range.v_x;
        Self::at_speeds(model, [min, 2.0 / (1.0 / min + 1.0 / max), max].into_iter())
    }

    /// The vertices of the rules' premise, each with both ends of v_y.
    pub fn vertices(model: &TsModel) -> Vec<Self> {
        let ends = |interval: Interval| [interval.min, interval.max];
        let speeds = ends(model.range.v_x).into_iter();
        let of_speed = |v_x| ends(model.range.r).map(|r| [v_x, r]);
        let premises = speeds.flat_map(of_speed);
        let of_premise =
            |[v_x, r]: [f64; 2]| ends(model.range.v_y).map(|v_y| Self::new(model, [v_x, v_y, r]));
        premises.flat_map(of_premise).collect()
    }

    fn at_speeds(model: &TsModel, speeds: impl Iterator<Item = f64>) -> Vec<Self> {
        let mut points = Vec::new();
        for v_x in speeds {
            for r in spread(model.range.r, YAW_RATES) {
                for v_y in spread(model.range.v_y, LATERAL_SPEEDS) {
                    points.push(Self::new(model, [v_x, v_y, r]));
                }
            }
        }
        points
    }
}

/// The unit of e_2 that balances what is sent `to` it and `from` it: a power of two.
pub(crate) fn balance(to: f64, from: f64) -> f64 {
    let s = (to / from).sqrt();
    if s.is_normal() { s.log2().round().exp2() } else { 1.0 }
}

/// Evenly spread values, ends included.
fn spread(interval: Interval, count: u32) -> impl Iterator<Item = f64> {
    let step = (interval.max - interval.min) / f64::from(count - 1);
    (0..count).map(
        move |k| if k + 1 == count { interval.max } else { interval.min + step * f64::from(k) },
    )
}

/// Column of an input, and of its feedthrough.
pub(crate) type Column = (Vector3<Complex<f64>>, Vector2<Complex<f64>>);

/// The error dynamics of an observer at an operating point.
#[derive(Clone, Copy, Debug)]
pub struct FrozenError {
    /// `N(h) + M G rho [0 1 0]`.
    pub n: Matrix3<f64>,
    /// M.
    pub m: Matrix3<f64>,
    /// `-L(h) + M G rho E - M K`, to be multiplied by D_y.
    pub from_noise: Matrix3x2<f64>,
    /// `W_r C`.
    pub output: Matrix2x3<f64>,
    /// `W_r (I + C E)`, to be multiplied by D_y.
    pub feedthrough: Matrix2<f64>,
}

impl FrozenError {
    /// The error dynamics of `gains` at `point`, with the diagonal `weights` of W_r.
    pub fn new(point: &OperatingPoint, gains: &Gains, weights: [f64; 2]) -> Self {
        let (m, e, c) = (fixed(&gains.m), fixed(&gains.e), fixed(&C));
        let mut n = m * point.g_rho;
        let mut l = Matrix3x2::zeros();
        for (h, (n_i, l_i)) in point.membership.iter().zip(gains.n.iter().zip(&gains.l)) {
            n += fixed(n_i) * *h;
            l += fixed(l_i) * *h;
        }
        let w_r = Matrix2::from_diagonal(&Vector2::from(weights));
        Self {
            n,
            m,
            from_noise: m * point.g_rho * e - l - m * point.k,
            output: w_r * c,
            feedthrough: w_r * (Matrix2::identity() + c * e),
        }
    }

    /// The same with e_2 in units in which what N sends to it is as large as what N sends back, powers
    /// of two that round nothing: norms then say what the dynamics do, not what they are measured in.
    pub(crate) fn balanced(&self) -> Self {
        let n = &self.n;
        let s = balance(n[(1, 0)].abs().max(n[(1, 2)].abs()), n[(0, 1)].abs().max(n[(2, 1)].abs()));
        let mut scaled = *self;
        for k in 0..3 {
            scaled.n[(1, k)] /= s;
            scaled.m[(1, k)] /= s;
        }
        for k in 0..3 {
            scaled.n[(k, 1)] *= s;
        }
        scaled.from_noise.row_mut(1).unscale_mut(s);
        scaled.output.column_mut(1).scale_mut(s);
        scaled
    }

    /// Every input of `channel`.
    pub(crate) fn columns(&self, channel: &Channel) -> Vec<Column> {
        let complex =
            |b: Vector3<f64>, d: Vector2<f64>| (b.map(Complex::from), d.map(Complex::from));
        let direct = channel
            .direction
            .column_iter()
            .map(|d| complex(self.m * Vector3::from_iterator(d.iter().copied()), Vector2::zeros()));
        let noise = channel.noise.column_iter().map(|d_y| {
            let d_y = Vector2::from_iterator(d_y.iter().copied());
            complex(self.from_noise * d_y, self.feedthrough * d_y)
        });
        direct.chain(noise).collect()
    }

    /// Magnitudes of the poles, the largest first; none where they were not found.
    pub fn pole_magnitudes(&self) -> Option<[f64; 3]> {
        let mut magnitudes = <[f64; 3]>::from(eigenvalues(&self.n)?.map(|z| z.norm()));
        magnitudes.sort_by(|a, b| b.total_cmp(a));
        Some(magnitudes)
    }

    /// `(z I - N)^-1` at `z = exp(jw)`; none where z is an eigenvalue.
    pub fn resolvent(&self, w: f64) -> Option<Matrix3<Complex<f64>>> {
        let z = Complex::from_polar(1.0, w);
        (Matrix3::from_diagonal_element(z) - self.n.map(Complex::from)).try_inverse()
    }
}

/// Singular values of a transfer matrix with two outputs, `[largest, smallest]`, the smallest of a
/// single column being its norm.
pub(crate) fn extreme_gains(columns: impl Iterator<Item = Vector2<Complex<f64>>>) -> [f64; 2] {
    let (mut a, mut d, mut b, mut count) = (0.0, 0.0, Complex::new(0.0, 0.0), 0);
    for g in columns {
        a += g[0].norm_sqr();
        d += g[1].norm_sqr();
        b += g[0] * g[1].conj();
        count += 1;
    }
    let (mean, half) = ((a + d) / 2.0, (a - d) / 2.0);
    let radius = half.hypot(b.norm());
    let largest = (mean + radius).sqrt();
    match count {
        0 => [0.0, 0.0],
        1 => [(a + d).sqrt(); 2],
        // The product of both is the determinant.
        _ => [largest, ((a * d - b.norm_sqr()).max(0.0)).sqrt() / largest.max(f64::MIN_POSITIVE)],
    }
}

/// Largest magnitude of an eigenvalue; infinite where none were found.
pub fn spectral_radius(x: &Matrix3<f64>) -> f64 {
    eigenvalues(x).map_or(f64::INFINITY, |z| z.iter().map(|z| z.norm()).fold(0.0, f64::max))
}

/// Eigenvalues; none of what is not finite, or where the QR iterations do not end.
pub(crate) fn eigenvalues(x: &Matrix3<f64>) -> Option<Vector3<Complex<f64>>> {
    let finite = x.iter().all(|x| x.is_finite());
    let schur = finite.then(|| Schur::try_new(*x, f64::EPSILON, QR_ITERATIONS)).flatten()?;
    Some(schur.complex_eigenvalues())
}

/// A 3 x 3 matrix, its size known.
pub(crate) fn square(x: &Matrix) -> Matrix3<f64> {
    Matrix3::from_iterator(x.iter().copied())
}

/// A matrix of rows, its size known.
pub(crate) fn fixed<const R: usize, const K: usize>(rows: &[[f64; K]; R]) -> SMatrix<f64, R, K> {
    SMatrix::from_fn(|row, column| rows[row][column])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eigenvalues_end_whatever_the_matrix() {
        let rotation = Matrix3::new(0.0, -2.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0, 1.0);
        assert!((spectral_radius(&rotation) - 2.0).abs() < 1e-12);
        for x in [f64::NAN, f64::INFINITY] {
            assert_eq!(spectral_radius(&Matrix3::from_element(x)), f64::INFINITY);
        }
    }
}
