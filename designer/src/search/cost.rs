//! What the refinement minimises, and its slope.
//!
//! ```text
//! -ln ratio + price of slow modes + price of an estimate that leaves + price of another scale
//! ```
//!
//! Sums of powers stand for the extremes over the operating points. Slow are modes at the operating
//! points, and products of the error dynamics at two vertices, `N_i(rho) N_k(rho')`, which a common
//! decay has to bound as well: without them a certificate of decay often fails although every frozen
//! mode decays. The estimate leaves where e_2 after a step of the fault exceeds the cap.
//!
//! # Conventions
//! - Coordinates of gains: E by rows, then of each N_i by rows the first and third column; the second
//!   is that of M A_i.
//! - An [`Adjoint`] holds the derivatives of a number by N, M, `from_noise` and `I + C E` of an operating
//!   point, each of the form of what it is by; the chain rule takes it to the coordinates.

use nalgebra::{
    Complex, Matrix2, Matrix3, Matrix3x2, RowVector3, SMatrix, SVector, Vector2, Vector3,
};
use steerguard_detector::{C, RULES};

use crate::analysis::frequency::discrete_lyapunov;
use crate::analysis::operating_point::{OperatingPoint, eigenvalues, fixed};
use crate::problem::channel::Channel;
use crate::search::objective::Objective;

/// Number of coordinates of gains.
pub(super) const COORDINATES: usize = 6 + 6 * RULES;
/// Coordinates of gains, or derivatives by them.
pub(super) type Coordinates = SVector<f64, COORDINATES>;

/// Price of a mode or product that decays too slowly.
const PENALTY: f64 = 1e3;
/// Price of an estimate that leaves, by the square of the logarithm of its excess.
const ESTIMATE_PRICE: f64 = 50.0;
/// Price of a residual whose scale drifts, by the square of its logarithm.
const DRIFT_PRICE: f64 = 0.01;
/// Modes no slower than this keep their noise in the search.
const STABLE: f64 = 0.995;
/// Length of the fault's response, samples.
const RESPONSE: usize = 300;

/// The cost of gains.
pub(super) struct Cost<'a> {
    pub(super) objective: &'a Objective<'a>,
    /// Of the sums of powers.
    pub(super) exponent: f64,
    /// Slowest decay of modes and products that costs nothing.
    pub(super) slowest: f64,
}

/// A number and its slope.
#[derive(Clone, Copy)]
struct Term {
    value: f64,
    slope: Coordinates,
}

/// The cost's terms at an operating point.
struct Terms {
    ln_beta: Term,
    ln_gamma_squared: Term,
    ln_variance: Term,
    /// Of e_2; none without a cap.
    ln_peak: Option<Term>,
    /// Price of slow modes.
    slow: Term,
}

