//! What the vehicle measures, is told and is: fields by name and unit, so that swapped arguments do not
//! compile.
//!
//! # Conventions
//! - Matrices meet a signal as its `vector`, in the order of its fields.

/// Vector beside a [`VehicleState`], in the order of its fields: what acts on the state or changes it,
/// the error, the observer's z.
pub type StateVector = [f64; 3];

/// State x of the vehicle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VehicleState {
    /// Longitudinal speed, m/s.
    pub v_x_m_per_s: f64,
    /// Lateral speed, m/s.
    pub v_y_m_per_s: f64,
    /// Yaw rate, rad/s.
    pub r_rad_per_s: f64,
}

impl VehicleState {
    /// `[v_x, v_y, r]`.
    pub const fn vector(self) -> StateVector {
        [self.v_x_m_per_s, self.v_y_m_per_s, self.r_rad_per_s]
    }

    /// `y = C x`.
    pub const fn measured(self) -> Measurement {
        Measurement { v_x_m_per_s: self.v_x_m_per_s, r_rad_per_s: self.r_rad_per_s }
    }
}

impl From<StateVector> for VehicleState {
    fn from([v_x_m_per_s, v_y_m_per_s, r_rad_per_s]: StateVector) -> Self {
        Self { v_x_m_per_s, v_y_m_per_s, r_rad_per_s }
    }
}

/// Measurement `y = C x`; a residual likewise.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measurement {
    /// Longitudinal speed, m/s.
    pub v_x_m_per_s: f64,
    /// Yaw rate, rad/s.
    pub r_rad_per_s: f64,
}

impl Measurement {
    /// `[v_x, r]`.
    pub const fn vector(self) -> [f64; 2] {
        [self.v_x_m_per_s, self.r_rad_per_s]
    }
}

/// Input u, held over a sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Input {
    /// Drive torque at the wheels, N m.
    pub t_eng_n_m: f64,
    /// Angle at the road wheel, rad.
    pub delta_rad: f64,
}

impl Input {
    /// `[T_eng, delta]`.
    pub const fn vector(self) -> [f64; 2] {
        [self.t_eng_n_m, self.delta_rad]
    }
}
