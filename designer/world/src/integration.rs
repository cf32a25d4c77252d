//! The classical Runge-Kutta method.

/// One step of length `h` for `dx/dt = f(x, u(t))`, `u` given at the step's beginning, middle and end.
pub fn rk4<const N: usize>(
    f: impl Fn([f64; N], f64) -> [f64; N],
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
    let k_1 = f(x, begin);
    let k_2 = f(along(k_1, h / 2.0), middle);
    let k_3 = f(along(k_2, h / 2.0), middle);
    let k_4 = f(along(k_3, h), end);
    let mut slope = k_1;
    for (((slope, k_2), k_3), k_4) in slope.iter_mut().zip(k_2).zip(k_3).zip(k_4) {
        *slope = (*slope + 2.0 * k_2 + 2.0 * k_3 + k_4) / 6.0;
    }
    along(slope, h)
}
