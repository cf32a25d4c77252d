//! Gains refined by a quasi-Newton method.
//!
//! BFGS with a bisection for the weak Wolfe conditions: the extremes over points and frequencies leave
//! kinks in the cost, which this pair passes (Lewis and Overton, Nonsmooth optimization via
//! quasi-Newton methods, Mathematical Programming 141, 2013).

use nalgebra::SMatrix;
use steerguard_detector::{C, Gains, RULES};

use crate::lmi::matrix::{Matrix, matrix};
use crate::search::cost::{COORDINATES, Coordinates, Cost};
use crate::search::objective::Objective;
use crate::synthesis::gains::ObserverGains;
use crate::synthesis::theorem4::Theorem4;

/// Exponents of the sums of powers that stand for minima and maxima, one refinement after the other.
const EXPONENTS: [f64; 3] = [12.0, 30.0, 80.0];
/// Quasi-Newton steps of each, until nothing is gained.
pub(super) const STEPS: usize = 300;
/// Bisections of a line search.
const BISECTIONS: usize = 25;
/// Decrease asked of a step, in units of what the slope promises.
const DECREASE: f64 = 1e-4;
/// Share of the slope that may be left after a step.
const CURVATURE: f64 = 0.5;
/// Length of the first step.
const FIRST_STEP: f64 = 1e-3;
/// A step that lowers the cost by less is the last.
const CONVERGED: f64 = 1e-9;

/// Gains near `start` with the smallest cost found by `steps` for each exponent, modes and products to
/// decay by `slowest`.
pub(super) fn refine(
    objective: &Objective<'_>,
    start: &ObserverGains,
    theorem: &Theorem4,
    slowest: f64,
    steps: usize,
) -> ObserverGains {
    let mut best = coordinates(&objective.to_scale(start, theorem).gains);
    for exponent in EXPONENTS {
        best = minimise(&Cost { objective, exponent, slowest }, best, steps);
    }
    objective.to_scale(&gains_at(&best, theorem), theorem)
}

/// A minimum of `cost` near `x`, or the best that was seen.
fn minimise(cost: &Cost<'_>, mut x: Coordinates, steps: usize) -> Coordinates {
    let (mut value, mut slope) = cost.at(&x);
    // The inverse of the second derivatives, so far.
    let mut inverse: Option<SMatrix<f64, COORDINATES, COORDINATES>> = None;
    for _ in 0..steps {
        let direction = match &inverse {
            Some(inverse) => -(inverse * slope),
            None => -slope * (FIRST_STEP / slope.norm()),
        };
        let Some((step, next_value, next_slope)) = line_search(cost, &x, value, &slope, direction)
        else {
            break;
        };
        let (bend, gained) = (next_slope - slope, value - next_value);
        (x, value, slope) = (x + step, next_value, next_slope);
        let curvature = step.dot(&bend);
        if curvature > 0.0 {
            let old = inverse
                .unwrap_or_else(|| SMatrix::from_diagonal_element(curvature / bend.norm_squared()));
            let across = old * bend;
            let along = (1.0 + bend.dot(&across) / curvature) / curvature;
            let mixed = (across * step.transpose() + step * across.transpose()) / curvature;
            inverse = Some(old + step * step.transpose() * along - mixed);
        }
        if gained < CONVERGED {
            break;
        }
    }
    x
}

/// A step along `direction` that meets the weak Wolfe conditions, with cost and slope at its end; none
/// where no step lowers the cost.
fn line_search(
    cost: &Cost<'_>,
    x: &Coordinates,
    value: f64,
    slope: &Coordinates,
    direction: Coordinates,
) -> Option<(Coordinates, f64, Coordinates)> {
    let promised = slope.dot(&direction);
    if promised >= 0.0 || !promised.is_finite() {
        return None;
    }
    let (mut too_short, mut too_long) = (0.0, f64::INFINITY);
    let mut length = 1.0;
    let mut lower = None;
    for _ in 0..BISECTIONS {
        let step = direction * length;
        let (next_value, next_slope) = cost.at(&(x + step));
        let ends = next_value.is_finite() && next_slope.iter().all(|x| x.is_finite());
        if !ends || next_value > value + DECREASE * length * promised {
            too_long = length;
        } else {
            lower = Some((step, next_value, next_slope));
            if next_slope.dot(&direction) >= CURVATURE * promised {
                break;
            }
            too_short = length;
        }
        length = if too_long.is_finite() { (too_short + too_long) / 2.0 } else { 2.0 * too_short };
    }
    lower
}

/// Coordinates of gains, see [`crate::search::cost`].
pub(super) fn coordinates(gains: &Gains) -> Coordinates {
    let e = gains.e.iter().flatten().copied();
    let n = gains.n.iter().flat_map(|n| n.iter().flat_map(|row| [row[0], row[2]]));
    Coordinates::from_iterator(e.chain(n))
}

/// The gains with the given coordinates.
pub(super) fn gains_at(x: &Coordinates, theorem: &Theorem4) -> ObserverGains {
    let (of_e, of_n) = x.as_slice().split_at(6);
    let e = Matrix::from_row_slice(3, 2, of_e);
    let c = matrix(&C);
    let m = Matrix::identity(3, 3) + &e * &c; // (11)
    let h: [Matrix; RULES] = std::array::from_fn(|i| {
        let of_rule = Matrix::from_row_slice(3, 2, &of_n[6 * i..6 * i + 6]);
        (&m * &theorem.a[i]) * c.transpose() - of_rule // (35)
    });
    ObserverGains::new(&e, &h, &theorem.a)
}
