//! Ten million steps of the packaged detector, or as many as asked for: `endurance [STEPS]`. Prints
//! the processor time that a set-step-get cycle takes in each tenth of the run.
#![allow(clippy::unwrap_used)]

#[path = "../tests/common/mod.rs"]
mod common;

use std::ffi::c_long;

use common::Packaged;
use common::drive::inputs;
use common::raw::Raw;
use steerguard_conformance_tests::host;
use steerguard_fmi2::types::fmi2Status;

/// The drive repeats after this many samples; its inputs are computed beforehand.
const ROUND: u64 = 6000;

unsafe extern "C" {
    /// Processor time of this process, in microseconds by POSIX.
    fn clock() -> c_long;
}

fn processor_time_us() -> c_long {
    // SAFETY: the C library's function has no preconditions.
    unsafe { clock() }
}

fn main() {
    let steps = std::env::args().nth(1).map_or(10_000_000, |steps| steps.parse().unwrap());
    let packaged = Packaged::new();
    let (functions, _code) = packaged.load();
    let period_s = packaged.sample_period_s();
    let round: Vec<[f64; 4]> = (0..ROUND).map(|k| inputs(k as f64 * period_s)).collect();

    let raw = Raw::new(&functions, &packaged.guid, "endurance");
    let created = host::counts();
    let tenth = steps / 10;
    println!("{tenth} steps each, ns per step:");
    for part in 0..10 {
        let started = processor_time_us();
        let mut sum = 0_u64;
        for k in part * tenth..(part + 1) * tenth {
            raw.set(&round[(k % ROUND) as usize]);
            assert!(raw.step(k as f64 * period_s, period_s) <= fmi2Status::fmi2Warning);
            sum = sum.wrapping_add(raw.results().into_iter().fold(0, u64::wrapping_add));
        }
        let nanoseconds = 1e3 * (processor_time_us() - started) as f64 / tenth as f64;
        println!("  {:2}: {nanoseconds:7.1}   checksum {sum:016x}", part + 1);
    }
    let counts = host::counts();
    assert_eq!((counts.allocations, counts.frees), (created.allocations, created.frees));
}
