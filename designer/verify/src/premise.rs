//! What sensor noise does by the measured premise (method 5).
//!
//! With `y = C x + D_y v` the observer evaluates `A(xi) x + g(xi)` at the measured instead of the
//! true premise. By the mean value theorem the difference is `K D_y v`, where K is the mean of
//! `d[A(xi) x + g(xi)] / dy`, 3 x 2, over the segment between both. If both lie in S_x, a box, so
//! does the segment, and K lies in the hull of the derivative's values on S_x, for any v.
//!
//! # The hull
//! The derivative is affine in `(v_x, s, s^2)`, `s = 1/v_x`, at given v_y and r, and affine in
//! (v_y, r) at a given speed. Where `(v_x, s, s^2)` lies in the hull of some points and (v_y, r) in
//! that of its corners, the derivative is therefore a mean, with products of both weights, of its
//! values at all pairs of a point and a corner.
//!
//! Four points suffice: multiplied by s, the curve `(1, v_x, s, s^2)` is `(s, 1, s^2, s^3)`, whose
//! Bernstein form over `[s_0, s_1]` has the coefficients
//!
//! ```text
//! s:   s_0,   (2 s_0 + s_1) / 3,          (s_0 + 2 s_1) / 3,          s_1
//! 1:   1,     1,                          1,                          1
//! s^2: s_0^2, (s_0^2 + 2 s_0 s_1) / 3,    (s_1^2 + 2 s_0 s_1) / 3,    s_1^2
//! s^3: s_0^3, s_0^2 s_1,                  s_0 s_1^2,                  s_1^3
//! ```
//!
//! Divided by the first row, which is positive, the others are points whose mean with the weights
//! `b_j(s) c_j / s` is `(v_x, s, s^2)`; c_j is that row, and the Bernstein polynomials b_j are not
//! negative and `sum b_j c_j = s`. With the four corners these are 16 vertices.

use crate::exact::{Matrix, Rational, exact, whole};
use crate::model::Coefficients;
use crate::read::Design;

/// Vertices of K at each control point of the speed: the corners of (v_y, r).
pub const VERTICES_OF_SPEED: usize = 4;

/// `(v_x, s, s^2)`, or a point that its hull is spanned by.
type OfSpeed = [Rational; 3];

/// Matrices whose hull holds K for any true and measured premise in S_x.
pub fn vertices(design: &Design) -> Vec<Matrix> {
    let coefficients = Coefficients::new(design);
    let range = &design.detector.model.range;
    let mut vertices = Vec::new();
    for speed in control_points(range.v_x.ends()) {
        for v_y in range.v_y.ends() {
            for r in range.r.ends() {
                vertices.push(derivative(&coefficients, &speed, &exact(v_y), &exact(r)));
            }
        }
    }
    vertices
}

/// K at `[v_x, v_y, r]`.
pub fn at(design: &Design, state: [f64; 3]) -> Matrix {
    let [v_x, v_y, r] = state.map(exact);
    derivative(&Coefficients::new(design), &of_speed(&v_x), &v_y, &r)
}

fn of_speed(v_x: &Rational) -> OfSpeed {
    let s = v_x.recip();
    [v_x.clone(), s.clone(), &s * &s]
}

/// Points whose hull holds `(v_x, s, s^2)` on a range of speeds.
fn control_points([slowest, fastest]: [f64; 2]) -> [OfSpeed; 4] {
    let [s_0, s_1] = [fastest, slowest].map(|v_x| exact(v_x).recip());
    let blossoms = [[&s_0; 3], [&s_0, &s_0, &s_1], [&s_0, &s_1, &s_1], [&s_1; 3]];
    blossoms.map(|[a, b, c]| {
        let weight = (a + b + c) / whole(3);
        let squares = (a * b + b * c + a * c) / whole(3);
        [weight.recip(), squares / &weight, a * b * c / weight]
    })
}

