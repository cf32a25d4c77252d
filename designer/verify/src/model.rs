//! The model, recomputed from the vehicle data: what the file's A_i, B, G, D, D_y, F must agree with.
//!
//! From (1)-(3) of Wang et al., IFAC CESCIT 2021, doi 10.1016/j.ifacol.2021.10.033, discretised by
//! Euler: see method 1 and 2.

use crate::agreement::same;
use crate::band::pi;
use crate::channel::d_y;
use crate::exact::{Matrix, Rational, approximate, exact, whole};
use crate::read::{Design, Disturbance, Range, columns};
use crate::refusal::Refusal;

/// How far a stored element may be from the exact one, relative to the largest of its column.
const AGREEMENT: f64 = 1e-12;

/// Exact coefficients of the model: what stands in A_i, B, G and K, with the period and 1/v_x apart.
pub struct Coefficients {
    /// T_s.
    pub period: Rational,
    /// M_v.
    pub mass: Rational,
    /// I_z.
    pub yaw_inertia: Rational,
    /// 2 (C_f + C_r) / M_v.
    pub force: Rational,
    /// 2 (C_r l_r - C_f l_f).
    pub coupling: Rational,
    /// 2 (C_f l_f^2 + C_r l_r^2) / I_z.
    pub damping: Rational,
    /// C_x / I_e.
    pub drag: Rational,
}

impl Coefficients {
    pub fn new(design: &Design) -> Self {
        let v = &design.detector.model.vehicle;
        let (mass, yaw_inertia) = (exact(v.mass_kg), exact(v.yaw_inertia_kg_m2));
        let (l_f, l_r) = (exact(v.front_axle_distance_m), exact(v.rear_axle_distance_m));
        let c_f = exact(v.front_cornering_stiffness_n_per_rad);
        let c_r = exact(v.rear_cornering_stiffness_n_per_rad);
        Self {
            period: exact(design.detector.model.sampling_period_s),
            force: whole(2) * (&c_f + &c_r) / &mass,
            coupling: whole(2) * (&c_r * &l_r - &c_f * &l_f),
            damping: whole(2) * (c_f * &l_f * l_f + c_r * &l_r * l_r) / &yaw_inertia,
            drag: exact(v.longitudinal_drag_n_m_s2_per_m2)
                / exact(v.effective_longitudinal_inertia_kg_m),
            mass,
            yaw_inertia,
        }
    }

    /// A at a premise, (5), corrected.
    fn a(&self, v_x: f64, r: f64) -> Matrix {
        let t = &self.period;
        let [a_22, a_32] =
            [-&self.force, &self.coupling / &self.yaw_inertia].map(|x| x / exact(v_x));
        matrix([
            [whole(1), t * exact(r), whole(0)],
            [whole(0), whole(1) + t * a_22, whole(0)],
            [whole(0), t * a_32, whole(1)],
        ])
    }
}

