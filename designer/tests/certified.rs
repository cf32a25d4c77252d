//! Certified gains: against an independent solver, the reference values, and the exact proof.

#![allow(clippy::unwrap_used)]

use serde::Deserialize;
use steerguard_designer::certificate::ErrorDynamics;
use steerguard_designer::certified::{Gain, certified, certify};
use steerguard_designer::frequency::frozen;
use steerguard_designer::gains::ObserverGains;
use steerguard_designer::lmi::Matrix;
use steerguard_designer::spec::{Calibration, Disturbance, Manoeuvre};
use steerguard_designer::synthesis::{Goal, solve};
use steerguard_designer::theorem4::{Band, Channel, Theorem4, g_rho, matrix};
use steerguard_designer::{Design, DesignStatus, Spec, design};
use steerguard_verify::{Refusal, verify};

const THETA: f64 = std::f64::consts::TAU * 1.5 * 0.01;

fn near(value: f64, expected: f64, relative: f64) {
    assert!((value / expected - 1.0).abs() < relative, "{value}, expected {expected}");
}

/// A specification with few drives in the calibration.
fn spec(text: &str) -> Spec {
    let mut spec = Spec::from_toml(text).unwrap();
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
    spec
}

fn designed(text: &str) -> Design {
    design(&spec(text), &mut |_| {}).unwrap()
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

#[test]
fn values_agree_with_an_independent_solver() {
    let cases: Vec<Case> =
        serde_json::from_str(include_str!("fixtures/certified_gains.json")).unwrap();
    let spec = Spec::paper();
    let model = spec.model();
    let c = matrix(&steerguard_detector::C);
    for case in cases {
        let m = Matrix::identity(3, 3) + matrix(&case.e) * &c;
        let dynamics: ErrorDynamics = std::array::from_fn(|i| {
            let n = &m * matrix(&model.vertices()[i]) - matrix(&case.h[i]) * &c;
            [-3.0, 3.0].map(|rho| &n + &m * g_rho(&model, rho))
        });
        let inputs = case.d[0].len();
        let from_disturbances = &m * Matrix::from_fn(3, inputs, |row, column| case.d[row][column]);
        let from_fault = &m * spec.f();
        // Either solver stops within 1e-4 of the optimum, with its own margin.
        for (input, band, gain, expected) in [
            (&from_fault, Band::Low(THETA), Gain::Smallest, case.beta.value),
            (&from_disturbances, Band::Low(THETA), Gain::Largest, case.gamma.value),
            (&from_disturbances, Band::Full, Gain::Largest, case.gamma_full_band.value),
        ] {
            let (value, _) = certify(&dynamics, input, band, gain, input.norm()).unwrap();
            assert!((value / expected - 1.0).abs() < 1e-3, "{}: {value}, {expected}", case.name);
        }
    }
}

#[test]
fn papers_largest_beta_is_worth_its_reference_values() {
    let spec = Spec::paper();
    let model = spec.model();
    let disturbance = Channel { direction: spec.d(), band: Band::Low(THETA) };
    let fault = Channel { direction: spec.f(), band: Band::Low(THETA) };
    let theorem = Theorem4::new(&model, &disturbance, &fault, &spec.multipliers(), 0.97);
    let synthesis = solve(&theorem, Goal::LargestBeta { gamma: Some(0.8) }).unwrap();
    let magnitudes = frozen(&model, &synthesis.gains, &disturbance, &fault);
    let (figures, _) =
        certified(&theorem, &synthesis.gains, &magnitudes, 0.5_f64.to_radians(), 0.1).unwrap();
    // METHOD.md 7.
    near(figures.beta, 1.10, 0.02);
    assert!(figures.gamma < 0.0056, "{figures:?}");
    // Three times what synthesis claims, a hundred times less gamma.
    assert!(figures.beta > 3.0 * synthesis.beta && figures.gamma < 0.01 * 0.8);
}

/// S1 of METHOD.md 7.
const S1: &str = r#"
    [[fault]]
    channel = "steering"
    smallest_deg = 1
    [[disturbance]]
    name = "lateral"
    kind = "direction"
    direction = [0, 1, 0]
    bound = 0.5
    [[disturbance]]
    name = "yaw"
    kind = "direction"
    direction = [0, 0, 1]
    bound = 0.1
    [design]
    alpha_d = 0.02
    V = [0, 15.44715447, 14.23425414]
"#;

#[test]
fn two_disturbances_reach_the_reference_gap() {
    let design = designed(S1);
    let certified = design.performance.certified.unwrap();
    // Per degree, and per bound.
    near(certified.beta * 1_f64.to_radians(), 0.14268, 2e-3);
    near(certified.gamma * 0.5, 0.014793, 2e-3);
    near(certified.gap, 9.645, 1e-3);
    assert_eq!(design.synthesis.status, DesignStatus::Certified);
    let verdict = verify(&design.to_json().unwrap()).unwrap();
    assert_eq!(verdict.figures.gap, certified.gap);
    assert_eq!(verdict.hash, design.hash);
}

#[test]
fn certified_figures_lie_between_synthesis_and_frozen_ones() {
    for text in ["", S1] {
        let Design { synthesis, performance, .. } = designed(text);
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
    let papers = designed("");
    let spec = &papers.spec;
    let model = spec.model();
    let fault = Channel { direction: spec.f(), band: Band::Low(THETA) };
    let gains = ObserverGains {
        gains: papers.configuration().gains,
        h: papers.vertices.map(|rule| rule.h),
    };
    let theta = std::f64::consts::TAU * 0.5 * 0.01;
    for (band, band_hz) in [(Band::Full, [0.0, 50.0]), (Band::High(theta), [0.5, 50.0])] {
        let disturbance = Channel { direction: spec.d(), band };
        let theorem = Theorem4::new(&model, &disturbance, &fault, &spec.multipliers(), 0.97);
        let magnitudes = frozen(&model, &gains, &disturbance, &fault);
        let (figures, certificate) =
            certified(&theorem, &gains, &magnitudes, 0.5_f64.to_radians(), 0.1).unwrap();
        assert!(magnitudes.gamma < figures.gamma);
        assert!(figures.gamma < figures.gamma_full_band * (1.0 + 1e-4));
        assert_eq!(certificate.gamma.band.is_none(), band == Band::Full);

        let mut design = papers.clone();
        design.spec.disturbance = vec![Disturbance::SideWind {
            name: "side wind".into(),
            acting_ahead_m: 0.25,
            bound_m_per_s2: 0.1,
            band_hz,
        }];
        design.performance.certified = Some(figures);
        design.certificate.a_posteriori = Some(certificate);
        let proof = |design: &mut Design| {
            design.hash = design.computed_hash().unwrap();
            verify(&design.to_json().unwrap())
        };
        proof(&mut design).unwrap();
        // Of a high band, 2 cos(theta) must not be too small.
        let mut wider = design.clone();
        if let Some(a_posteriori) = &mut wider.certificate.a_posteriori
            && let Some(band) = &mut a_posteriori.gamma.band
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
    assert_eq!(design.synthesis.status, DesignStatus::Certified);
}

#[test]
fn unstable_error_dynamics_have_no_certificate() {
    let model = Spec::paper().model();
    let dynamics: ErrorDynamics = model.vertices().map(|a| {
        let mut n = matrix(&a);
        n[(0, 0)] = 1.2;
        [-3.0, 3.0].map(|rho| &n + g_rho(&model, rho))
    });
    let input = Matrix::from_column_slice(3, 1, &[0.01, 0.0, 0.0]);
    assert!(certify(&dynamics, &input, Band::Full, Gain::Largest, 1.0).is_err());
}

#[test]
fn the_status_is_that_of_the_proof() {
    let design = designed("");
    assert_eq!(design.synthesis.status, DesignStatus::Certified);
    // The same file with a figure beyond the proof is no longer certified by anyone.
    let mut better = design.clone();
    if let Some(certified) = &mut better.performance.certified {
        certified.gamma *= 0.99;
        certified.gap = 0.0;
    }
    better.hash = better.computed_hash().unwrap();
    let refusal = verify(&better.to_json().unwrap()).unwrap_err();
    assert!(matches!(refusal, Refusal::Broken { .. }), "{refusal}");
}
