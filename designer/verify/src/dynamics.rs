//! The error dynamics of the stored gains.
//!
//! With bounded sensor noise v in `y = C x + D_y v`, the error `e = x - x^ - E D_y v` obeys
//! (method 5)
//!
//! ```text
//! e+    = N(h, rho) e + M D d + M F f + (-L(h) + M G rho [0 1 0] E - M K) D_y v
//! W_r r = W_r C e + W_r (I + C E) D_y v,         N(h, rho) = N(h) + M G rho [0 1 0]
//! ```
//!
//! where h are the membership functions at the measured premise, rho lies between twice the ends of
//! v_y's range (15), and K in the hull of [`premise::vertices`]. In h, rho and K these are affine,
//! without products of them: an inequality that is affine in them holds if it does for all rules, at
//! both ends of rho and at all vertices of K.

use crate::channel::Channel;
use crate::exact::{Matrix, approximate, exact, whole};
use crate::premise;
use crate::read::{Design, Detector, RULES};
use crate::refusal::Refusal;

/// Largest residue of the observer's equations that counts as rounding.
const RESIDUE: f64 = 1e-10;

/// The error dynamics.
pub struct ErrorDynamics {
    /// The ends of rho.
    rho: [f64; 2],
    /// `N_i + M G rho [0 1 0]`, at both.
    n: [[Matrix; RULES]; 2],
    /// `-L_i + M G rho [0 1 0] E`, at both.
    injection: [[Matrix; RULES]; 2],
    /// M.
    m: Matrix,
    /// `M K` at the vertices of K.
    m_k: Vec<Matrix>,
    /// `W_r C`.
    output: Matrix,
    /// `W_r (I + C E)`.
    feedthrough: Matrix,
}

/// What sends (e, w, e+) to zero along the error's course, at vertices of rho and K.
pub struct Course {
    /// rho.
    pub rho: f64,
    /// Vertex of K; none without noise.
    pub vertex: Option<usize>,
    /// `[N_i(rho), B_i, -I]`.
    pub by_rule: [Matrix; RULES],
}

impl ErrorDynamics {
    /// From the gains as stored.
    pub fn new(design: &Design) -> Self {
        let Detector { gains, model, evaluation, .. } = &design.detector;
        let [c, e, m] =
            [Matrix::exactly(&design.c), Matrix::exactly(&gains.e), Matrix::exactly(&gains.m)];
        let rho = model.range.v_y.ends().map(|v_y| 2.0 * v_y);
        let e_2 = Matrix::exactly(&[[0.0, 1.0, 0.0]]);
        let m_g = &(&m * &Matrix::exactly(&design.g)) * &e_2;
        let m_g_rho = rho.map(|rho| m_g.times(&exact(rho)));
        let [w_1, w_2] = evaluation.weights;
        let w_r = Matrix::exactly(&[[w_1, 0.0], [0.0, w_2]]);
        Self {
            rho,
            n: m_g_rho.each_ref().map(|m_g| gains.n.each_ref().map(|n| &Matrix::exactly(n) + m_g)),
            injection: m_g_rho
                .each_ref()
                .map(|m_g| gains.l.each_ref().map(|l| &(m_g * &e) - &Matrix::exactly(l))),
            m_k: premise::vertices(design).iter().map(|k| &m * k).collect(),
            output: &w_r * &c,
            feedthrough: &w_r * &(&Matrix::identity(2) + &(&c * &e)),
            m,
        }
    }

    /// Every rule, successor and end of rho, with `N_i(rho)`.
    pub fn successors(&self) -> impl Iterator<Item = (usize, usize, f64, &Matrix)> {
        let at_rho = self.n.iter().zip(self.rho);
        at_rho.flat_map(|(n, rho)| {
            n.iter().enumerate().flat_map(move |(i, n)| (0..RULES).map(move |k| (i, k, rho, n)))
        })
    }

