//! Products and sums of the few small matrices the detector works with, and whether numbers are finite.

/// `a b` for an R x K matrix and a K-vector.
pub(crate) fn product<const R: usize, const K: usize>(a: &[[f64; K]; R], b: &[f64; K]) -> [f64; R] {
    let mut out = [0.0; R];
    for (out, row) in out.iter_mut().zip(a) {
        for (a, b) in row.iter().zip(b) {
            *out += a * b;
        }
    }
    out
}

/// `a + b`, element by element.
pub(crate) fn sum<const N: usize>(a: [f64; N], b: [f64; N]) -> [f64; N] {
    let mut out = a;
    for (out, b) in out.iter_mut().zip(b) {
        *out += b;
    }
    out
}

/// `sum_i h_i a_i`: the blend of the rules' matrices, A(h) of (7).
pub(crate) fn blend<const I: usize, const R: usize, const K: usize>(
    h: &[f64; I],
    a: &[[[f64; K]; R]; I],
) -> [[f64; K]; R] {
    let mut out = [[0.0; K]; R];
    for (h, a) in h.iter().zip(a) {
        for (out, a) in out.iter_mut().zip(a) {
            for (out, a) in out.iter_mut().zip(a) {
                *out += h * a;
            }
        }
    }
    out
}

/// Whether all `values` are finite. Not inlined: copies of its loop would be a tenth of the FMU's code.
#[inline(never)]
pub(crate) fn all_finite(values: &[f64]) -> bool {
    values.iter().all(|x| x.is_finite())
}

/// `|x|`.
pub(crate) fn magnitude(x: f64) -> f64 {
    x.max(-x)
}
