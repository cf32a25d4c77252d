//! What sensor noise does by the measured premise (METHOD.md 5).
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
use crate::file::Design;
use crate::model::Coefficients;

/// `(v_x, s, s^2)`, or a point that its hull is spanned by.
type OfSpeed = [Rational; 3];

/// Matrices whose hull holds K for any true and measured premise in S_x.
pub fn vertices(design: &Design) -> Vec<Matrix> {
    let coefficients = Coefficients::new(design);
    let premise = &design.premise;
    let mut vertices = Vec::new();
    for speed in control_points(premise.v_x_m_per_s) {
        for v_y in premise.v_y_m_per_s {
            for r in premise.r_rad_per_s {
                vertices.push(derivative(&coefficients, &speed, &exact(v_y), &exact(r)));
            }
        }
    }
    vertices
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

/// `d[A(xi) x + g(xi)] / dy`, METHOD.md 5.
fn derivative(x: &Coefficients, [v_x, s, s_2]: &OfSpeed, v_y: &Rational, r: &Rational) -> Matrix {
    let [per_mass, per_inertia] = [&x.mass, &x.yaw_inertia].map(|inertia| &x.coupling / inertia);
    let rows = [
        [whole(-2) * &x.drag * v_x, v_y.clone()],
        [(&x.force * v_y - &per_mass * r) * s_2 - r, &per_mass * s - v_x],
        [(&x.damping * r - &per_inertia * v_y) * s_2, -&x.damping * s],
    ];
    Matrix::new(3, 2, |row, column| &x.period * &rows[row][column])
}
