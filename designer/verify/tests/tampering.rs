//! Changed design files: refused by their hash, and with a forged hash wherever a proof breaks.
//!
//! The fixtures are designs: `paper.json` of `examples/paper.toml`, the others of the specification
//! beside them. `cargo run --release -p steerguard-designer --example fixtures` makes them anew.

#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use common::{GAP, GUARANTEED, NOISE, PAPER, parsed};
use serde_json::{Value, json};
use steerguard_verify::{FORMAT, Family, Refusal, Status, Verdict, content_hash, verify};

fn verified(design: &Value) -> Result<Verdict, Refusal> {
    verify(&design.to_string())
}

/// A design with a change, refused by its hash; then proven or not with a forged one.
fn forged(text: &str, change: impl FnOnce(&mut Value)) -> Result<Verdict, Refusal> {
    let mut design = parsed(text);
    change(&mut design);
    assert!(matches!(verified(&design), Err(Refusal::Hash { .. })));
    design["hash"] = content_hash(&design).unwrap().into();
    verified(&design)
}

/// The same of the paper's design.
fn with_forged_hash(change: impl FnOnce(&mut Value)) -> Result<Verdict, Refusal> {
    forged(PAPER, change)
}

fn at<'a>(design: &'a mut Value, pointer: &str) -> &'a mut Value {
    design.pointer_mut(pointer).unwrap_or_else(|| panic!("{pointer}"))
}

/// Applies `change` to the numbers at `pointers`.
fn each(design: &mut Value, pointers: &[&str], change: impl Fn(f64) -> f64) {
    for pointer in pointers {
        let number = at(design, pointer);
        *number = change(number.as_f64().unwrap()).into();
    }
}

/// What becomes of the paper's design whose numbers at `pointers` were changed.
fn changed(pointers: &[&str], change: impl Fn(f64) -> f64) -> Result<Verdict, Refusal> {
    with_forged_hash(|design| each(design, pointers, change))
}

/// What becomes of the design with noise.
fn noise_changed(pointers: &[&str], change: impl Fn(f64) -> f64) -> Result<Verdict, Refusal> {
    forged(NOISE, |design| each(design, pointers, change))
}

fn plus(pointer: &str, difference: f64) -> Result<Verdict, Refusal> {
    changed(&[pointer], |x| x + difference)
}

fn times(pointer: &str, factor: f64) -> Result<Verdict, Refusal> {
    changed(&[pointer], |x| x * factor)
}

fn swap(design: &mut Value, a: &str, b: &str) {
    let taken = at(design, a).take();
    let other = std::mem::replace(at(design, b), taken);
    *at(design, a) = other;
}

fn swapped(a: &str, b: &str) -> Result<Verdict, Refusal> {
    with_forged_hash(|design| swap(design, a, b))
}

fn replaced(pointer: &str, value: Value) -> Result<Verdict, Refusal> {
    with_forged_hash(|design| *at(design, pointer) = value)
}

/// Asserts that a result is the refusal with the given pattern.
macro_rules! refused {
    ($result:expr, $pattern:pat) => {{
        let result = $result;
        assert!(matches!(result, Err($pattern)), "{result:?}");
    }};
}

#[track_caller]
fn broken(result: Result<Verdict, Refusal>, expected: Family) {
    let Err(Refusal::Broken { family, .. }) = result else { panic!("{result:?}") };
    assert_eq!(family, expected);
}

#[test]
fn papers_design_is_proven() {
    let verdict = verify(PAPER).unwrap();
    let figures = verdict.figures.unwrap();
    assert!((figures.gap - 18.315).abs() < 0.002);
    assert!(figures.gamma < figures.gamma_full_band);
    assert_eq!(figures.decay, 0.97);
    let counts: Vec<usize> = verdict.margins.iter().map(|margin| margin.inequalities).collect();
    // 4 rules + 4 rules x 4 successors x 2 rho; Q + 10 pairs of rules x 4 successors x 2 rho.
    assert_eq!(counts, [36, 36, 81, 81, 80]);
    for margin in &verdict.margins {
        assert!(margin.smallest_pivot > 1e-8 && margin.smallest_pivot <= 1.0, "{margin:?}");
    }
    assert!(verdict.residues.observer_equation < 1e-14);
    let text = verdict.to_string();
    for part in [
        "certified",
        "<= 4 sin^2(0.094248 / 2) sum e e'",
        "Unconditionally",
        "0.97^k",
        "side wind (0.1)",
    ] {
        assert!(text.contains(part), "{text}");
    }
}

