//! Unknown-input-like fuzzy observer (10) with gains (11)-(13).

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::algebra::{blend, product, sum};
use crate::ts_model::{Columns, RULES, TsModel};
use crate::{Input, Measurement, VehicleState};

/// Gains of the observer (10).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize), serde(deny_unknown_fields))]
pub struct Gains {
    /// N_i, 3 x 3 each.
    pub n: [[[f64; 3]; 3]; RULES],
    /// L_i, 3 x 2 each.
    pub l: [[[f64; 2]; 3]; RULES],
    /// M = I + E C, 3 x 3.
    pub m: [[f64; 3]; 3],
    /// E, 3 x 2.
    pub e: [[f64; 2]; 3],
}

/// The observer (10): maps from one sample to the next; its state z is kept by the caller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observer {
    /// Model the gains belong to.
    pub(crate) model: TsModel,
    /// Gains.
    pub(crate) gains: Gains,
    columns: Columns,
}

impl Observer {
    /// The observer of `model` with `gains`.
    pub fn new(model: TsModel, gains: Gains) -> Self {
        Self { model, gains, columns: model.columns() }
    }

    /// `z = M [v_x, 0, r]`: the estimate starts at the measurement with no lateral speed, so the
    /// error starts at `[0, v_y, 0]` and the residual at zero.
    pub fn start(&self, [v_x, r]: Measurement) -> VehicleState {
        product(&self.gains.m, &[v_x, 0.0, r])
    }

    /// `x^ = z - E y` (10).
    pub fn estimate(&self, z: VehicleState, y: Measurement) -> VehicleState {
        let e_y = product(&self.gains.e, &y);
        [z[0] - e_y[0], z[1] - e_y[1], z[2] - e_y[2]]
    }

    /// `N(h)` (10) for membership functions h, 3 x 3.
    pub fn n(&self, h: &[f64; RULES]) -> [[f64; 3]; 3] {
        blend(h, &self.gains.n)
    }

    /// `z+ = N(h) z + L(h) y + M (g + B u + G phi(x^))` (10), for `y` inside S_x, the membership
    /// functions `h` there and `n` = N(h).
    pub fn advance(
        &self,
        h: &[f64; RULES],
        n: &[[f64; 3]; 3],
        z: VehicleState,
        y: Measurement,
        u: Input,
        v_y_hat: f64,
    ) -> VehicleState {
        let linear = sum(product(n, &z), product(&blend(h, &self.gains.l), &y));
        let consequent = self.model.consequent(&self.columns, y, u, v_y_hat);
        sum(linear, product(&self.gains.m, &consequent))
    }

    /// `e+ = N(h) e + M w`: how the error goes on from `e` where the vehicle departs by `w` from the
    /// model (7), to first order in e.
    pub fn respond(&self, n: &[[f64; 3]; 3], e: VehicleState, w: VehicleState) -> VehicleState {
        sum(product(n, &e), product(&self.gains.m, &w))
    }
}
