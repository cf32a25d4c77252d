//! Inputs of the error dynamics, and what sensor noise does to them.
//!
//! With `y = C x + D_y v` the noise v enters by the injection, by `E y`, and by the measured
//! premise: `A(xi) x + g(xi)` changes by `K D_y v` with `K = d[A(xi) x + g(xi)] / dy`, 3 x 2
//! (method 5).
//!
//! # Conventions
//! - K is taken at the true v_x, v_y, r of a point; between a true and a measured premise it is a
//!   mean of such values, so it lies in the hull of those on S_x.
//! - K is affine in v_y and r, with factors v_x, s = 1/v_x and s^2. In s, the curve (v_x, s, s^2) is
//!   rational of degree three with the positive denominator s, so it lies in the hull of the four
//!   control points of its Bezier form; with the corners of v_y and r these span 16 vertices whose
//!   hull holds every K on S_x.

use steerguard_detector::{Interval, TsModel};

use crate::lmi::matrix::{Matrix, beside};
use crate::problem::band::Band;

/// Inputs of one band, stacked: disturbances or faults by their direction, noise by its signal.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// D or F, 3 x n.
    pub direction: Matrix,
    /// D_y, 2 x n_y.
    pub noise: Matrix,
    /// Their frequency range.
    pub band: Band,
}

impl Channel {
    /// Inputs that act on the state only.
    pub fn disturbance(direction: Matrix, band: Band) -> Self {
        Self { direction, noise: Matrix::zeros(2, 0), band }
    }

    /// The block of `band` among `channels`, which gets an empty one if it has none.
    pub(crate) fn of_band(channels: &mut Vec<Self>, band: Band) -> &mut Self {
        let index = channels.iter().position(|x| x.band == band).unwrap_or_else(|| {
            channels.push(Self::disturbance(Matrix::zeros(3, 0), band));
            channels.len() - 1
        });
        &mut channels[index]
    }

    pub(crate) fn push_direction(&mut self, column: &Matrix) {
        self.direction = beside(&[&self.direction, column]);
    }

    pub(crate) fn push_noise(&mut self, column: &Matrix) {
        self.noise = beside(&[&self.noise, column]);
    }

    /// Number of inputs.
    pub fn inputs(&self) -> usize {
        self.direction.ncols() + self.noise.ncols()
    }

    /// The disturbances alone; none where there are none.
    pub(crate) fn without_noise(&self) -> Option<Self> {
        let direction = self.direction.clone();
        (direction.ncols() > 0).then(|| Self::disturbance(direction, self.band))
    }

    /// Magnitude of what the inputs do.
    pub fn norm(&self) -> f64 {
        self.direction.norm().hypot(self.noise.norm())
    }

    /// All inputs of `channels` as one of all frequencies.
    pub fn stacked(channels: &[Self]) -> Self {
        let mut all = Self::disturbance(Matrix::zeros(3, 0), Band::Full);
        for channel in channels {
            all.push_direction(&channel.direction);
            all.push_noise(&channel.noise);
        }
        all
    }

    /// The same with all inputs counted in units of `1 / unit`.
    pub fn in_unit(&self, unit: f64) -> Self {
        Self { direction: &self.direction / unit, noise: &self.noise / unit, band: self.band }
    }
}

/// The factors of K that depend on v_x.
#[derive(Clone, Copy)]
struct OfSpeed {
    v_x: f64,
    inverse: f64,
    inverse_squared: f64,
}

/// K at `[v_x, v_y, r]`, 3 x 2.
pub fn premise_sensitivity(model: &TsModel, [v_x, v_y, r]: [f64; 3]) -> Matrix {
    let inverse = 1.0 / v_x;
    k(model, OfSpeed { v_x, inverse, inverse_squared: inverse * inverse }, v_y, r)
}

/// Points whose hull holds the curve (v_x, s, s^2), from the highest speed to the lowest: its control
/// points (1, s, s^2, s^3) as a cubic in s, divided by the second.
fn control_points(v_x: Interval) -> [OfSpeed; 4] {
    let [s_0, s_1] = [1.0 / v_x.max, 1.0 / v_x.min];
    let end = |s: f64| OfSpeed { v_x: 1.0 / s, inverse: s, inverse_squared: s * s };
    let between = |near: f64, far: f64| {
        let weight = (2.0 * near + far) / 3.0;
        OfSpeed {
            v_x: 1.0 / weight,
            inverse: (near * near + 2.0 * near * far) / (3.0 * weight),
            inverse_squared: near * near * far / weight,
        }
    };
    [end(s_0), between(s_0, s_1), between(s_1, s_0), end(s_1)]
}

/// Matrices whose hull holds K everywhere on S_x: four for each control point of the speed.
pub fn premise_sensitivity_vertices(model: &TsModel) -> Vec<Matrix> {
    let range = &model.range;
    let corners = |interval: Interval| [interval.min, interval.max];
    let mut vertices = Vec::new();
    for speed in control_points(range.v_x) {
        for v_y in corners(range.v_y) {
            for r in corners(range.r) {
                vertices.push(k(model, speed, v_y, r));
            }
        }
    }
    vertices
}

/// The share of the rules of the lowest speed at each control point, the measured speed being up to
/// `v_x_noise` away: where K is taken at speeds between the true and the measured one, both shares lie
/// in the hull of these ends.
pub fn speed_memberships(model: &TsModel, v_x_noise: f64) -> [[f64; 2]; 4] {
    let Interval { min, max } = model.range.v_x;
    let width = 1.0 / min - 1.0 / max;
    // |1/v - 1/w| = |v - w| / (v w), largest at the lowest speeds.
    let apart = v_x_noise / (min * (min + v_x_noise)) / width;
    control_points(model.range.v_x).map(|speed| {
        let share = (speed.inverse - 1.0 / max) / width;
        [share - apart, share + apart]
    })
}

/// method 5, K.
fn k(model: &TsModel, speed: OfSpeed, v_y: f64, r: f64) -> Matrix {
    let v = &model.vehicle;
    let (l_f, l_r) = (v.front_axle_distance_m, v.rear_axle_distance_m);
    let (c_f, c_r) = (v.front_cornering_stiffness_n_per_rad, v.rear_cornering_stiffness_n_per_rad);
    let (mass, yaw_inertia) = (v.mass_kg, v.yaw_inertia_kg_m2);
    let force = 2.0 * (c_f + c_r) / mass;
    let coupling = 2.0 * (c_r * l_r - c_f * l_f);
    let damping = 2.0 * (c_f * l_f * l_f + c_r * l_r * l_r) / yaw_inertia;
    let OfSpeed { v_x, inverse, inverse_squared } = speed;

    let drag = v.longitudinal_drag_n_m_s2_per_m2 / v.effective_longitudinal_inertia_kg_m;
    Matrix::from_row_slice(
        3,
        2,
        &[
            -2.0 * drag * v_x,
            v_y,
            (force * v_y - coupling / mass * r) * inverse_squared - r,
            coupling / mass * inverse - v_x,
            (damping * r - coupling / yaw_inertia * v_y) * inverse_squared,
            -damping * inverse,
        ],
    ) * model.sampling_period_s
}
