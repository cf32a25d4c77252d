//! Specifications that have no design, each with a twin beside it that has one: by method and channel.

#![allow(clippy::unwrap_used, clippy::panic)]

#[path = "common/designed.rs"]
mod designed;

use steerguard_designer::{Design, DesignError, Obstacle, Spec};

use designed::designed_with_few_drives;

/// The paper's: the default's leaves method "paper" less.
const RANGE: &str = "operating_range.v_y_m_per_s = [-1.5, 1.5]\n\
                     operating_range.r_rad_per_s = [-0.55, 0.55]\n";

fn designed(text: &str) -> Result<Design, DesignError> {
    designed_with_few_drives(Spec::from_toml(&format!("{RANGE}{text}")).unwrap())
}

fn obstacle(text: &str) -> Obstacle {
    match designed(text) {
        Err(DesignError::Infeasible(obstacle)) => obstacle,
        other => panic!("{text}\n{other:?}"),
    }
}

#[test]
fn of_method_gap_the_decay_rate_is_blamed_and_the_nearest_named() {
    let text = |decay: f64| format!("design.decay = {decay}\ndesign.search_budget = 2\n");
    let found = obstacle(&text(0.5));
    let Obstacle::Stability { decay: 0.5, smallest: Some(smallest) } = found else {
        panic!("{found:?}");
    };
    assert!(found.to_string().contains("design.decay"), "{found}");
    // Its twin, a little slower than the edge.
    designed(&text(smallest)).unwrap();
}

#[test]
fn of_method_paper_bounded_noise_is_blamed_and_a_multiplier_named() {
    let text = |alpha_d: f64| {
        format!(
            "noise.r.bound_rad_per_s = 0.001\ndesign.method = \"paper\"\ndesign.gamma = 0.1\n\
             design.alpha_d = {alpha_d}\n"
        )
    };
    let found = obstacle(&text(2.0));
    let Obstacle::Disturbance { smallest: None, possible_alpha_d: Some(possible), .. } = found
    else {
        panic!("{found:?}");
    };
    let message = found.to_string();
    assert!(
        message.contains("bounds of the sensor noise of all frequencies leave none"),
        "{message}"
    );
    assert!(message.contains(&format!("design.alpha_d = {possible}")), "{message}");
    designed(&text(possible)).unwrap();
}

#[test]
fn of_a_torque_fault_by_method_paper_the_decay_rate_is_blamed() {
    let text = |decay: f64| {
        format!(
            "design.method = \"paper\"\ndesign.decay = {decay}\n[[fault]]\nchannel = \"torque\"\n\
             smallest_n_m = 100\n"
        )
    };
    let found = obstacle(&text(0.4));
    let Obstacle::Stability { smallest: Some(smallest), .. } = found else {
        panic!("{found:?}");
    };
    assert!(0.4 < smallest && smallest < 0.97, "{found}");
    designed(&text(0.97)).unwrap();
}
