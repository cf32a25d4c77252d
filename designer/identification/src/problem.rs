//! Output error as a least-squares problem: what the sensors show less what they would show of the
//! model, in standard deviations, each sample with a weight.

use levenberg_marquardt::LeastSquaresProblem;
use nalgebra::storage::Owned;
use nalgebra::{DMatrix, DVector, Dyn};

use crate::course::{Course, smooth, window};
use crate::model::{Chassis, Shown, shown};
use crate::parameter::{Parameter, Parameter::*, Values};

/// Standard deviations of what the model leaves over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Deviations {
    /// rad/s.
    pub(crate) yaw_rate: f64,
    /// m/s^2.
    pub(crate) lateral_acceleration: f64,
}

/// A row of the problem.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Row {
    /// Time in the drive, s: of pieces one after the other.
    pub(crate) time_s: f64,
    /// Whether it is of the lateral acceleration.
    pub(crate) lateral: bool,
    /// What it counts for, of 1.
    pub(crate) share: f64,
}

/// The problem of `free` parameters of `values` on `courses`.
#[derive(Clone)]
pub(crate) struct Problem<'a> {
    pub(crate) chassis: &'a Chassis,
    pub(crate) courses: &'a [Course],
    pub(crate) free: &'a [Parameter],
    pub(crate) values: Values,
    pub(crate) deviations: Deviations,
    /// Of each row, at most 1; empty for ones.
    pub(crate) weights: Vec<f64>,
    /// Every so many samples is compared.
    pub(crate) stride: usize,
}

/// Of the smoothed lateral acceleration, every so many of the compared samples is a row.
const LATERAL_STRIDE: usize = 10;

impl Problem<'_> {
    /// What is left over in every row, in standard deviations, with any values.
    pub(crate) fn left_over(&self, values: &Values) -> Vec<f64> {
        let mut rows = Vec::new();
        for course in self.courses {
            let shown = shown(self.chassis, values, course);
            let lateral = shown_laterally(&shown, values, course);
            for (k, is_lateral) in self.compared(course) {
                rows.push(if is_lateral {
                    let left = course.lateral_acceleration[k] - lateral[k];
                    left / self.deviations.lateral_acceleration
                } else {
                    (course.yaw_rate[k] - shown[k].yaw_rate) / self.deviations.yaw_rate
                });
            }
        }
        rows
    }

    /// Samples of `course` that are rows, and whether of the lateral acceleration.
    fn compared(&self, course: &Course) -> impl Iterator<Item = (usize, bool)> {
        let lateral = !course.lateral_acceleration.is_empty();
        let all = (0..course.len()).step_by(self.stride).enumerate();
        all.filter(|&(_, k)| course.compared[k]).flat_map(move |(n, k)| {
            let lateral = (lateral && n % LATERAL_STRIDE == 0).then_some((k, true));
            [Some((k, false)), lateral].into_iter().flatten()
        })
    }

    /// What the rows are.
    pub(crate) fn rows(&self) -> Vec<Row> {
        let mut rows = Vec::new();
        let mut start_s = 0.0;
        for course in self.courses {
            rows.extend(self.compared(course).map(|(k, lateral)| {
                // Smoothed rows say one thing several times.
                let smoothed = window(course.period_s) / (self.stride * LATERAL_STRIDE).max(1);
                let share = if lateral { 1.0 / smoothed.max(1) as f64 } else { 1.0 };
                Row { time_s: start_s + k as f64 * course.period_s, lateral, share }
            }));
            start_s += course.len() as f64 * course.period_s;
        }
        rows
    }

    fn weighted(&self, mut rows: Vec<f64>) -> DVector<f64> {
        for (row, weight) in rows.iter_mut().zip(&self.weights) {
            *row *= weight.sqrt();
        }
        DVector::from_vec(rows)
    }
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Problem<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, x: &DVector<f64>) {
        for (&parameter, &value) in self.free.iter().zip(x.iter()) {
            self.values[parameter] = value;
        }
    }

    fn params(&self) -> DVector<f64> {
        DVector::from_iterator(self.free.len(), self.free.iter().map(|&free| self.values[free]))
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        let rows = self.weighted(self.left_over(&self.values));
        // None ends the search: the step went where the model has no answer.
        rows.iter().all(|row| row.is_finite()).then_some(rows)
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let columns = self.free.iter().map(|&parameter| {
            let step = parameter.step();
            let moved = |by: f64| {
                let mut values = self.values;
                values[parameter] += by;
                self.weighted(self.left_over(&values))
            };
            (moved(step) - moved(-step)) / (2.0 * step)
        });
        Some(DMatrix::from_columns(&columns.collect::<Vec<_>>()))
    }
}

/// The lateral acceleration that the sensor would show of `shown`, smoothed as the measured one is; empty
/// where it is not logged.
fn shown_laterally(shown: &[Shown], values: &Values, course: &Course) -> Vec<f64> {
    if course.lateral_acceleration.is_empty() {
        return Vec::new();
    }
    let scale = 1.0 + values[LateralScale];
    let there: Vec<f64> = shown
        .iter()
        .map(|shown| scale * shown.lateral_acceleration + values[LateralBias])
        .collect();
    let (smoothed, slope) = smooth(&there, course.period_s);
    // Delays are a few samples at most, over which a smoothed signal is a straight line.
    smoothed.iter().zip(&slope).map(|(value, slope)| value - values[LateralDelay] * slope).collect()
}
