//! Threshold kind "guaranteed": against worst-found drives, an independent solver, and the exact proof.

#![allow(clippy::unwrap_used)]

#[path = "common/adversary.rs"]
mod adversary;
#[path = "common/few_drives.rs"]
mod few_drives;

use rayon::prelude::*;
use steerguard_designer::{Design, Spec};

use adversary::{Inputs, drive, largest_j};
use few_drives::designed_with_few_drives;

/// Largest J of 1000 worst-found drives.
fn worst_found(design: &Design) -> f64 {
    let inputs = Inputs::of(design);
    let j = (0..1000_u64).into_par_iter().map(|index| {
        let (course, signals) = drive(design, &inputs, index);
        largest_j(design, &inputs, &course, &signals)
    });
    j.reduce(|| 0.0, f64::max)
}

fn guaranteed(text: &str) -> Design {
    designed_with_few_drives(Spec::from_toml(text).unwrap()).unwrap()
}

fn holds(text: &str) {
    let t = std::time::Instant::now();
    let design = guaranteed(text);
    println!("{:?} designed", t.elapsed());
    let bound = design.evaluation.guaranteed.as_ref().unwrap();
    println!("{bound:#?}");
    println!(
        "{:?}",
        design
            .certificate
            .peaks
            .as_ref()
            .unwrap()
            .iter()
            .map(|p| (p.lambda, p.gain, p.energy))
            .collect::<Vec<_>>()
    );
    let largest = worst_found(&design);
    println!(
        "bound {} largest {largest} ratio {} {:?}",
        bound.bound,
        bound.bound / largest,
        t.elapsed()
    );
    assert!(largest < bound.bound);
}

#[test]
fn paper() {
    holds(
        &(include_str!("../../examples/paper.toml")
            .replace("threshold = \"calibrated\"", "threshold = \"guaranteed\"")),
    );
}

#[test]
fn noise() {
    holds(
        "evaluation.threshold = \"guaranteed\"\nnoise.v_x.bound_m_per_s = 0.06\nnoise.r.bound_rad_per_s = 0.006\n[design]\nsearch_budget = 1",
    );
}
#[test]
fn van() {
    holds(&format!(
        "{}\n[evaluation]\nthreshold = \"guaranteed\"\n[noise.v_x]\nwhite_std_m_per_s = 0.0\n",
        include_str!("../../examples/van.toml").split("[evaluation]").next().unwrap()
    ));
}
