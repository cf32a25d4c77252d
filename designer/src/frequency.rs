//! Frozen analysis: gains of the error dynamics at constant operating points.
//!
//! At constant v_x, v_y and r the residual is `G(z) input` with
//! `G(z) = C (z I - N(h) - M G rho)^-1 M B` and rho = 2 v_y.
//!
//! # Conventions
//! - Operating points and frequencies form a grid; a figure is the worst of the grid.
//! - Between grid frequencies `||G(z) - G(z_0)|| <= d ||C R|| ||R M B|| / (1 - d ||R||)`, with
//!   `R = (z_0 I - N)^-1` and d the largest distance of z from a grid point z_0: the figures
//!   `at_least` and `at_most` include it and hold for the whole band.

use nalgebra::{Complex, Matrix3, SMatrix};
use serde::{Deserialize, Serialize};
use steerguard_detector::{C, Interval, TsModel};

use crate::gains::ObserverGains;
use crate::lmi::Matrix;
use crate::theorem4::Channel;

/// Frequencies across a band.
const FREQUENCIES: u32 = 1000;
/// Speeds, and values of r and v_y, across the operating range.
const SPEEDS: u32 = 6;
const YAW_RATES: u32 = 3;
const LATERAL_SPEEDS: u32 = 3;

/// What the frozen error dynamics do to fault and disturbance, the worst over the operating points.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Frozen {
    /// Smallest gain from the fault over its band, per rad or N m.
    pub beta: f64,
    /// What lies between grid frequencies included.
    pub beta_at_least: f64,
    /// Largest gain from the disturbances over their band, per unit of the first, 2-norm of the
    /// stacked vector.
    pub gamma: f64,
    /// What lies between grid frequencies included.
    pub gamma_at_most: f64,
}

/// Evaluates the frozen error dynamics over the operating range.
pub fn frozen(
    model: &TsModel,
    gains: &ObserverGains,
    disturbance: &Channel,
    fault: &Channel,
) -> Frozen {
    let m = fixed::<3, 3>(&gains.gains.m);
    let mut result = Frozen {
        beta: f64::INFINITY,
        beta_at_least: f64::INFINITY,
        gamma: 0.0,
        gamma_at_most: 0.0,
    };
    for v_x in grid(model.range.v_x, SPEEDS) {
        for r in grid(model.range.r, YAW_RATES) {
            for v_y in grid(model.range.v_y, LATERAL_SPEEDS) {
                let n = error_matrix(model, gains, [v_x, v_y, r]);
                let from_fault = gain(&n, &m, fault);
                let from_disturbance = gain(&n, &m, disturbance);
                result.beta = result.beta.min(from_fault.smallest);
                result.beta_at_least = result.beta_at_least.min(from_fault.at_least);
                result.gamma = result.gamma.max(from_disturbance.largest);
                result.gamma_at_most = result.gamma_at_most.max(from_disturbance.at_most);
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

/// Extremes of a gain over a band: on the grid, and with what lies between.
struct Gain {
    smallest: f64,
    largest: f64,
    at_least: f64,
    at_most: f64,
}

/// The gain of `C (z I - N)^-1 M B` over a band.
fn gain(n: &Matrix3<f64>, m: &Matrix3<f64>, input: &Channel) -> Gain {
    let [from, to] = input.band.limits();
    let step = (to - from) / f64::from(FREQUENCIES);
    // A chord is shorter than its arc.
    let distance = step / 2.0;
    let c: SMatrix<Complex<f64>, 2, 3> = fixed(&C).map(Complex::from);
    let m_b =
        (Matrix::from_iterator(3, 3, m.iter().copied()) * &input.direction).map(Complex::from);

    let unknown =
        Gain { smallest: 0.0, largest: f64::INFINITY, at_least: 0.0, at_most: f64::INFINITY };
    let mut gain =
        Gain { smallest: f64::INFINITY, largest: 0.0, at_least: f64::INFINITY, at_most: 0.0 };
    for point in 0..=FREQUENCIES {
        let z = Complex::from_polar(1.0, from + step * f64::from(point));
        let zi_n = Matrix3::from_diagonal_element(z) - n.map(Complex::from);
        let Some(resolvent) = zi_n.try_inverse() else {
            return unknown;
        };
        let c_r = c * resolvent;
        let r_b = resolvent * &m_b;
        let near = distance * resolvent.norm();
        let between = if near < 1.0 {
            distance * c_r.norm() * r_b.norm() / (1.0 - near)
        } else {
            f64::INFINITY
        };
        let g = (c_r * &m_b).singular_values();
        gain.smallest = gain.smallest.min(g.min());
        gain.largest = gain.largest.max(g.max());
        gain.at_least = gain.at_least.min((g.min() - between).max(0.0));
        gain.at_most = gain.at_most.max(g.max() + between);
    }
    gain
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
