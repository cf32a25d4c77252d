//! Changed design files: refused by their hash, and with a forged hash wherever a proof breaks.
//!
//! `fixtures/paper.json` is what `steerguard design examples/paper.toml` wrote once: the format's files stay provable.

#![allow(clippy::unwrap_used, clippy::panic)]

use serde_json::{Value, json};
use steerguard_verify::{Family, Refusal, Verdict, content_hash, verify};

const PAPER: &str = include_str!("fixtures/paper.json");

fn paper() -> Value {
    serde_json::from_str(PAPER).unwrap()
}

fn verified(design: &Value) -> Result<Verdict, Refusal> {
    verify(&design.to_string())
}

/// The paper's design with a change, refused by its hash; then proven or not with a forged one.
fn with_forged_hash(change: impl FnOnce(&mut Value)) -> Result<Verdict, Refusal> {
    let mut design = paper();
    change(&mut design);
    assert!(matches!(verified(&design), Err(Refusal::Hash { .. })));
    design["hash"] = content_hash(&design).into();
    verified(&design)
}

fn at<'a>(design: &'a mut Value, pointer: &str) -> &'a mut Value {
    design.pointer_mut(pointer).unwrap_or_else(|| panic!("{pointer}"))
}

/// Refusal of the file whose numbers at `pointers` were changed.
fn changed(pointers: &[&str], change: impl Fn(f64) -> f64) -> Result<Verdict, Refusal> {
    with_forged_hash(|design| {
        for pointer in pointers {
            let number = at(design, pointer);
            *number = change(number.as_f64().unwrap()).into();
        }
    })
}

fn plus(pointer: &str, difference: f64) -> Result<Verdict, Refusal> {
    changed(&[pointer], |x| x + difference)
}

fn times(pointer: &str, factor: f64) -> Result<Verdict, Refusal> {
    changed(&[pointer], |x| x * factor)
}

