//! Takagi-Sugeno model with nonlinear consequents (N-TS), discretised by Euler: (5)-(8), corrected.
//!
//! `x+ = A(h) x + B u + g(xi) + G phi(x)`, `phi(x) = v_y^2`, premise variables `xi = (1/v_x, r)`.
//! Built from (1)-(3), not from the misprinted (5): method 1.
//!
//! # Conventions
//! Rule order: (v_x min, r min), (v_x min, r max), (v_x max, r min), (v_x max, r max).

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::algebra::{blend, product, sum};
use crate::{Input, Interval, Measurement, OperatingRange, StateVector, Vehicle, VehicleState};

/// Number of rules: the vertices of the two premise variables.
pub const RULES: usize = 4;

/// Output matrix, 2 x 3: `y = C x = [v_x, r]`.
pub const C: [[f64; 3]; 2] = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];

/// What of (7) and (8) no sample changes, computed once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Constants {
    /// B, 3 x 2.
    b: [[f64; 2]; 3],
    /// G, 3 x 1.
    g_phi: StateVector,
    /// Numerators of g by v_x^2, r and r.
    g: StateVector,
    /// 1/v_x at the ends of S_x, s/m.
    slow: f64,
    fast: f64,
}

/// The discrete-time N-TS model of a vehicle on an operating range.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize), serde(deny_unknown_fields))]
pub struct TsModel {
    /// Vehicle data.
    pub vehicle: Vehicle,
    /// T_s, s.
    pub sampling_period_s: f64,
    /// S_x (4), whose v_x and r bounds give the rules.
    pub range: OperatingRange,
}

impl TsModel {
    /// The paper's: its vehicle, T_s and S_x (4).
    pub const PAPER: Self = Self {
        vehicle: Vehicle::PAPER,
        sampling_period_s: 0.01,
        range: OperatingRange {
            v_x: Interval::new(5.0, 30.0),
            v_y: Interval::new(-1.5, 1.5),
            r: Interval::new(-0.55, 0.55),
        },
    };

    /// `A(xi) = I + T_s A_v(xi)`, 3 x 3, (5) corrected, at premise `(1/v_x, r)`.
    pub fn a(&self, inverse_v_x: f64, r: f64) -> [[f64; 3]; 3] {
        let v = &self.vehicle;
        let t = self.sampling_period_s;
        let (c_f, c_r) =
            (v.front_cornering_stiffness_n_per_rad, v.rear_cornering_stiffness_n_per_rad);
        let a_22 = -2.0 * (c_f + c_r) / v.mass_kg * inverse_v_x;
        let a_32 = 2.0 * self.stiffness_moment() / v.yaw_inertia_kg_m2 * inverse_v_x;
        [[1.0, t * r, 0.0], [0.0, 1.0 + t * a_22, 0.0], [0.0, t * a_32, 1.0]]
    }

    /// `A_i` of the rules, in their order.
    pub fn vertices(&self) -> [[[f64; 3]; 3]; RULES] {
        let (v_x, r) = (self.range.v_x, self.range.r);
        [(v_x.min, r.min), (v_x.min, r.max), (v_x.max, r.min), (v_x.max, r.max)]
            .map(|(v_x, r)| self.a(1.0 / v_x, r))
    }

    /// `B = T_s B_v`, 3 x 2.
    pub fn b(&self) -> [[f64; 2]; 3] {
        let v = &self.vehicle;
        let t = self.sampling_period_s;
        let c_f = v.front_cornering_stiffness_n_per_rad;
        [
            [t / v.effective_longitudinal_inertia_kg_m, 0.0],
            [0.0, t * 2.0 * c_f / v.mass_kg],
            [0.0, t * 2.0 * v.front_axle_distance_m * c_f / v.yaw_inertia_kg_m2],
        ]
    }

    /// `g(xi) = T_s g_v(xi)`, (5) corrected: what depends on the measured v_x and r alone.
    pub fn g(&self, y: Measurement) -> StateVector {
        self.constants().g(self, y)
    }