impl Cost<'_> {
    /// The cost at coordinates `x` and its slope; infinite where a frequency is an eigenvalue.
    pub(super) fn at(&self, x: &Coordinates) -> (f64, Coordinates) {
        let Some(terms) = self.points(x) else { return (f64::INFINITY, Coordinates::zeros()) };
        let of = |f: fn(&Terms) -> Term| terms.iter().map(f).collect::<Vec<_>>();
        let (beta, gamma) = (of(|t| t.ln_beta), of(|t| t.ln_gamma_squared));
        let noise = of(|t| t.ln_variance);

        let smallest = soft_maximum(&beta, -self.exponent);
        let (gamma, noise) =
            (soft_maximum(&gamma, self.exponent / 2.0), soft_maximum(&noise, self.exponent / 2.0));
        let inputs = self.objective.inputs;
        let [gamma_squared, variance] =
            [gamma.value.exp() * inputs.bound * inputs.bound, noise.value.exp()];
        let background = gamma_squared + variance;
        let ratio = smallest.value + inputs.smallest_fault.ln() - background.ln() / 2.0;
        let of_ratio = smallest.slope
            - (gamma.slope * gamma_squared + noise.slope * variance) / (2.0 * background);

        let drift = smallest.value - self.objective.scale.ln();
        let mut cost = DRIFT_PRICE * drift * drift - ratio;
        let mut slope = smallest.slope * (2.0 * DRIFT_PRICE * drift) - of_ratio;
        for term in terms.iter().map(|t| t.slow).chain([self.slow_products(x)]) {
            cost += term.value;
            slope += term.slope;
        }
        let peaks: Vec<Term> = terms.iter().filter_map(|t| t.ln_peak).collect();
        if let (Some(cap), false) = (self.objective.cap, peaks.is_empty()) {
            let peak = soft_maximum(&peaks, self.exponent);
            let excess = (peak.value - cap.ln()).max(0.0);
            cost += ESTIMATE_PRICE * excess * excess;
            slope += peak.slope * (2.0 * ESTIMATE_PRICE * excess);
        }
        (cost, slope)
    }

    fn points(&self, x: &Coordinates) -> Option<Vec<Terms>> {
        let points = &self.objective.points;
        points.iter().map(|point| self.terms(&Frozen::new(point, x))).collect()
    }

    fn terms(&self, frozen: &Frozen<'_>) -> Option<Terms> {
        let inputs = self.objective.inputs;
        let weights = Vector2::from(inputs.weights);
        let output = Matrix2::from_diagonal(&weights) * fixed(&C);
        let ln = |(value, adjoint): (f64, Adjoint)| {
            // Without noise there is no variance.
            let per = if value > 0.0 { 1.0 / value } else { 0.0 };
            Term { value: value.ln(), slope: frozen.slope(&adjoint) * per }
        };

        // Over frequencies too, sums of powers leave fewer kinks. Of a single column the squared
        // largest gain is the squared smallest.
        let over = |channel: &Channel, frequencies: &[f64], exponent: f64| {
            let at = |&w: &f64| Some(ln(frozen.squared_gain(&output, &weights, channel, w)?));
            let gains: Option<Vec<Term>> = frequencies.iter().map(at).collect();
            Some(soft_maximum(&gains?, exponent / 2.0))
        };
        let fault_frequencies = &self.objective.fault_frequencies;
        let beta_squared = over(&inputs.fault, fault_frequencies, -self.exponent)?;
        let of_bands = inputs.disturbances.iter().zip(&self.objective.disturbance_frequencies);
        let bands: Option<Vec<Term>> = of_bands
            .map(|(channel, frequencies)| over(channel, frequencies, self.exponent))
            .collect();

        let (radius, of_radius) = spectral_radius(&frozen.n);
        let of_radius = Adjoint { n: of_radius, ..Adjoint::default() };
        let excess = (radius - self.slowest).max(0.0);
        let slow = Term {
            value: PENALTY * excess * excess,
            slope: frozen.slope(&of_radius) * (2.0 * PENALTY * excess),
        };
        Some(Terms {
            ln_beta: Term { value: beta_squared.value / 2.0, slope: beta_squared.slope / 2.0 },
            // ln of the sum.
            ln_gamma_squared: soft_maximum(&bands?, 1.0),
            ln_variance: ln(frozen.variance(
                &output,
                &weights,
                inputs.white_std,
                (radius, &of_radius),
            )?),
            ln_peak: self.objective.cap.map(|_| ln(frozen.peak(&inputs.fault))),
            slow,
        })
    }

    /// Price of products of the error dynamics at two vertices that decay too slowly.
    fn slow_products(&self, x: &Coordinates) -> Term {
        let vertices: Vec<Frozen<'_>> =
            self.objective.vertices.iter().map(|point| Frozen::new(point, x)).collect();
        let mut price = 0.0;
        let mut of_n = vec![Matrix3::zeros(); vertices.len()];
        for (a, first) in vertices.iter().enumerate() {
            for (b, second) in vertices.iter().enumerate().take(a + 1) {
                let (radius, of_product) = spectral_radius(&(first.n * second.n));
                let rate = radius.sqrt();
                let excess = (rate - self.slowest).max(0.0);
                if excess > 0.0 {
                    price += PENALTY * excess * excess;
                    let of_product = of_product * (PENALTY * excess / rate);
                    of_n[a] += of_product * second.n.transpose();
                    of_n[b] += first.n.transpose() * of_product;
                }
            }
        }
        let slopes = vertices.iter().zip(of_n);
        let slope =
            slopes.map(|(frozen, n)| frozen.slope(&Adjoint { n, ..Adjoint::default() })).sum();
        Term { value: price, slope }
    }
}

