//! Products of matrices and vectors (BLAS levels 2 and 3).
//!
//! The products fill a temporary of nalgebra's, whose kernels are fast on matrices and careless of
//! triangles and increments; the caller's array then takes what belongs to it.
#![allow(clippy::too_many_arguments)] // the argument lists are the reference's

use nalgebra::{DMatrix, DVector};

use crate::storage::{Real, is_leading, is_triangle, triangle_rows, view, view_mut};

/// C := alpha op(A) op(B) + beta C, where C is `m` x `n` and op(A) is `m` x `k`.
///
/// # Safety
/// The arrays are as the dimensions describe, and `c` overlaps no other.
pub(crate) unsafe fn gemm<T: Real>(
    transa: u8,
    transb: u8,
    m: i32,
    n: i32,
    k: i32,
    alpha: T,
    a: *const T,
    lda: i32,
    b: *const T,
    ldb: i32,
    beta: T,
    c: *mut T,
    ldc: i32,
) {
    let (Some(transa), Some(transb)) = (is_transposed(transa), is_transposed(transb)) else {
        return;
    };
    let (rows_a, rows_b) = (if transa { k } else { m }, if transb { n } else { k });
    let leading = is_leading(lda, rows_a) && is_leading(ldb, rows_b) && is_leading(ldc, m);
    if m < 0 || n < 0 || k < 0 || !leading {
        return;
    }
    // SAFETY: the dimensions were checked, and the caller vouches for the array.
    let mut c = unsafe { view_mut(c, m, n, ldc) };
    if alpha.is_zero() {
        c.apply(|c| *c = scaled(beta, *c));
        return;
    }
    // SAFETY: the dimensions were checked, and the caller vouches for the arrays.
    let (a, b) = unsafe { (view(transa, a, m, k, lda), view(transb, b, k, n, ldb)) };
    c.gemm(alpha, &a, &b, beta);
}

/// y := alpha op(A) x + beta y, where A is `m` x `n`.
///
/// # Safety
/// The arrays are as the dimensions and increments describe, and `y` overlaps no other.
pub(crate) unsafe fn gemv<T: Real>(
    trans: u8,
    m: i32,
    n: i32,
    alpha: T,
    a: *const T,
    lda: i32,
    x: *const T,
    incx: i32,
    beta: T,
    y: *mut T,
    incy: i32,
) {
    let Some(transposed) = is_transposed(trans) else {
        return;
    };
    if m <= 0 || n <= 0 || !is_leading(lda, m) || incx == 0 || incy == 0 {
        return;
    }
    let (rows, cols) = if transposed { (n, m) } else { (m, n) };
    let mut product = DVector::zeros(rows as usize);
    if !alpha.is_zero() {
        // SAFETY: the dimensions were checked, and the caller vouches for the arrays.
        let (a, x) = unsafe { (view(transposed, a, rows, cols, lda), gather(x, cols, incx)) };
        product.gemv(alpha, &a, &x, T::zero());
    }
    // SAFETY: the increment was checked, and the caller vouches for the array.
    unsafe { update(y, incy, beta, &product) };
}

/// y := alpha A x + beta y, where one triangle gives the symmetric A of order `n`.
///
/// # Safety
/// The arrays are as the dimensions and increments describe, and `y` overlaps no other.
pub(crate) unsafe fn symv<T: Real>(
    uplo: u8,
    n: i32,
    alpha: T,
    a: *const T,
    lda: i32,
    x: *const T,
    incx: i32,
    beta: T,
    y: *mut T,
    incy: i32,
) {
    if !is_triangle(uplo) || n <= 0 || !is_leading(lda, n) || incx == 0 || incy == 0 {
        return;
    }
    let mut product = DVector::zeros(n as usize);
    if !alpha.is_zero() {
        // SAFETY: the dimensions were checked, and the caller vouches for the arrays.
        let (a, x) = unsafe { (view(uplo == b'U', a, n, n, lda), gather(x, n, incx)) };
        // Reads the lower triangle only: the upper one was transposed into its place.
        product.sygemv(alpha, &a, &x, T::zero());
    }
    // SAFETY: the increment was checked, and the caller vouches for the array.
    unsafe { update(y, incy, beta, &product) };
}

