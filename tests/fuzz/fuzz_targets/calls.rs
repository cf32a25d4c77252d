//! Calls in any order with any arguments, chosen by coverage, on the detector FMU linked into this
//! program: what is asserted stands in `steerguard_conformance_tests::random_calls`.
#![no_main]
#![allow(clippy::unwrap_used, reason = "this is test code")]

#[path = "../../../packaging/tests/common/mod.rs"]
mod common;

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use steerguard_conformance_tests::Functions;
use steerguard_conformance_tests::random_calls::{Fmu, run};
use steerguard_fmu::DetectorModel;
use steerguard_fmu_core::Block;
use steerguard_model_description::VariableSet;
use steerguard_model_description::detector::DetectorVariable;

static BLOCK: LazyLock<Block> = LazyLock::new(|| {
    let payload = common::design().encode().unwrap();
    Block::sealed("{fuzz}", &payload).unwrap()
});

steerguard_fmi2::export_fmi2!(DetectorModel, block = &BLOCK);

static FUNCTIONS: Functions = steerguard_conformance_tests::linked_functions!();

fuzz_target!(|bytes: &[u8]| {
    let fmu = Fmu {
        functions: &FUNCTIONS,
        guid: c"{fuzz}",
        variables: DetectorVariable::TABLE,
        sample_period_s: 0.01,
    };
    run(fmu, bytes);
});
