//! Random calls on the packaged detector library for a given time: `fuzz [SECONDS [SEED]]`.
//!
//! Runs are numbered from SEED on and each is made from its number alone: if run N ends the process,
//! `fuzz 1 N` begins with it.
#![allow(clippy::unwrap_used)]

#[path = "../tests/common/mod.rs"]
mod common;

use std::time::Duration;

use common::{Packaged, VARIABLES};
use steerguard_conformance_tests::random_calls::{Fmu, run_for};

fn main() {
    let mut arguments = std::env::args().skip(1).map(|argument| argument.parse::<u64>().unwrap());
    let seconds = arguments.next().unwrap_or(60);
    let seed = arguments.next().unwrap_or(0);

    let packaged = Packaged::new();
    let (functions, _code) = packaged.load();
    let fmu = Fmu {
        functions: &functions,
        guid: &packaged.guid,
        variables: VARIABLES,
        sample_period_s: packaged.sample_period_s(),
    };
    let started = std::time::Instant::now();
    let mut shown = 0;
    let (runs, summary) = run_for(fmu, seed, Duration::from_secs(seconds), |run, summary| {
        let now = started.elapsed().as_secs() / 10;
        if now > shown {
            shown = now;
            println!("{:4} s: run {run}, {summary}", 10 * now);
        }
    });
    println!("{runs} runs from {seed}, {:.0} per second: {summary}", runs as f64 / seconds as f64);
}
