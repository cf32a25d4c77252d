//! What designs see, and what no method can tell from a fault.

#![allow(clippy::unwrap_used, clippy::panic)]

use serde_json::{Value, json};
use steerguard_designer::sight::equivalent::equivalent_angle_rad;
use steerguard_designer::sight::{HiddenBy, Sight};
use steerguard_designer::{Design, DesignStatus, Spec};
use steerguard_detector::{Gust, Vehicle, VehicleState};
use steerguard_verify::{content_hash, verify};
use steerguard_world::{Excitation, STEP_S, State, Steering, TrueVehicle, World, bank_m_per_s2};

mod common;
#[path = "common/designed.rs"]
mod designed;

use designed::{designed, designed_with_few_drives};

/// Yaw rate and its like a second earlier, rad/s, and lateral speed likewise, m/s, 20 s after Table 1's car
/// began to drive straight with its wheel off by `fault_rad`.
fn steady(v_x: f64, bank_rad: f64, force_n: f64, ahead_m: f64, fault_rad: f64) -> [[f64; 2]; 2] {
    let vehicle = Vehicle::PAPER;
    let world = World { bank_rad, ..World::of(TrueVehicle::linear(vehicle), Steering::DIRECT) };
    let motion = VehicleState { v_x_m_per_s: v_x, v_y_m_per_s: 0.0, r_rad_per_s: 0.0 };
    let mut state = State::new(&world, STEP_S, motion, 0.0);
    let excitation = Excitation {
        drive_torque_n_m: vehicle.cruise_torque(v_x),
        command_rad: 0.0,
        fault_rad,
        // To the right.
        push: world.vehicle.push(-force_n, -force_n * ahead_m),
    };
    let mut at = |seconds: u32| {
        for _ in 0..seconds * 1000 {
            state.step(&world, &excitation, STEP_S);
        }
        [state.motion.r_rad_per_s, state.motion.v_y_m_per_s]
    };
    [at(19), at(1)]
}

/// Under bank or wind, and off by the closed form's angle, the car drives straight with its command at 0.
#[test]
fn what_bank_and_wind_look_like_drives_straight_in_the_world() {
    for v_x in [6.0, 15.0, 29.0] {
        for (bank_deg, force_n, ahead_m) in
            [(3.0, 0.0, 0.0), (-5.0, 0.0, 0.0), (0.0, 800.0, 0.25), (2.0, 500.0, 0.4)]
        {
            let bank_rad = f64::to_radians(bank_deg);
            // Positive with the left side raised, and then to the right.
            let to_the_right = -bank_m_per_s2(bank_rad);
            let f = equivalent_angle_rad(&Vehicle::PAPER, to_the_right, force_n, ahead_m);
            let [[_, _], [unsteered, _]] = steady(v_x, bank_rad, force_n, ahead_m, 0.0);
            let [[_, before], [r, v_y]] = steady(v_x, bank_rad, force_n, ahead_m, f);
            let case =
                format!("{bank_deg} deg, {force_n} N at {v_x} m/s: {r} of {unsteered} rad/s");
            assert!(unsteered.abs() > 1e-4, "{case}");
            assert!(r.abs() < 1e-3 * unsteered.abs(), "{case}");
            assert!((v_y - before).abs() < 1e-6 * v_y.abs(), "{case}: {before} to {v_y} m/s");
        }
    }
}

/// Values of method 12.
#[test]
fn table_1s_car_takes_bank_and_wind_for_small_angles() {
    let gust = Gust { speed_m_per_s: 10.0, coefficient_n_s2_per_m2: 2.64, acting_ahead_m: 0.25 };
    let deg = |bank: f64, force: f64| {
        equivalent_angle_rad(&Vehicle::PAPER, bank, force, gust.acting_ahead_m).to_degrees()
    };
    let bank = -bank_m_per_s2(3_f64.to_radians());
    assert!((deg(bank, 0.0) - 0.058).abs() < 5e-4, "{}", deg(bank, 0.0));
    for (v_x, expected) in [(6.0, 0.053), (15.0, 0.081), (29.0, 0.138)] {
        let found = deg(0.0, gust.side_force(v_x));
        assert!((found - expected).abs() < 5e-4, "{found} deg at {v_x} m/s");
    }
}

fn sight(design: &Design) -> &Sight {
    design.performance.sight.as_ref().unwrap()
}