/// Ends that the share of the rules of the lowest speed lies between at each control point: that of
/// the measured speed, which K's speeds are up to the noise of v_x away from.
///
/// K is a mean over the segment between true and measured premise. At a speed v of that segment
/// `(v, s, s^2)` is a mean of the control points, and the share, affine in s, is the same mean of
/// theirs, up to what `|1/v - 1/w| = |v - w| / (v w)` adds for the measured speed w.
pub fn speed_memberships(design: &Design) -> [[Rational; 2]; 4] {
    let v_x = design.detector.model.range.v_x.ends();
    let [slowest, fastest] = v_x.map(exact);
    let width = slowest.recip() - fastest.recip();
    let noise = exact(design.spec.noise.v_x.bound_m_per_s.unwrap_or(0.0));
    let apart = &noise / (&slowest * (&slowest + &noise)) / &width;
    control_points(v_x).map(|[_, s, _]| {
        let share = (s - fastest.recip()) / &width;
        [&share - &apart, &share + &apart]
    })
}

/// `d[A(xi) x + g(xi)] / dy`, method 5.
fn derivative(x: &Coefficients, [v_x, s, s_2]: &OfSpeed, v_y: &Rational, r: &Rational) -> Matrix {
    let [per_mass, per_inertia] = [&x.mass, &x.yaw_inertia].map(|inertia| &x.coupling / inertia);
    let rows = [
        [whole(-2) * &x.drag * v_x, v_y.clone()],
        [(&x.force * v_y - &per_mass * r) * s_2 - r, &per_mass * s - v_x],
        [(&x.damping * r - &per_inertia * v_y) * s_2, -&x.damping * s],
    ];
    Matrix::new(3, 2, |row, column| &x.period * &rows[row][column])
}