/// Checks A_i, B, G, C, D, D_y and F of the file.
pub fn check(design: &Design) -> Result<(), Refusal> {
    same("C", &design.c, &[[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])?;
    check_ranges(design)?;
    let coefficients = Coefficients::new(design);
    let Coefficients { period: t, mass, yaw_inertia, .. } = &coefficients;

    let range = &design.detector.model.range;
    let [[slowest, fastest], [right, left]] = [range.v_x.ends(), range.r.ends()];
    let rules = [(slowest, right), (slowest, left), (fastest, right), (fastest, left)];
    for (i, (v_x, r)) in rules.into_iter().enumerate() {
        let stored = Matrix::exactly(&design.vertices[i].a);
        agree(&format!("vertices[{i}].A"), &stored, &coefficients.a(v_x, r))?;
    }
    let v = &design.detector.model.vehicle;
    let front = whole(2) * t * exact(v.front_cornering_stiffness_n_per_rad);
    let b = matrix([
        [t / exact(v.effective_longitudinal_inertia_kg_m), whole(0)],
        [whole(0), &front / mass],
        [whole(0), front * exact(v.front_axle_distance_m) / yaw_inertia],
    ]);
    agree("B", &Matrix::exactly(&design.b), &b)?;
    let g_2 = -t * exact(v.lateral_drag_n_s2_per_m2) / mass;
    agree("G", &Matrix::exactly(&design.g), &matrix([[whole(0)], [g_2], [whole(0)]]))?;

    let spec = &design.spec;
    let f = design.f()?;
    agree("F", &f, &Matrix::new(3, f.width(), |row, k| b.at(row, spec.fault[k].column())))?;
    let gravity = design.constants.gravity_m_per_s2;
    let directions: Vec<_> =
        spec.disturbance.iter().map(|x| direction(x, mass, yaw_inertia, gravity)).collect();
    let d = design.d()?;
    agree("D", &d, &Matrix::new(3, d.width(), |row, k| t * &directions[k][row]))?;
    check_d_y(design)
}

/// D_y has a column of each bounded noise, and is null without.
fn check_d_y(design: &Design) -> Result<(), Refusal> {
    const EXPECTED: &str = "a column of each bounded noise, or null without";
    let d_y = d_y(design);
    let Some(stored) = &design.d_y else {
        return match d_y.width() {
            0 => Ok(()),
            _ => Err(Refusal::Shape { key: "D_y", expected: EXPECTED }),
        };
    };
    let stored =
        columns(stored, d_y.width()).ok_or(Refusal::Shape { key: "D_y", expected: EXPECTED })?;
    agree("D_y", &stored, &d_y)
}

/// S_x is a box with positive speeds, and T_s is positive.
fn check_ranges(design: &Design) -> Result<(), Refusal> {
    let model = &design.detector.model;
    let Range { v_x, v_y, r } = &model.range;
    for (key, interval) in [("v_x", v_x), ("v_y", v_y), ("r", r)] {
        let [min, max] = interval.ends();
        if min >= max || (key == "v_x" && min <= 0.0) {
            let key = format!("detector.model.range.{key}");
            return Err(Refusal::Range { key, value: [min, max] });
        }
    }
    let v = &design.detector.model.vehicle;
    for (key, value) in [
        ("sampling_period_s", model.sampling_period_s),
        ("vehicle.mass_kg", v.mass_kg),
        ("vehicle.yaw_inertia_kg_m2", v.yaw_inertia_kg_m2),
        ("vehicle.effective_longitudinal_inertia_kg_m", v.effective_longitudinal_inertia_kg_m),
    ] {
        if value <= 0.0 {
            return Err(Refusal::NotPositive { key: format!("detector.model.{key}"), value });
        }
    }
    Ok(())
}

/// Effect of a disturbance on [v_x', v_y', r'] per unit.
fn direction(
    disturbance: &Disturbance,
    mass: &Rational,
    yaw_inertia: &Rational,
    gravity_m_per_s2: f64,
) -> [Rational; 3] {
    match disturbance {
        Disturbance::SideWind { acting_ahead_m, .. } => {
            [whole(0), whole(1), mass * exact(*acting_ahead_m) / yaw_inertia]
        }
        Disturbance::Bank { .. } => {
            let gravity = exact(gravity_m_per_s2);
            let [pi, _] = pi();
            [whole(0), -gravity * pi / whole(180), whole(0)]
        }
        Disturbance::YawMoment { .. } => [whole(0), whole(0), yaw_inertia.recip()],
        Disturbance::Direction { direction, .. } => direction.map(exact),
    }
}

fn agree(key: &str, stored: &Matrix, recomputed: &Matrix) -> Result<(), Refusal> {
    for column in 0..recomputed.width() {
        let (stored, recomputed) = (stored.column(column), recomputed.column(column));
        let difference = (&stored - &recomputed).largest();
        if difference > recomputed.largest() * exact(AGREEMENT) {
            let difference = approximate(&difference);
            return Err(Refusal::Model { key: key.into(), column, difference });
        }
    }
    Ok(())
}

fn matrix<const K: usize>(rows: [[Rational; K]; 3]) -> Matrix {
    Matrix::new(3, K, |row, column| rows[row][column].clone())
}
