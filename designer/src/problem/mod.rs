//! From specification to mathematics: frequency bands, inputs and their units.

pub mod band;
pub mod channel;
pub mod inputs;
pub mod model;
