//! Gains that the refinement starts from, beside those of a synthesis.
//!
//! The refinement finds a local optimum, and the start decides which: from the synthesis of a
//! neutral-steer car it ends where v_y^ runs away under a fault, from gains of another kind it does not.

use steerguard_detector::RULES;
use steerguard_world::Stream;

use crate::search::cost::{COORDINATES, Coordinates};
use crate::search::refine::{coordinates, gains_at};
use crate::synthesis::gains::ObserverGains;
use crate::synthesis::theorem4::Theorem4;

/// E of the gains carried over, for a fault column F = [0, F_2, F_3] with F_2 / F_3 = [`LENGTH`].
///
/// Source: the default specification (Table 1 of the paper) as method "gap" refined it at decay 0.97
/// before it had other starts than syntheses, rounded. They treat left and right differently, and
/// should: a start that does not is led to an optimum that does not, which is worse.
const E: [[f64; 2]; 3] = [[-1.0, 0.114], [-0.003, -1.385], [0.0, -1.012]];
/// The first and third column of the N_i of the same gains.
const N: [[[f64; 2]; 3]; RULES] = [
    [[0.59, 0.137], [0.002, -0.776], [-0.217, 0.949]],
    [[0.594, 0.136], [0.002, -0.776], [-0.214, 0.949]],
    [[0.377, 0.009], [-0.001, -0.891], [-0.533, 0.817]],
    [[0.377, 0.005], [-0.001, -0.892], [-0.531, 0.815]],
];
/// I_z / (M l_f) of that vehicle, m.
const LENGTH: f64 = 1.0852;
/// Decay of the measured states in the start with E = 0.
const DECAY_AT_ZERO: f64 = 0.8;

/// Moved starts around the gains carried over and the observer without E: how many, and the standard
/// deviation of every coordinate.
const MOVED: [(u64, f64); 2] = [(2, 0.1), (3, 0.3)];
/// Seed of what is moved.
const SEED: u64 = 1;

/// All starts but the synthesis.
pub(super) fn starts(theorem: &Theorem4) -> Vec<ObserverGains> {
    let carried_over = carried_over(theorem);
    let mut starts: Vec<ObserverGains> = carried_over.into_iter().collect();
    let centres = [carried_over, Some(without_e(theorem))];
    for (stream, (centre, (count, size))) in (0..).zip(centres.into_iter().zip(MOVED)) {
        let Some(centre) = centre else { continue };
        let random = Stream::new(SEED, stream);
        let normal = |start: u64, k: usize| random.normal(start * COORDINATES as u64 + k as u64);
        for start in 0..count {
            let of_start = Coordinates::from_fn(|k, _| size * normal(start, k));
            starts.push(gains_at(&(coordinates(&centre.gains) + of_start), theorem));
        }
    }
    starts
}

/// The gains of Table 1's car carried over: lengths are scaled by I_z / (M l_f), the distance at
/// which a fault's force acts as on a point mass.
pub(super) fn carried_over(theorem: &Theorem4) -> Option<ObserverGains> {
    let f = &theorem.fault.direction;
    let scale = f[(1, 0)] / f[(2, 0)] / LENGTH;
    if !scale.is_normal() {
        return None;
    }
    // e_2 in units of `scale`.
    let scaled = |row: usize, x: f64| if row == 1 { scale * x } else { x };
    let blocks = std::iter::once(&E).chain(&N);
    let rows = blocks.flat_map(|block| block.iter().enumerate());
    let x = rows.flat_map(|(row, x)| x.map(|x| scaled(row, x)));
    Some(gains_at(&Coordinates::from_iterator(x), theorem))
}

/// An observer without E: the measured states decay, v_y by the vehicle's own damping. It treats left
/// and right alike, so that only what is moved away from it is a start.
fn without_e(theorem: &Theorem4) -> ObserverGains {
    let of_rule = [DECAY_AT_ZERO, 0.0, 0.0, 0.0, 0.0, DECAY_AT_ZERO];
    let x = [0.0; 6].into_iter().chain([of_rule; RULES].into_iter().flatten());
    gains_at(&Coordinates::from_iterator(x), theorem)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::inputs::Inputs;
    use crate::problem::model;
    use crate::search::objective::Objective;
    use crate::search::refine::{STEPS, refine};
    use crate::spec::Spec;

    /// A BMW 320i as CommonRoad has it: neutral-steer.
    fn neutral() -> Spec {
        let mut spec = Spec::default();
        spec.vehicle.mass_kg = 1093.295;
        spec.vehicle.yaw_inertia_kg_m2 = 1791.6;
        spec.vehicle.effective_longitudinal_inertia_kg_m = 1093.295;
        spec.vehicle.front_axle_distance_m = 1.1562;
        spec.vehicle.rear_axle_distance_m = 1.4227;
        spec.vehicle.front_cornering_stiffness_n_per_rad = 64848.3;
        spec.vehicle.rear_cornering_stiffness_n_per_rad = 52700.1;
        spec.operating_range = crate::spec::OperatingRangeTable::PAPER;
        spec
    }

    /// The start decides: what treats left and right alike stays that way, and is worth less (method 5).
    /// A cap is held.
    #[test]
    fn a_neutral_car_sees_from_what_is_carried_over() {
        let spec = neutral();
        let inputs = Inputs::of(&spec).unwrap_or_else(|mistakes| panic!("{mistakes}"));
        let theorem = Theorem4::of(&spec, &inputs, 0.97);
        for (cap_m_per_s_per_deg, at_least) in [(0.3, 21.0), (0.03, 10.0)] {
            let cap = cap_m_per_s_per_deg / 1f64.to_radians();
            let scale = theorem.beta_bound();
            let objective = Objective::new(&model::model(&spec), &inputs, scale, Some(cap));
            let worst = |start: &ObserverGains| {
                objective.worst(&refine(&objective, start, &theorem, 0.966, STEPS).gains)
            };
            let start = carried_over(&theorem).unwrap_or_else(|| panic!("a steering fault"));
            let found = worst(&start);
            assert!(found.excess(Some(1.05 * cap)) <= 1.0, "{found:?}");
            assert!(found.ratio(&inputs) > at_least, "{found:?}");
            let alike = worst(&without_e(&theorem));
            assert!(alike.ratio(&inputs) < 0.9 * found.ratio(&inputs), "{alike:?}");
        }
    }
}
