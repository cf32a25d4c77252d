//! Gains that the refinement starts from, beside those of a synthesis.
//!
//! The refinement finds a local optimum, and the start decides which: from the synthesis of a
//! neutral-steer car it ends where v_y^ runs away under a fault, from gains of another kind it does not.

use steerguard_detector::RULES;

use crate::search::cost::Coordinates;
use crate::search::refine::gains_at;
use crate::synthesis::gains::ObserverGains;
use crate::synthesis::theorem4::Theorem4;

/// E of the gains carried over, for a fault column F = [0, F_2, F_3] with F_2 / F_3 = [`LENGTH`].
///
/// Source: the default specification (Table 1 of the paper) as method "gap" refined it at decay 0.97,
/// rounded, and made symmetric in left and right.
const E: [[f64; 2]; 3] = [[-1.0, 0.0], [0.0, -1.385], [0.0, -1.012]];
/// The first and third column of N_i at the lowest and the highest speed, of the same gains.
const N: [[[f64; 2]; 3]; 2] = [
    [[0.592, 0.0], [0.0, -0.776], [0.0, 0.949]],
    [[0.377, 0.0], [0.0, -0.891], [0.0, 0.816]],
];
/// I_z / (M l_f) of that vehicle, m.
const LENGTH: f64 = 1.0852;
/// Rules of the lowest speed come first.
const AT_LOWEST_SPEED: usize = 2;
/// Decay of the measured states in the start with E = 0.
const DECAY_AT_ZERO: f64 = 0.8;

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
    let of_rules = (0..RULES).map(|rule| &N[usize::from(rule >= AT_LOWEST_SPEED)]);
    let blocks = std::iter::once(&E).chain(of_rules);
    let rows = blocks.flat_map(|block| block.iter().enumerate());
    let x = rows.flat_map(|(row, x)| x.map(|x| scaled(row, x)));
    Some(gains_at(&Coordinates::from_iterator(x), theorem))
}

/// An observer without E: the measured states decay, v_y by the vehicle's own damping.
pub(super) fn without_e(theorem: &Theorem4) -> ObserverGains {
    let of_rule = [DECAY_AT_ZERO, 0.0, 0.0, 0.0, 0.0, DECAY_AT_ZERO];
    let x = [0.0; 6].into_iter().chain([of_rule; RULES].into_iter().flatten());
    gains_at(&Coordinates::from_iterator(x), theorem)
}
