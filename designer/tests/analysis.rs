//! The analysis: sensor noise through the observer against simulation, and what whole designs are
//! worth.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::sync::OnceLock;

use chacha20::ChaCha8Rng;
use chacha20::rand_core::SeedableRng;
use nalgebra::{Matrix3, Vector2, Vector3};
use proptest::prelude::*;
use rand_distr::{Distribution, StandardNormal};
use steerguard_designer::analysis::frequency::noise_rms;
use steerguard_designer::analysis::operating_point::{FrozenError, OperatingPoint};
use steerguard_designer::document::{Mistake, MistakeKind};
use steerguard_designer::lmi::matrix::{Matrix, matrix};
use steerguard_designer::problem::channel::{premise_sensitivity, premise_sensitivity_vertices};
use steerguard_designer::problem::inputs::Inputs;
use steerguard_designer::spec::Fault;
use steerguard_designer::synthesis::gains::ObserverGains;
use steerguard_designer::synthesis::theorem4::Theorem4;
use steerguard_designer::{Design, DesignError, Spec};
use steerguard_detector::{
    Actuator, Configuration, Detector, Deviations, Evaluation, Input, Measurement, Monitor, RULES,
    Staleness, TsModel, VehicleState, Zero,
};
use steerguard_test_support::cases::ReferenceCase;

mod common;
#[path = "common/designed.rs"]
mod designed;

use common::papers_but;
use designed::designed_with_few_drives;

const MODEL: TsModel = TsModel::PAPER;

fn near(what: &str, value: f64, expected: f64, relative: f64) {
    assert!((value / expected - 1.0).abs() <= relative, "{what}: {value}, expected {expected}");
}

/// Any state of S_x.
fn states() -> impl Strategy<Value = [f64; 3]> {
    let range = MODEL.range;
    [range.v_x, range.v_y, range.r].map(|x| x.min..=x.max)
}

proptest! {
    /// K is the slope of A(xi) x + g(xi) in the measurement.
    #[test]
    fn premise_sensitivity_is_the_slope_of_the_model(x in states()) {
        let prediction = |y: [f64; 2]| {
            let a = MODEL.a(1.0 / y[0], y[1]);
            let g = MODEL.g(Measurement { v_x_m_per_s: y[0], r_rad_per_s: y[1] });
            Vector3::from_fn(|row, _| (0..3).map(|k| a[row][k] * x[k]).sum::<f64>() + g[row])
        };
        let k = premise_sensitivity(&MODEL, x);
        for column in 0..2 {
            let step = 1e-4;
            let at = |step: f64| {
                let mut y = [x[0], x[2]];
                y[column] += step;
                prediction(y)
            };
            let slope = (at(step) - at(-step)) / (2.0 * step);
            for row in 0..3 {
                let error = (k[(row, column)] - slope[row]).abs();
                prop_assert!(error < 1e-9, "K[{row}][{column}]: {} or {}", k[(row, column)], slope[row]);
            }
        }
    }

    /// The hull of the vertices holds every K of S_x, with the weights of Bernstein.
    #[test]
    fn vertices_span_every_premise_sensitivity(x in states()) {
        let [v_x, v_y, r] = x;
        let range = MODEL.range;
        let [s_0, s_1] = [1.0 / range.v_x.max, 1.0 / range.v_x.min];
        let s = 1.0 / v_x;
        let t = (s - s_0) / (s_1 - s_0);
        // s itself as a cubic has these control points; divided by it the curve is rational.
        let of_speed = [
            (1.0 - t).powi(3) * s_0,
            t * (1.0 - t).powi(2) * (2.0 * s_0 + s_1),
            t.powi(2) * (1.0 - t) * (s_0 + 2.0 * s_1),
            t.powi(3) * s_1,
        ]
        .map(|weight| weight / s);
        let linear = |x: f64, min: f64, max: f64| [(max - x) / (max - min), (x - min) / (max - min)];
        let of_v_y = linear(v_y, range.v_y.min, range.v_y.max);
        let of_r = linear(r, range.r.min, range.r.max);
        let weights: Vec<f64> = of_speed
            .into_iter()
            .flat_map(|a| of_v_y.map(|b| of_r.map(|c| a * b * c)))
            .flatten()
            .collect();

        prop_assert!(weights.iter().all(|&weight| weight >= -1e-12));
        prop_assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        let vertices = premise_sensitivity_vertices(&MODEL);
        prop_assert_eq!(vertices.len(), weights.len());
        let blend = vertices
            .iter()
            .zip(weights)
            .fold(Matrix::zeros(3, 2), |sum, (vertex, weight)| sum + vertex * weight);
        prop_assert!((blend - premise_sensitivity(&MODEL, x)).amax() < 1e-12);
    }
}

