//! Unknown-input-like fuzzy observer (10) with gains (11)-(13).

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::algebra::{blend, product, sum};
use crate::ts_model::{Constants, RULES, TsModel};
use crate::{Input, Measurement, StateVector, VehicleState};

/// Gains of the observer (10). Rows are in the units of z, m/s, m/s, rad/s; columns per unit of what they
/// take: z, or y in m/s, rad/s.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize), serde(deny_unknown_fields))]
pub struct Gains {
    /// N_i, 3 x 3 each, from z.
    pub n: [[[f64; 3]; 3]; RULES],
    /// L_i, 3 x 2 each, from y.
    pub l: [[[f64; 2]; 3]; RULES],
    /// M = I + E C, 3 x 3, from what is added to the state.
    pub m: [[f64; 3]; 3],
    /// E, 3 x 2, from y.
    pub e: [[f64; 2]; 3],
}

/// The observer (10): maps from one sample to the next; its state z is kept by the caller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observer {
    /// Model the gains belong to.
    pub(crate) model: TsModel,
    /// Gains.
    pub(crate) gains: Gains,
    constants: Constants,
}

impl Observer {
    /// The observer of `model` with `gains`.
    pub fn new(model: TsModel, gains: Gains) -> Self {
        Self { model, gains, constants: model.constants() }
    }

    /// `z = M [v_x, 0, r]`: the estimate starts at the measurement with no lateral speed, so the
    /// error starts at `[0, v_y, 0]` and the residual at zero.
    pub fn start(&self, y: Measurement) -> StateVector {
        product(&self.gains.m, &[y.v_x_m_per_s, 0.0, y.r_rad_per_s])
    }

    /// `x^ = z - E y` (10).
    pub fn estimate(&self, z: StateVector, y: Measurement) -> VehicleState {
        let e_y = product(&self.gains.e, &y.vector());
        VehicleState {
            v_x_m_per_s: z[0] - e_y[0],
            v_y_m_per_s: z[1] - e_y[1],
            r_rad_per_s: z[2] - e_y[2],
        }
    }

    /// [`TsModel::membership`] of the observer's model.
    pub(crate) fn membership(&self, y: Measurement) -> [f64; RULES] {
        self.constants.membership(&self.model, y)
    }

    /// `N(h)` (10) for membership functions h, 3 x 3.
    pub fn n(&self, h: &[f64; RULES]) -> [[f64; 3]; 3] {
        blend(h, &self.gains.n)
    }

    /// `L(h)` (10) for membership functions h, 3 x 2.
    pub fn l(&self, h: &[f64; RULES]) -> [[f64; 2]; 3] {
        blend(h, &self.gains.l)
    }

    /// `z+ = N(h) z + L(h) y + M (g + B u + G phi(x^))` (10), for `y` inside S_x, with `n` = N(h) and `l`
    /// = L(h) there.
    pub fn advance(
        &self,
        n: &[[f64; 3]; 3],
        l: &[[f64; 2]; 3],
        z: StateVector,
        y: Measurement,
        u: Input,
        v_y_hat_m_per_s: f64,
    ) -> StateVector {
        let linear = sum(product(n, &z), product(l, &y.vector()));
        let consequent = self.constants.consequent(&self.model, y, u, v_y_hat_m_per_s);
        sum(linear, product(&self.gains.m, &consequent))
    }

    /// `e+ = N(h) e + M w`: how the error goes on from `e` where the vehicle departs by `w` from the
    /// model (7), to first order in e.
    pub fn respond(&self, n: &[[f64; 3]; 3], e: StateVector, w: StateVector) -> StateVector {
        sum(product(n, &e), product(&self.gains.m, &w))
    }

    /// `M (I + T_s J / 2)`, 3 x 3, for the model's Jacobian J: what `T_s` times a slope that acts over a
    /// sampling period leaves in the error.
    pub(crate) fn held(&self, jacobian: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
        let half = 0.5 * self.model.sampling_period_s;
        let mut held = self.gains.m;
        for (row, m) in held.iter_mut().zip(&self.gains.m) {
            for (m, by) in m.iter().zip(jacobian) {
                for (held, by) in row.iter_mut().zip(by) {
                    *held += half * m * by;
                }
            }
        }
        held
    }
}
