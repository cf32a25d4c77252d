//! Calls of FMI 2.0 in any order with any arguments on the detector FMU, linked into this program: what is
//! asserted stands in `steerguard_conformance_tests::random_calls`.

use steerguard_conformance_tests::Functions;
use steerguard_conformance_tests::random_calls::{self, Fmu};
use steerguard_fmu::DetectorModel;
use steerguard_model_description::VariableSet;
use steerguard_model_description::detector::DetectorVariable;

use crate::unsolved::{BLOCK, GUID};

steerguard_fmi2::export_fmi2!(DetectorModel, block = &BLOCK);

static FUNCTIONS: Functions = steerguard_conformance_tests::linked_functions!();

pub fn run(bytes: &[u8]) {
    let fmu = Fmu {
        functions: &FUNCTIONS,
        guid: GUID,
        variables: DetectorVariable::TABLE,
        sample_period_s: 0.01,
    };
    random_calls::run(fmu, bytes);
}