    /// The courses with the inputs of `channel`, at both ends of rho and, with noise, at all
    /// vertices of K.
    pub fn courses(&self, channel: &Channel) -> Vec<Course> {
        let direct = &self.m * &channel.direction;
        let minus_identity = -&Matrix::identity(3);
        let of = |end: usize, vertex: Option<usize>| {
            let by_rule = std::array::from_fn(|i| {
                let injection = &self.injection[end][i];
                let from_noise = match vertex {
                    Some(vertex) => &(injection - &self.m_k[vertex]) * &channel.noise,
                    None => Matrix::zeros(3, 0),
                };
                Matrix::blocks(&[&[&self.n[end][i], &direct, &from_noise, &minus_identity]])
            });
            Course { rho: self.rho[end], vertex, by_rule }
        };
        let vertices: Vec<_> = match channel.noise.width() {
            0 => vec![None],
            _ => (0..self.m_k.len()).map(Some).collect(),
        };
        vertices.into_iter().flat_map(|vertex| [0, 1].map(|end| of(end, vertex))).collect()
    }

    /// What noise of `channel` starts the error with: `z_0 = M C' y` makes it `-M C' D_y v`.
    pub fn start(&self, channel: &Channel) -> Matrix {
        let c_transposed = Matrix::exactly(&[[1.0, 0.0], [0.0, 0.0], [0.0, 1.0]]);
        -&(&(&self.m * &c_transposed) * &channel.noise)
    }

    /// `W_r C`.
    pub fn output(&self) -> &Matrix {
        &self.output
    }

    /// `[W_r C, D_r]` over (e, w), with the inputs w of `channel`.
    pub fn output_with(&self, channel: &Channel) -> Matrix {
        let direct = Matrix::zeros(2, channel.direction.width());
        Matrix::blocks(&[&[&self.output, &direct, &(&self.feedthrough * &channel.noise)]])
    }
}

/// Largest elements of what rounding left of the observer's equations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Residues {
    /// `M - (I + E C)` (11).
    pub m: f64,
    /// `M A_i - N_i M - L_i C` (13).
    pub observer_equation: f64,
    /// `L_i - (H_i - N_i E)` (34), corrected.
    pub l: f64,
}

