//! Frozen analysis: gains of the error dynamics at constant operating points.
//!
//! At constant v_x, v_y and r the residual is `G(z) input` with
//! `G(z) = C (z I - N(h) - M G rho)^-1 M B` and rho = 2 v_y.
//!
//! # Conventions
//! Each figure holds for the whole band, not only on the grid: it includes the bound
//! `||G(z) - G(z_0)|| <= d ||C R|| ||R M B|| / (1 - d ||R||)`, with `R = (z_0 I - N)^-1` and d the
//! largest distance of z from a grid point z_0. The operating points are a grid.

use nalgebra::{Complex, Matrix3, SMatrix};
use serde::{Deserialize, Serialize};
use steerguard_detector::{C, Interval, TsModel};

use crate::gains::ObserverGains;
use crate::lmi::Matrix;
use crate::theorem4::Channel;

/// Frequencies across a band.
const FREQUENCIES: u32 = 500;
/// Speeds, and values of r and v_y, across the operating range.
const SPEEDS: u32 = 6;
const YAW_RATES: u32 = 3;
const LATERAL_SPEEDS: u32 = 3;

/// What the frozen error dynamics do to fault and disturbance, the worst over the operating points.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Frozen {
    /// Smallest gain from the fault over its band, per rad or N m.
    pub beta: f64,
    /// Largest gain from the disturbances over their band, per unit of the first, 2-norm of the
    /// stacked vector.
    pub gamma: f64,
}

/// Evaluates the frozen error dynamics over the operating range.
pub fn frozen(
    model: &TsModel,
    gains: &ObserverGains,
    disturbance: &Channel,
    fault: &Channel,
) -> Frozen {
    let m = fixed::<3, 3>(&gains.gains.m);
    let mut result = Frozen { beta: f64::INFINITY, gamma: 0.0 };
    for v_x in grid(model.range.v_x, SPEEDS) {
        for r in grid(model.range.r, YAW_RATES) {
            for v_y in grid(model.range.v_y, LATERAL_SPEEDS) {
                let n = error_matrix(model, gains, [v_x, v_y, r]);
                let [_, gamma] = extreme_gains(&n, &m, disturbance);
                let [beta, _] = extreme_gains(&n, &m, fault);
                result.beta = result.beta.min(beta);
                result.gamma = result.gamma.max(gamma);
            }
        }
    }
    result
}

/// `N(h) + M G rho` at `[v_x, v_y, r]`, where rho = 2 v_y.
fn error_matrix(model: &TsModel, gains: &ObserverGains, [v_x, v_y, r]: [f64; 3]) -> Matrix3<f64> {
    let membership = model.membership([v_x, r]);
    let rules = membership.iter().zip(&gains.gains.n);
    let n = rules.fold(Matrix3::zeros(), |sum, (&h, n)| sum + fixed::<3, 3>(n) * h);
    let m_g = fixed::<3, 3>(&gains.gains.m)
        * Matrix3::from_fn(|row, column| if column == 1 { model.g_phi()[row] } else { 0.0 });
    n + m_g * (2.0 * v_y)
}

/// Smallest and largest gain of `C (z I - N)^-1 M B` over a band.
fn extreme_gains(n: &Matrix3<f64>, m: &Matrix3<f64>, input: &Channel) -> [f64; 2] {
    let [from, to] = input.band.limits();
    let step = (to - from) / f64::from(FREQUENCIES);
    // A chord is shorter than its arc.
    let distance = step / 2.0;
    let c: SMatrix<Complex<f64>, 2, 3> = fixed::<2, 3>(&C).map(Complex::from);
    let m_b =
        (Matrix::from_iterator(3, 3, m.iter().copied()) * &input.direction).map(Complex::from);

    let (mut smallest, mut largest) = (f64::INFINITY, 0.0_f64);
    for point in 0..=FREQUENCIES {
        let z = Complex::from_polar(1.0, from + step * f64::from(point));
        let zi_n = Matrix3::from_diagonal_element(z) - n.map(Complex::from);
        let Some(resolvent) = zi_n.try_inverse() else {
            return [0.0, f64::INFINITY];
        };
        let c_r = c * resolvent;
        let g = c_r * &m_b;
        let r_b = resolvent * &m_b;
        let r_norm = distance * resolvent.norm();
        if r_norm >= 1.0 {
            return [0.0, f64::INFINITY];
        }
        let between = distance * c_r.norm() * r_b.norm() / (1.0 - r_norm);
        let gains = g.singular_values();
        smallest = smallest.min(gains.min() - between);
        largest = largest.max(gains.max() + between);
    }
    [smallest.max(0.0), largest]
}

/// Evenly spread values, ends included.
fn grid(interval: Interval, count: u32) -> impl Iterator<Item = f64> {
    let step = (interval.max - interval.min) / f64::from(count - 1);
    (0..count).map(
        move |k| if k + 1 == count { interval.max } else { interval.min + step * f64::from(k) },
    )
}

/// A matrix of rows, its size known.
fn fixed<const R: usize, const K: usize>(rows: &[[f64; K]; R]) -> SMatrix<f64, R, K> {
    SMatrix::from_fn(|row, column| rows[row][column])
}