/// Derivatives by the matrices of an operating point.
#[derive(Clone, Copy, Default)]
struct Adjoint {
    n: Matrix3<f64>,
    m: Matrix3<f64>,
    from_noise: Matrix3x2<f64>,
    /// By `I + C E`.
    feedthrough: Matrix2<f64>,
}

/// The error dynamics at an operating point.
struct Frozen<'a> {
    point: &'a OperatingPoint,
    e: Matrix3x2<f64>,
    m: Matrix3<f64>,
    n: Matrix3<f64>,
    from_noise: Matrix3x2<f64>,
    feedthrough: Matrix2<f64>,
}

impl<'a> Frozen<'a> {
    fn new(point: &'a OperatingPoint, x: &Coordinates) -> Self {
        let c: SMatrix<f64, 2, 3> = fixed(&C);
        let (of_e, of_n) = x.as_slice().split_at(6);
        let e = Matrix3x2::from_row_slice(of_e);
        let m = Matrix3::identity() + e * c; // (11)
        let mut columns = Matrix3x2::zeros();
        for (h, of_rule) in point.membership.iter().zip(of_n.chunks_exact(6)) {
            columns += Matrix3x2::from_row_slice(of_rule) * *h;
        }
        let of_v_y = m * point.a.column(1);
        let n = Matrix3::from_columns(&[
            columns.column(0).into_owned(),
            of_v_y,
            columns.column(1).into_owned(),
        ]);
        // -L + M G rho E - M K with (34) and (35), where M G rho E cancels.
        let from_noise = (n - m * point.a) * c.transpose() + n * e - m * point.k;
        Self { point, e, m, n, from_noise, feedthrough: Matrix2::identity() + c * e }
    }

    /// By the coordinates.
    fn slope(&self, by: &Adjoint) -> Coordinates {
        let c: SMatrix<f64, 2, 3> = fixed(&C);
        let Self { point, e, n, .. } = self;
        let noise = &by.from_noise;
        let of_n = by.n + noise * (c + e.transpose());
        let mut of_m = by.m - noise * (c * point.a.transpose() + point.k.transpose());
        of_m += of_n.column(1) * point.a.column(1).transpose();
        let of_e = n.transpose() * noise + of_m * c.transpose() + c.transpose() * by.feedthrough;

        let mut slope = Coordinates::zeros();
        for row in 0..3 {
            for column in 0..2 {
                slope[2 * row + column] = of_e[(row, column)];
                for (rule, h) in point.membership.iter().enumerate() {
                    slope[6 + 6 * rule + 2 * row + column] = h * of_n[(row, 2 * column)];
                }
            }
        }
        slope
    }