/// What rounding left of the equations that the observer is built on. They make the error obey the
/// equation that everything else is about.
///
/// # Errors
/// [`Refusal::Residue`]: more than rounding.
pub fn residues(design: &Design) -> Result<Residues, Refusal> {
    let gains = &design.detector.gains;
    let [c, e, m] =
        [Matrix::exactly(&design.c), Matrix::exactly(&gains.e), Matrix::exactly(&gains.m)];
    let m_equation = &m - &(&Matrix::identity(3) + &(&e * &c));
    let mut observer_equation = whole(0);
    let mut l_equation = whole(0);
    for (rule, (n, l)) in design.vertices.iter().zip(gains.n.iter().zip(&gains.l)) {
        let [a, n] = [&rule.a, n].map(|x| Matrix::exactly(x));
        let [l, h] = [l, &rule.h].map(|x| Matrix::exactly(x));
        let observer = &(&(&m * &a) - &(&n * &m)) - &(&l * &c);
        observer_equation = observer_equation.max(observer.largest());
        l_equation = l_equation.max((&(&h - &(&n * &e)) - &l).largest());
    }
    for (equation, residue) in [
        ("M - (I + E C)", &m_equation.largest()),
        ("M A_i - N_i M - L_i C", &observer_equation),
        ("L_i - (H_i - N_i E)", &l_equation),
    ] {
        if *residue > exact(RESIDUE) {
            return Err(Refusal::Residue { equation, residue: approximate(residue) });
        }
    }
    Ok(Residues {
        m: approximate(&m_equation.largest()),
        observer_equation: approximate(&observer_equation),
        l: approximate(&l_equation),
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::channel::Channels;
    use crate::exact::Rational;
    use crate::premise::tests::{design, prediction, weights};

    proptest! {
        /// A step of model (1)-(3) and observer (10), a disturbance and yaw-rate noise included, is
        /// a mean of the courses at the vertices.
        #[test]
        fn courses_are_those_of_model_and_observer(
            (v_x, v_y, r) in (5.0..30.0, -1.5..1.5, -0.5..0.5),
            e in prop::array::uniform3(-0.5..0.5),
            d in -1.0..1.0, noise in -0.05..0.05,
        ) {
            let design = design();
            let Detector { gains, model, evaluation, .. } = &design.detector;
            let column = |rows: [f64; 3]| Matrix::exactly(&rows.map(|x| [x]));
            let [c, e_gain, m, g] = [
                Matrix::exactly(&design.c), Matrix::exactly(&gains.e), Matrix::exactly(&gains.m),
                Matrix::exactly(&design.g),
            ];
            // Yaw moment and yaw-rate noise.
            let channels = Channels::new(&design).unwrap_or_else(|error| panic!("{error}"));
            let channel = &channels.disturbances[1];
            let (d, noise) = (exact(d), exact(noise));
            let v = channel.noise.times(&noise);

            let (x, e) = (column([v_x, v_y, r]), column(e));
            let y = &(&c * &x) + &v;
            let z = &(&m * &x) - &e;
            let x_hat = &z - &(&e_gain * &y);
            let [v_x, v_y, r] = [v_x, v_y, r].map(exact);
            let measured_r = y.at(1, 0);
            let h: Vec<Rational> = {
                let share = |x: &Rational, [from, to]: [&Rational; 2]| (x - from) / (to - from);
                let [slow, fast] = model.range.v_x.ends().map(|v_x| exact(v_x).recip());
                let [right, left] = model.range.r.ends().map(exact);
                let (at_slow, at_left) =
                    (share(&v_x.recip(), [&fast, &slow]), share(&measured_r, [&right, &left]));
                let other = |x: &Rational| whole(1) - x;
                [at_slow.clone(), other(&at_slow)]
                    .iter()
                    .flat_map(|speed| [speed * other(&at_left), speed * &at_left])
                    .collect()
            };

            let next_x = &(&(&x + &prediction(&design, &v_x, &r, &v_y)) + &g.times(&(&v_y * &v_y)))
                + &channel.direction.times(&d);
            let v_y_hat = x_hat.at(1, 0);
            let mut next_z = &m
                * &(&prediction(&design, &v_x, &measured_r, &whole(0))
                    + &g.times(&(&v_y_hat * &v_y_hat)));
            for ((n, l), h) in gains.n.iter().zip(&gains.l).zip(&h) {
                let by_rule = &(&Matrix::exactly(n) * &z) + &(&Matrix::exactly(l) * &y);
                next_z = &next_z + &by_rule.times(h);
            }
            let next_e = &(&m * &next_x) - &next_z;

            let [low, high] = model.range.v_y.ends().map(|v_y| whole(2) * exact(v_y));
            let at_high = (&v_y + &v_y_hat - &low) / (high - &low);
            let of_k = weights(&design, &v_x, &v_y, &r);
            let state = Matrix::new(8, 1, |row, _| match row {
                0..3 => e.at(row, 0),
                3 => d.clone(),
                4 => noise.clone(),
                _ => next_e.at(row - 5, 0),
            });
            let mut left = Matrix::zeros(3, 1);
            let dynamics = ErrorDynamics::new(&design);
            for course in dynamics.courses(channel) {
                let of_rho =
                    if course.rho > 0.0 { at_high.clone() } else { whole(1) - &at_high };
                let of_k = &of_k[course.vertex.unwrap_or_default()];
                for (course, h) in course.by_rule.iter().zip(&h) {
                    left = &left + &(course * &state).times(&(h * &of_rho * of_k));
                }
            }
            prop_assert!(approximate(&left.largest()) < 1e-13);

            // r = y - C x^.
            let residual = &y - &(&c * &x_hat);
            let state = Matrix::new(5, 1, |row, _| state.at(row, 0));
            let [w_1, w_2] = evaluation.weights;
            let weighted = &Matrix::exactly(&[[w_1, 0.0], [0.0, w_2]]) * &residual;
            let missed = &(&dynamics.output_with(channel) * &state) - &weighted;
            prop_assert!(approximate(&missed.largest()) < 1e-13);
        }
    }
}