/// C := alpha op(A) op(A)' + beta C in one triangle of C, where op(A) is `n` x `k`.
///
/// # Safety
/// The arrays are as the dimensions describe, and `c` overlaps no other.
pub(crate) unsafe fn syrk<T: Real>(
    uplo: u8,
    trans: u8,
    n: i32,
    k: i32,
    alpha: T,
    a: *const T,
    lda: i32,
    beta: T,
    c: *mut T,
    ldc: i32,
) {
    // SAFETY: with B = A the product is the same and the contract is the caller's own.
    unsafe {
        update_triangle(uplo, trans, n, k, alpha, a, lda, a, lda, beta, c, ldc, |p, i, j| p[(i, j)])
    };
}

/// C := alpha (op(A) op(B)' + op(B) op(A)') + beta C in one triangle of C, where op(A) and op(B)
/// are `n` x `k`.
///
/// # Safety
/// The arrays are as the dimensions describe, and `c` overlaps no other.
pub(crate) unsafe fn syr2k<T: Real>(
    uplo: u8,
    trans: u8,
    n: i32,
    k: i32,
    alpha: T,
    a: *const T,
    lda: i32,
    b: *const T,
    ldb: i32,
    beta: T,
    c: *mut T,
    ldc: i32,
) {
    // SAFETY: the contract is the caller's own.
    unsafe {
        update_triangle(uplo, trans, n, k, alpha, a, lda, b, ldb, beta, c, ldc, |p, i, j| {
            p[(i, j)] + p[(j, i)]
        });
    }
}

/// The triangle of C in `syrk` and `syr2k`: `term` picks the update of an element from
/// P = alpha op(A) op(B)'.
///
/// # Safety
/// As [`syr2k`].
unsafe fn update_triangle<T: Real>(
    uplo: u8,
    trans: u8,
    n: i32,
    k: i32,
    alpha: T,
    a: *const T,
    lda: i32,
    b: *const T,
    ldb: i32,
    beta: T,
    c: *mut T,
    ldc: i32,
    term: impl Fn(&DMatrix<T>, usize, usize) -> T,
) {
    let Some(transposed) = is_transposed(trans) else {
        return;
    };
    let rows = if transposed { k } else { n };
    let leading = is_leading(lda, rows) && is_leading(ldb, rows) && is_leading(ldc, n);
    if !is_triangle(uplo) || n < 0 || k < 0 || !leading {
        return;
    }
    let mut product = DMatrix::zeros(n as usize, n as usize);
    if !alpha.is_zero() {
        // SAFETY: the dimensions were checked, and the caller vouches for the arrays.
        let (a, bt) = unsafe { (view(transposed, a, n, k, lda), view(!transposed, b, k, n, ldb)) };
        product.gemm(alpha, &a, &bt, T::zero());
    }
    // SAFETY: the dimensions were checked, and the caller vouches for the array.
    let mut c = unsafe { view_mut(c, n, n, ldc) };
    for j in 0..c.ncols() {
        for i in triangle_rows(uplo, j, c.nrows()) {
            c[(i, j)] = term(&product, i, j) + scaled(beta, c[(i, j)]);
        }
    }
}

/// What TRANS says of op(A), if it is legal; the conjugate of a real matrix is the matrix.
fn is_transposed(trans: u8) -> Option<bool> {
    match trans {
        b'N' => Some(false),
        b'T' | b'C' => Some(true),
        _ => None,
    }
}

/// beta c, where `beta = 0` takes no notice of c.
fn scaled<T: Real>(beta: T, c: T) -> T {
    if beta.is_zero() { beta } else { beta * c }
}

/// Where in its array a vector of length `n` has its elements: a negative increment starts at the
/// far end.
fn offsets(n: usize, inc: i32) -> impl Iterator<Item = usize> {
    let step = inc.unsigned_abs() as usize;
    (0..n).map(move |i| step * if inc < 0 { n - 1 - i } else { i })
}

/// The vector of length `n` at `x`.
///
/// # Safety
/// `n` is not negative, and the elements are valid for reads.
unsafe fn gather<T: Real>(x: *const T, n: i32, inc: i32) -> DVector<T> {
    // SAFETY: the caller vouches for the elements that the increment reaches.
    let elements = offsets(n as usize, inc).map(|offset| unsafe { *x.add(offset) });
    DVector::from_iterator(n as usize, elements)
}

/// y := product + beta y.
///
/// # Safety
/// The elements of the vector at `y`, as long as `product`, are valid for reads and writes.
unsafe fn update<T: Real>(y: *mut T, inc: i32, beta: T, product: &DVector<T>) {
    for (offset, &term) in offsets(product.len(), inc).zip(product) {
        // SAFETY: the caller vouches for the elements that the increment reaches.
        let y = unsafe { &mut *y.add(offset) };
        *y = term + scaled(beta, *y);
    }
}