    /// The squared largest gain of `channel` at the frequency `w`.
    fn squared_gain(
        &self,
        output: &SMatrix<f64, 2, 3>,
        weights: &Vector2<f64>,
        channel: &Channel,
        w: f64,
    ) -> Option<(f64, Adjoint)> {
        let z = Complex::from_polar(1.0, w);
        let resolvent =
            (Matrix3::from_diagonal_element(z) - self.n.map(Complex::from)).try_inverse()?;
        let to_residual = output.map(Complex::from) * resolvent;
        let columns = |x: &crate::lmi::matrix::Matrix| -> Vec<Vec<f64>> {
            x.column_iter().map(|x| x.iter().copied().collect()).collect()
        };
        let directions: Vec<Vector3<f64>> =
            columns(&channel.direction).iter().map(|d| Vector3::from_column_slice(d)).collect();
        let noises: Vec<Vector2<f64>> =
            columns(&channel.noise).iter().map(|d| Vector2::from_column_slice(d)).collect();
        let complex = |x: f64| Complex::from(x);
        let driven: Vec<Vector3<f64>> = directions
            .iter()
            .map(|d| self.m * d)
            .chain(noises.iter().map(|d| self.from_noise * d))
            .collect();
        let none = vec![Vector2::zeros(); directions.len()];
        let direct = none
            .into_iter()
            .chain(noises.iter().map(|d| weights.component_mul(&(self.feedthrough * d))));
        let gains: Vec<Vector2<Complex<f64>>> = driven
            .iter()
            .zip(direct)
            .map(|(b, d)| to_residual * b.map(complex) + d.map(complex))
            .collect();

        let mut product = Matrix2::<Complex<f64>>::zeros();
        for g in &gains {
            product += g * g.adjoint();
        }
        let (squared, u) = largest_eigenvector(&product);
        let row: RowVector3<Complex<f64>> = u.adjoint() * to_residual;
        let mut by = Adjoint::default();
        let mut state = Vector3::<Complex<f64>>::zeros();
        for (k, g) in gains.iter().enumerate() {
            let v = g.dotc(&u);
            state += driven[k].map(complex) * v;
            let of_driven = row.transpose().map(|q| 2.0 * (q * v).re);
            if let Some(direction) = directions.get(k) {
                by.m += of_driven * direction.transpose();
            } else {
                let noise = noises[k - directions.len()];
                by.from_noise += of_driven * noise.transpose();
                let of_direct = u.map(|u| 2.0 * (u.conj() * v).re).component_mul(weights);
                by.feedthrough += of_direct * noise.transpose();
            }
        }
        let state = resolvent * state;
        by.n = Matrix3::from_fn(|i, j| 2.0 * (row[i] * state[j]).re);
        Some((squared, by))
    }

    /// Variance of the weighted residual under white noise. Beyond stability it goes on growing with
    /// the gains, not to infinity: the line search can turn back.
    fn variance(
        &self,
        output: &SMatrix<f64, 2, 3>,
        weights: &Vector2<f64>,
        white_std: [f64; 2],
        (radius, of_radius): (f64, &Adjoint),
    ) -> Option<(f64, Adjoint)> {
        let std = Matrix2::from_diagonal(&Vector2::from(white_std));
        let contraction = f64::min(1.0, STABLE / radius);
        let n = self.n * contraction;
        let b = self.from_noise * std;
        let weighted = output.transpose() * output;
        let covariance = discrete_lyapunov(&n, &(b * b.transpose()))?;
        let adjoint = discrete_lyapunov(&n.transpose(), &weighted)?;
        let direct = Matrix2::from_diagonal(weights) * self.feedthrough * std;
        let value = (weighted * covariance).trace() + direct.norm_squared();
        let of_n = adjoint * n * covariance * 2.0;
        let mut by = Adjoint {
            n: of_n * contraction,
            m: Matrix3::zeros(),
            from_noise: adjoint * b * std * 2.0,
            feedthrough: Matrix2::from_diagonal(weights) * direct * std * 2.0,
        };
        if contraction < 1.0 {
            by.n -= of_radius.n * (of_n.dot(&self.n) * contraction / radius);
        }
        (value >= 0.0 && value.is_finite()).then_some((value, by))
    }

    /// Largest |e_2| after a unit step of `fault`.
    fn peak(&self, fault: &Channel) -> (f64, Adjoint) {
        let f = Vector3::from_column_slice(fault.direction.column(0).as_slice());
        let step = self.m * f;
        let mut course = [Vector3::zeros(); RESPONSE];
        let (mut peak, mut at) = (0.0, 0);
        for k in 1..RESPONSE {
            course[k] = self.n * course[k - 1] + step;
            if course[k][1].abs() > peak {
                (peak, at) = (course[k][1].abs(), k);
            }
        }
        let mut by = Adjoint::default();
        let mut costate = Vector3::new(0.0, course[at][1].signum(), 0.0);
        let mut of_step = Vector3::zeros();
        for k in (0..at).rev() {
            by.n += costate * course[k].transpose();
            of_step += costate;
            costate = self.n.tr_mul(&costate);
        }
        by.m = of_step * f.transpose();
        (peak.max(f64::MIN_POSITIVE), by)
    }
}

