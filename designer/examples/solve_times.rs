//! Time of a synthesis: the smallest gamma at 0.97 of the bound on beta.
//!
//! Prints a line of JSON for each problem; with the argument "growth" for problems of growing size.
//! `tests/bench/solve_times.py` compares these times with those of a modelling language and draws
//! them.

use std::error::Error;
use std::time::Instant;

use steerguard_designer::Spec;
use steerguard_designer::problem::inputs::Inputs;
use steerguard_designer::synthesis::solve::{Goal, solve};
use steerguard_designer::synthesis::theorem4::Theorem4;

/// Lateral and yaw acceleration of each disturbance, at a bound of 1: the first two are those of S1
/// (method 7).
const DIRECTIONS: [[f64; 2]; 5] = [[0.5, 0.0], [0.0, 0.1], [0.3, 0.06], [0.3, -0.06], [0.1, 0.08]];
/// Upper ends of bands, Hz.
const BANDS: [f64; 5] = [1.5, 1.25, 1.0, 0.75, 0.5];
const NOISE: &str = "[noise.r]\nbound_rad_per_s = 0.002\nband_hz = [0.0, 1.5]\n";
/// All vertices of K.
const ALL: usize = 16;
/// Decay rate, a sample.
const DECAY: f64 = 0.97;

fn main() -> Result<(), Box<dyn Error>> {
    if std::env::args().nth(1).as_deref() != Some("growth") {
        report("paper", 1, "", ALL)?;
        return report("two disturbances", 2, &disturbances(&[1.5; 2]), ALL);
    }
    for size in 1..=DIRECTIONS.len() {
        report("disturbances in one band", size, &disturbances(&[1.5; 5][..size]), ALL)?;
        report("bands", size, &disturbances(&BANDS[..size]), ALL)?;
    }
    for size in [1, 2, 4, 8, ALL] {
        report("vertices of K", size, &(disturbances(&[1.5]) + NOISE), size)?;
    }
    Ok(())
}

/// A specification with disturbances from 0 to the given frequencies.
fn disturbances(up_to_hz: &[f64]) -> String {
    let channels = DIRECTIONS.iter().zip(up_to_hz).map(|([lateral, yaw], hz)| {
        format!(
            "[[disturbance]]\nkind = 'direction'\nname = 'd'\nbound = 1.0\n\
             direction = [0.0, {lateral}, {yaw}]\nband_hz = [0.0, {hz}]\n"
        )
    });
    channels.collect()
}

/// Solves the problem of a specification with the first vertices of K, and prints its time.
fn report(series: &str, size: usize, spec: &str, vertices: usize) -> Result<(), Box<dyn Error>> {
    let mut spec = Spec::from_toml(spec)?;
    spec.evaluation.weights = Spec::paper().evaluation.weights;
    let inputs = Inputs::of(&spec)?;
    let start = Instant::now();
    let mut theorem = Theorem4::of(&spec, &inputs, DECAY);
    theorem.k.truncate(vertices);
    let beta = spec.design.beta_fraction * theorem.beta_bound();
    let synthesis = solve(&theorem, Goal::SmallestGamma { beta: Some(beta) })?;
    let seconds = start.elapsed().as_secs_f64();
    let line = serde_json::json!({
        "series": series, "size": size, "seconds": seconds, "iterations": synthesis.iterations,
        "beta": beta, "gamma": synthesis.gamma,
    });
    println!("{line}");
    Ok(())
}
