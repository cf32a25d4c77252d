//! The caller's arrays as nalgebra's views, and the rules their arguments obey.
//!
//! A view touches only the elements that belong to its matrix: what lies between the columns may
//! be another matrix of the caller's. Elements of a column are neighbours in every view: nalgebra
//! 0.35 oversteps the end of columns with gaps (its issue 1616).

use std::cmp::Ordering;
use std::ops::Range;

use nalgebra::{
    Const, DMatrix, DVector, Dyn, MatrixView, MatrixViewMut, RealField, ViewStorage, ViewStorageMut,
};

/// C := alpha A B + beta C with any strides: `matrixmultiply`'s kernel for one precision.
pub(crate) type Multiply<T> = unsafe fn(
    usize,
    usize,
    usize,
    T,
    *const T,
    isize,
    isize,
    *const T,
    isize,
    isize,
    T,
    *mut T,
    isize,
    isize,
);

/// `f32` or `f64`.
pub(crate) trait Real: RealField + Copy {
    const MULTIPLY: Multiply<Self>;
}

impl Real for f32 {
    const MULTIPLY: Multiply<f32> = matrixmultiply::sgemm;
}

impl Real for f64 {
    const MULTIPLY: Multiply<f64> = matrixmultiply::dgemm;
}

pub(crate) type View<'a, T> = MatrixView<'a, T, Dyn, Dyn, Const<1>, Dyn>;
pub(crate) type ViewMut<'a, T> = MatrixViewMut<'a, T, Dyn, Dyn, Const<1>, Dyn>;

/// The matrix of `rows` x `cols` stored by columns `ld` apart.
///
/// # Safety
/// `rows`, `cols` and `ld` are not negative, and the elements are valid for reads and are not
/// written during the lifetime of the view.
pub(crate) unsafe fn view<'a, T: Real>(a: *const T, rows: i32, cols: i32, ld: i32) -> View<'a, T> {
    let shape = (Dyn(rows as usize), Dyn(cols as usize));
    // SAFETY: the caller vouches for the elements that shape and strides reach.
    View::from_data(unsafe {
        ViewStorage::from_raw_parts(a, shape, (Const::<1>, Dyn(ld as usize)))
    })
}

/// The matrix of `rows` x `cols` stored by columns `ld` apart, to read and write.
///
/// # Safety
/// `rows`, `cols` and `ld` are not negative, and the elements are valid for reads and writes and
/// are used through this view alone during its lifetime.
pub(crate) unsafe fn view_mut<'a, T: Real>(
    a: *mut T,
    rows: i32,
    cols: i32,
    ld: i32,
) -> ViewMut<'a, T> {
    let shape = (Dyn(rows as usize), Dyn(cols as usize));
    // SAFETY: the caller vouches for the elements that shape and strides reach.
    ViewMut::from_data(unsafe {
        ViewStorageMut::from_raw_parts(a, shape, (Const::<1>, Dyn(ld as usize)))
    })
}

/// Whether `ld` may separate the columns of a matrix of `rows` rows.
pub(crate) fn is_leading(ld: i32, rows: i32) -> bool {
    ld >= rows.max(1)
}

/// Whether UPLO names a triangle.
pub(crate) fn is_triangle(uplo: u8) -> bool {
    matches!(uplo, b'U' | b'L')
}

/// The rows that the triangle `uplo` of a matrix of order `n` has in column `j`.
pub(crate) fn triangle_rows(uplo: u8, j: usize, n: usize) -> Range<usize> {
    if uplo == b'U' { 0..j + 1 } else { j..n }
}

/// The lower triangle, under zeros, of the symmetric matrix whose triangle `uplo` `a` holds.
pub(crate) fn lower_triangle<T: Real>(uplo: u8, a: &View<T>) -> DMatrix<T> {
    if uplo == b'U' { a.transpose().lower_triangle() } else { a.lower_triangle() }
}

/// The order that sorts `values`.
pub(crate) fn ascending<T: Real>(values: &DVector<T>) -> Vec<usize> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&i, &j| values[i].partial_cmp(&values[j]).unwrap_or(Ordering::Equal));
    order
}
