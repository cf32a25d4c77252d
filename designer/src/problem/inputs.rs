//! What is asked of the residual.

use crate::problem::channel::Channel;

/// What is asked of the residual: the inputs, in the units of the figures.
#[derive(Clone, Debug)]
pub struct Inputs {
    /// The fault that is designed for, per rad or N m.
    pub fault: Channel,
    /// Disturbances and bounded noise by their bands, per unit of the first disturbance.
    pub disturbances: Vec<Channel>,
    /// Standard deviations of white sensor noise on [v_x, r], m/s and rad/s.
    pub white_std: [f64; 2],
    /// Smallest fault of interest, rad or N m.
    pub smallest_fault: f64,
    /// Bound of the first disturbance, in its unit.
    pub bound: f64,
    /// Diagonal of W_r.
    pub weights: [f64; 2],
}
