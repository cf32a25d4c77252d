//! The model, recomputed from the vehicle data: what the file's A_i, B, G, D, D_y, F must agree with.
//!
//! From (1)-(3) of Wang et al., IFAC CESCIT 2021, doi 10.1016/j.ifacol.2021.10.033, discretised by
//! Euler: see `designer/METHOD.md` 1 and 2.

use crate::Refusal;
use crate::band::pi;
use crate::channel::d_y;
use crate::exact::{Matrix, Rational, approximate, exact, whole};
use crate::file::{Design, Disturbance, columns};

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
        let v = &design.vehicle;
        let (mass, yaw_inertia) = (exact(v.mass_kg), exact(v.yaw_inertia_kg_m2));
        let (l_f, l_r) = (exact(v.front_axle_distance_m), exact(v.rear_axle_distance_m));
        let c_f = exact(v.front_cornering_stiffness_n_per_rad);
        let c_r = exact(v.rear_cornering_stiffness_n_per_rad);
        Self {
            period: exact(design.sampling_period_s),
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
    if design.c != [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]] {
        return Err(Refusal::Contradiction { key: "C".into() });
    }
    check_ranges(design)?;
    let coefficients = Coefficients::new(design);
    let Coefficients { period: t, mass, yaw_inertia, .. } = &coefficients;

    let [slowest, fastest] = design.premise.v_x_m_per_s;
    let [right, left] = design.premise.r_rad_per_s;
    let rules = [(slowest, right), (slowest, left), (fastest, right), (fastest, left)];
    for (i, (v_x, r)) in rules.into_iter().enumerate() {
        let stored = Matrix::exactly(&design.vertices[i].a);
        agree(&format!("vertices[{i}].A"), &stored, &coefficients.a(v_x, r))?;
    }
    let v = &design.vehicle;
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
    let directions: Vec<_> =
        spec.disturbance.iter().map(|x| direction(x, mass, yaw_inertia)).collect();
    let d = design.d()?;
    agree("D", &d, &Matrix::new(3, d.width(), |row, k| t * &directions[k][row]))?;
    check_d_y(design)
}

/// D_y has a column of each bounded noise, and is null without.
fn check_d_y(design: &Design) -> Result<(), Refusal> {
    let d_y = d_y(design);
    let Some(stored) = &design.d_y else {
        let contradiction = Refusal::Contradiction { key: "D_y".into() };
        return if d_y.width() == 0 { Ok(()) } else { Err(contradiction) };
    };
    let expected = "a column of each bounded noise, or null without";
    let stored = columns(stored, d_y.width()).ok_or(Refusal::Shape { key: "D_y", expected })?;
    agree("D_y", &stored, &d_y)
}

/// S_x is a box with positive speeds, and T_s is positive.
fn check_ranges(design: &Design) -> Result<(), Refusal> {
    let premise = &design.premise;
    for (key, [min, max]) in [
        ("v_x_m_per_s", premise.v_x_m_per_s),
        ("v_y_m_per_s", premise.v_y_m_per_s),
        ("r_rad_per_s", premise.r_rad_per_s),
    ] {
        if min >= max || (key == "v_x_m_per_s" && min <= 0.0) {
            return Err(Refusal::Range { key: format!("premise.{key}"), value: [min, max] });
        }
    }
    let v = &design.vehicle;
    for (key, value) in [
        ("sampling_period_s", design.sampling_period_s),
        ("vehicle.mass_kg", v.mass_kg),
        ("vehicle.yaw_inertia_kg_m2", v.yaw_inertia_kg_m2),
        ("vehicle.effective_longitudinal_inertia_kg_m", v.effective_longitudinal_inertia_kg_m),
    ] {
        if value <= 0.0 {
            return Err(Refusal::NotPositive { key: key.into(), value });
        }
    }
    Ok(())
}

/// Effect of a disturbance on [v_x', v_y', r'] per unit.
fn direction(disturbance: &Disturbance, mass: &Rational, yaw_inertia: &Rational) -> [Rational; 3] {
    match disturbance {
        Disturbance::SideWind { acting_ahead_m, .. } => {
            [whole(0), whole(1), mass * exact(*acting_ahead_m) / yaw_inertia]
        }
        Disturbance::Bank { .. } => {
            let gravity = whole(980_665) / whole(100_000);
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
