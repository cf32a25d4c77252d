//! Certified gains: against an independent solver, the reference values, and the exact proof.

#![allow(clippy::unwrap_used)]

mod common;
#[path = "common/designed.rs"]
mod designed;

use serde::Deserialize;
use steerguard_designer::analysis::certified::{ErrorSystem, Gain, certified, certify};
use steerguard_designer::analysis::frequency::frozen;
use steerguard_designer::analysis::operating_point::OperatingPoint;
use steerguard_designer::analysis::worth::Worth;
use steerguard_designer::lmi::matrix::{Matrix, matrix};
use steerguard_designer::problem::band::Band;
use steerguard_designer::problem::channel::Channel;
use steerguard_designer::problem::inputs::Inputs;
use steerguard_designer::problem::model::model;
use steerguard_designer::spec::Disturbance;
use steerguard_designer::synthesis::gains::ObserverGains;
use steerguard_designer::synthesis::solve::{Goal, solve};
use steerguard_designer::synthesis::theorem4::Theorem4;
use steerguard_designer::{Design, DesignStatus, FrozenRecord, Spec};
use steerguard_test_support::cases::ReferenceCase;
use steerguard_verify::{Refusal, verify};

use common::papers_but;
use designed::designed_with_few_drives;

const PAPER: &str = include_str!("../../examples/paper.toml");
const THETA: f64 = std::f64::consts::TAU * 1.5 * 0.01;

fn designed(text: &str) -> Design {
    designed_with_few_drives(Spec::from_toml(text).unwrap()).unwrap()
}

/// A case of fixtures/certified_gains.json.
#[derive(Deserialize)]
struct Case {
    name: String,
    #[serde(rename = "D")]
    d: [Vec<f64>; 3],
    #[serde(rename = "E")]
    e: [[f64; 2]; 3],
    #[serde(rename = "H")]
    h: [[[f64; 2]; 3]; 4],
    beta: Value,
    gamma: Value,
    gamma_full_band: Value,
}

#[derive(Deserialize)]
struct Value {
    value: f64,
}

fn papers_theorem() -> Theorem4 {
    let spec = Spec::paper();
    Theorem4::of(&spec, &Inputs::of(&spec).unwrap(), 0.97)
}

#[test]
fn values_agree_with_an_independent_solver() {
    let cases: Vec<Case> =
        serde_json::from_str(include_str!("fixtures/certified_gains.json")).unwrap();
    let theorem = papers_theorem();
    for case in cases {
        let h = case.h.each_ref().map(matrix);
        let gains = ObserverGains::new(&matrix(&case.e), &h, &theorem.a);
        let d = Matrix::from_fn(3, case.d[0].len(), |row, column| case.d[row][column]);
        let disturbances = Channel::disturbance(d, Band::Low(THETA));
        // Either solver stops within 1e-4 of the optimum, with its own margin.
        for (input, band, gain, expected) in [
            (&theorem.fault, Band::Low(THETA), Gain::Smallest, case.beta.value),
            (&disturbances, Band::Low(THETA), Gain::Largest, case.gamma.value),
            (&disturbances, Band::Full, Gain::Largest, case.gamma_full_band.value),
        ] {
            let error = ErrorSystem::new(&theorem, &gains, input);
            let value = certify(&error, band, gain, input.norm()).unwrap().gain;
            assert!((value / expected - 1.0).abs() < 1e-3, "{}: {value}, {expected}", case.name);
        }
    }
}

#[test]
fn papers_largest_beta_is_worth_its_reference_values() {
    let spec = Spec::paper();
    let inputs = Inputs::of(&spec).unwrap();
    let theorem = papers_theorem();
    let synthesis = solve(&theorem, Goal::LargestBeta { gamma: Some(0.8) }).unwrap();
    let points = OperatingPoint::grid(&model(&spec));
    let magnitudes = frozen(&points, &synthesis.gains.gains, &inputs);
    let (figures, _) = certified(&theorem, &synthesis.gains, &magnitudes, &inputs).unwrap();
    let reference = ReferenceCase::read("largest_beta");
    reference.check("certified_beta", figures.beta);
    reference.check("certified_gamma", figures.gamma);
    // Three times what synthesis claims, a hundred times less gamma.
    assert!(figures.beta > 3.0 * synthesis.beta && figures.gamma < 0.01 * 0.8);
}

