//! Designs that several tests need, each made once for all tests of a run.

#![allow(dead_code, reason = "not every test needs both")]

use std::fs;

use steerguard_designer::spec::{Calibration, Manoeuvre};
use steerguard_designer::{Design, DesignError, Spec, design};
use steerguard_test_support::once::made_once;

/// The design of `spec`.
pub fn designed(spec: &Spec) -> Result<Design, DesignError> {
    let key = format!("the design alone of {}", toml::to_string(spec).unwrap());
    let folder = made_once(&key, &[], |folder| -> Result<(), DesignError> {
        let text = design(spec, &mut |_| {})?.to_json().unwrap();
        fs::write(folder.join("design.json"), text).unwrap();
        Ok(())
    })?;
    Ok(Design::from_json(&fs::read_to_string(folder.join("design.json")).unwrap()).unwrap())
}

/// A design of `spec` in little time: with few drives in the calibration and none searched.
pub fn designed_with_few_drives(mut spec: Spec) -> Result<Design, DesignError> {
    spec.evaluation.calibration = Calibration {
        speeds: 1,
        manoeuvres: vec![Manoeuvre::Sine],
        lateral_acceleration_m_per_s2: vec![1.0],
        disturbance_frequencies: 1,
        disturbance_phases: 1,
        initial_v_y_m_per_s: Some(vec![0.0]),
        duration_s: 4.0,
        search_drives: 0,
        ..Calibration::default()
    };
    designed(&spec)
}
