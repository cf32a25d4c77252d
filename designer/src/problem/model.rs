//! The matrices of the model.

use steerguard_detector::{Deviations, TsModel};

use crate::lmi::matrix::Matrix;
use crate::spec::Spec;

/// The N-TS model.
pub fn model(spec: &Spec) -> TsModel {
    TsModel {
        vehicle: spec.vehicle,
        sampling_period_s: spec.sampling.period_s,
        range: spec.operating_range.range(),
    }
}

/// What the detector is told of deviations from the model.
pub fn deviations(spec: &Spec) -> Deviations {
    let column = spec.fault[0].column();
    Deviations {
        euler_correction: spec.sampling.euler_correction,
        uncertainty: spec.uncertainty.bounds(),
        smallest_fault: model(spec).b().map(|row| row[column] * spec.fault[0].smallest()),
    }
}

/// D, 3 x n_d: a column of each disturbance, per unit.
pub fn d(spec: &Spec) -> Matrix {
    let t = spec.sampling.period_s;
    Matrix::from_fn(3, spec.disturbance.len(), |row, column| {
        t * spec.disturbance[column].direction(&spec.vehicle)[row]
    })
}

/// F, 3 x n_f: a column of each fault, per rad or N m.
pub fn f(spec: &Spec) -> Matrix {
    let b = model(spec).b();
    Matrix::from_fn(3, spec.fault.len(), |row, column| b[row][spec.fault[column].column()])
}
