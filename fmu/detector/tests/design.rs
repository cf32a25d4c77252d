//! A design as bytes.

#![allow(clippy::unwrap_used)]

mod common;

use common::design;
use steerguard_fmu::{BakedDesign, DesignError};
use steerguard_fmu_core::PAYLOAD_CAPACITY;

#[test]
fn a_design_survives_its_encoding() {
    let mut design = design();
    // Every number another one, so that no two fields can be exchanged unnoticed.
    let gains = &mut design.configuration.gains;
    let numbers = gains.n.as_flattened_mut().as_flattened_mut().iter_mut();
    let numbers = numbers.chain(gains.l.as_flattened_mut().as_flattened_mut());
    let numbers = numbers.chain(gains.m.as_flattened_mut()).chain(gains.e.as_flattened_mut());
    for (i, number) in numbers.enumerate() {
        *number = 1.0 / (i + 3) as f64;
    }
    let bytes = design.encode().unwrap();
    assert_eq!(bytes.len(), BakedDesign::LENGTH);
    const { assert!(BakedDesign::LENGTH <= PAYLOAD_CAPACITY) };
    assert_eq!(BakedDesign::decode(&bytes).unwrap(), design);
}

#[test]
fn what_is_no_design_is_refused() {
    let bytes = design().encode().unwrap();
    for length in [0, 7, 8, bytes.len() - 1] {
        assert_eq!(BakedDesign::decode(&bytes[..length]), Err(DesignError::Format));
    }
    assert_eq!(BakedDesign::decode(&[&bytes[..], &[0]].concat()), Err(DesignError::Format));
    for place in [0, 4] {
        let mut other = bytes;
        other[place] ^= 1;
        assert_eq!(BakedDesign::decode(&other), Err(DesignError::Format));
    }
}

#[test]
fn impossible_designs_are_not_baked() {
    let refuse = |change: fn(&mut BakedDesign)| {
        let mut design = design();
        change(&mut design);
        design.encode().unwrap_err()
    };
    assert_eq!(refuse(|design| design.hash[0] = b'g'), DesignError::Hash);
    assert_eq!(refuse(|design| design.gap = f64::INFINITY), DesignError::Figure("gap"));
    assert_eq!(refuse(|design| design.beta = f64::NAN), DesignError::Figure("beta"));
    let error = refuse(|design| design.configuration.evaluation.window = 0);
    assert!(error.to_string().contains("window"), "{error}");
}
