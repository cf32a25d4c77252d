//! Nonlinear two-degree-of-freedom vehicle model with longitudinal speed, (1)-(3).

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::{Input, StateVector, VehicleState};

/// Vehicle data, Table 1 of the paper. All values positive and finite; drags may be zero.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize), serde(deny_unknown_fields))]
pub struct Vehicle {
    /// M_v, kg.
    pub mass_kg: f64,
    /// I_z, kg m^2.
    pub yaw_inertia_kg_m2: f64,
    /// I_e, kg m: mass times effective wheel radius, so that T_eng / I_e is an acceleration
    /// (the paper's "kg m^2" is corrected: method 1).
    pub effective_longitudinal_inertia_kg_m: f64,
    /// l_f, m: centre of gravity to front axle.
    pub front_axle_distance_m: f64,
    /// l_r, m: centre of gravity to rear axle.
    pub rear_axle_distance_m: f64,
    /// C_f, N/rad, of one front tyre.
    pub front_cornering_stiffness_n_per_rad: f64,
    /// C_r, N/rad, of one rear tyre.
    pub rear_cornering_stiffness_n_per_rad: f64,
    /// C_x, N m/(m/s)^2: C_x v_x^2 is the drag's torque at the wheels.
    pub longitudinal_drag_n_m_s2_per_m2: f64,
    /// C_y, N/(m/s)^2: C_y v_y^2 is a force.
    pub lateral_drag_n_s2_per_m2: f64,
}

impl Vehicle {
    /// The passenger car of Table 1.
    pub const PAPER: Self = Self {
        mass_kg: 1476.0,
        yaw_inertia_kg_m2: 1810.0,
        effective_longitudinal_inertia_kg_m: 442.8,
        front_axle_distance_m: 1.13,
        rear_axle_distance_m: 1.49,
        front_cornering_stiffness_n_per_rad: 57000.0,
        rear_cornering_stiffness_n_per_rad: 59000.0,
        longitudinal_drag_n_m_s2_per_m2: 0.35,
        lateral_drag_n_s2_per_m2: 0.45,
    };

    /// Slip angles `[front, rear]` in rad at state `x`, `v_x > 0`, and a road-wheel angle.
    pub fn slip_angles(&self, x: VehicleState, delta_rad: f64) -> [f64; 2] {
        let [v_x, v_y, r] = x.vector();
        [
            delta_rad - (v_y + self.front_axle_distance_m * r) / v_x,
            (self.rear_axle_distance_m * r - v_y) / v_x,
        ]
    }

    /// Axle forces `[F_yf, F_yr]` in N (2): two linear tyres an axle.
    pub fn axle_forces(&self, x: VehicleState, delta_rad: f64) -> [f64; 2] {
        let [front, rear] = self.slip_angles(x, delta_rad);
        [
            2.0 * self.front_cornering_stiffness_n_per_rad * front,
            2.0 * self.rear_cornering_stiffness_n_per_rad * rear,
        ]
    }

    /// `dx/dt` (1) in m/s^2, m/s^2, rad/s^2 under given axle forces in N and drive torque at the wheels.
    pub fn derivative_under(
        &self,
        x: VehicleState,
        t_eng_n_m: f64,
        [front, rear]: [f64; 2],
    ) -> StateVector {
        let [v_x, v_y, r] = x.vector();
        [
            (t_eng_n_m - self.longitudinal_drag_n_m_s2_per_m2 * v_x * v_x)
                / self.effective_longitudinal_inertia_kg_m
                + v_y * r,
            (front + rear - self.lateral_drag_n_s2_per_m2 * v_y * v_y) / self.mass_kg - v_x * r,
            (self.front_axle_distance_m * front - self.rear_axle_distance_m * rear)
                / self.yaw_inertia_kg_m2,
        ]
    }

    /// `dx/dt` of (3) in m/s^2, m/s^2, rad/s^2 with linear tyres, for `v_x > 0`.
    pub fn derivative(&self, x: VehicleState, u: Input) -> StateVector {
        self.derivative_under(x, u.t_eng_n_m, self.axle_forces(x, u.delta_rad))
    }

    /// `d^2x/dt^2` of (3) in m/s^3, m/s^3, rad/s^3 with linear tyres under a held input, for `v_x > 0`.
    pub fn second_derivative(&self, x: VehicleState, u: Input) -> StateVector {
        self.second_derivative_along(x, self.derivative(x, u))
    }

    /// The same where `dx/dt` is known.
    pub(crate) fn second_derivative_along(
        &self,
        x: VehicleState,
        x_dot: StateVector,
    ) -> StateVector {
        let [v_x, v_y, r] = x.vector();
        let [v_x_dot, v_y_dot, r_dot] = x_dot;
        let (m, i_z) = (self.mass_kg, self.yaw_inertia_kg_m2);
        let (l_f, l_r) = (self.front_axle_distance_m, self.rear_axle_distance_m);
        // Slip angles (v_y + l_f r) / v_x and (v_y - l_r r) / v_x, by the quotient rule.
        let slip_dot = |lateral: f64, dot: f64| (dot - lateral / v_x * v_x_dot) / v_x;
        let front_dot = -2.0
            * self.front_cornering_stiffness_n_per_rad
            * slip_dot(v_y + l_f * r, v_y_dot + l_f * r_dot);
        let rear_dot = -2.0
            * self.rear_cornering_stiffness_n_per_rad
            * slip_dot(v_y - l_r * r, v_y_dot - l_r * r_dot);
        let (c_x, c_y) = (self.longitudinal_drag_n_m_s2_per_m2, self.lateral_drag_n_s2_per_m2);
        [
            -2.0 * c_x * v_x * v_x_dot / self.effective_longitudinal_inertia_kg_m
                + v_y_dot * r
                + v_y * r_dot,
            (front_dot + rear_dot - 2.0 * c_y * v_y * v_y_dot) / m - v_x_dot * r - v_x * r_dot,
            (l_f * front_dot - l_r * rear_dot) / i_z,
        ]
    }

    /// Drive torque in N m at the wheels that holds a speed on a straight road.
    pub fn cruise_torque(&self, v_x_m_per_s: f64) -> f64 {
        self.longitudinal_drag_n_m_s2_per_m2 * v_x_m_per_s * v_x_m_per_s
    }
}
