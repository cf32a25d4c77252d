//! Random calls on the packaged library, seeded: five seconds of what `examples/fuzz.rs` does for as
//! long as wanted.
#![allow(clippy::unwrap_used)]

mod common;

use std::time::Duration;

use common::{Packaged, VARIABLES};
use steerguard_conformance_tests::random_calls::{self, Fmu};
use steerguard_fmi2::Function;

#[test]
fn random_calls_break_no_promise() {
    let packaged = Packaged::new();
    let (functions, _code) = packaged.load();
    let fmu = Fmu {
        functions: &functions,
        guid: &packaged.guid,
        variables: VARIABLES,
        sample_period_s: packaged.sample_period_s(),
    };
    let (runs, summary) = random_calls::run_for(fmu, 0, Duration::from_secs(5), |_, _| {});
    println!("{runs} runs: {summary}");

    let answered = |function: &Function, status| {
        let position = Function::ALL.iter().position(|other| other == function).unwrap();
        summary.answers.contains(&(position, status))
    };
    // Those that return no status, and those that succeed in no state.
    use Function::*;
    let silent = [fmi2GetTypesPlatform, fmi2GetVersion, fmi2Instantiate, fmi2FreeInstance];
    for function in Function::ALL.iter().filter(|function| !silent.contains(function)) {
        assert!(answered(function, 3), "{} was never refused", function.name());
        let succeeds = !random_calls::NEVER_SUCCEED.contains(function);
        assert_eq!(answered(function, 0), succeeds, "{} answered fmi2OK", function.name());
    }
    assert!(summary.restored > 0);
}
