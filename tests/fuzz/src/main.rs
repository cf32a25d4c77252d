//! Bytes chosen by coverage, given to the target that the variable `STEERGUARD_TARGET` names: see
//! `steerguard_corpora`.
#![no_main]

use std::env;
use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;

static TARGET: LazyLock<fn(&[u8])> = LazyLock::new(|| {
    let name = env::var("STEERGUARD_TARGET").unwrap_or_default();
    steerguard_corpora::target(&name)
});

fuzz_target!(|bytes: &[u8]| TARGET(bytes));