#[cfg(test)]
pub mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::read::{Interval, Range};

    pub fn design() -> Design {
        let text = include_str!("../tests/fixtures/noise.json");
        Design::read(text).map(|(design, _)| design).unwrap_or_else(|error| panic!("{error}"))
    }

    /// Weights of the Bernstein polynomials of degree three at t.
    fn bernstein(t: &Rational) -> [Rational; 4] {
        let u = whole(1) - t;
        [&u * &u * &u, whole(3) * t * &u * &u, whole(3) * t * t * &u, t * t * t]
    }

    /// Weights of the vertices whose mean is K at a point.
    pub fn weights(design: &Design, v_x: &Rational, v_y: &Rational, r: &Rational) -> Vec<Rational> {
        let [slowest, fastest] = design.detector.model.range.v_x.ends();
        let [s, s_0, s_1] = [v_x, &exact(fastest), &exact(slowest)].map(Rational::recip);
        let c = [
            s_0.clone(),
            (whole(2) * &s_0 + &s_1) / whole(3),
            (&s_0 + whole(2) * &s_1) / whole(3),
            s_1.clone(),
        ];
        let bernstein = bernstein(&((&s - &s_0) / (s_1 - s_0)));
        let corners = |x: &Rational, [from, to]: [f64; 2]| {
            let share = (x - exact(from)) / (exact(to) - exact(from));
            [whole(1) - &share, share]
        };
        let mut weights = Vec::new();
        for (b, c) in bernstein.iter().zip(&c) {
            for of_v_y in corners(v_y, design.detector.model.range.v_y.ends()) {
                for of_r in corners(r, design.detector.model.range.r.ends()) {
                    weights.push(b * c / &s * &of_v_y * of_r);
                }
            }
        }
        weights
    }

    fn point(range: [f64; 2]) -> impl Strategy<Value = (f64, f64, f64)> {
        let [min, max] = range;
        (min..max, min..max, min..=max).prop_map(|(a, b, x)| {
            let (from, to) = (a.min(b), a.max(b).max(a.min(b).next_up()));
            (from, to, x.clamp(from, to))
        })
    }

    proptest! {
        /// On a random S_x, K at a random point is the mean of the vertices with weights that are
        /// not negative and sum up to one: all exactly.
        #[test]
        fn hull_of_the_vertices_holds_k(
            (slowest, fastest, v_x) in point([0.5, 60.0]),
            (right, left, v_y) in point([-3.0, 3.0]),
            (least, most, r) in point([-1.0, 1.0]),
        ) {
            let mut design = design();
            design.detector.model.range = Range {
                v_x: Interval { min: slowest, max: fastest },
                v_y: Interval { min: right, max: left },
                r: Interval { min: least, max: most },
            };
            let k = derivative(
                &Coefficients::new(&design), &of_speed(&exact(v_x)), &exact(v_y), &exact(r),
            );

            let weights = weights(&design, &exact(v_x), &exact(v_y), &exact(r));
            prop_assert!(weights.iter().all(|weight| *weight >= whole(0)));
            prop_assert_eq!(weights.iter().sum::<Rational>(), whole(1));
            let vertices = vertices(&design);
            prop_assert_eq!(vertices.len(), weights.len());
            let terms = vertices.iter().zip(&weights).map(|(vertex, weight)| vertex.times(weight));
            prop_assert_eq!(terms.fold(Matrix::zeros(3, 2), |sum, term| &sum + &term), k);
        }

        /// The measured speed's share and a speed between it and the true one: the share lies between
        /// the means of the ends at the control points, with the weights that give that speed's K.
        #[test]
        fn speed_memberships_hold_true_and_measured_speed(
            (v_x, other) in (5.0..30.0, 5.0..30.0), bound in 0.001..30.0, between in 0.0..=1.0,
        ) {
            let mut design = design();
            design.spec.noise.v_x.bound_m_per_s = Some(bound);
            let measured = f64::clamp(other, v_x - bound, v_x + bound);
            let [v_x, measured, between] = [v_x, measured, between].map(exact);
            let speed = &v_x + &between * (&measured - &v_x);
            let v_x = design.detector.model.range.v_x.ends();
            let [slowest, fastest] = v_x.map(|v_x| exact(v_x).recip());
            let share = (measured.recip() - &fastest) / (slowest - fastest);

            let weights = weights(&design, &speed, &whole(0), &whole(0));
            let mut ends = [whole(0), whole(0)];
            for (at_speed, of_speed) in weights.chunks(4).zip(speed_memberships(&design)) {
                for (end, at) in ends.iter_mut().zip(of_speed) {
                    *end += at_speed.iter().sum::<Rational>() * at;
                }
            }
            prop_assert!(ends[0] <= share && share <= ends[1]);
        }

        /// K against the difference of the model's own equations (1)-(3) at two measured premises,
        /// the state the same: its mean over the segment in r, exactly; in v_x, at its middle up to
        /// the square of half its length.
        #[test]
        fn derivative_is_that_of_the_model(
            v_x in 5.0..30.0, v_y in -1.5..1.5, r in -0.55..0.55, step in 0.001..0.1,
        ) {
            let design = design();
            let [v_x, v_y, r, step] = [v_x, v_y, r, step].map(exact);
            let coefficients = Coefficients::new(&design);
            let k = derivative(&coefficients, &of_speed(&v_x), &v_y, &r);
            let model = |v_x: &Rational, r: &Rational| prediction(&design, v_x, r, &v_y);

            let difference = &model(&v_x, &(&r + &step)) - &model(&v_x, &r);
            prop_assert_eq!(difference, k.column(1).times(&step));

            let half = &step / whole(1_000_000);
            let difference = &model(&(&v_x + &half), &r) - &model(&(&v_x - &half), &r);
            let missed = &difference - &k.column(0).times(&(whole(2) * &half));
            prop_assert!(missed.largest() < k.largest() * &half * &half * &half);
        }
    }

    /// `T_s (A(xi) x + g(xi))` without what does not depend on xi, from (1)-(3).
    pub fn prediction(design: &Design, v_x: &Rational, r: &Rational, v_y: &Rational) -> Matrix {
        let v = &design.detector.model.vehicle;
        let (c_f, c_r) = (
            exact(v.front_cornering_stiffness_n_per_rad),
            exact(v.rear_cornering_stiffness_n_per_rad),
        );
        let (l_f, l_r) = (exact(v.front_axle_distance_m), exact(v.rear_axle_distance_m));
        // Lateral forces of the axles without steering: side slips (v_y +- l r) / v_x.
        let front = whole(-2) * c_f * (v_y + &l_f * r) / v_x;
        let rear = whole(-2) * c_r * (v_y - &l_r * r) / v_x;
        let drag = exact(v.longitudinal_drag_n_m_s2_per_m2) * v_x * v_x
            / exact(v.effective_longitudinal_inertia_kg_m);
        let rows = [
            r * v_y - drag,
            (&front + &rear) / exact(v.mass_kg) - r * v_x,
            (l_f * front - l_r * rear) / exact(v.yaw_inertia_kg_m2),
        ];
        Matrix::new(3, 1, |row, _| exact(design.detector.model.sampling_period_s) * &rows[row])
    }
}
