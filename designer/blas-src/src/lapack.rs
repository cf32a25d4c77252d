//! Factorisations and what is solved with them (LAPACK).
//!
//! Each routine writes `info` first: the number of the first illegal argument with a minus sign,
//! or zero. A positive value is set where the matrix defeats the factorisation.
#![allow(clippy::too_many_arguments)] // the argument lists are the reference's

use nalgebra::{DMatrix, DVector, Dyn, LU, SymmetricEigen};

use crate::storage::{
    Real, ascending, is_leading, is_triangle, lower_triangle, triangle_rows, view, view_mut,
};
use crate::svd::Svd;

/// INFO of an iteration that did not converge, or could not start on a NaN or an infinity.
const NOT_CONVERGED: i32 = 1;

/// Bound on the sweeps of an iteration, as a multiple of the order: the reference's is 30; a
/// sweep here may also do no more than split the problem.
const SWEEPS_PER_VALUE: usize = 60;

/// The size that a workspace query reports: nalgebra has its own.
const WORKSPACE: i32 = 1;

/// A = L L' or U' U of the symmetric A, in the triangle `uplo`. INFO = i: the leading minor of
/// order i is not positive definite (or not finite), and A is left as it was.
///
/// # Safety
/// The array is as the dimensions describe.
pub(crate) unsafe fn potrf<T: Real>(uplo: u8, n: i32, a: *mut T, lda: i32, info: &mut i32) {
    *info = first_illegal(&[(1, is_triangle(uplo)), (2, n >= 0), (4, is_leading(lda, n))]);
    if *info != 0 {
        return;
    }
    // SAFETY: the dimensions were checked, and the caller vouches for the array.
    let mut a = unsafe { view_mut(a, n, n, lda) };
    let lower = lower_triangle(uplo, &a.as_view());
    let Some(l) = cholesky(lower.clone()) else {
        // A leading block can be factored if and only if all smaller ones can.
        let orders: Vec<usize> = (1..=lower.nrows()).collect();
        let factored =
            |&order: &usize| cholesky(lower.view_range(..order, ..order).into_owned()).is_some();
        *info = orders.partition_point(factored) as i32 + 1;
        return;
    };
    for j in 0..l.ncols() {
        for i in triangle_rows(uplo, j, l.nrows()) {
            a[(i, j)] = if uplo == b'U' { l[(j, i)] } else { l[(i, j)] };
        }
    }
}

/// B := the solution X of A X = B by the factor of `potrf`.
///
/// # Safety
/// The arrays are as the dimensions describe, and do not overlap.
pub(crate) unsafe fn potrs<T: Real>(
    uplo: u8,
    n: i32,
    nrhs: i32,
    a: *const T,
    lda: i32,
    b: *mut T,
    ldb: i32,
    info: &mut i32,
) {
    *info = first_illegal(&[
        (1, is_triangle(uplo)),
        (2, n >= 0),
        (3, nrhs >= 0),
        (5, is_leading(lda, n)),
        (7, is_leading(ldb, n)),
    ]);
    if *info != 0 {
        return;
    }
    // SAFETY: the dimensions were checked, and the caller vouches for the arrays.
    let (a, mut b) = unsafe { (view(a, n, n, lda), view_mut(b, n, nrhs, ldb)) };
    if uplo == b'U' {
        a.tr_solve_upper_triangular_unchecked_mut(&mut b);
        a.solve_upper_triangular_unchecked_mut(&mut b);
    } else {
        a.solve_lower_triangular_unchecked_mut(&mut b);
        a.tr_solve_lower_triangular_unchecked_mut(&mut b);
    }
}

/// A := its factors P L U, IPIV := P, B := the solution X of A X = B. INFO = i: U(i, i) is zero,
/// or the factors are not finite from column i on; B is left as it was.
///
/// # Safety
/// The arrays are as the dimensions describe, and do not overlap.
pub(crate) unsafe fn gesv<T: Real>(
    n: i32,
    nrhs: i32,
    a: *mut T,
    lda: i32,
    ipiv: *mut i32,
    b: *mut T,
    ldb: i32,
    info: &mut i32,
) {
    *info = first_illegal(&[
        (1, n >= 0),
        (2, nrhs >= 0),
        (4, is_leading(lda, n)),
        (7, is_leading(ldb, n)),
    ]);
    if *info != 0 || n == 0 {
        return;
    }
    // SAFETY: the dimensions were checked, and the caller vouches for the arrays.
    let (mut a, mut b) = unsafe { (view_mut(a, n, n, lda), view_mut(b, n, nrhs, ldb)) };
    let factors = LU::new(a.clone_owned());
    let lu = factors.lu_internal();
    a.copy_from(lu);
    // SAFETY: the caller vouches for the `n` elements of IPIV.
    unsafe { write(ipiv, interchanges(&factors)) };
    let defect = lu.column_iter().enumerate().position(|(j, column)| {
        column[j].is_zero() || column.iter().any(|value| !value.is_finite())
    });
    match defect {
        Some(j) => *info = j as i32 + 1,
        None => {
            factors.solve_mut(&mut b);
        }
    }
}

