//! The singular value decomposition by one-sided Jacobi rotations (Hestenes).
//!
//! Rotations from the right make the columns of A V orthogonal; their lengths are the singular
//! values. Written here because nalgebra 0.35 returns wrong values for some matrices of ordinary
//! kind when it also computes their vectors (its issues 1172 and 1612).
//!
//! Method: J. Demmel and K. Veselic, "Jacobi's method is more accurate than QR", SIAM Journal on
//! Matrix Analysis and Applications 13(4), 1992 (the right-handed method).

use nalgebra::{DMatrix, DVector};

use crate::storage::{Real, ascending};

/// Bound on the sweeps over all pairs of columns; ten are usual, and twenty rare.
const SWEEPS: usize = 60;

/// A = U diag(values) VT with k = min(m, n) values, descending.
pub(crate) struct Svd<T> {
    /// m x k, orthonormal columns.
    pub u: DMatrix<T>,
    /// k, not negative.
    pub values: DVector<T>,
    /// k x n, orthonormal rows.
    pub vt: DMatrix<T>,
}

impl<T: Real> Svd<T> {
    /// The decomposition of a finite `a` that is not empty, or none if the sweeps do not converge.
    pub(crate) fn new(a: DMatrix<T>) -> Option<Self> {
        if a.nrows() < a.ncols() {
            let Svd { u, values, vt } = Self::new(a.transpose())?;
            return Some(Svd { u: vt.transpose(), values, vt: u.transpose() });
        }
        // Scaled, so that no square overflows.
        let scale = a.amax();
        let mut av = if scale.is_zero() { a } else { a.unscale(scale) };
        let mut v = DMatrix::identity(av.ncols(), av.ncols());
        (0..SWEEPS).find(|_| !sweep(&mut av, &mut v))?;

        let lengths =
            DVector::from_iterator(av.ncols(), av.column_iter().map(|column| column.norm()));
        let mut order = ascending(&lengths);
        order.reverse();
        Some(Svd {
            // Orthogonal columns are their own QR factors, up to their lengths; where a length is
            // zero, Q completes the basis.
            u: av.select_columns(&order).qr().q(),
            values: lengths.select_rows(&order) * scale,
            vt: v.select_columns(&order).transpose(),
        })
    }
}

/// Makes each pair of columns of A V orthogonal in turn. Returns whether there was one to rotate.
fn sweep<T: Real>(av: &mut DMatrix<T>, v: &mut DMatrix<T>) -> bool {
    let (rows, cols) = av.shape();
    let eps = T::default_epsilon();
    let tolerance = eps * nalgebra::convert(rows as f64);
    // On the scale where the largest element is one, shorter columns are rounding errors of the
    // longer ones: their angles do not matter.
    let negligible = eps.powi(4);
    let mut rotated = false;
    for j in 1..cols {
        for i in 0..j {
            let (x, y) = (av.column(i), av.column(j));
            let (xx, yy, xy) = (x.norm_squared(), y.norm_squared(), x.dot(&y));
            if xy.abs() <= negligible.max(tolerance * xx.sqrt() * yy.sqrt()) {
                continue;
            }
            rotated = true;
            let zeta = (yy - xx) / (xy + xy);
            let tan = T::one().copysign(zeta) / (zeta.abs() + T::one().hypot(zeta));
            let cos = T::one() / T::one().hypot(tan);
            rotate(av, i, j, cos, cos * tan);
            rotate(v, i, j, cos, cos * tan);
        }
    }
    rotated
}

/// Turns the columns `i` and `j`: (x, y) := (cos x - sin y, sin x + cos y).
fn rotate<T: Real>(matrix: &mut DMatrix<T>, i: usize, j: usize, cos: T, sin: T) {
    let (mut x, mut y) = matrix.columns_range_pair_mut(i, j);
    for (x, y) in x.iter_mut().zip(y.iter_mut()) {
        (*x, *y) = (cos * *x - sin * *y, sin * *x + cos * *y);
    }
}
