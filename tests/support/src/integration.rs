//! The classical Runge-Kutta method.

/// One step of length `h` for `dx/dt = f(x)`.
pub fn rk4<const N: usize>(f: impl Fn([f64; N]) -> [f64; N], x: [f64; N], h: f64) -> [f64; N] {
    let along = |slope: [f64; N], h: f64| std::array::from_fn(|i| x[i] + h * slope[i]);
    let k_1 = f(x);
    let k_2 = f(along(k_1, h / 2.0));
    let k_3 = f(along(k_2, h / 2.0));
    let k_4 = f(along(k_3, h));
    along(std::array::from_fn(|i| (k_1[i] + 2.0 * k_2[i] + 2.0 * k_3[i] + k_4[i]) / 6.0), h)
}