    /// `G = T_s G_v`, (5) corrected: the column of `phi(x) = v_y^2`.
    pub fn g_phi(&self) -> StateVector {
        let v = &self.vehicle;
        [0.0, -self.sampling_period_s * v.lateral_drag_n_s2_per_m2 / v.mass_kg, 0.0]
    }

    /// Membership functions `h_i` (8) at a measurement inside S_x: bilinear in `(1/v_x, r)`,
    /// in `[0, 1]`, summing to 1.
    pub fn membership(&self, y: Measurement) -> [f64; RULES] {
        self.constants().membership(self, y)
    }

    /// One step (7) of the fault- and disturbance-free model; equals the Euler step of (3)
    /// for `x` inside S_x.
    pub fn step(&self, x: VehicleState, u: Input) -> VehicleState {
        let y = x.measured();
        let a = blend(&self.membership(y), &self.vertices());
        let consequent = self.constants().consequent(self, y, u, x.v_y_m_per_s);
        sum(product(&a, &x.vector()), consequent).into()
    }

    pub(crate) fn constants(&self) -> Constants {
        let v = &self.vehicle;
        let t = self.sampling_period_s;
        let (l_f, l_r) = (v.front_axle_distance_m, v.rear_axle_distance_m);
        let (c_f, c_r) =
            (v.front_cornering_stiffness_n_per_rad, v.rear_cornering_stiffness_n_per_rad);
        let yaw_damping = 2.0 * (c_f * l_f * l_f + c_r * l_r * l_r);
        Constants {
            b: self.b(),
            g_phi: self.g_phi(),
            g: [
                -t * v.longitudinal_drag_n_m_s2_per_m2,
                2.0 * self.stiffness_moment(),
                -t * yaw_damping,
            ],
            slow: 1.0 / self.range.v_x.min,
            fast: 1.0 / self.range.v_x.max,
        }
    }

    /// `C_r l_r - C_f l_f`, N m/rad.
    fn stiffness_moment(&self) -> f64 {
        let v = &self.vehicle;
        v.rear_cornering_stiffness_n_per_rad * v.rear_axle_distance_m
            - v.front_cornering_stiffness_n_per_rad * v.front_axle_distance_m
    }
}

impl Constants {
    /// [`TsModel::g`] of `model`.
    fn g(&self, model: &TsModel, y: Measurement) -> StateVector {
        let [v_x, r] = y.vector();
        let v = &model.vehicle;
        let [by_square, by_side, by_yaw] = self.g;
        [
            by_square * v_x * v_x / v.effective_longitudinal_inertia_kg_m,
            model.sampling_period_s * (by_side * r / (v.mass_kg * v_x) - v_x * r),
            by_yaw * r / (v.yaw_inertia_kg_m2 * v_x),
        ]
    }

    /// [`TsModel::membership`] of `model`.
    pub(crate) fn membership(&self, model: &TsModel, y: Measurement) -> [f64; RULES] {
        let [v_x, r] = y.vector();
        let r_range = &model.range.r;
        let at_v_x_min = (1.0 / v_x - self.fast) / (self.slow - self.fast);
        let at_v_x_max = 1.0 - at_v_x_min;
        let at_r_max = (r - r_range.min) / (r_range.max - r_range.min);
        let at_r_min = 1.0 - at_r_max;
        [at_v_x_min * at_r_min, at_v_x_min * at_r_max, at_v_x_max * at_r_min, at_v_x_max * at_r_max]
    }

    /// `B u + g(xi) + G phi`: the part of (7) that the premise does not blend.
    pub(crate) fn consequent(
        &self,
        model: &TsModel,
        y: Measurement,
        u: Input,
        v_y_m_per_s: f64,
    ) -> StateVector {
        let phi = v_y_m_per_s * v_y_m_per_s;
        let g_phi = self.g_phi.map(|g| g * phi);
        sum(sum(self.g(model, y), product(&self.b, &u.vector())), g_phi)
    }
}
