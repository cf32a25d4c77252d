//! The model, recomputed from the vehicle data: what the file's A_i, B, G, D, F must agree with.
//!
//! From (1)-(3) of Wang et al., IFAC CESCIT 2021, doi 10.1016/j.ifacol.2021.10.033, discretised by
//! Euler: see `designer/METHOD.md` 1 and 2.

use crate::Refusal;
use crate::exact::{Matrix, Rational, approximate, exact, whole};
use crate::file::{Design, Disturbance, Fault};

/// How far a stored element may be from the exact one, relative to the largest of its column.
const AGREEMENT: f64 = 1e-12;

/// pi lies between these.
pub fn pi() -> [Rational; 2] {
    let digits = whole(3_141_592_653_589_793_238);
    let unit = whole(1_000_000_000_000_000_000);
    [&digits / &unit, (&digits + whole(1)) / &unit]
}

/// Checks A_i, B, G, C, D and F of the file.
pub fn check(design: &Design) -> Result<(), Refusal> {
    if design.c != [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]] {
        return Err(Refusal::Contradiction { key: "C".into() });
    }
    check_ranges(design)?;
    let v = &design.vehicle;
    let t = exact(design.sampling_period_s);
    let (mass, yaw_inertia) = (exact(v.mass_kg), exact(v.yaw_inertia_kg_m2));
    let (l_f, l_r) = (exact(v.front_axle_distance_m), exact(v.rear_axle_distance_m));
    let c_f = exact(v.front_cornering_stiffness_n_per_rad);
    let c_r = exact(v.rear_cornering_stiffness_n_per_rad);
    let (zero, one, two) = (whole(0), whole(1), whole(2));

    // (5), corrected.
    let [slowest, fastest] = design.premise.v_x_m_per_s;
    let [right, left] = design.premise.r_rad_per_s;
    let rules = [(slowest, right), (slowest, left), (fastest, right), (fastest, left)];
    for (i, (v_x, r)) in rules.into_iter().enumerate() {
        let (v_x, r) = (exact(v_x), exact(r));
        let a_22 = -&two * (&c_f + &c_r) / (&mass * &v_x);
        let a_32 = &two * (&l_r * &c_r - &l_f * &c_f) / (&yaw_inertia * &v_x);
        let a = matrix([
            [one.clone(), &t * r, zero.clone()],
            [zero.clone(), &one + &t * a_22, zero.clone()],
            [zero.clone(), &t * a_32, one.clone()],
        ]);
        agree(&format!("vertices[{i}].A"), &Matrix::exactly(&design.vertices[i].a), &a)?;
    }
    let b = matrix([
        [&t / exact(v.effective_longitudinal_inertia_kg_m), zero.clone()],
        [zero.clone(), &two * &t * &c_f / &mass],
        [zero.clone(), &two * &t * &l_f * &c_f / &yaw_inertia],
    ]);
    agree("B", &Matrix::exactly(&design.b), &b)?;
    let g_2 = -&t * exact(v.lateral_drag_n_s2_per_m2) / &mass;
    agree("G", &Matrix::exactly(&design.g), &matrix([[zero.clone()], [g_2], [zero.clone()]]))?;

    let fault = match design.spec.fault[0] {
        Fault::Torque { .. } => 0,
        Fault::Steering { .. } => 1,
    };
    let f = Matrix::new(3, 1, |row, _| b.at(row, fault));
    agree("F", &Matrix::exactly(&design.f), &f)?;
    let directions: Vec<_> =
        design.spec.disturbance.iter().map(|d| direction(d, &mass, &yaw_inertia)).collect();
    let d = design.d()?;
    agree("D", &d, &Matrix::new(3, d.width(), |row, column| &t * &directions[column][row]))
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
        let of_column = |x: &Matrix| Matrix::new(3, 1, |row, _| x.at(row, column));
        let (stored, recomputed) = (of_column(stored), of_column(recomputed));
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

/// A frequency range in radians a sample.
pub enum Band {
    /// `|w| <= theta`.
    Low(Theta),
    /// `|w| >= theta`.
    High(Theta),
    /// All.
    Full,
}

/// `theta = 2 pi f T_s`: f T_s, exactly.
pub struct Theta {
    cycles_per_sample: Rational,
}

impl Band {
    /// The range that `band_hz` stands for.
    pub fn new(band_hz: [f64; 2], sampling_period_s: f64) -> Result<Self, Refusal> {
        let [from, to] = band_hz.map(|hz| exact(hz) * exact(sampling_period_s));
        // Rounding of the Nyquist frequency.
        let [half_below, half_above] =
            [whole(1) - exact(AGREEMENT), whole(1) + exact(AGREEMENT)].map(|x| x / whole(2));
        let from_zero = from == whole(0);
        let to_nyquist = to >= half_below;
        let ordered = whole(0) <= from && from < to && from < half_below && to <= half_above;
        if !ordered || !(from_zero || to_nyquist) {
            return Err(Refusal::Band { band_hz });
        }
        Ok(match (from_zero, to_nyquist) {
            (true, true) => Self::Full,
            (true, false) => Self::Low(Theta { cycles_per_sample: to }),
            _ => Self::High(Theta { cycles_per_sample: from }),
        })
    }
}

impl Theta {
    /// Numbers that `2 cos(theta)` lies between.
    pub fn two_cos(&self) -> [Rational; 2] {
        let two = whole(2);
        // Of theta in [0, pi] the cosine falls.
        let [below, above] = pi().map(|pi| &two * pi * &self.cycles_per_sample);
        [&two * cosine(&above, 23), &two * cosine(&below, 24)]
    }

    /// The nearest f64.
    pub fn approximate(&self) -> f64 {
        2.0 * std::f64::consts::PI * approximate(&self.cycles_per_sample)
    }
}

/// `1 - x^2/2! + x^4/4! - ...` up to the power `2 last`: at most cos(x) for odd `last`, at least
/// for even, whatever x.
fn cosine(x: &Rational, last: i64) -> Rational {
    let mut term = whole(1);
    let mut sum = whole(1);
    for k in 1..=last {
        term = -term * x * x / whole(2 * k * (2 * k - 1));
        sum += &term;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cosine_is_enclosed() {
        for (hz, period) in [(1.5, 0.01), (0.001, 0.001), (49.0, 0.01), (25.0, 0.01)] {
            let Ok(Band::Low(theta)) = Band::new([0.0, hz], period) else { panic!() };
            let [below, above] = theta.two_cos();
            assert!(below < above);
            assert!(approximate(&(&above - &below)) < 1e-16);
            let expected = 2.0 * theta.approximate().cos();
            assert!((approximate(&below) - expected).abs() < 1e-15);
        }
    }

    #[test]
    fn bands_are_low_high_or_full() {
        assert!(matches!(Band::new([0.0, 1.5], 0.01), Ok(Band::Low(_))));
        assert!(matches!(Band::new([1.5, 50.0], 0.01), Ok(Band::High(_))));
        assert!(matches!(Band::new([0.0, 0.5 / 0.03], 0.03), Ok(Band::Full)));
        for band in [[1.0, 2.0], [2.0, 2.0], [-1.0, 2.0], [3.0, 2.0]] {
            assert!(matches!(Band::new(band, 0.01), Err(Refusal::Band { .. })));
        }
    }
}