/// Largest magnitude of an eigenvalue, and its derivative by the matrix: that of the eigenvalue l is
/// `adj(N - l I)' / tr adj(N - l I)`.
fn spectral_radius(n: &Matrix3<f64>) -> (f64, Matrix3<f64>) {
    let Some(eigenvalues) = eigenvalues(n) else { return (f64::INFINITY, Matrix3::zeros()) };
    let largest = eigenvalues
        .iter()
        .copied()
        .fold(Complex::from(0.0), |largest, x| if x.norm() > largest.norm() { x } else { largest });
    let radius = largest.norm();
    if radius == 0.0 {
        return (0.0, Matrix3::zeros());
    }
    let shifted = n.map(Complex::from) - Matrix3::from_diagonal_element(largest);
    let cofactor = |row: usize, column: usize| {
        let [a, b] = [(row + 1) % 3, (row + 2) % 3];
        let [c, d] = [(column + 1) % 3, (column + 2) % 3];
        shifted[(a, c)] * shifted[(b, d)] - shifted[(a, d)] * shifted[(b, c)]
    };
    let cofactors = Matrix3::from_fn(cofactor);
    let direction = largest.conj() / radius / cofactors.trace();
    (radius, cofactors.map(|x| (x * direction).re))
}

/// Largest eigenvalue of a Hermitian matrix, and its eigenvector of norm one.
fn largest_eigenvector(x: &Matrix2<Complex<f64>>) -> (f64, Vector2<Complex<f64>>) {
    let (a, d, b) = (x[(0, 0)].re, x[(1, 1)].re, x[(0, 1)]);
    let (mean, half) = ((a + d) / 2.0, (a - d) / 2.0);
    let largest = mean + half.hypot(b.norm());
    let u = if half >= 0.0 {
        Vector2::new(Complex::from(largest - d), b.conj())
    } else {
        Vector2::new(b, Complex::from(largest - a))
    };
    let norm = u.norm();
    if norm > 0.0 {
        (largest, u.unscale(norm))
    } else {
        (largest, Vector2::new(Complex::from(1.0), Complex::from(0.0)))
    }
}

/// `ln (sum exp(k x))^(1/k)`: near the largest x for k > 0, near the smallest for k < 0.
fn soft_maximum(terms: &[Term], k: f64) -> Term {
    let extreme = terms.iter().map(|x| k * x.value).fold(f64::NEG_INFINITY, f64::max);
    let (mut sum, mut slope) = (0.0, Coordinates::zeros());
    if !extreme.is_finite() {
        return Term { value: extreme / k, slope };
    }
    for term in terms {
        let weight = (k * term.value - extreme).exp();
        sum += weight;
        slope += term.slope * weight;
    }
    Term { value: (extreme + sum.ln()) / k, slope: slope / sum }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::inputs::Inputs;
    use crate::problem::model;
    use crate::search::refine::coordinates;
    use crate::search::starts::carried_over;
    use crate::spec::Spec;
    use crate::synthesis::theorem4::Theorem4;

    /// The slope is that of difference quotients, with every price at work: noise in bands, a cap that
    /// is missed, modes and products that are too slow.
    #[test]
    fn slope_is_that_of_differences() {
        let mut spec = Spec::default();
        spec.noise.r.bound_rad_per_s = Some(0.002);
        let inputs = Inputs::of(&spec).unwrap_or_else(|mistakes| panic!("{mistakes}"));
        let theorem = Theorem4::of(&spec, &inputs, 0.97);
        let objective = Objective::new(&model::model(&spec), &inputs, 0.3, Some(0.1));
        let gains = carried_over(&theorem).unwrap_or_else(|| panic!("a steering fault"));
        let x = coordinates(&gains.gains);
        for slowest in [0.99, 0.8] {
            let cost = Cost { objective: &objective, exponent: 12.0, slowest };
            let (_, slope) = cost.at(&x);
            for axis in 0..COORDINATES {
                let step = 1e-6;
                let at = |shift: f64| {
                    let mut x = x;
                    x[axis] += shift;
                    cost.at(&x).0
                };
                let quotient = (at(step) - at(-step)) / (2.0 * step);
                let allowed = 1e-5 * (1.0 + slope.norm());
                assert!(
                    (slope[axis] - quotient).abs() < allowed,
                    "{axis}: {} {quotient}",
                    slope[axis]
                );
            }
        }
    }
}
