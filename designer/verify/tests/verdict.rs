//! What the verdict says of a design, held against the numbers in its file.

#![allow(clippy::unwrap_used)]

mod common;

use common::{GAP, GUARANTEED, NOISE, PAPER, parsed};
use serde_json::{Value, json};
use steerguard_verify::{Verdict, content_hash, verify};

/// How many of the lines contain every part.
fn with(lines: &[String], parts: &[&str]) -> usize {
    lines.iter().filter(|line| parts.iter().all(|part| line.contains(part))).count()
}

/// The gain of each band, and that of all.
fn gains(design: &Value, verdict: &Verdict) {
    let bands = design["certificate"]["a_posteriori"]["gamma"].as_array().unwrap();
    for band in bands {
        let stated = format!("||W_r r|| < {} ||d|| per unit", band["gain"].as_f64().unwrap());
        assert_eq!(with(&verdict.statements, &[&stated]), 1, "{stated}");
    }
    assert_eq!(with(&verdict.statements, &["||d|| per unit"]), bands.len());
    // Fault and disturbances up to 1.5 Hz in each of the files; what else there is has all frequencies.
    let theta =
        std::f64::consts::TAU * 1.5 * design["spec"]["sampling"]["period_s"].as_f64().unwrap();
    let condition = format!("<= 4 sin^2({theta:.6} / 2) sum e e'");
    assert_eq!(with(&verdict.statements, &["whose error obeys sum", &condition]), 2);
    let gamma = format!("gamma = {}", verdict.figures.unwrap().gamma);
    let of_one = with(&verdict.statements, &[&gamma, "for all disturbances"]);
    let of_several = with(&verdict.statements, &[&gamma, "root of the sum of squares"]);
    let expected = if bands.len() == 1 { (1, 0) } else { (0, 1) };
    assert_eq!((of_one, of_several), expected, "{:?}", verdict.statements);
}

/// Counts of what was simulated, which nobody proves.
fn simulated(design: &Value, verdict: &Verdict) {
    let courses = design["performance"]["sight"]["courses"].as_array().unwrap();
    let straight: Vec<_> =
        courses.iter().filter(|x| x["lateral_acceleration_m_per_s2"] == 0.0).collect();
    let seen = straight.iter().filter(|x| x["faults"][0]["seen"] == true).count();
    let expected = format!("was seen on {seen} of {} straight courses", straight.len());
    let found = with(&verdict.unchecked, &["`performance.sight`", &expected]);
    assert_eq!(found, 1, "{:?}", verdict.unchecked);
}

/// What a guaranteed threshold covers: each input with its bound and what it does.
fn covered(design: &Value, verdict: &Verdict) {
    let guaranteed = &design["threshold"]["guaranteed"];
    let stated = ["Without a fault", "every input within its bound at every sample"];
    assert_eq!(with(&verdict.statements, &stated), usize::from(guaranteed.is_object()));
    if let Some(inputs) = guaranteed["inputs"].as_array() {
        let bound = format!("J < {} plus the start-up term", guaranteed["bound"].as_f64().unwrap());
        assert_eq!(with(&verdict.statements, &[&bound]), 1);
        for x in inputs {
            let [of, j] = ["bound", "j"].map(|key| x[key].as_f64().unwrap());
            let part = format!("{} ({of}): {j}", x["name"].as_str().unwrap());
            assert_eq!(with(&verdict.statements, &[&bound, &part]), 1, "{part}");
        }
    }
}

/// Whether the threshold is named as one that was specified.
fn specifies_its_threshold(verdict: &Verdict) -> bool {
    with(&verdict.unchecked, &["`spec.evaluation.constant`", "as specified"]) == 1
}

/// One test, so that each file is proven once: that takes most of a second.
#[test]
fn what_is_said_of_a_design_is_what_its_file_says() {
    for text in [PAPER, GAP, NOISE, GUARANTEED] {
        let design = parsed(text);
        let verdict = verify(text).unwrap();
        gains(&design, &verdict);
        simulated(&design, &verdict);
        covered(&design, &verdict);
        assert!(!specifies_its_threshold(&verdict));
        let is_blind = design["synthesis"]["status"] == "blind";
        assert_eq!(verdict.is_blind(), is_blind);
        assert_eq!(verdict.to_string().contains("blind, as it says of itself"), is_blind);
        assert!(verdict.is_certified());
    }
}

#[test]
fn a_threshold_that_was_specified_is_named() {
    let mut design = parsed(PAPER);
    design["spec"]["evaluation"]["threshold"] = json!("constant");
    design["spec"]["evaluation"]["constant"] =
        design["detector"]["evaluation"]["threshold"].clone();
    design["threshold"]["kind"] = json!("constant");
    design["threshold"]["calibration"] = Value::Null;
    // Without figures to prove, which is the longer part.
    design["synthesis"]["status"] = json!("uncertified");
    design["performance"]["certified"] = Value::Null;
    design["certificate"]["a_posteriori"] = Value::Null;
    design["hash"] = content_hash(&design).unwrap().into();
    let verdict = verify(&design.to_string()).unwrap();
    assert!(specifies_its_threshold(&verdict));
    assert!(!verdict.is_certified());
}
