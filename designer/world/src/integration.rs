//! The classical Runge-Kutta method.

/// `dx/dt = f(x, u)`.
///
/// A trait, not a closure, so that each of the four stages can be inlined: what does not wait for the stage before
/// then runs beside it.
pub trait Dynamics<const N: usize> {
    /// `f(x, u)`.
    fn derivative(&self, x: [f64; N], u: f64) -> [f64; N];
}

/// One step of length `h`, `u` given at the step's beginning, middle and end.
#[inline(always)]
pub fn rk4<const N: usize>(
    dynamics: &impl Dynamics<N>,
    x: [f64; N],
    [begin, middle, end]: [f64; 3],
    h: f64,
) -> [f64; N] {
    let along = |slope: [f64; N], h: f64| {
        let mut to = x;
        for (to, slope) in to.iter_mut().zip(slope) {
            *to += h * slope;
        }
        to
    };
    let k_1 = dynamics.derivative(x, begin);
    let k_2 = dynamics.derivative(along(k_1, h / 2.0), middle);
    let k_3 = dynamics.derivative(along(k_2, h / 2.0), middle);
    let k_4 = dynamics.derivative(along(k_3, h), end);
    let mut slope = k_1;
    for (((slope, k_2), k_3), k_4) in slope.iter_mut().zip(k_2).zip(k_3).zip(k_4) {
        *slope = (*slope + 2.0 * k_2 + 2.0 * k_3 + k_4) / 6.0;
    }
    along(slope, h)
}
