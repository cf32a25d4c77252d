//! What a fault does to the estimated lateral speed: the error's second component, e_2 = v_y - v_y^.
//!
//! At a frozen operating point a fault f that begins and stays, a step, makes
//! `e_2(k) = f [0 1 0] sum_(j<k) N^j M F`. The residual does not hold e_2 where yaw rate hardly depends
//! on v_y, as on a neutral-steer car: gains with a large detection ratio may then send v_y^ out of S_x
//! within a few samples of the very fault that is to be reported (method 5, "The estimate").
//!
//! # Conventions
//! - Peaks are over all time and, of several operating points, the largest.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use steerguard_detector::{Gains, TsModel};

use crate::analysis::operating_point::{FrozenError, OperatingPoint};
use crate::problem::channel::Channel;

/// Longest response considered, samples.
const LONGEST: u32 = 4000;
/// A step of the error below this share of the largest so far ends a response.
const SETTLED: f64 = 1e-12;

/// What the fault does to the estimate, per degree of steering.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EstimateFigures {
    /// Largest |e_2| that a step of one degree makes, at the worst operating point.
    pub peak_m_per_s_per_deg: f64,
    /// What the search held it below.
    pub cap_m_per_s_per_deg: f64,
    /// Smallest step from which e_2 alone is as large as the range of v_y to its nearer end.
    pub leaves_range_from_deg: f64,
}

impl EstimateFigures {
    /// The figures of `gains`, worst over the grid of operating points; `fault` is in rad.
    pub fn of(model: &TsModel, gains: &Gains, fault: &Channel, cap: f64) -> Self {
        let points = OperatingPoint::grid(model);
        // The weights are of the residual, which has no part here.
        let peaks =
            points.iter().map(|point| peak(&FrozenError::new(point, gains, [1.0; 2]), fault));
        let per_deg = 1f64.to_radians();
        let peak = peaks.fold(0.0, f64::max) * per_deg;
        let v_y = model.range.v_y;
        Self {
            peak_m_per_s_per_deg: peak,
            cap_m_per_s_per_deg: cap * per_deg,
            leaves_range_from_deg: f64::min(v_y.max, -v_y.min) / peak,
        }
    }
}

/// Largest |e_2| after a unit step of `fault`; infinite where it does not settle.
pub(crate) fn peak(error: &FrozenError, fault: &Channel) -> f64 {
    let f = Vector3::from_iterator(fault.direction.column(0).iter().copied());
    let mut step = error.m * f;
    let mut e = Vector3::zeros();
    let (mut peak, mut largest) = (0.0_f64, 0.0_f64);
    for _ in 0..LONGEST {
        e += step;
        peak = peak.max(e[1].abs());
        largest = largest.max(step.norm());
        step = error.n * step;
        if step.norm() < SETTLED * largest {
            return peak;
        }
    }
    f64::INFINITY
}