/// Gains without structure, near the paper's design.
fn gains() -> ObserverGains {
    let e = matrix(&[[-0.8, 0.05], [0.1, -3.6657], [0.02, -1.9856]]);
    let h: [Matrix; RULES] = [
        [[-0.2, 0.03], [0.05, -1.44], [0.01, -0.71]],
        [[-0.18, 0.02], [-0.04, -1.42], [0.02, -0.7]],
        [[-0.21, -0.03], [0.02, -0.96], [-0.01, -0.66]],
        [[-0.2, 0.01], [0.03, -0.98], [0.01, -0.67]],
    ]
    .map(|h| matrix(&h));
    ObserverGains::new(&e, &h, &MODEL.vertices().each_ref().map(matrix))
}

/// The steady state at a speed and a yaw rate: x and u with `x = step(x, u)`.
fn steady_state(v_x: f64, r: f64) -> (VehicleState, Input) {
    let mut found = Vector3::new(0.0, 0.0, 0.0); // v_y, delta, T_eng / 100 N m
    let drift = |p: &Vector3<f64>| {
        let x = [v_x, p[0], r];
        let u = Input { t_eng_n_m: 100.0 * p[2], delta_rad: p[1] };
        let next = MODEL.step(x.into(), u).vector();
        Vector3::from_fn(|k, _| next[k] - x[k])
    };
    for _ in 0..20 {
        let slope = Matrix3::from_columns(&[0, 1, 2].map(|k| {
            let step = 1e-6 * Vector3::ith(k, 1.0);
            (drift(&(found + step)) - drift(&(found - step))) / 2e-6
        }));
        found -= slope.lu().solve(&drift(&found)).unwrap();
    }
    assert!(drift(&found).amax() < 1e-13);
    let u = Input { t_eng_n_m: 100.0 * found[2], delta_rad: found[1] };
    ([v_x, found[0], r].into(), u)
}

fn detector() -> Detector {
    Detector::new(&Configuration {
        model: MODEL,
        hysteresis: [0.5, 0.25, 0.05],
        gains: gains().gains,
        evaluation: Evaluation {
            window: 40,
            weights: [1.0, 1.0],
            threshold: 1.0,
            uncertainty_share: 0.0,
            start_up_amplitude: 0.0,
            start_up_decay: 0.0,
            debounce_samples: 1,
            alarm_hold_s: 0.0,
        },
        actuator: Actuator::NONE,
        deviations: Deviations::NONE,
        zero: Zero::default(),
        staleness: Staleness::NEVER,
        estimator: None,
    })
    .unwrap()
}

/// Residuals of the detector at a steady state of the plant, with the given sensor errors.
fn residuals(
    v_x: f64,
    r: f64,
    errors: impl Iterator<Item = [f64; 2]>,
) -> (VehicleState, Vec<Vector2<f64>>) {
    let (x, u) = steady_state(v_x, r);
    let mut detector = detector();
    let residuals = errors
        .map(|v| {
            let y = Measurement {
                v_x_m_per_s: x.v_x_m_per_s + v[0],
                r_rad_per_s: x.r_rad_per_s + v[1],
            };
            let output = detector.sample(y, u);
            assert_eq!(output.monitor, Monitor::Monitoring);
            Vector2::from(output.residual.vector())
        })
        .collect();
    (x, residuals)
}

/// Speeds and yaw rates of the simulations.
const STEADY: [[f64; 2]; 3] = [[8.0, 0.3], [15.0, 0.1], [27.0, -0.12]];

#[test]
fn constant_sensor_offset_shows_as_predicted() {
    for [v_x, r] in STEADY {
        for v in [[0.0, 0.002], [0.05, 0.0], [0.05, 0.002]] {
            let (x, residuals) = residuals(v_x, r, std::iter::repeat_n(v, 4000));
            let simulated = residuals.last().unwrap();

            let point = OperatingPoint::new(&MODEL, x.vector());
            let error = FrozenError::new(&point, &gains().gains, [1.0, 1.0]);
            let v = Vector2::from(v);
            let predicted = |from_noise| {
                let steady = (Matrix3::identity() - error.n).lu().solve(&(from_noise * v)).unwrap();
                error.output * steady + error.feedthrough * v
            };
            let difference = (predicted(error.from_noise) - simulated).norm();
            assert!(difference < 0.02 * simulated.norm(), "{x:?}, {v:?}: {difference:e}");
            // An offset of a sensor alone changes nothing: all of it enters by the premise.
            let without_premise = predicted(error.from_noise + error.m * point.k);
            assert!(without_premise.norm() < 1e-6 * simulated.norm(), "{x:?}, {v:?}");
        }
    }
}

