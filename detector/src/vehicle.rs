//! Nonlinear two-degree-of-freedom vehicle model with longitudinal speed, (1)-(3).

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::{Input, StateVector, VehicleState};

/// Standard gravity, m/s^2.
pub const GRAVITY_M_PER_S2: f64 = 9.80665;

/// Vehicle data, Table 1 of the paper. All values positive and finite; drags may be zero.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize), serde(deny_unknown_fields))]
pub struct Vehicle {
    /// Mass M_v, kg.
    pub mass_kg: f64,
    /// Yaw moment of inertia I_z, kg m^2.
    pub yaw_inertia_kg_m2: f64,
    /// Effective longitudinal inertia I_e, kg m: mass times effective wheel radius, so that
    /// T_eng / I_e is an acceleration (the paper's "kg m^2" is corrected: method 1).
    pub effective_longitudinal_inertia_kg_m: f64,
    /// Distance l_f from the centre of gravity to the front axle, m.
    pub front_axle_distance_m: f64,
    /// Distance l_r from the centre of gravity to the rear axle, m.
    pub rear_axle_distance_m: f64,
    /// Cornering stiffness C_f of one front tyre, N/rad.
    pub front_cornering_stiffness_n_per_rad: f64,
    /// Cornering stiffness C_r of one rear tyre, N/rad.
    pub rear_cornering_stiffness_n_per_rad: f64,
    /// Longitudinal drag C_x, N m/(m/s)^2: C_x v_x^2 is a torque at the wheels.
    pub longitudinal_drag_n_m_s2_per_m2: f64,
    /// Lateral drag C_y, N/(m/s)^2: C_y v_y^2 is a force.
    pub lateral_drag_n_s2_per_m2: f64,
    /// Height of the centre of gravity above the road, m, not negative; 0 for no transfer of axle load.
    pub centre_of_gravity_height_m: f64,
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
        centre_of_gravity_height_m: 0.0,
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

    /// Jacobian of (3) by x with linear tyres, 3 x 3, for `v_x > 0`. The steering angle has no part in it.
    pub fn jacobian(&self, x: VehicleState) -> [[f64; 3]; 3] {
        let [v_x, v_y, r] = x.vector();
        let (m, i_z) = (self.mass_kg, self.yaw_inertia_kg_m2);
        let (l_f, l_r) = (self.front_axle_distance_m, self.rear_axle_distance_m);
        // Axle forces by v_y, and by r and v_x over it.
        let front = -2.0 * self.front_cornering_stiffness_n_per_rad / v_x;
        let rear = -2.0 * self.rear_cornering_stiffness_n_per_rad / v_x;
        let (front_by_v_x, rear_by_v_x) =
            (-front * (v_y + l_f * r) / v_x, -rear * (v_y - l_r * r) / v_x);
        let (c_x, c_y) = (self.longitudinal_drag_n_m_s2_per_m2, self.lateral_drag_n_s2_per_m2);
        [
            [-2.0 * c_x * v_x / self.effective_longitudinal_inertia_kg_m, r, v_y],
            [
                (front_by_v_x + rear_by_v_x) / m - r,
                (front + rear - 2.0 * c_y * v_y) / m,
                (l_f * front - l_r * rear) / m - v_x,
            ],
            [
                (l_f * front_by_v_x - l_r * rear_by_v_x) / i_z,
                (l_f * front - l_r * rear) / i_z,
                (l_f * l_f * front + l_r * l_r * rear) / i_z,
            ],
        ]
    }

    /// Loads `[F_zf, F_zr]` in N of the axles on a level road at the longitudinal acceleration `a_x` in
    /// m/s^2: `M (g l_r - a_x h) / L` and `M (g l_f + a_x h) / L`. A lifted axle carries nothing, and the
    /// other all.
    pub fn axle_loads_n(&self, a_x: f64) -> [f64; 2] {
        let weight = self.mass_kg * GRAVITY_M_PER_S2;
        let wheelbase = self.front_axle_distance_m + self.rear_axle_distance_m;
        let shift = self.mass_kg * a_x * self.centre_of_gravity_height_m;
        let front = (weight * self.rear_axle_distance_m - shift) / wheelbase;
        let front = front.max(0.0).min(weight);
        [front, weight - front]
    }

    /// How far back the weight acts at the longitudinal acceleration `a_x` in m/s^2, m.
    fn shift_m(&self, a_x: f64) -> f64 {
        a_x * self.centre_of_gravity_height_m / GRAVITY_M_PER_S2
    }

    /// Loads of the axles, front and rear, at the longitudinal acceleration `a_x` in m/s^2 over those at
    /// rest; not below a tenth.
    pub fn load_factors(&self, a_x: f64) -> [f64; 2] {
        if self.centre_of_gravity_height_m == 0.0 {
            return [1.0; 2]; // As below, at no cost.
        }
        let shift = self.shift_m(a_x);
        let front = 1.0 - shift / self.rear_axle_distance_m;
        let rear = 1.0 + shift / self.front_axle_distance_m;
        [front.max(0.1), rear.max(0.1)]
    }

    /// What the transfer of axle load at the longitudinal acceleration `a_x` in m/s^2 adds to `dx/dt`, in
    /// m/s^2, m/s^2, rad/s^2, where cornering stiffness is in proportion to load and tyres at the static
    /// load have the `[front, rear]` axle forces in N. Method 2.
    pub fn load_transfer(&self, [front, rear]: [f64; 2], a_x: f64) -> StateVector {
        let shift = self.shift_m(a_x);
        let front = -front * shift / self.rear_axle_distance_m;
        let rear = rear * shift / self.front_axle_distance_m;
        [
            0.0,
            (front + rear) / self.mass_kg,
            (self.front_axle_distance_m * front - self.rear_axle_distance_m * rear)
                / self.yaw_inertia_kg_m2,
        ]
    }

    /// Drive torque in N m at the wheels that holds a speed on a straight road.
    pub fn cruise_torque(&self, v_x_m_per_s: f64) -> f64 {
        self.longitudinal_drag_n_m_s2_per_m2 * v_x_m_per_s * v_x_m_per_s
    }
}
