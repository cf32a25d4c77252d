//! Matrices of rational numbers, and the one question asked of them: positive definite or not.
//!
//! # Conventions
//! - Every f64 is a rational number and converts without error.
//! - Operands fit each other: sizes are examined where a file is read.

use std::ops::{Add, Mul, Neg, Sub};

use num_bigint::BigInt;
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{One, Signed, ToPrimitive, Zero};

/// A rational number of any size.
pub type Rational = BigRational;

/// The exact value of a finite number.
pub fn exact(x: f64) -> Rational {
    debug_assert!(x.is_finite(), "JSON holds finite numbers only");
    Rational::from_float(x).unwrap_or_else(Rational::zero)
}

/// A whole number.
pub fn whole(x: i64) -> Rational {
    Rational::from_integer(x.into())
}

/// The nearest f64, for print.
pub fn approximate(x: &Rational) -> f64 {
    x.to_f64().unwrap_or(f64::NAN)
}

/// A matrix: whole numbers over one positive denominator, which costs no search for common divisors
/// in products.
#[derive(Clone, Debug)]
pub struct Matrix {
    numerators: Vec<Vec<BigInt>>,
    denominator: BigInt,
}

impl Matrix {
    /// The matrix whose element at (row, column) is `element(row, column)`.
    pub fn new(rows: usize, columns: usize, element: impl Fn(usize, usize) -> Rational) -> Self {
        let row = |row| (0..columns).map(|column| element(row, column)).collect();
        let elements: Vec<Vec<Rational>> = (0..rows).map(row).collect();
        let denominators = elements.iter().flatten().map(Rational::denom);
        let denominator = denominators.fold(BigInt::one(), |common, x| common.lcm(x));
        let numerators = elements
            .iter()
            .map(|row| row.iter().map(|x| x.numer() * (&denominator / x.denom())).collect())
            .collect();
        Self { numerators, denominator }
    }

    /// The exact values of `rows`.
    pub fn exactly<const K: usize>(rows: &[[f64; K]]) -> Self {
        Self::new(rows.len(), K, |row, column| exact(rows[row][column]))
    }

    /// The unit matrix.
    pub fn identity(order: usize) -> Self {
        Self::new(order, order, |row, column| whole(i64::from(row == column)))
    }

    /// All zero.
    pub fn zeros(rows: usize, columns: usize) -> Self {
        Self::new(rows, columns, |_, _| whole(0))
    }

    /// The matrix of the given blocks, row by row.
    pub fn blocks(blocks: &[&[&Self]]) -> Self {
        let denominators = blocks.iter().flat_map(|row| row.iter()).map(|block| &block.denominator);
        let denominator = denominators.fold(BigInt::one(), |common, x| common.lcm(x));
        let beside = |blocks: &&[&Self]| -> Vec<Vec<BigInt>> {
            let scaled: Vec<_> = blocks.iter().map(|block| block.over(&denominator)).collect();
            let height = scaled.first().map_or(0, Vec::len);
            (0..height)
                .map(|row| scaled.iter().flat_map(|block| block[row].clone()).collect())
                .collect()
        };
        Self { numerators: blocks.iter().flat_map(beside).collect(), denominator }
    }

    /// The columns of this matrix, then those of another of the same height.
    pub fn beside(&self, right: &Self) -> Self {
        Self::blocks(&[&[self, right]])
    }

    /// A column.
    pub fn column(&self, column: usize) -> Self {
        Self::new(self.height(), 1, |row, _| self.at(row, column))
    }

    /// Number of rows.
    pub fn height(&self) -> usize {
        self.numerators.len()
    }

    /// Number of columns.
    pub fn width(&self) -> usize {
        self.numerators.first().map_or(0, Vec::len)
    }

    /// The element at (row, column).
    pub fn at(&self, row: usize, column: usize) -> Rational {
        Rational::new(self.numerators[row][column].clone(), self.denominator.clone())
    }

    /// X'.
    pub fn transpose(&self) -> Self {
        let row = |row: usize| self.numerators.iter().map(|x| x[row].clone()).collect();
        let numerators = (0..self.width()).map(row).collect();
        Self { numerators, denominator: self.denominator.clone() }
    }

