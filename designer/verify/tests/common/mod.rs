//! Designs that the verifier is held to.

use serde_json::Value;

/// One disturbance, no noise; gains of a synthesis.
pub const PAPER: &str = include_str!("../fixtures/paper.json");
/// The default specification; gains of a search.
pub const GAP: &str = include_str!("../fixtures/gap.json");
/// Side wind and speed noise in a low band, yaw moment and yaw-rate noise in the full one; two
/// faults; weights.
pub const NOISE: &str = include_str!("../fixtures/noise.json");
/// A guaranteed threshold, with side wind and bounded noise of both sensors.
pub const GUARANTEED: &str = include_str!("../fixtures/guaranteed.json");

pub fn parsed(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}
