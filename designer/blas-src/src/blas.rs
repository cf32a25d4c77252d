//! Products of matrices and vectors (BLAS levels 2 and 3): `matrixmultiply`'s kernels, told by
//! strides what is transposed.
#![allow(clippy::too_many_arguments)] // the argument lists are the reference's

use nalgebra::DMatrix;

use crate::storage::{
    Real, is_leading, is_triangle, lower_triangle, triangle_rows, view, view_mut,
};

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
    let (a, b) = (Operand::matrix(a, lda, transa), Operand::matrix(b, ldb, transb));
    // SAFETY: the dimensions were checked, and the caller vouches for the arrays.
    unsafe { multiply((m, n, k), alpha, a, b, beta, c, 1, ldc) };
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
    let a = Operand::matrix(a, lda, transposed);
    let x = Operand { first: x.wrapping_offset(first(cols, incx)), down: incx, right: 0 };
    let y = y.wrapping_offset(first(rows, incy));
    // SAFETY: the dimensions and increments were checked, and the caller vouches for the arrays.
    unsafe { multiply((rows, 1, cols), alpha, a, x, beta, y, incy, 0) };
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
    if !is_triangle(uplo) || n <= 0 || !is_leading(lda, n) {
        return;
    }
    // SAFETY: the dimensions were checked, and the caller vouches for the array.
    let mut full = lower_triangle(uplo, &unsafe { view(a, n, n, lda) });
    full.fill_upper_triangle_with_lower_triangle();
    // SAFETY: A is now stored in full, and the rest of the contract is the caller's own.
    unsafe { gemv(b'N', n, n, alpha, full.as_ptr(), n, x, incx, beta, y, incy) };
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
    let term = |p: &DMatrix<T>, i, j| p[(i, j)];
    // SAFETY: the contract is the caller's own, with A for B.
    unsafe { update_triangle(uplo, trans, n, k, alpha, a, lda, a, lda, beta, c, ldc, term) };
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
    let term = |p: &DMatrix<T>, i, j| p[(i, j)] + p[(j, i)];
    // SAFETY: the contract is the caller's own.
    unsafe { update_triangle(uplo, trans, n, k, alpha, a, lda, b, ldb, beta, c, ldc, term) };
}

/// `syrk` and `syr2k`: `term` picks the update of an element of C from P = alpha op(A) op(B)'.
/// All of P costs less than half of it without the kernel.
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
    let (a, bt) = (Operand::matrix(a, lda, transposed), Operand::matrix(b, ldb, !transposed));
    // SAFETY: the dimensions were checked, and the caller vouches for the arrays.
    let mut c = unsafe {
        multiply((n, n, k), alpha, a, bt, T::zero(), product.as_mut_ptr(), 1, n);
        view_mut(c, n, n, ldc)
    };
    for j in 0..c.ncols() {
        for i in triangle_rows(uplo, j, c.nrows()) {
            let before = if beta.is_zero() { beta } else { beta * c[(i, j)] };
            c[(i, j)] = term(&product, i, j) + before;
        }
    }
}

/// A matrix to multiply by, or a vector as a matrix of one column: its first element and the
/// strides from row to row and from column to column.
struct Operand<T> {
    first: *const T,
    down: i32,
    right: i32,
}

impl<T> Operand<T> {
    /// The matrix stored by columns `ld` apart, or its transpose.
    fn matrix(first: *const T, ld: i32, transposed: bool) -> Self {
        let (down, right) = if transposed { (ld, 1) } else { (1, ld) };
        Operand { first, down, right }
    }
}

/// C := alpha A B + beta C, where C is `m` x `n` and A is `m` x `k`.
///
/// # Safety
/// The dimensions are not negative. The elements that the strides reach are valid for reads, those
/// of C also for writes; those of C are distinct and overlap no other.
unsafe fn multiply<T: Real>(
    (m, n, k): (i32, i32, i32),
    alpha: T,
    a: Operand<T>,
    b: Operand<T>,
    beta: T,
    c: *mut T,
    down: i32,
    right: i32,
) {
    // The kernel would multiply what must not even be read.
    let k = if alpha.is_zero() { 0 } else { k };
    // SAFETY: the contract is the caller's own. The kernel does not read C where beta is zero.
    unsafe {
        T::MULTIPLY(
            m as usize,
            k as usize,
            n as usize,
            alpha,
            a.first,
            a.down as isize,
            a.right as isize,
            b.first,
            b.down as isize,
            b.right as isize,
            beta,
            c,
            down as isize,
            right as isize,
        );
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

/// The offset of the first element of a vector of `n` elements: with a negative increment it is at
/// the far end of the array.
fn first(n: i32, inc: i32) -> isize {
    if inc < 0 { (1 - n as isize) * inc as isize } else { 0 }
}