fn swapped(a: &str, b: &str) -> Result<Verdict, Refusal> {
    with_forged_hash(|design| {
        let taken = at(design, a).take();
        let other = std::mem::replace(at(design, b), taken);
        *at(design, a) = other;
    })
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

fn broken(result: Result<Verdict, Refusal>, expected: Family) {
    let Err(Refusal::Broken { family, .. }) = result else { panic!("{result:?}") };
    assert_eq!(family, expected);
}

#[test]
fn papers_design_is_proven() {
    let verdict = verify(PAPER).unwrap();
    assert!((verdict.figures.gap - 18.315).abs() < 0.002);
    assert!(verdict.figures.gamma < verdict.figures.gamma_full_band);
    assert_eq!(verdict.figures.decay, 0.97);
    let counts: Vec<usize> = verdict.margins.iter().map(|margin| margin.inequalities).collect();
    // 4 rules + 4 rules x 4 successors x 2 rho; Q + 10 pairs of rules x 4 successors x 2 rho.
    assert_eq!(counts, [36, 36, 81, 81, 80]);
    for margin in &verdict.margins {
        assert!(margin.smallest_pivot > 1e-8 && margin.smallest_pivot <= 1.0, "{margin:?}");
    }
    assert!(verdict.residues.observer_equation < 1e-14);
    let text = verdict.to_string();
    for part in ["certified", "<= 4 sin^2(0.094248 / 2) sum e e'", "Unconditionally", "0.97^k"] {
        assert!(text.contains(part), "{text}");
    }
}

#[test]
fn layout_order_of_keys_and_notation_are_free() {
    let compact = paper().to_string();
    let other_notation = PAPER.replacen("\"window\": 40,", "\"window\": 4.0e1,", 1);
    assert_ne!(other_notation, PAPER);
    let hash = verify(PAPER).unwrap().hash;
    for text in [compact, other_notation] {
        assert_eq!(verify(&text).unwrap().hash, hash);
    }
}

#[test]
fn changed_gains_are_refused() {
    for gain in ["/vertices/3/N/1/1", "/vertices/0/L/1/0", "/vertices/2/H/2/1", "/M/1/2", "/E/2/0"]
    {
        refused!(plus(gain, 1e-9), Refusal::Residue { .. });
    }
    refused!(swapped("/vertices/0/N", "/vertices/1/N"), Refusal::Residue { .. });
}

#[test]
fn gains_changed_together_with_the_observer_equation_intact_break_the_proof() {
    // N_3 and L_3 of another H_3: still an observer, not the certified one.
    let result = with_forged_hash(|design| {
        let e = at(design, "/E").clone();
        let difference = 0.02;
        for (gain, change) in [
            ("/vertices/3/H/1/1".to_string(), difference),
            ("/vertices/3/N/1/2".to_string(), -difference),
        ] {
            let number = at(design, &gain);
            *number = (number.as_f64().unwrap() + change).into();
        }
        // L = H - N E, row 1.
        for column in 0..2 {
            let e = e[2][column].as_f64().unwrap();
            let own = if column == 1 { difference } else { 0.0 };
            let number = at(design, &format!("/vertices/3/L/1/{column}"));
            *number = (number.as_f64().unwrap() + own + difference * e).into();
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
    refused!(plus("/C/1/1", 1e-3), Refusal::Contradiction { .. });
    refused!(plus("/vehicle/mass_kg", 1.0), Refusal::Contradiction { .. });
    let both = ["/vehicle/mass_kg", "/spec/vehicle/mass_kg"];
    refused!(changed(&both, |x| x + 1.0), Refusal::Model { .. });
    let both = ["/sampling_period_s", "/spec/sampling/period_s"];
    refused!(changed(&both, |x| 2.0 * x), Refusal::Model { .. });
    refused!(times("/spec/disturbance/0/acting_ahead_m", 2.0), Refusal::Model { .. });
}

#[test]
fn wider_ranges_and_bands_are_refused() {
    // A little beyond the range of v_y only the start-up's amplitude is too small, far beyond it
    // the error may grow.
    let v_y = |factor: f64| {
        let pointers = ["/premise/v_y_m_per_s/0", "/spec/operating_range/v_y_m_per_s/0"];
        changed(&pointers, |x| factor * x)
    };
    refused!(v_y(1.001), Refusal::Claim { key: "evaluation.start_up.amplitude", .. });
    refused!(v_y(100.0), Refusal::Broken { .. });
    let speed = ["/premise/v_x_m_per_s/0", "/spec/operating_range/v_x_m_per_s/0"];
    refused!(changed(&speed, |x| x - 0.5), Refusal::Model { .. });
    refused!(changed(&speed, |x| -x), Refusal::Range { .. });
    let upper = ["/spec/fault/0/band_hz/1", "/spec/disturbance/0/band_hz/1"];
    refused!(times(upper[0], 1.1), Refusal::Cosine { family: Family::FaultSensitivity, .. });
    refused!(times(upper[1], 1.1), Refusal::Cosine { family: Family::DisturbanceAttenuation, .. });
    refused!(plus("/spec/fault/0/band_hz/0", 0.1), Refusal::Band { .. });
}

#[test]
fn better_figures_are_refused() {
    let certified = |key: &str| format!("/performance/certified/{key}");
    broken(times(&certified("beta"), 1.01), Family::FaultSensitivity);
    broken(times(&certified("gamma_full_band"), 0.99), Family::FullBandAttenuation);
    broken(times(&certified("decay"), 0.95), Family::Decay);
    refused!(times(&certified("decay"), 1.1), Refusal::Range { .. });
    refused!(times(&certified("gap"), 1.01), Refusal::Claim { .. });
    refused!(times(&certified("gamma"), 1.01), Refusal::Claim { .. });
    broken(times(&certified("gamma"), 0.99), Family::DisturbanceAttenuation);
    refused!(times(&certified("gamma"), -1.0), Refusal::NotPositive { .. });
    // The gap counts faults and disturbances in units of what is stated.
    refused!(times("/spec/disturbance/0/bound_m_per_s2", 1.01), Refusal::Claim { .. });
    refused!(times("/spec/fault/0/smallest_deg", 0.99), Refusal::Claim { .. });
    refused!(times("/evaluation/start_up/amplitude", 0.99), Refusal::Claim { .. });
    broken(times("/evaluation/start_up/decay", 0.9), Family::StartUp);
    broken(times("/evaluation/weights/1", 1.1), Family::StartUp);
}

#[test]
fn changed_certificates_are_refused() {
    let of = |pointer: &str| format!("/certificate/a_posteriori/{pointer}");
    refused!(plus(&of("beta/band/two_cos_theta"), 1e-12), Refusal::Cosine { .. });
    broken(plus(&of("gamma/band/two_cos_theta"), -0.1), Family::DisturbanceAttenuation);
    refused!(plus(&of("beta/P/0/0/1"), 1e-3), Refusal::NotSymmetric { .. });
    refused!(plus(&of("gamma/band/Q/0/1"), 1e-3), Refusal::NotSymmetric { .. });
    broken(
        replaced(&of("beta/band/Q"), json!([[0, 0, 0], [0, 0, 0], [0, 0, 0]])),
        Family::FaultSensitivity,
    );
    broken(replaced(&of("gamma/band"), Value::Null), Family::DisturbanceAttenuation);
    broken(plus(&of("gamma/P/1/2/2"), 1.0), Family::DisturbanceAttenuation);
    broken(plus(&of("gamma_full_band/X/2/1/0/1"), 1.0), Family::FullBandAttenuation);
    broken(swapped(&of("beta/X/0/0"), &of("beta/X/3/3")), Family::FaultSensitivity);
    refused!(replaced(&of("beta/X/1/1"), json!([[0, 0, 0]])), Refusal::Shape { .. });
    broken(swapped(&of("gamma"), &of("gamma_full_band")), Family::DisturbanceAttenuation);
    broken(swapped("/certificate/P_s/0", "/certificate/P_s/3"), Family::Decay);
    broken(times("/certificate/P_s/2/2/2", -1.0), Family::Decay);
    for key in ["/certificate/a_posteriori", "/performance/certified"] {
        refused!(replaced(key, Value::Null), Refusal::NoCertificate { .. });
    }
}

/// Changes that a forged hash hides, because what the file then claims is still true, or is no
/// claim of the proof.
#[test]
fn changes_that_leave_a_theorem() {
    // Weaker claims follow from the one that was proven: a narrower band or range, a smaller gap.
    times("/spec/fault/0/band_hz/1", 0.9).unwrap();
    let v_y = ["/premise/v_y_m_per_s/0", "/spec/operating_range/v_y_m_per_s/0"];
    changed(&v_y, |x| 0.9 * x).unwrap();
    times("/performance/certified/gap", 0.99).unwrap();
    times("/performance/certified/gamma_full_band", 1.01).unwrap();
    // One unit in the last place of a gain is within the residues that the verdict states, and the
    // inequalities are those of the changed gain.
    changed(&["/vertices/3/N/1/1"], f64::next_up).unwrap();
    // Measured on simulations or grids, not proven: only the hash protects them.
    times("/evaluation/threshold", 2.0).unwrap();
    times("/performance/frozen/gap", 2.0).unwrap();
    replaced("/synthesis/solver", "another".into()).unwrap();
}

#[test]
fn what_is_no_design_file_is_unreadable() {
    for text in ["", "{", "[]", "null", "{}"] {
        let result = verify(text);
        let unreadable = matches!(result, Err(Refusal::Unreadable(_) | Refusal::Format { .. }));
        assert!(unreadable, "{text}: {result:?}");
    }
    let format = PAPER.replacen("steerguard-design/1", "steerguard-design/2", 1);
    refused!(verify(&format), Refusal::Format { .. });
    let incomplete = with_forged_hash(|design| {
        design.as_object_mut().unwrap().remove("M");
    });
    refused!(incomplete, Refusal::Unreadable(_));
}