#[test]
fn the_default_design_sees() {
    let design = designed(&Spec::default()).unwrap();
    assert_eq!(design.synthesis.status, DesignStatus::Certified);
    let sight = sight(&design);
    assert_eq!(sight.blind, None);
    assert_eq!(sight.courses.len(), 6);
    for course in &sight.courses {
        let sizes: Vec<f64> = course.faults.iter().map(|fault| fault.fault_deg).collect();
        assert_eq!(sizes, [0.5, 2.0, 5.0, 20.0]);
        assert!(course.faults.iter().all(|fault| !fault.false_alarm), "{course:?}");
        if course.is_judged() {
            assert!(course.faults.iter().all(|fault| fault.seen), "{course:?}");
            let delays = course.faults.iter().map(|fault| fault.delay_s.unwrap());
            let latest = [0.4, 0.2, 0.2, 0.2];
            assert!(delays.zip(latest).all(|(delay_s, latest)| delay_s <= latest), "{course:?}");
            assert!(course.seen_from_deg.unwrap() < 0.5, "{course:?}");
        }
    }
    // Table 1's car at the end of its range: 3 deg of bank and a gust of 10 m/s.
    assert!((sight.bank_and_wind_deg - 0.2).abs() < 0.01, "{}", sight.bank_and_wind_deg);
    assert_eq!(sight.told_from_deg(0.5), None);
    assert_eq!(sight.told_from_deg(0.3), Some(2.0 * sight.bank_and_wind_deg));
}

/// The default with a margin that makes up for few drives.
fn with_a_wide_margin() -> Spec {
    let mut spec = Spec::default();
    spec.evaluation.margin = 3.0;
    spec
}

/// What hides the smallest fault in a design of `spec`, which is blind.
fn blind(spec: &Spec) -> (Design, HiddenBy) {
    let design = designed_with_few_drives(spec.clone()).unwrap();
    assert_eq!(design.synthesis.status, DesignStatus::Blind);
    assert!(design.performance.certified.is_some(), "blind, not refuted");
    let blind = sight(&design).blind.as_ref().unwrap();
    assert!(blind.seen_from_deg.unwrap() > 0.5);
    let hidden = blind.hidden_by.clone().unwrap();
    (design, hidden)
}

#[test]
fn a_steep_bank_blinds_and_is_named() {
    let mut spec = with_a_wide_margin();
    spec.uncertainty.bank_deg = 20.0;
    let (_, hidden) = blind(&spec);
    assert_eq!(hidden.key, "uncertainty.bank_deg");
    assert_eq!(hidden.value, [20.0]);
    // With what is said, it sees.
    spec.uncertainty.bank_deg = hidden.seen_at.unwrap()[0];
    assert!(spec.uncertainty.bank_deg > 3.0);
    let design = designed_with_few_drives(spec).unwrap();
    assert_eq!(design.synthesis.status, DesignStatus::Certified);
}

#[test]
fn a_yaw_moment_blinds_and_is_named_and_no_edit_hides_that() {
    let spec = common::papers_but(
        "[[disturbance]]\nkind = \"yaw_moment\"\nname = \"brakes\"\nbound_n_m = 2000.0\n",
    );
    let (design, hidden) = blind(&spec);
    assert_eq!(hidden.key, "bound_n_m of disturbance \"brakes\"");
    assert_eq!(hidden.value, [2000.0]);
    assert!(hidden.seen_at.unwrap()[0] < 2000.0);

    let verdict = verify(&design.to_json().unwrap()).unwrap();
    assert!(verdict.is_blind() && verdict.is_certified());
    let edited = |edit: &dyn Fn(&mut Value)| {
        let mut edited = serde_json::to_value(&design).unwrap();
        edit(&mut edited);
        edited["hash"] = content_hash(&edited).unwrap().into();
        verify(&edited.to_string()).unwrap_err().to_string()
    };
    let f = sight(&design).bank_and_wind_deg;
    for (pointer, value, part) in [
        ("/synthesis/status", json!("certified"), "`synthesis.status"),
        ("/performance/sight/blind", Value::Null, "`performance.sight.blind"),
        ("/performance/sight", Value::Null, "`performance.sight: whether there is one`"),
        ("/performance/sight/courses", json!([]), "`performance.sight.courses"),
        ("/performance/sight/bank_and_wind_deg", json!(0.5 * f + 0.1), "bank_and_wind_deg`"),
        ("/performance/sight/courses/0/faults/0/fault_deg", json!(2.0), "first fault_deg`"),
    ] {
        let refusal = edited(&|design| *design.pointer_mut(pointer).unwrap() = value.clone());
        assert!(refusal.contains(part), "{pointer}: {refusal}");
    }
}

/// A fault of the drive torque is not driven.
#[test]
fn torque_is_not_judged() {
    let spec = common::papers_but("[[fault]]\nchannel = \"torque\"\nsmallest_n_m = 500.0\n");
    let design = designed_with_few_drives(spec).unwrap();
    assert_eq!(design.performance.sight, None);
    assert!(verify(&design.to_json().unwrap()).is_ok());
}
