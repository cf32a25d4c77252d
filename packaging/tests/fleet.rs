//! Cars of the fleet, as unlike as they are, with default keys: `tests/fleet/run` tries all of them.

#![allow(clippy::unwrap_used)]

use std::path::PathBuf;

#[path = "common/fleet/mod.rs"]
mod fleet;

use fleet::cars::fleet;
use fleet::trial::Trials;
use steerguard_designer::DesignStatus;

/// Drives with biases of a car, and as many without a fault.
const DRIVES: u64 = 20;

/// The car called `name` is designed, proven, packaged and sees its smallest fault, or what bank and wind do
/// not hide; no fault is missed, no alarm is false.
fn assert_served(name: &str) {
    let car = fleet(true).unwrap().into_iter().find(|car| car.name == name).unwrap();
    let steerguard = PathBuf::from(env!("CARGO_BIN_EXE_steerguard"));
    let trials = Trials { steerguard, drives: DRIVES, seed: 1 }.of(car.spec().unwrap()).unwrap();
    let made = trials.last().unwrap().made.as_ref().unwrap();
    assert_eq!(made.design.synthesis.status, DesignStatus::Certified);
    assert!(made.proven);
    assert_eq!(made.findings, 0, "of check");
    assert_eq!((made.biases.faults, made.biases.detected), (DRIVES, DRIVES), "{:?}", made.biases);
    assert_eq!(made.fault_free.with_alarm, 0, "{:?}", made.fault_free);
    assert!(made.fault_free.monitored >= 0.9, "{:?}", made.fault_free);
}

macro_rules! served {
    ($($test:ident: $name:literal,)*) => {
        $(
            #[test]
            fn $test() {
                assert_served($name);
            }
        )*
    };
}

served! {
    one_that_steers_neutrally: "BMW 320i (CommonRoad 2)",
    one_with_stiff_rear_tyres: "Volvo S90 (identified)",
    one_that_is_slow: "saloon of a teaching laboratory",
    one_for_the_city: "small car, city",
    one_for_races: "Ferrari 250 LM, race",
    one_that_steers_late: "single-seater, automated race car",
    one_with_a_delay_that_steers_neutrally: "RAV4, neutral",
    one_that_oversteers: "VW Vanagon (CommonRoad 3), C_f x 1.2, C_r x 0.8",
}