#[test]
fn layout_order_of_keys_notation_and_sign_of_zero_are_free() {
    let compact = parsed(PAPER).to_string();
    let other_notation = PAPER.replacen("\"window\": 40,", "\"window\": 4.0e1,", 1);
    assert_ne!(other_notation, PAPER);
    let hash = verify(PAPER).unwrap().hash;
    for text in [compact, other_notation] {
        assert_eq!(verify(&text).unwrap().hash, hash);
    }
}

#[test]
fn changed_gains_are_refused() {
    let of = |gain: &str| format!("/detector/gains/{gain}");
    for gain in ["/vertices/2/H/2/1".into(), of("m/1/2"), of("e/2/0")] {
        refused!(plus(&gain, 1e-9), Refusal::Residue { .. });
    }
    for (here, there) in
        [("/vertices/3/N/1/1", of("n/3/1/1")), ("/vertices/0/L/1/0", of("l/0/1/0"))]
    {
        refused!(changed(&[here, &there], |x| x + 1e-9), Refusal::Residue { .. });
        refused!(plus(here, 1e-9), Refusal::Disagreement { .. });
        refused!(plus(&there, 1e-9), Refusal::Disagreement { .. });
    }
    let swapped = with_forged_hash(|design| {
        swap(design, "/vertices/0/N", "/vertices/1/N");
        swap(design, &of("n/0"), &of("n/1"));
    });
    refused!(swapped, Refusal::Residue { .. });
}

#[test]
fn gains_changed_together_with_the_observer_equation_intact_break_the_proof() {
    // N_3 and L_3 of another H_3: still an observer, not the certified one.
    let result = with_forged_hash(|design| {
        let e = at(design, "/detector/gains/e").clone();
        let difference = 0.02;
        each(design, &["/vertices/3/H/1/1"], |x| x + difference);
        each(design, &["/vertices/3/N/1/2", "/detector/gains/n/3/1/2"], |x| x - difference);
        // L = H - N E, row 1.
        for column in 0..2 {
            let e = e[2][column].as_f64().unwrap();
            let own = if column == 1 { difference } else { 0.0 };
            let l = ["/vertices/3/L/1/", "/detector/gains/l/3/1/"].map(|l| format!("{l}{column}"));
            each(design, &l.each_ref().map(String::as_str), |x| x + own + difference * e);
        }
    });
    refused!(result, Refusal::Broken { .. });
}

#[test]
fn changed_models_are_refused() {
    for element in ["/vertices/1/A/1/1", "/B/1/1", "/G/1/0", "/F/2/0", "/D/2/0"] {
        refused!(times(element, 1.0 + 1e-9), Refusal::Model { .. });
    }
    refused!(swapped("/vertices/0", "/vertices/2"), Refusal::Model { .. });
    refused!(plus("/C/1/1", 1e-3), Refusal::Disagreement { .. });
    let both = ["/detector/model/vehicle/mass_kg", "/spec/vehicle/mass_kg"];
    refused!(plus(both[1], 1.0), Refusal::Disagreement { .. });
    refused!(changed(&both, |x| x + 1.0), Refusal::Model { .. });
    let both = ["/detector/model/sampling_period_s", "/spec/sampling/period_s"];
    refused!(changed(&both, |x| 2.0 * x), Refusal::Model { .. });
    refused!(times("/spec/disturbance/0/acting_ahead_m", 2.0), Refusal::Model { .. });
}

#[test]
fn wider_ranges_and_bands_are_refused() {
    // A little beyond the range of v_y only the start-up's amplitude is too small, far beyond it
    // the error may grow.
    let v_y = |factor: f64| {
        let range = ["/detector/model/range/v_y/min", "/spec/operating_range/v_y_m_per_s/0"];
        let amplitude = "/detector/evaluation/start_up_amplitude";
        refused!(
            changed(&range, |x| factor * x),
            Refusal::Claim { key: "detector.evaluation.start_up_amplitude", .. }
        );
        changed(&[range[0], range[1], amplitude], |x| factor * x)
    };
    // The proof holds a little beyond; the operating points are those of the range.
    refused!(v_y(1.001), Refusal::Disagreement { .. });
    refused!(v_y(100.0), Refusal::Broken { .. });
    let speed = ["/detector/model/range/v_x/min", "/spec/operating_range/v_x_m_per_s/0"];
    refused!(changed(&speed, |x| x - 0.5), Refusal::Model { .. });
    refused!(changed(&speed, |x| -x), Refusal::Range { .. });
    let upper = ["/spec/fault/0/band_hz/1", "/spec/disturbance/0/band_hz/1"];
    refused!(times(upper[0], 1.1), Refusal::Cosine { family: Family::FaultSensitivity, .. });
    refused!(
        times(upper[1], 1.1),
        Refusal::Cosine { family: Family::DisturbanceAttenuation(0), .. }
    );
    refused!(plus("/spec/fault/0/band_hz/0", 0.1), Refusal::Band { .. });
}

