//! Matrices of numbers, and their conversions to and from arrays of rows.

use nalgebra::DMatrix;

/// A matrix of numbers.
pub type Matrix = DMatrix<f64>;
/// Rows of a 3 x 3 matrix.
pub type Rows3 = [[f64; 3]; 3];

/// A matrix of rows as a [`Matrix`].
pub fn matrix<const R: usize, const K: usize>(rows: &[[f64; K]; R]) -> Matrix {
    Matrix::from_fn(R, K, |row, column| rows[row][column])
}

/// A matrix as its rows.
pub fn rows<const R: usize, const K: usize>(x: &Matrix) -> [[f64; K]; R] {
    std::array::from_fn(|row| std::array::from_fn(|column| x[(row, column)]))
}

/// A matrix as nested rows.
pub fn nested(x: &Matrix) -> Vec<Vec<f64>> {
    x.row_iter().map(|row| row.iter().copied().collect()).collect()
}

/// The given blocks, of one height, beside each other.
pub(crate) fn beside(blocks: &[&Matrix]) -> Matrix {
    let columns: Vec<_> = blocks.iter().flat_map(|block| block.column_iter()).collect();
    match columns.is_empty() {
        true => Matrix::zeros(blocks.first().map_or(0, |block| block.nrows()), 0),
        false => Matrix::from_columns(&columns),
    }
}

/// Smallest eigenvalue of a symmetric matrix.
pub fn smallest_eigenvalue(x: &Matrix) -> f64 {
    x.symmetric_eigenvalues().min()
}