/// W := the eigenvalues of the symmetric A, ascending; with JOBZ = V, Z := their vectors.
///
/// # Safety
/// The arrays are as the dimensions describe, and do not overlap.
pub(crate) unsafe fn syevr<T: Real>(
    jobz: u8,
    range: u8,
    uplo: u8,
    n: i32,
    a: *mut T,
    lda: i32,
    _vl: T,
    _vu: T,
    _il: i32,
    _iu: i32,
    _abstol: T,
    m: &mut i32,
    w: *mut T,
    z: *mut T,
    ldz: i32,
    isuppz: *mut i32,
    work: *mut T,
    lwork: i32,
    iwork: *mut i32,
    liwork: i32,
    info: &mut i32,
) {
    let vectors = jobz == b'V';
    *info = first_illegal(&[
        (1, matches!(jobz, b'N' | b'V')),
        (2, range == b'A'),
        (3, is_triangle(uplo)),
        (4, n >= 0),
        (6, is_leading(lda, n)),
        (15, is_leading(ldz, if vectors { n } else { 1 })),
        (18, is_workspace(lwork)),
        (20, is_workspace(liwork)),
    ]);
    if *info != 0 {
        return;
    }
    // SAFETY: workspaces have one element at least, in a query too.
    unsafe {
        write(work, [T::one()]);
        write(iwork, [WORKSPACE]);
    }
    if lwork == -1 || liwork == -1 {
        return;
    }
    *m = n;
    if n == 0 {
        return;
    }
    // SAFETY: the dimensions were checked, and the caller vouches for the array.
    let lower = lower_triangle(uplo, &unsafe { view(a, n, n, lda) });
    let Some((values, columns)) = symmetric_eigen(&lower) else {
        *info = NOT_CONVERGED;
        return;
    };
    // SAFETY: the caller vouches for the `n` elements of W.
    unsafe { write(w, values.iter().copied()) };
    if vectors {
        // SAFETY: the dimensions were checked, and the caller vouches for the arrays. A vector's
        // support is all of it.
        unsafe {
            view_mut(z, n, n, ldz).copy_from(&columns);
            write(isuppz, (0..n).flat_map(|_| [1, n]));
        }
    }
}

/// A = U diag(S) VT with S descending; with JOBZ = S, the first min(m, n) columns of U and rows
/// of VT.
///
/// # Safety
/// The arrays are as the dimensions describe, and do not overlap.
pub(crate) unsafe fn gesdd<T: Real>(
    jobz: u8,
    m: i32,
    n: i32,
    a: *mut T,
    lda: i32,
    s: *mut T,
    u: *mut T,
    ldu: i32,
    vt: *mut T,
    ldvt: i32,
    work: *mut T,
    lwork: i32,
    _iwork: *mut i32,
    info: &mut i32,
) {
    let vectors = jobz == b'S';
    *info = first_illegal(&[
        (1, is_job(jobz)),
        (2, m >= 0),
        (3, n >= 0),
        (5, is_leading(lda, m)),
        (8, is_leading(ldu, if vectors { m } else { 1 })),
        (10, is_leading(ldvt, if vectors { m.min(n) } else { 1 })),
        (12, is_workspace(lwork)),
    ]);
    if *info == 0 {
        // SAFETY: the dimensions were checked, and the contract is the caller's own.
        *info = unsafe { svd(vectors, vectors, m, n, a, lda, s, u, ldu, vt, ldvt, work, lwork) };
    }
}

/// As [`gesdd`], with a job for each side.
///
/// # Safety
/// The arrays are as the dimensions describe, and do not overlap.
pub(crate) unsafe fn gesvd<T: Real>(
    jobu: u8,
    jobvt: u8,
    m: i32,
    n: i32,
    a: *mut T,
    lda: i32,
    s: *mut T,
    u: *mut T,
    ldu: i32,
    vt: *mut T,
    ldvt: i32,
    work: *mut T,
    lwork: i32,
    info: &mut i32,
) {
    let (left, right) = (jobu == b'S', jobvt == b'S');
    *info = first_illegal(&[
        (1, is_job(jobu)),
        (2, is_job(jobvt)),
        (3, m >= 0),
        (4, n >= 0),
        (6, is_leading(lda, m)),
        (9, is_leading(ldu, if left { m } else { 1 })),
        (11, is_leading(ldvt, if right { m.min(n) } else { 1 })),
        (13, is_workspace(lwork)),
    ]);
    if *info == 0 {
        // SAFETY: the dimensions were checked, and the contract is the caller's own.
        *info = unsafe { svd(left, right, m, n, a, lda, s, u, ldu, vt, ldvt, work, lwork) };
    }
}

