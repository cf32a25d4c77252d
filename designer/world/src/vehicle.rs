//! The true vehicle: (1)-(2) with what the detector's model leaves out.

use steerguard_detector::{StateVector, Vehicle, VehicleState};

use crate::Tyres;

/// Below this speed, m/s, slip angles are taken at this speed: 1/v_x has no meaning at standstill.
const SLIP_SPEED_FLOOR_M_PER_S: f64 = 0.5;

/// A vehicle on its tyres.
///
/// (1) corrected: the lateral drag opposes the motion to either side, `C_y v_y |v_y|`; as printed,
/// `C_y v_y^2`, it would always push to the right.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrueVehicle {
    /// Vehicle data; cornering stiffnesses are those at the static axle loads.
    pub data: Vehicle,
    /// Its tyres.
    pub tyres: Tyres,
}

impl TrueVehicle {
    /// `data` on linear tyres: the vehicle that the detector's model knows.
    pub const fn linear(data: Vehicle) -> Self {
        Self { data, tyres: Tyres::Linear }
    }

    /// What a lateral force in N at the centre of gravity and a yaw moment in N m add to the state's
    /// derivative.
    pub fn push(&self, side_force_n: f64, yaw_moment_n_m: f64) -> StateVector {
        [0.0, side_force_n / self.data.mass_kg, yaw_moment_n_m / self.data.yaw_inertia_kg_m2]
    }

    /// Axle forces `[F_yf, F_yr]` in N at state `x`, road-wheel angle `delta` and longitudinal
    /// acceleration `a_x`. Cornering stiffness is in proportion to the axle's load.
    #[inline(always)]
    pub fn axle_forces_n(&self, x: VehicleState, delta: f64, a_x: f64) -> [f64; 2] {
        let v_x_m_per_s = x.v_x_m_per_s.max(SLIP_SPEED_FLOOR_M_PER_S);
        let at_speed = VehicleState { v_x_m_per_s, ..x };
        let [mut front, mut rear] = self.data.axle_forces(at_speed, delta);
        let transfers = self.data.centre_of_gravity_height_m > 0.0;
        if !transfers && self.tyres == Tyres::Linear {
            return [front, rear];
        }
        let [front_load, rear_load] = self.data.axle_loads_n(a_x);
        if transfers {
            let [static_front, static_rear] = self.data.axle_loads_n(0.0);
            front *= front_load / static_front;
            rear *= rear_load / static_rear;
        }
        [self.tyres.force_n(front, front_load), self.tyres.force_n(rear, rear_load)]
    }

    /// `d[v_x, v_y, r]/dt` under `drive_torque_n_m` at the wheels and road-wheel angle `delta`, with
    /// `push` added.
    // Inlined: between the stages of rk4 the state stays in registers, a quarter of the time saved.
    #[inline(always)]
    pub fn derivative(
        &self,
        x: VehicleState,
        drive_torque_n_m: f64,
        delta: f64,
        [p_x, p_y, p_r]: StateVector,
    ) -> StateVector {
        let [v_x, v_y, r] = x.vector();
        let Vehicle {
            mass_kg,
            yaw_inertia_kg_m2,
            effective_longitudinal_inertia_kg_m,
            front_axle_distance_m,
            rear_axle_distance_m,
            longitudinal_drag_n_m_s2_per_m2,
            lateral_drag_n_s2_per_m2,
            ..
        } = self.data;
        let a_x = (drive_torque_n_m - longitudinal_drag_n_m_s2_per_m2 * v_x * v_x)
            / effective_longitudinal_inertia_kg_m;
        let [front, rear] = self.axle_forces_n(x, delta, a_x);
        let drag = lateral_drag_n_s2_per_m2 * v_y * v_y.abs();
        [
            a_x + v_y * r + p_x,
            (front + rear - drag) / mass_kg - v_x * r + p_y,
            (front_axle_distance_m * front - rear_axle_distance_m * rear) / yaw_inertia_kg_m2 + p_r,
        ]
    }
}