/// S1, by the best multipliers of a grid.
fn s1_by_paper() -> Design {
    let method = "design.method = \"paper\"\ndesign.alpha_d = 0.02\n\
                  design.V = [0, 15.44715447, 14.23425414]\n";
    designed_with_few_drives(papers_but(&format!("{method}{}", ReferenceCase::read("s1").spec)))
        .unwrap()
}

#[test]
fn two_disturbances_reach_the_reference_gap() {
    let design = s1_by_paper();
    let certified = design.performance.certified.unwrap();
    let reference = ReferenceCase::read("s1");
    reference.check("certified_beta_per_deg_by_grid", certified.beta * 1_f64.to_radians());
    // Of disturbances in units of their bounds.
    reference.check("certified_gamma_by_grid", certified.gamma * 0.5);
    reference.check("certified_gap_by_grid", certified.gap);
    assert_eq!(design.synthesis.status, DesignStatus::Certified);
    let verdict = verify(&design.to_json().unwrap()).unwrap();
    assert_eq!(verdict.figures.unwrap().gap, certified.gap);
    assert_eq!(verdict.hash, design.hash);
}

#[test]
fn certified_figures_lie_between_synthesis_and_frozen_ones() {
    for design in [designed(PAPER), s1_by_paper()] {
        let Design { synthesis, performance, .. } = design;
        let (certified, frozen) = (performance.certified.unwrap(), performance.frozen);
        assert!(synthesis.beta < certified.beta && certified.beta < frozen.beta);
        assert!(frozen.gamma < certified.gamma && certified.gamma < synthesis.gamma);
        assert!(synthesis.gap < certified.gap && certified.gap < frozen.gap);
        assert!(certified.gamma < certified.gamma_full_band);
    }
}

/// The paper's gains, certified for a disturbance of another band.
#[test]
fn full_and_high_bands_of_disturbances_are_proven() {
    let papers = designed(PAPER);
    let points = OperatingPoint::grid(&model(&papers.spec));
    let gains = ObserverGains {
        gains: papers.configuration().gains,
        h: papers.vertices.map(|rule| rule.h),
    };
    let theta = std::f64::consts::TAU * 0.5 * 0.01;
    for (band, band_hz) in [(Band::Full, [0.0, 50.0]), (Band::High(theta), [0.5, 50.0])] {
        let mut inputs = Inputs::of(&papers.spec).unwrap();
        inputs.disturbances[0].band = band;
        let theorem = Theorem4::of(&papers.spec, &inputs, 0.97);
        let magnitudes = frozen(&points, &gains.gains, &inputs);
        let (figures, certificate) = certified(&theorem, &gains, &magnitudes, &inputs).unwrap();
        assert!(magnitudes.gamma < figures.gamma);
        assert!(figures.gamma < figures.gamma_full_band * (1.0 + 1e-4));
        assert_eq!(certificate.gamma[0].band.is_none(), band == Band::Full);

        let mut design = papers.clone();
        design.spec.disturbance = vec![Disturbance::SideWind {
            name: "side wind".into(),
            acting_ahead_m: 0.25,
            bound_m_per_s2: 0.1,
            band_hz,
        }];
        // The other figures of that band, which are recomputed too.
        let worth = Worth::of(&gains, &theorem, &model(&papers.spec), &inputs);
        let performance = &mut design.performance;
        performance.detection_ratio = worth.detection_ratio(&inputs);
        performance.frozen = FrozenRecord::new(worth.frozen, inputs.smallest_fault, inputs.bound);
        performance.limit = worth.points.iter().filter_map(|x| x.limit).reduce(f64::min);
        performance.operating_points = worth.points;
        performance.certified = Some(figures);
        design.certificate.a_posteriori = Some(certificate);
        let proof = |design: &mut Design| {
            design.hash = design.computed_hash().unwrap();
            verify(&design.to_json().unwrap())
        };
        proof(&mut design).unwrap();
        // Of a high band, 2 cos(theta) must not be too small.
        let mut wider = design.clone();
        if let Some(a_posteriori) = &mut wider.certificate.a_posteriori
            && let Some(band) = &mut a_posteriori.gamma[0].band
        {
            band.two_cos_theta -= 1e-12;
            assert!(matches!(proof(&mut wider), Err(Refusal::Cosine { .. })));
        }
    }
}

