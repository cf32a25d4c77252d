//! Designs in little time: few drives in the calibration.

use steerguard_designer::spec::{Calibration, Manoeuvre};
use steerguard_designer::{Design, DesignError, Spec, design};

/// A design of `spec` with few drives in the calibration.
pub fn designed_with_few_drives(mut spec: Spec) -> Result<Design, DesignError> {
    spec.evaluation.calibration = Calibration {
        speeds: 1,
        manoeuvres: vec![Manoeuvre::Sine],
        lateral_acceleration_m_per_s2: vec![1.0],
        disturbance_frequencies: 1,
        disturbance_phases: 1,
        initial_v_y_m_per_s: vec![0.0],
        duration_s: 2.0,
        ..Calibration::default()
    };
    design(&spec, &mut |_| {})
}
