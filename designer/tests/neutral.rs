//! A neutral-steer car: its design sees, and says what a fault does to the estimate.

#![allow(clippy::unwrap_used)]

#[path = "common/designed.rs"]
mod designed;

use steerguard_designer::problem::inputs::Inputs;
use steerguard_designer::spec::Method;
use steerguard_designer::{DesignStatus, Spec};
use steerguard_test_support::cases::ReferenceCase;

use designed::designed_with_few_drives;

#[test]
fn a_neutral_car_has_a_certified_design_that_sees() {
    let reference = ReferenceCase::read("neutral");
    let spec = Spec::from_toml(&reference.spec).unwrap();
    let design = designed_with_few_drives(spec.clone()).unwrap();
    assert_eq!(design.synthesis.status, DesignStatus::Certified);
    let performance = &design.performance;
    reference.check("detection_ratio_of_neutral_car", performance.detection_ratio);
    let certified = performance.certified.unwrap();
    let inputs = Inputs::of(&spec).unwrap();
    let background = (certified.gamma * inputs.bound).hypot(performance.noise_rms);
    let ratio = certified.beta * inputs.smallest_fault / background;
    reference.check("certified_ratio_of_neutral_car", ratio);

    // No rate was stated: one was found, and is reported.
    assert_eq!(certified.decay, performance.decay);
    assert!(Method::default().decays(0.01).contains(&performance.decay));

    // The fault leaves the estimate where it is, up to the size that is said.
    let estimate = performance.estimate.unwrap();
    assert!((estimate.cap_m_per_s_per_deg - 0.3).abs() < 1e-12, "{estimate:?}");
    assert!(estimate.peak_m_per_s_per_deg <= estimate.cap_m_per_s_per_deg, "{estimate:?}");
    let leaves = 1.5 / estimate.peak_m_per_s_per_deg;
    assert!((estimate.leaves_range_from_deg - leaves).abs() < 1e-9, "{estimate:?}");
}