#[test]
fn better_figures_are_refused() {
    let certified = |key: &str| format!("/performance/certified/{key}");
    let gain = |of: &str| format!("/certificate/a_posteriori/{of}/gain");
    // Beyond the certificate's gain, then with a gain beyond its inequalities.
    for (key, of, factor, family) in [
        ("beta", "beta", 1.01, Family::FaultSensitivity),
        ("gamma", "gamma/0", 0.99, Family::DisturbanceAttenuation(0)),
        ("gamma_full_band", "gamma_full_band", 0.99, Family::FullBandAttenuation),
    ] {
        refused!(times(&certified(key), factor), Refusal::Claim { .. });
        broken(changed(&[&gain(of), &certified(key)], |x| x * factor), family);
        refused!(times(&certified(key), -1.0), Refusal::NotPositive { .. });
        broken(times(&gain(of), factor), family);
    }
    broken(times(&certified("decay"), 0.95), Family::Decay);
    refused!(times(&certified("decay"), 1.1), Refusal::Range { .. });
    refused!(times(&certified("gap"), 1.01), Refusal::Claim { .. });
    refused!(times(&certified("gamma"), 1.01), Refusal::Claim { .. });
    // A sign does not make a gain smaller than it is.
    refused!(times(&gain("gamma_full_band"), -2.0), Refusal::Claim { .. });
    // The gap counts faults and disturbances in units of what is stated.
    refused!(times("/spec/disturbance/0/bound_m_per_s2", 1.01), Refusal::Claim { .. });
    let fault = "/detector/deviations/smallest_fault";
    let fault = ["/spec/fault/0/smallest_deg", &format!("{fault}/1"), &format!("{fault}/2")];
    refused!(changed(&fault, |x| 0.99 * x), Refusal::Claim { .. });
    refused!(times("/detector/evaluation/start_up_amplitude", 0.99), Refusal::Claim { .. });
    broken(times("/detector/evaluation/start_up_decay", 0.9), Family::StartUp);
    refused!(times("/detector/evaluation/start_up_decay", -1.0), Refusal::Range { .. });
}

#[test]
fn changed_weights_are_refused() {
    let [of_spec, used] = ["/spec/evaluation/weights/1", "/detector/evaluation/weights/1"];
    refused!(times(used, 1.1), Refusal::Disagreement { .. });
    refused!(times(of_spec, 1.1), Refusal::Disagreement { .. });
    broken(changed(&[of_spec, used], |x| 1.1 * x), Family::StartUp);
    // A smaller weight keeps all but the sensitivity to faults.
    broken(changed(&[of_spec, used], |x| 0.9 * x), Family::FaultSensitivity);
}

#[test]
fn changed_certificates_are_refused() {
    let of = |pointer: &str| format!("/certificate/a_posteriori/{pointer}");
    refused!(plus(&of("beta/band/two_cos_theta"), 1e-12), Refusal::Cosine { .. });
    broken(plus(&of("gamma/0/band/two_cos_theta"), -0.1), Family::DisturbanceAttenuation(0));
    refused!(plus(&of("beta/P/0/0/1"), 1e-3), Refusal::NotSymmetric { .. });
    refused!(plus(&of("gamma/0/band/Q/0/1"), 1e-3), Refusal::NotSymmetric { .. });
    broken(
        replaced(&of("beta/band/Q"), json!([[0, 0, 0], [0, 0, 0], [0, 0, 0]])),
        Family::FaultSensitivity,
    );
    broken(replaced(&of("gamma/0/band"), Value::Null), Family::DisturbanceAttenuation(0));
    broken(plus(&of("gamma/0/P/1/2/2"), 1.0), Family::DisturbanceAttenuation(0));
    broken(plus(&of("gamma_full_band/X/2/1/0/1"), 100.0), Family::FullBandAttenuation);
    broken(swapped(&of("beta/X/0/0"), &of("beta/X/3/3")), Family::FaultSensitivity);
    refused!(replaced(&of("beta/X/1/1"), json!([[0, 0, 0]])), Refusal::Shape { .. });
    refused!(swapped(&of("gamma/0"), &of("gamma_full_band")), Refusal::Claim { .. });
    let matrices = with_forged_hash(|design| {
        for key in ["P", "X"] {
            swap(design, &of(&format!("gamma/0/{key}")), &of(&format!("gamma_full_band/{key}")));
        }
    });
    broken(matrices, Family::DisturbanceAttenuation(0));
    broken(swapped("/certificate/P_s/0", "/certificate/P_s/3"), Family::Decay);
    broken(times("/certificate/P_s/2/2/2", -1.0), Family::Decay);
    for key in ["/certificate/a_posteriori", "/performance/certified"] {
        refused!(replaced(key, Value::Null), Refusal::NoCertificate { .. });
    }
}