#[test]
fn another_vehicle_range_and_period_is_proven() {
    let design = designed(
        r#"
        [vehicle]
        mass_kg = 2100
        yaw_inertia_kg_m2 = 3900
        effective_longitudinal_inertia_kg_m = 700
        front_axle_distance_m = 1.5
        rear_axle_distance_m = 1.7
        front_cornering_stiffness_n_per_rad = 75000
        rear_cornering_stiffness_n_per_rad = 95000
        [operating_range]
        v_x_m_per_s = [6, 28]
        [sampling]
        period_s = 0.005
        [[disturbance]]
        name = "bank"
        kind = "bank"
        bound_deg = 3
        "#,
    );
    // Proven; so few drives say nothing of what it sees.
    assert!(design.performance.certified.is_some());
}

/// One of the fleet, for which the start-up's own programme has no solution that passes its check: what proves the
/// decay bounds the residual too.
#[test]
fn a_start_is_bounded_by_what_proves_the_decay() {
    let design = designed(
        "[vehicle]
        mass_kg = 1225.9
        yaw_inertia_kg_m2 = 1538.9
        effective_longitudinal_inertia_kg_m = 1225.9
        front_axle_distance_m = 0.8839
        rear_axle_distance_m = 1.5088
        front_cornering_stiffness_n_per_rad = 91423.20000000001
        rear_cornering_stiffness_n_per_rad = 58430.4",
    );
    let verdict = verify(&design.to_json().unwrap()).unwrap();
    assert!(verdict.is_certified());
    assert_eq!(design.detector.evaluation.start_up_decay, design.performance.decay);
    assert!(design.threshold.start_up.margin.holds());
}

#[test]
fn unstable_error_dynamics_have_no_certificate() {
    let theorem = papers_theorem();
    // Without E, and with -0.2 fed back from v_x, N is A but for 1.2 in its first element.
    let h = Matrix::from_fn(3, 2, |row, column| if (row, column) == (0, 0) { -0.2 } else { 0.0 });
    let h = std::array::from_fn(|_| h.clone());
    let gains = ObserverGains::new(&Matrix::zeros(3, 2), &h, &theorem.a);
    let input = Matrix::from_column_slice(3, 1, &[0.01, 0.0, 0.0]);
    let error = ErrorSystem::new(&theorem, &gains, &Channel::disturbance(input, Band::Full));
    assert!(certify(&error, Band::Full, Gain::Largest, 1.0).is_err());
}

#[test]
fn the_status_is_that_of_the_proof() {
    let design = designed(PAPER);
    assert_eq!(design.synthesis.status, DesignStatus::Certified);
    // The same file with a figure beyond the proof is no longer certified by anyone.
    let mut better = design.clone();
    if let Some(certified) = &mut better.performance.certified {
        certified.gamma *= 0.99;
        certified.gap = 0.0;
    }
    let refusal = |design: &mut Design| {
        design.hash = design.computed_hash().unwrap();
        verify(&design.to_json().unwrap()).unwrap_err()
    };
    assert!(matches!(refusal(&mut better), Refusal::Claim { .. }));
    // Nor is it with a certificate that claims as much.
    if let Some(a_posteriori) = &mut better.certificate.a_posteriori {
        a_posteriori.gamma[0].gain *= 0.99;
    }
    assert!(matches!(refusal(&mut better), Refusal::Broken { .. }));
}