#[test]
fn white_noise_raises_the_residual_as_predicted() {
    const SAMPLES: usize = 300_000;
    const SETTLED: usize = 1000;
    for (seed, [v_x, r]) in (0..).zip(STEADY) {
        for std in [[0.01, 0.0], [0.0, 0.001]] {
            let mut generator = ChaCha8Rng::seed_from_u64(seed);
            let mut white = move || -> f64 { StandardNormal.sample(&mut generator) };
            let noise = std::iter::repeat_with(|| std.map(|std| std * white())).take(SAMPLES);
            let (x, residuals) = residuals(v_x, r, noise);
            let squares = residuals[SETTLED..].iter().map(|x| x.norm_squared());
            let simulated = (squares.sum::<f64>() / (SAMPLES - SETTLED) as f64).sqrt();

            let point = OperatingPoint::new(&MODEL, x.vector());
            let error = FrozenError::new(&point, &gains().gains, [1.0, 1.0]);
            // The mean of so many samples is itself uncertain by a part of that.
            near(&format!("{x:?}, {std:?}"), noise_rms(&error, std), simulated, 0.015);
        }
    }
}

const TORQUE: &str = r#"
    [[fault]]
    channel = "torque"
    smallest_n_m = 50
"#;

fn designed(text: &str) -> Result<Design, DesignError> {
    designed_with_few_drives(papers_but(text))
}

fn with_method(text: &str, method: &str) -> Design {
    designed(&format!("{text}\n[design]\nmethod = '{method}'")).unwrap()
}

/// S1 by method "gap", with a second fault.
fn s1_by_gap() -> &'static Design {
    static DESIGN: OnceLock<Design> = OnceLock::new();
    DESIGN.get_or_init(|| with_method(&(ReferenceCase::read("s1").spec + TORQUE), "gap"))
}

/// Every figure on the right side of every other.
fn assert_ordered(design: &Design) {
    let performance = &design.performance;
    let frozen = performance.frozen;
    let certified = performance.certified.unwrap();
    let gamma_at_most = frozen.gamma_at_most.unwrap_or(f64::INFINITY);
    assert!(frozen.beta_at_least <= frozen.beta && frozen.gamma <= gamma_at_most);
    assert!(certified.beta <= frozen.beta, "{} > {}", certified.beta, frozen.beta);
    assert!(frozen.gamma <= certified.gamma, "{} > {}", frozen.gamma, certified.gamma);
    assert!(certified.gap <= frozen.gap);
    // Within what the solver of either stops at.
    assert!(certified.gamma <= certified.gamma_full_band * 1.01);
    for point in &performance.operating_points {
        assert!(frozen.beta <= point.beta && point.noise_rms <= performance.noise_rms);
        let gap = frozen.gap / (frozen.beta / frozen.gamma) * (point.beta / point.gamma);
        if let Some(limit) = point.limit {
            assert!(gap <= limit * (1.0 + 1e-6), "{point:?}: gap {gap}");
        }
    }
}

#[test]
fn two_disturbances_come_near_the_limit() {
    let performance = &s1_by_gap().performance;
    assert_ordered(s1_by_gap());
    let reference = ReferenceCase::read("s1");
    reference.check("frozen_gap_by_search", performance.frozen.gap);
    reference.check("certified_gap_by_search", performance.certified.unwrap().gap);
    for point in &performance.operating_points {
        let turning = point.r_rad_per_s != 0.0;
        let figure = if turning { "limit_while_turning" } else { "limit_at_r_0" };
        reference.check(figure, point.limit.unwrap());
    }
    // Nothing but the ratio matters to the search: it holds beta where Theorem 4 would.
    let spec = &s1_by_gap().spec;
    let bound = Theorem4::of(spec, &Inputs::of(spec).unwrap(), 0.97).beta_bound();
    near("beta", performance.frozen.beta, bound, 0.05);
}

