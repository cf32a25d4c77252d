//! Time derivatives of inputs, as an importer may give them for a step.

/// Most inputs a model may have.
pub const MAX_INPUTS: usize = 16;
/// Highest order of input derivatives.
pub const MAX_ORDER: usize = 3;

/// Time derivatives of the inputs at the communication point, valid for the next step.
#[derive(Clone, Copy)]
pub struct InputDerivatives {
    /// By value reference of the input, then by order less one.
    pub orders: [[f64; MAX_ORDER]; MAX_INPUTS],
    /// Whether any was set.
    pub given: bool,
}

impl InputDerivatives {
    /// None was set.
    pub const NONE: Self = Self { orders: [[0.0; MAX_ORDER]; MAX_INPUTS], given: false };
}
