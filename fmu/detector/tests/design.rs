//! A design as bytes.

#![allow(clippy::unwrap_used)]

mod common;

use common::design;
use steerguard_detector::Configuration;
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
    let Configuration { model, evaluation, deviations, actuator, zero, staleness, .. } =
        &mut design.configuration;
    let uncertainty = &mut deviations.uncertainty;
    for (i, number) in [
        &mut model.vehicle.centre_of_gravity_height_m,
        &mut evaluation.uncertainty_share,
        &mut evaluation.alarm_hold_s,
        &mut actuator.lag_s,
        &mut actuator.delay_s,
        actuator.angle_limit_rad.insert(0.0),
        &mut uncertainty.mass,
        &mut uncertainty.yaw_inertia,
        &mut uncertainty.front_cornering_stiffness,
        &mut uncertainty.rear_cornering_stiffness,
        uncertainty.friction.insert(0.0),
        &mut uncertainty.load_transfer,
        &mut uncertainty.bank_m_per_s2,
        &mut uncertainty.gust.speed_m_per_s,
        &mut uncertainty.gust.coefficient_n_s2_per_m2,
        &mut uncertainty.gust.acting_ahead_m,
        &mut uncertainty.actuator_lag_s,
        &mut uncertainty.actuator_delay_s,
        &mut uncertainty.steering_ratio,
        &mut uncertainty.steering_offset_rad,
        &mut uncertainty.yaw_rate_bias_rad_per_s,
        &mut uncertainty.v_x_scale,
        &mut zero.steering_offset_rad,
        &mut zero.yaw_rate_bias_rad_per_s,
        &mut staleness.after_s,
        &mut staleness.v_x_jump_m_per_s,
        &mut staleness.r_jump_rad_per_s,
    ]
    .into_iter()
    .enumerate()
    {
        *number = 1.0 / (i + 300) as f64;
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