#[test]
fn every_fault_is_reported() {
    let design = s1_by_gap();
    let [torque] = &design.performance.other_faults[..] else { panic!("one other fault") };
    assert_eq!(torque.fault, Fault::Torque { smallest_n_m: 50.0, band_hz: [0.0, 1.5] });
    // It acts on v_x alone, the disturbances without yaw rate on the others alone.
    assert!(torque.frozen.beta > 0.0 && torque.frozen.gamma == design.performance.frozen.gamma);
    near("gap", torque.frozen.gap, torque.frozen.beta * 50.0 / (torque.frozen.gamma * 0.5), 1e-12);
    assert_eq!(design.f[0].len(), 2);
    assert!(designed(&ReferenceCase::read("s1").spec).unwrap().performance.other_faults.is_empty());
}

#[test]
fn search_multiplies_the_papers_detection_ratio_under_noise() {
    let reference = ReferenceCase::read("s2");
    let s2 = ReferenceCase::read("s1").spec + &reference.spec;
    let [gap, paper] = ["gap", "paper"].map(|method| with_method(&s2, method));
    for design in [&gap, &paper] {
        assert_ordered(design);
    }
    let by = |design: &Design| design.performance.detection_ratio;
    reference.check("detection_ratio_by_papers_constants", by(&paper));
    reference.check("detection_ratio_by_search", by(&gap));
}

#[test]
fn bands_of_every_kind_have_a_design_or_a_clear_refusal() {
    let wind = |band: &str, alpha_d: f64| {
        designed(&format!(
            "[[disturbance]]\nkind = 'side_wind'\nname = 'wind'\nbound_m_per_s2 = 0.1\n\
             band_hz = {band}\n[design]\nalpha_d = {alpha_d}"
        ))
    };
    for band in ["[0, 1.5]", "[0.5, 50]", "[0, 50]"] {
        let design = wind(band, 0.5).unwrap();
        assert_ordered(&design);
        let a_posteriori = design.certificate.a_posteriori.unwrap();
        assert_eq!(a_posteriori.gamma[0].band.is_none(), band == "[0, 50]");
    }
    // (31) with e+ = -alpha_d e, where its multiplier drops out: beyond a low band P would have to
    // be positive and negative at once.
    for band in ["[0.5, 50]", "[0, 50]"] {
        let refusal = wind(band, 2.0).unwrap_err();
        assert!(matches!(refusal, DesignError::Infeasible(_)), "{refusal}");
        let refusal = refusal.to_string();
        for part in ["(31)", "alpha_d = 2", "design.alpha_d = 0.5"] {
            assert!(refusal.contains(part), "{refusal}");
        }
    }
}

#[test]
fn mistakes_in_noise_are_named() {
    let v_x = |text: &str| format!("[noise.v_x]\n{text}");
    let r = |text: &str| format!("[noise.r]\n{text}");
    for (text, parts) in [
        (
            v_x("white_std_m_per_s = -0.1"),
            &["`noise.v_x.white_std_m_per_s` = -0.1", "from 0 to 10"][..],
        ),
        (r("white_std_rad_per_s = nan"), &["`noise.r.white_std_rad_per_s` = NaN", "from 0 to 2"]),
        (v_x("bound_m_per_s = 0"), &["`noise.v_x.bound_m_per_s` = 0.0", "above 0, up to 10"]),
        (r("bound_rad_per_s = inf"), &["`noise.r.bound_rad_per_s` = inf", "above 0, up to 2"]),
        (r("band_hz = [0, 1.5]"), &["`noise.r.band_hz`", "with a bound only", "white noise"]),
        (
            v_x("bound_m_per_s = 0.1\nband_hz = [1, 2]"),
            &["`noise.v_x.band_hz` = [1.0, 2.0]", "middle bands"],
        ),
        (
            r("bound_rad_per_s = 0.1\nband_hz = [0, 51]"),
            &["`noise.r.band_hz` = [0.0, 51.0]", "50 Hz, the Nyquist frequency"],
        ),
        (v_x("white_std = 0.1"), &["`noise.v_x.white_std`", "did you mean `white_std_m_per_s`?"]),
        (r("bound_deg_per_s = 1"), &["`noise.r.bound_deg_per_s`", "bound_rad_per_s`?", "unit"]),
        ("[noise.v_y]\nwhite_std_m_per_s = 1".into(), &["`noise.v_y`", "known here are v_x, r"]),
        ("[noise]\nr = 0.1".into(), &["`noise.r`", "0.1"]),
    ] {
        let error = Spec::from_toml(&text).unwrap_err();
        let is_syntax = |mistake: &Mistake| matches!(mistake.kind, MistakeKind::Syntax { .. });
        assert!(!error.list().iter().any(is_syntax), "{error}");
        let message = error.to_string();
        for part in parts {
            assert!(message.contains(part), "{text}\ngave: {message}\nwithout: {part}");
        }
    }
}
