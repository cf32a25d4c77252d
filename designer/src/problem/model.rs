//! The matrices of the model.

use steerguard_detector::{Deviations, Estimator, Staleness, TsModel};

use crate::lmi::matrix::Matrix;
use crate::spec::{Spec, ThresholdKind};

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

/// Longest time in s for which sensors with noise show the same.
const STALE_AFTER_S: f64 = 0.2;
/// Faster than any vehicle accelerates along the road, m/s^2, and in yaw, rad/s^2.
const LARGEST_ACCELERATION_M_PER_S2: f64 = 20.0;
const LARGEST_YAW_ACCELERATION_RAD_PER_S2: f64 = 20.0;
/// Standard deviations of the noise of a difference of two readings that are no jump: 6 sqrt 2.
const NOISE_OF_A_STEP: f64 = 8.5;

/// When the detector takes measurements for stale: never where the sensors have no noise, since a
/// simulation without noise may stand still.
pub fn staleness(spec: &Spec) -> Staleness {
    let period_s = spec.sampling.period_s;
    let [v_x_std, r_std] = spec.noise.white_std();
    let noisy = v_x_std > 0.0 || r_std > 0.0;
    Staleness {
        after_s: if noisy { STALE_AFTER_S.max(2.0 * period_s) } else { 0.0 },
        v_x_jump_m_per_s: LARGEST_ACCELERATION_M_PER_S2 * period_s + NOISE_OF_A_STEP * v_x_std,
        r_jump_rad_per_s: LARGEST_YAW_ACCELERATION_RAD_PER_S2 * period_s + NOISE_OF_A_STEP * r_std,
    }
}

/// Noise that the second test assumes where less is stated, m/s and rad/s: what the discretisation leaves.
const LEAST_NOISE: [f64; 2] = [0.002, 0.0002];

/// The second test with its threshold and the factor of its estimate's bound; none where `spec` asks for none,
/// or for a kind of threshold that is told no uncertainty.
pub fn estimator(spec: &Spec, threshold: f64, estimate_factor: f64) -> Option<Estimator> {
    let asked = spec.estimator.enabled && spec.evaluation.threshold == ThresholdKind::Adaptive;
    let [v_x_std, r_std] = spec.noise.white_std();
    let noise = [v_x_std.max(LEAST_NOISE[0]), r_std.max(LEAST_NOISE[1])];
    asked.then_some(Estimator { threshold, estimate_factor, noise })
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