    /// `X' X`.
    pub fn squared(&self) -> Self {
        &self.transpose() * self
    }

    /// `He(X) = X + X'`.
    pub fn he(&self) -> Self {
        self + &self.transpose()
    }

    /// `x X`.
    pub fn times(&self, x: &Rational) -> Self {
        Self {
            numerators: map(&self.numerators, |element| element * x.numer()),
            denominator: &self.denominator * x.denom(),
        }
    }

    /// Whether X = X'.
    pub fn is_symmetric(&self) -> bool {
        self.numerators == self.transpose().numerators
    }

    /// Largest magnitude of an element.
    pub fn largest(&self) -> Rational {
        let magnitudes = self.numerators.iter().flatten().map(Signed::abs);
        let largest = magnitudes.max().unwrap_or_else(BigInt::zero);
        Rational::new(largest, self.denominator.clone())
    }

    /// The numerators over another denominator, a multiple of the matrix's own.
    fn over(&self, denominator: &BigInt) -> Vec<Vec<BigInt>> {
        let factor = denominator / &self.denominator;
        map(&self.numerators, |x| x * &factor)
    }

    /// Element by element.
    fn zip(&self, other: &Self, f: impl Fn(&BigInt, &BigInt) -> BigInt) -> Self {
        let denominator = self.denominator.lcm(&other.denominator);
        let rows = self.over(&denominator).into_iter().zip(other.over(&denominator));
        let numerators =
            rows.map(|(a, b)| a.iter().zip(&b).map(|(a, b)| f(a, b)).collect()).collect();
        Self { numerators, denominator }
    }

    /// Proves a symmetric matrix positive definite: all pivots of its elimination without exchange
    /// of rows, `X = L D L'`, are positive, which is necessary and sufficient.
    ///
    /// Returns the smallest pivot relative to the diagonal element it stems from: 1 for a diagonal
    /// matrix, near 0 for an almost singular one, unchanged by a scaling of rows with columns.
    ///
    /// # Errors
    /// [`NotPositive`]: the first pivot that is zero or negative.
    pub fn positive_definite(&self) -> Result<f64, NotPositive> {
        // In whole numbers, without fractions on the way: E. H. Bareiss, Mathematics of Computation
        // 22 (1968) 565-578. After step k, x[k][k] is the leading minor of order k + 1.
        let mut x = self.numerators.clone();
        let order = x.len();
        let diagonal: Vec<BigInt> = (0..order).map(|k| x[k][k].clone()).collect();

        let mut smallest = f64::INFINITY;
        let mut previous = BigInt::one();
        for k in 0..order {
            let minor = x[k][k].clone();
            let ratio = Rational::new_raw(minor.clone(), &previous * diagonal[k].abs());
            let relative = if diagonal[k].is_zero() { 0.0 } else { approximate(&ratio) };
            if !minor.is_positive() {
                return Err(NotPositive { number: k + 1, relative });
            }
            smallest = smallest.min(relative);
            for i in k + 1..order {
                for j in i..order {
                    x[i][j] = (&x[i][j] * &minor - &x[k][i] * &x[k][j]) / &previous;
                }
            }
            previous = minor;
        }
        Ok(smallest)
    }
}

/// A pivot that shall be positive and is not.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("pivot {number} is {relative:.3e} of its diagonal element, not positive")]
pub struct NotPositive {
    /// Which pivot, from 1.
    pub number: usize,
    /// The pivot relative to the magnitude of its diagonal element.
    pub relative: f64,
}

impl Add for &Matrix {
    type Output = Matrix;
    fn add(self, other: &Matrix) -> Matrix {
        self.zip(other, |a, b| a + b)
    }
}

impl Sub for &Matrix {
    type Output = Matrix;
    fn sub(self, other: &Matrix) -> Matrix {
        self.zip(other, |a, b| a - b)
    }
}

impl Neg for &Matrix {
    type Output = Matrix;
    fn neg(self) -> Matrix {
        Matrix { numerators: map(&self.numerators, |x| -x), denominator: self.denominator.clone() }
    }
}