#[test]
fn gains_of_a_search_are_proven() {
    let verdict = verify(GAP).unwrap();
    // Limited by the disturbance, the gap is that of the synthesis; beta is not.
    assert!((verdict.figures.unwrap().gap - 11.380).abs() < 0.01);
    let design = parsed(GAP);
    for key in ["statement", "attenuation", "P_f", "Q_f", "R", "margins"] {
        assert_eq!(design["certificate"][key], Value::Null, "{key}");
    }
}

#[test]
fn bands_and_bounded_noise_are_proven() {
    let verdict = verify(NOISE).unwrap();
    let counts: Vec<usize> = verdict.margins.iter().map(|margin| margin.inequalities).collect();
    // Q + 10 pairs of rules x 4 successors x 2 rho x 16 K; the second band is the full one.
    assert_eq!(counts, [36, 36, 81, 1281, 1280, 1280]);
    for margin in &verdict.margins {
        assert!(margin.smallest_pivot > 1e-8 && margin.smallest_pivot <= 1.0, "{margin:?}");
    }
    let text = verdict.to_string();
    for part in [
        "W_r = diag(0.1, 1)",
        "side wind (0.1), noise of v_x (0.05) whose error obeys",
        "tyre pull (20), noise of r (0.001): ||W_r r||",
        "the root of the sum of squares",
        "e = x - x^ - E D_y v",
        "gamma[1]",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

#[test]
fn changed_blocks_are_refused() {
    let gamma = "/certificate/a_posteriori/gamma";
    let gain = |band: usize| format!("{gamma}/{band}/gain");
    for band in 0..2 {
        let smaller = noise_changed(&[&gain(band)], |x| 0.99 * x);
        broken(smaller, Family::DisturbanceAttenuation(band));
        let larger = noise_changed(&[&gain(band)], |x| 1.01 * x);
        refused!(larger, Refusal::Claim { .. });
    }
    let dropped = forged(NOISE, |design| {
        at(design, gamma).as_array_mut().unwrap().pop();
    });
    refused!(dropped, Refusal::Shape { key: "certificate.a_posteriori.gamma", .. });
    let doubled = forged(NOISE, |design| {
        let blocks = at(design, gamma).as_array_mut().unwrap();
        blocks.push(blocks[1].clone());
    });
    refused!(doubled, Refusal::Shape { key: "certificate.a_posteriori.gamma", .. });
    // Both have two inputs, and the sum of squares stays the same.
    let swapped = forged(NOISE, |design| {
        swap(design, &format!("{gamma}/0"), &format!("{gamma}/1"));
    });
    broken(swapped, Family::DisturbanceAttenuation(0));
    // The figure of one band alone is no figure of all.
    let best = parsed(NOISE).pointer(&gain(0)).unwrap().as_f64().unwrap();
    refused!(noise_changed(&["/performance/certified/gamma"], |_| best), Refusal::Claim { .. });
}

#[test]
fn changed_noise_is_refused() {
    let noise = "/spec/noise";
    let [speed, yaw_rate] =
        ["v_x/bound_m_per_s", "r/bound_rad_per_s"].map(|bound| format!("{noise}/{bound}"));
    broken(noise_changed(&[&speed], |x| 1.01 * x), Family::DisturbanceAttenuation(0));
    broken(noise_changed(&[&yaw_rate], |x| 1.01 * x), Family::DisturbanceAttenuation(1));
    refused!(noise_changed(&[&yaw_rate], |x| -x), Refusal::NotPositive { .. });
    let set = |pointer: &str, value: Value| forged(NOISE, |design| *at(design, pointer) = value);
    // Noise that is left out, or moves to another band.
    refused!(set(&yaw_rate, Value::Null), Refusal::Shape { key: "D_y", .. });
    let all_frequencies = format!("{noise}/v_x/band_hz");
    refused!(set(&all_frequencies, Value::Null), Refusal::Shape { .. });
    let band = |band: Value| set(&format!("{noise}/v_x/band_hz"), band);
    refused!(band(json!([0.0, 2.0])), Refusal::Shape { .. });
    refused!(band(json!([1.0, 2.0])), Refusal::Band { .. });

    refused!(set("/D_y", Value::Null), Refusal::Shape { key: "D_y", .. });
    refused!(set("/D_y", json!([[1.0], [0.0]])), Refusal::Shape { key: "D_y", .. });
    refused!(noise_changed(&["/D_y/0/0"], |x| 0.99 * x), Refusal::Model { .. });
    refused!(noise_changed(&["/D_y/1/0"], |x| x + 1e-3), Refusal::Model { .. });
    refused!(replaced("/D_y", json!([[0.0], [1.0]])), Refusal::Shape { key: "D_y", .. });
}

/// The longitudinal drag is in no matrix of the file: it acts by K alone, on the speed's noise.
#[test]
fn noise_by_the_measured_premise_counts() {
    let drag = ["/detector/model", "/spec"]
        .map(|at| format!("{at}/vehicle/longitudinal_drag_n_m_s2_per_m2"));
    let drag = drag.each_ref().map(String::as_str);
    let result = noise_changed(&drag, |x| 1000.0 * x);
    let Err(Refusal::Broken { family, combination, .. }) = result else { panic!("{result:?}") };
    assert_eq!(family, Family::DisturbanceAttenuation(0));
    assert!(combination.to_string().contains("of K"), "{combination}");
    changed(&drag, |x| 1000.0 * x).unwrap();

    // v_y's range bounds K and rho.
    let v_y = ["/detector/model/range/v_y/max", "/spec/operating_range/v_y_m_per_s/1"];
    let wider = forged(NOISE, |design| {
        each(design, &v_y, |x| 1.5 * x);
        each(design, &["/detector/evaluation/start_up_amplitude"], |x| 1.5 * x);
    });
    let Err(Refusal::Broken { family, .. }) = wider else { panic!("{wider:?}") };
    assert!(matches!(family, Family::DisturbanceAttenuation(_)), "{family}");
}

#[test]
fn changed_faults_are_refused() {
    for element in ["/F/1/0", "/F/0/1"] {
        let result = noise_changed(&[element], |x| x * (1.0 + 1e-9));
        refused!(result, Refusal::Model { .. });
    }
    let swapped = forged(NOISE, |design| swap(design, "/spec/fault/0", "/spec/fault/1"));
    refused!(swapped, Refusal::Model { .. });
    // Beta is about the first.
    let other = forged(NOISE, |design| {
        swap(design, "/spec/fault/0", "/spec/fault/1");
        let torque = 50.0 * at(design, "/B/0/0").as_f64().unwrap();
        *at(design, "/detector/deviations/smallest_fault") = json!([torque, 0.0, 0.0]);
        for row in 0..3 {
            swap(design, &format!("/F/{row}/0"), &format!("/F/{row}/1"));
        }
    });
    refused!(other, Refusal::Claim { .. } | Refusal::Broken { .. });
    let fewer = forged(NOISE, |design| {
        at(design, "/spec/fault").as_array_mut().unwrap().pop();
    });
    refused!(fewer, Refusal::Shape { key: "F", .. });
    for key in ["fault", "disturbance"] {
        let none = replaced(&format!("/spec/{key}"), json!([]));
        refused!(none, Refusal::Shape { .. });
    }
}

/// Pointers of all numbers and nulls below `value`.
fn leaves(value: &Value, pointer: &str, found: &mut Vec<String>) {
    match value {
        Value::Object(keys) => {
            for (key, value) in keys {
                leaves(value, &format!("{pointer}/{key}"), found);
            }
        }
        Value::Array(elements) => {
            for (index, value) in elements.iter().enumerate() {
                leaves(value, &format!("{pointer}/{index}"), found);
            }
        }
        _ => found.push(pointer.to_owned()),
    }
}

/// Whatever is baked, another number in its place is refused.
#[test]
fn every_number_of_the_detector_is_vouched_for() {
    for text in [PAPER, NOISE, GUARANTEED] {
        let (mut pointers, mut overlooked) = (Vec::new(), Vec::new());
        leaves(&parsed(text)["detector"], "/detector", &mut pointers);
        assert!(pointers.len() > 120, "{}", pointers.len());
        for pointer in pointers {
            let result = forged(text, |design| {
                let value = at(design, &pointer);
                *value = match &*value {
                    Value::Null => json!(0.5),
                    Value::Bool(x) => json!(!x),
                    // Less of the start-up term, more of the rest.
                    Value::Number(_) if pointer.contains("/start_up_") => {
                        json!(0.9 * value.as_f64().unwrap())
                    }
                    number => json!(number.as_f64().unwrap() * 1.013 + 0.017),
                };
            });
            if result.is_ok() {
                overlooked.push(pointer);
            }
        }
        assert_eq!(overlooked, [""; 0]);
    }
}

/// So is another number in the specification, but where it says how something was simulated or searched,
/// is for recorded drives alone, is a name, or asks for what this kind of threshold cannot have.
#[test]
fn every_number_of_the_specification_is_held_against_the_rest() {
    let free = [
        "/spec/sensors/steering_ratio",
        "/spec/disturbance/0/name",
        "/spec/uncertainty/friction/1",
        "/spec/design/",
        "/spec/evaluation/calibration/",
        "/spec/estimator/enabled",
    ];
    let (mut pointers, mut overlooked) = (Vec::new(), Vec::new());
    leaves(&parsed(PAPER)["spec"], "/spec", &mut pointers);
    for pointer in pointers {
        if free.iter().any(|free| pointer.starts_with(free)) {
            continue;
        }
        let result = forged(PAPER, |design| {
            let value = at(design, &pointer);
            *value = match &*value {
                Value::Null => json!(0.5),
                Value::Bool(x) => json!(!x),
                Value::String(text) => json!(format!("{text} and more")),
                number => json!(number.as_f64().unwrap() * 1.05 + 0.05),
            };
        });
        if result.is_ok() {
            overlooked.push(pointer);
        }
    }
    assert_eq!(overlooked, [""; 0]);
}

/// Figures that agree with each other, but not with the gains.
#[test]
fn frozen_figures_are_those_of_the_gains() {
    let better = forged(GAP, |design| {
        let points = at(design, "/performance/operating_points").as_array().unwrap().len();
        let mut pointers = Vec::new();
        for index in 0..points {
            let point = format!("/performance/operating_points/{index}");
            pointers.extend([format!("{point}/beta"), format!("{point}/detection_ratio")]);
        }
        let of_all = ["frozen/beta", "frozen/gap", "detection_ratio", "smallest_fault_residual"];
        pointers.extend(of_all.map(|key| format!("/performance/{key}")));
        let pointers: Vec<&str> = pointers.iter().map(String::as_str).collect();
        each(design, &pointers, |x| 1.1 * x);
    });
    let Err(Refusal::Disagreement { key, .. }) = better else { panic!("{better:?}") };
    assert_eq!(key, "performance.operating_points[0].beta");

    let fewer = forged(GAP, |design| {
        // One that is the worst in nothing.
        at(design, "/performance/operating_points").as_array_mut().unwrap().remove(30);
    });
    let Err(Refusal::Disagreement { key, .. }) = fewer else { panic!("{fewer:?}") };
    assert!(key.contains("their number"), "{key}");

    let quieter = forged(NOISE, |design| {
        at(design, "/spec/noise/r")["white_std_rad_per_s"] = json!(0.001);
        *at(design, "/detector/staleness/r_jump_rad_per_s") = json!(20.0 * 0.01 + 8.5 * 0.001);
    });
    let Err(Refusal::Disagreement { key, .. }) = quieter else { panic!("{quieter:?}") };
    assert!(key.contains("noise_rms"), "{key}");
    let other = forged(NOISE, |design| {
        let of = |key: &str| format!("/performance/other_faults/0/{key}");
        let pointers = [of("frozen/beta"), of("frozen/gap"), of("detection_ratio")];
        each(design, &pointers.each_ref().map(String::as_str), |x| 1.1 * x);
    });
    let Err(Refusal::Disagreement { key, .. }) = other else { panic!("{other:?}") };
    assert_eq!(key, "performance.other_faults[0].frozen.beta");
}

/// Null where the grid of frequencies is too coarse for it.
#[test]
fn a_bound_on_gamma_between_the_frequencies_may_be_missing_but_not_wrong() {
    let bound = "/performance/frozen/gamma_at_most";
    assert!(replaced(bound, Value::Null).is_ok());
    let wrong = changed(&[bound], |gamma| 0.5 * gamma);
    let Err(Refusal::Disagreement { key, .. }) = wrong else { panic!("{wrong:?}") };
    assert_eq!(key, "performance.frozen.gamma");
}

/// A design that says that it is not certified claims no figures.
#[test]
fn uncertified_designs_are_accepted_as_such() {
    let uncertified = |of: &str, also: &dyn Fn(&mut Value)| {
        forged(of, |design| {
            // What is blind is called so with and without a proof.
            let status = at(design, "/synthesis/status");
            if *status != json!("blind") {
                *status = json!("almost_solved");
            }
            *at(design, "/performance/certified") = Value::Null;
            *at(design, "/certificate/a_posteriori") = Value::Null;
            also(design);
        })
    };
    for text in [PAPER, GAP, NOISE, GUARANTEED] {
        let verdict = uncertified(text, &|_| {}).unwrap();
        let is_blind = parsed(text)["synthesis"]["status"] == "blind";
        let expected = if is_blind { Status::Blind } else { Status::AlmostSolved };
        assert_eq!((verdict.status, verdict.figures), (expected, None));
        assert!(!verdict.is_certified());
        let families: Vec<Family> = verdict.margins.iter().map(|margin| margin.family).collect();
        assert_eq!(families[..2], [Family::Decay, Family::StartUp]);
        let printed = verdict.to_string();
        assert!(printed.starts_with("not certified") && !printed.contains("gap "), "{printed}");
    }
    // What it does claim is checked all the same.
    let threshold = "/detector/evaluation/threshold";
    let twice = |design: &mut Value| each(design, &[threshold], |x| 2.0 * x);
    refused!(uncertified(PAPER, &twice), Refusal::Disagreement { .. });
    let start = |design: &mut Value| each(design, &["/threshold/start_up/P/1/0/0"], |x| 0.1 * x);
    broken(uncertified(PAPER, &start), Family::StartUp);
    let decay = |design: &mut Value| swap(design, "/certificate/P_s/0", "/certificate/P_s/3");
    let verdict = uncertified(PAPER, &decay).unwrap();
    assert!(verdict.unchecked.iter().any(|x| x.contains("P_s")), "{:?}", verdict.unchecked);
    // Figures without the status, and the other way round.
    for status in ["uncertified", "almost_solved"] {
        refused!(replaced("/synthesis/status", json!(status)), Refusal::Unproven { .. });
    }
}

/// Changes that a forged hash hides, because what the file then claims is still true, or is no
/// claim of the proof.
#[test]
fn changes_that_leave_a_theorem() {
    // Weaker claims follow from the one that was proven.
    times("/performance/certified/gamma_full_band", 1.01).unwrap();
    changed(&["/performance/certified/beta", "/performance/certified/gap"], |x| 0.99 * x).unwrap();
    // One unit in the last place of a gain is within the residues that the verdict states, and the
    // inequalities are those of the changed gain.
    changed(&["/vertices/3/N/1/1", "/detector/gains/n/3/1/1"], f64::next_up).unwrap();
    // Measured on simulations or grids, neither proven nor recomputed: only the hash protects them, and
    // the verdict names them.
    let level = ["/threshold/calibration/level", "/detector/evaluation/threshold"];
    let verdict = changed(&level, |x| 2.0 * x).unwrap();
    assert!(verdict.unchecked.iter().any(|x| x.contains("`threshold.calibration.level`")));
    replaced("/synthesis/solver", "another".into()).unwrap();
}

#[test]
fn what_is_no_design_file_is_unreadable() {
    for blank in ["", " \n\t"] {
        refused!(verify(blank), Refusal::Empty);
    }
    for half in ["{", &PAPER[..PAPER.len() / 2]] {
        refused!(verify(half), Refusal::Truncated(_));
    }
    refused!(verify("mass_kg = 1476"), Refusal::Unreadable(_));
    for other in ["[]", "null", "{}"] {
        refused!(verify(other), Refusal::NoFormat);
    }
    for older in ["steerguard-design/1", "steerguard-design/2", "steerguard-design/3"] {
        let format = PAPER.replacen(FORMAT, older, 1);
        let error = verify(&format).unwrap_err();
        assert!(matches!(error, Refusal::Format { .. }));
        assert!(error.to_string().contains(older), "{error}");
    }
    let without = |section: &'static str, key: &'static str| {
        with_forged_hash(move |design| {
            at(design, section).as_object_mut().unwrap().remove(key);
        })
    };
    refused!(without("", "detector"), Refusal::Key(_));
    refused!(without("/detector/gains", "m"), Refusal::Key(_));
    // What is baked and not known here is vouched for by nothing.
    let more =
        with_forged_hash(|design| at(design, "/detector/evaluation")["alarm_hold"] = 1.into());
    let error = more.unwrap_err();
    assert!(matches!(error, Refusal::Key(_)));
    assert!(error.to_string().contains("detector.evaluation.alarm_hold"), "{error}");
}

/// What becomes of the guaranteed threshold whose number at `pointer` is multiplied.
fn guaranteed_times(pointer: &str, factor: f64) -> Result<Verdict, Refusal> {
    forged(GUARANTEED, |design| each(design, &[pointer], |x| factor * x))
}

#[test]
fn guaranteed_threshold_is_proven() {
    let verdict = verify(GUARANTEED).unwrap();
    let peaks: Vec<usize> = verdict
        .margins
        .iter()
        .filter(|margin| matches!(margin.family, Family::Peak(_)))
        .map(|margin| margin.inequalities)
        .collect();
    // 3 for each rule, with noise 4; at the vertices of rules and rho, or of speed, its slack, r and
    // rho in h and v_y, r in K (that of r does not depend on r), 4 successors of P and V.
    assert_eq!(peaks, [12 + 8 * 8, 16 + 128 * 8, 16 + 64 * 8]);
    assert!(verdict.to_string().contains("of what each can do: side wind (0.1): "));
}

#[test]
fn claims_of_a_guaranteed_threshold_beyond_its_proof_are_refused() {
    for pointer in [
        "/detector/evaluation/threshold",
        "/threshold/guaranteed/bound",
        "/threshold/guaranteed/inputs/0/j",
        "/threshold/guaranteed/inputs/2/j",
    ] {
        refused!(guaranteed_times(pointer, 0.5), Refusal::Claim { .. });
    }
    refused!(guaranteed_times("/threshold/guaranteed/inputs/1/j", -1.0), Refusal::Claim { .. });
    refused!(
        guaranteed_times("/threshold/guaranteed/inputs/0/bound", 0.5),
        Refusal::Disagreement { .. }
    );
}

#[test]
fn altered_numbers_of_a_peak_certificate_are_refused() {
    for input in 0..3 {
        for (number, factor) in [
            ("lambda", 0.9),
            ("gain", 0.9),
            ("energy", 0.5),
            ("P/0/0/0", 0.1),
            ("P/3/1/1", 10.0),
            ("V/1/1/1", 0.1),
            ("V/2/2/2", 10.0),
        ] {
            let pointer = format!("/certificate/peaks/{input}/{number}");
            broken(guaranteed_times(&pointer, factor), Family::Peak(input));
        }
        let pointer = format!("/certificate/peaks/{input}/lambda");
        refused!(guaranteed_times(&pointer, 1.2), Refusal::Range { .. });
        refused!(
            forged(GUARANTEED, |design| {
                each(design, &[&format!("/certificate/peaks/{input}/P/0/0/1")], |x| x + 1e-3);
            }),
            Refusal::NotSymmetric { .. }
        );
    }
    let swapped = forged(GUARANTEED, |design| {
        swap(design, "/certificate/peaks/0", "/certificate/peaks/2");
    });
    refused!(swapped, Refusal::Claim { .. } | Refusal::Broken { .. });
}

#[test]
fn guaranteed_threshold_stands_for_the_bounds_of_the_specification() {
    // Larger bounds than those that were proven for.
    let louder = |specified: &str, claimed: &str| {
        forged(GUARANTEED, |design| each(design, &[specified, claimed], |x| 1.5 * x))
    };
    for (specified, claimed) in [
        ("/spec/noise/r/bound_rad_per_s", "/threshold/guaranteed/inputs/2/bound"),
        ("/spec/noise/v_x/bound_m_per_s", "/threshold/guaranteed/inputs/1/bound"),
    ] {
        refused!(louder(specified, claimed), Refusal::Broken { .. } | Refusal::Claim { .. });
    }
    // A longer window is proven for less than a shorter one: the other way round is refused.
    let shorter = forged(GUARANTEED, |design| {
        *at(design, "/detector/evaluation/window") = json!(10);
        at(design, "/spec/evaluation")["window_samples"] = json!(10);
    });
    refused!(shorter, Refusal::Claim { .. });
    refused!(
        forged(GUARANTEED, |design| *at(design, "/detector/evaluation/window") = json!(400)),
        Refusal::Disagreement { .. }
    );
    // Noise that is white only.
    let unbounded = with_forged_hash(|design| {
        *at(design, "/spec/noise/r/white_std_rad_per_s") = json!(0.002);
        *at(design, "/detector/staleness/after_s") = json!(0.2);
        *at(design, "/detector/staleness/r_jump_rad_per_s") = json!(20.0 * 0.01 + 8.5 * 0.002);
        *at(design, "/spec/evaluation/threshold") = json!("guaranteed");
        *at(design, "/threshold/kind") = json!("guaranteed");
    });
    refused!(unbounded, Refusal::UnboundedNoise { sensor: "r" });
}

#[test]
fn guaranteed_threshold_without_its_proof_is_refused() {
    for (pointer, key) in [
        ("/certificate/peaks", "certificate.peaks"),
        ("/threshold/guaranteed", "threshold.guaranteed"),
    ] {
        let without = forged(GUARANTEED, |design| *at(design, pointer) = Value::Null);
        let Err(Refusal::NoCertificate { key: missing }) = without else { panic!("{without:?}") };
        assert_eq!(missing, key);
    }
    let fewer = forged(GUARANTEED, |design| {
        at(design, "/certificate/peaks").as_array_mut().unwrap().pop();
    });
    refused!(fewer, Refusal::Shape { .. });
    // A kind that is claimed in one place only, and a claim under another kind.
    let kinds = ["/threshold/kind", "/spec/evaluation/threshold"];
    let renamed = |pointers: &[&str]| {
        forged(GUARANTEED, |design| {
            for pointer in pointers {
                *at(design, pointer) = json!("constant");
            }
        })
    };
    for kind in kinds {
        refused!(renamed(&[kind]), Refusal::Disagreement { .. });
    }
    refused!(renamed(&kinds), Refusal::OtherCause { .. });
    refused!(
        with_forged_hash(|design| {
            for pointer in kinds {
                *at(design, pointer) = json!("guaranteed");
            }
        }),
        Refusal::NoCertificate { .. }
    );
}