/// The singular value decomposition, or the answer to a workspace query; returns INFO.
///
/// # Safety
/// The dimensions are legal, and the arrays as [`gesdd`] demands.
unsafe fn svd<T: Real>(
    left: bool,
    right: bool,
    m: i32,
    n: i32,
    a: *const T,
    lda: i32,
    s: *mut T,
    u: *mut T,
    ldu: i32,
    vt: *mut T,
    ldvt: i32,
    work: *mut T,
    lwork: i32,
) -> i32 {
    // SAFETY: the workspace has one element at least, in a query too.
    unsafe { write(work, [T::one()]) };
    let k = m.min(n);
    if lwork == -1 || k == 0 {
        return 0;
    }
    // SAFETY: the caller vouches for the array.
    let a = unsafe { view(a, m, n, lda) }.into_owned();
    let Some(svd) = is_finite(&a).then(|| Svd::new(a)).flatten() else {
        return NOT_CONVERGED;
    };
    // SAFETY: the caller vouches for the arrays.
    unsafe {
        write(s, svd.values.iter().copied());
        if left {
            view_mut(u, m, k, ldu).copy_from(&svd.u);
        }
        if right {
            view_mut(vt, k, n, ldvt).copy_from(&svd.vt);
        }
    }
    0
}

/// The Cholesky factor of the matrix whose lower triangle is given, if it is positive definite.
fn cholesky<T: Real>(lower: DMatrix<T>) -> Option<DMatrix<T>> {
    let l = lower.cholesky()?.unpack();
    is_finite(&l).then_some(l)
}

/// The eigenvalues, ascending, and their vectors, of the matrix whose lower triangle is given.
///
/// The spectrum is shifted to one side of zero for the iteration. nalgebra drops what couples two
/// diagonal elements once it is small beside them; were both about zero it would go on with
/// elements whose squares underflow, and its rotations would not be orthogonal. The shift costs
/// digits that single precision would miss: the iteration is in double precision.
fn symmetric_eigen<T: Real>(lower: &DMatrix<T>) -> Option<(DVector<T>, DMatrix<T>)> {
    if !is_finite(lower) {
        return None;
    }
    let largest = lower.amax();
    let scale = if largest.is_zero() { T::one() } else { largest };
    let mut shifted = lower.map(|value| nalgebra::convert_unchecked::<T, f64>(value / scale));
    let shift = (2.0 * shifted.norm_squared()).sqrt(); // not below the norm of the whole matrix
    for i in 0..shifted.nrows() {
        shifted[(i, i)] += shift;
    }
    let sweeps = SWEEPS_PER_VALUE * shifted.nrows();
    let eigen = SymmetricEigen::try_new(shifted, f64::EPSILON, sweeps)?;
    let order = ascending(&eigen.eigenvalues);
    let values = eigen.eigenvalues.select_rows(&order);
    let vectors = eigen.eigenvectors.select_columns(&order);
    Some((
        values.map(|value| nalgebra::convert::<f64, T>(value - shift) * scale),
        vectors.map(nalgebra::convert),
    ))
}

fn is_finite<T: Real>(a: &DMatrix<T>) -> bool {
    a.iter().all(|value| value.is_finite())
}

/// IPIV: the row, counted from one, that each row in turn was interchanged with.
fn interchanges<T: Real>(factors: &LU<T, Dyn, Dyn>) -> Vec<i32> {
    let n = factors.lu_internal().nrows();
    let mut permuted = DVector::from_fn(n, |i, _| i);
    factors.p().permute_rows(&mut permuted);
    // Replay: once the earlier interchanges are done, row i holds what it ends with only after it
    // was interchanged with the row that holds it now.
    let mut rows: Vec<usize> = (0..n).collect();
    let mut ipiv = Vec::with_capacity(n);
    for (i, wanted) in permuted.iter().enumerate() {
        let from = rows.iter().position(|row| row == wanted).unwrap_or(i);
        rows.swap(i, from);
        ipiv.push(from as i32 + 1);
    }
    ipiv
}

/// INFO for the arguments that were checked, in ascending order: each its number and whether it
/// is legal.
fn first_illegal(arguments: &[(i32, bool)]) -> i32 {
    let illegal = arguments.iter().find(|(_, legal)| !legal);
    illegal.map_or(0, |&(number, _)| -number)
}

fn is_job(job: u8) -> bool {
    matches!(job, b'N' | b'S')
}

/// Whether LWORK is a size or a query.
fn is_workspace(lwork: i32) -> bool {
    lwork >= WORKSPACE || lwork == -1
}

/// Writes `values` one after the other.
///
/// # Safety
/// The array at `to` is valid for writes of as many elements.
unsafe fn write<T>(to: *mut T, values: impl IntoIterator<Item = T>) {
    for (i, value) in values.into_iter().enumerate() {
        // SAFETY: the caller vouches for this element.
        unsafe { to.add(i).write(value) };
    }
}