impl Mul for &Matrix {
    type Output = Matrix;
    fn mul(self, other: &Matrix) -> Matrix {
        let element = |row: &[BigInt], column: usize| {
            let products = row.iter().zip(&other.numerators).map(|(x, row)| x * &row[column]);
            products.sum::<BigInt>()
        };
        let row = |row: &Vec<BigInt>| (0..other.width()).map(|k| element(row, k)).collect();
        Matrix {
            numerators: self.numerators.iter().map(row).collect(),
            denominator: &self.denominator * &other.denominator,
        }
    }
}

impl PartialEq for Matrix {
    fn eq(&self, other: &Self) -> bool {
        (self.height(), self.width()) == (other.height(), other.width())
            && (self - other).largest().is_zero()
    }
}

fn map(rows: &[Vec<BigInt>], f: impl Fn(&BigInt) -> BigInt) -> Vec<Vec<BigInt>> {
    rows.iter().map(|row| row.iter().map(&f).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimal_fractions_are_not_what_they_look_like() {
        assert_ne!(exact(0.1) + exact(0.2), exact(0.3));
        assert_eq!(exact(0.1) * whole(1 << 55), whole(3602879701896397));
        assert_eq!(approximate(&exact(0.1)), 0.1);
    }

    #[test]
    fn algebra_is_that_of_matrices() {
        let a = Matrix::exactly(&[[1.0, 2.0], [3.0, 4.0]]);
        let b = Matrix::exactly(&[[0.5], [-0.25]]);
        assert_eq!(&a * &b, Matrix::exactly(&[[0.0], [0.5]]));
        assert_eq!(a.he(), Matrix::exactly(&[[2.0, 5.0], [5.0, 8.0]]));
        assert_eq!(
            Matrix::blocks(&[&[&a, &b], &[&b.transpose(), &Matrix::identity(1)]]),
            Matrix::exactly(&[[1.0, 2.0, 0.5], [3.0, 4.0, -0.25], [0.5, -0.25, 1.0]]),
        );
        assert_eq!((&a - &a.transpose()).largest(), whole(1));
    }

    #[test]
    fn pivots_are_relative_to_the_diagonal() {
        // Pivots 4 and 3 - 2 * 2 / 4 = 2.
        let x = Matrix::exactly(&[[4.0, 2.0], [2.0, 3.0]]);
        assert_eq!(x.positive_definite(), Ok(2.0 / 3.0));
        let scale = Matrix::exactly(&[[1e-30, 0.0], [0.0, 1e20]]);
        assert_eq!((&(&scale * &x) * &scale).positive_definite(), Ok(2.0 / 3.0));
    }

    #[test]
    fn indefinite_and_semidefinite_matrices_are_refused() {
        let refused = |rows: &[[f64; 2]]| Matrix::exactly(rows).positive_definite().unwrap_err();
        assert_eq!(refused(&[[1.0, 2.0], [2.0, 1.0]]), NotPositive { number: 2, relative: -3.0 });
        assert_eq!(refused(&[[1.0, 1.0], [1.0, 1.0]]), NotPositive { number: 2, relative: 0.0 });
        assert_eq!(refused(&[[-1.0, 0.0], [0.0, 1.0]]), NotPositive { number: 1, relative: -1.0 });
        assert_eq!(refused(&[[0.0, 0.0], [0.0, 1.0]]), NotPositive { number: 1, relative: 0.0 });
    }

    /// The products of (5, 41): singular, and whole numbers, so that nothing is rounded but the
    /// elimination itself.
    #[test]
    fn a_singular_matrix_that_is_definite_in_floating_point_is_refused() {
        let [x11, x12, x22] = [25.0, 205.0, 1681.0];
        let pivot_in_floating_point: f64 = x22 - x12 / x11 * x12;
        assert!(pivot_in_floating_point > 0.0);
        assert_eq!(
            Matrix::exactly(&[[x11, x12], [x12, x22]]).positive_definite(),
            Err(NotPositive { number: 2, relative: 0.0 }),
        );
        let next = f64::from_bits(x22.to_bits() + 1);
        assert!(Matrix::exactly(&[[x11, x12], [x12, next]]).positive_definite().is_ok());
    }
}
