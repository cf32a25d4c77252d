//! Matrix expressions affine in decision variables, written as on paper.

use std::collections::BTreeMap;
use std::ops::{Add, Mul, Neg, Sub};

use crate::lmi::matrix::Matrix;

/// Hands out decision variables.
#[derive(Clone, Debug, Default)]
pub struct Variables {
    pub(super) count: usize,
}

impl Variables {
    /// A full `rows x columns` matrix.
    pub fn full(&mut self, rows: usize, columns: usize) -> Affine {
        let mut x = Affine::zeros(rows, columns);
        for row in 0..rows {
            for column in 0..columns {
                x.terms.insert(self.next(), unit(rows, columns, &[(row, column)]));
            }
        }
        x
    }

    /// A symmetric `n x n` matrix.
    pub fn symmetric(&mut self, n: usize) -> Affine {
        let mut x = Affine::zeros(n, n);
        for column in 0..n {
            for row in 0..=column {
                x.terms.insert(self.next(), unit(n, n, &[(row, column), (column, row)]));
            }
        }
        x
    }

    /// A scalar, 1 x 1.
    pub fn scalar(&mut self) -> Affine {
        self.full(1, 1)
    }

    fn next(&mut self) -> usize {
        self.count += 1;
        self.count - 1
    }
}

/// The matrix with ones at `places` and zeros elsewhere.
fn unit(rows: usize, columns: usize, places: &[(usize, usize)]) -> Matrix {
    let mut x = Matrix::zeros(rows, columns);
    for &place in places {
        x[place] = 1.0;
    }
    x
}

/// A matrix affine in the decision variables x: `constant + sum_j x_j terms[j]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Affine {
    pub(super) constant: Matrix,
    pub(super) terms: BTreeMap<usize, Matrix>,
}

impl From<Matrix> for Affine {
    fn from(constant: Matrix) -> Self {
        Self { constant, terms: BTreeMap::new() }
    }
}

impl Affine {
    /// The zero matrix.
    pub fn zeros(rows: usize, columns: usize) -> Self {
        Matrix::zeros(rows, columns).into()
    }

    /// A number, 1 x 1.
    pub fn number(value: f64) -> Self {
        Matrix::from_element(1, 1, value).into()
    }

    /// The matrix of the given blocks, row by row. Blocks of a row have one height, blocks of a
    /// column one width.
    pub fn blocks<const R: usize, const K: usize>(blocks: [[Affine; K]; R]) -> Self {
        let heights: Vec<usize> = blocks.iter().map(|row| row[0].constant.nrows()).collect();
        let widths: Vec<usize> = blocks[0].iter().map(|block| block.constant.ncols()).collect();
        let (rows, columns) = (heights.iter().sum(), widths.iter().sum());
        let mut sum = Self::zeros(rows, columns);
        let mut top = 0;
        for (row, height) in blocks.iter().zip(heights) {
            let mut left = 0;
            for (block, width) in row.iter().zip(&widths) {
                sum = sum
                    + block.map(|x| {
                        let mut placed = Matrix::zeros(rows, columns);
                        placed.view_mut((top, left), (height, *width)).copy_from(x);
                        placed
                    });
                left += width;
            }
            top += height;
        }
        sum
    }

    /// X'.
    pub fn transpose(&self) -> Self {
        self.map(Matrix::transpose)
    }

    /// `He(X) = X + X'`.
    pub fn he(&self) -> Self {
        self + &self.transpose()
    }

    /// `x I`, n x n, of a scalar x.
    pub fn times_identity(&self, n: usize) -> Self {
        self.times(&Matrix::identity(n, n))
    }

    /// `x Y` of a scalar x.
    pub fn times(&self, y: &Matrix) -> Self {
        self.map(|x| y * x[0])
    }

    /// The expression's value at `x`, one number for each decision variable.
    pub fn at(&self, x: &[f64]) -> Matrix {
        self.terms.iter().fold(self.constant.clone(), |sum, (&j, term)| sum + term * x[j])
    }

    /// The value of an expression without decision variables.
    pub fn value(&self) -> &Matrix {
        debug_assert!(self.terms.is_empty(), "the expression has decision variables");
        &self.constant
    }

    /// Side length of a square expression.
    pub fn order(&self) -> usize {
        self.constant.nrows()
    }

    /// A linear map, applied to the constant and every term.
    fn map(&self, linear: impl Fn(&Matrix) -> Matrix) -> Self {
        Self {
            constant: linear(&self.constant),
            terms: self.terms.iter().map(|(&j, term)| (j, linear(term))).collect(),
        }
    }
}

impl Add<&Affine> for Affine {
    type Output = Affine;
    fn add(mut self, other: &Affine) -> Affine {
        self.constant += &other.constant;
        for (&j, term) in &other.terms {
            self.terms.entry(j).and_modify(|sum| *sum += term).or_insert_with(|| term.clone());
        }
        self
    }
}

impl Neg for &Affine {
    type Output = Affine;
    fn neg(self) -> Affine {
        self.map(|x| -x)
    }
}

impl Mul<&Matrix> for &Affine {
    type Output = Affine;
    fn mul(self, right: &Matrix) -> Affine {
        self.map(|x| x * right)
    }
}

impl Mul<&Affine> for &Matrix {
    type Output = Affine;
    fn mul(self, right: &Affine) -> Affine {
        right.map(|x| self * x)
    }
}

impl Mul<&Affine> for f64 {
    type Output = Affine;
    fn mul(self, right: &Affine) -> Affine {
        right.map(|x| x * self)
    }
}

// The remaining combinations of owned and borrowed operands.
impl Add for Affine {
    type Output = Affine;
    fn add(self, other: Affine) -> Affine {
        self + &other
    }
}
impl Add for &Affine {
    type Output = Affine;
    fn add(self, other: &Affine) -> Affine {
        self.clone() + other
    }
}
impl Sub<&Affine> for Affine {
    type Output = Affine;
    fn sub(self, other: &Affine) -> Affine {
        self + &-other
    }
}
impl Sub for Affine {
    type Output = Affine;
    fn sub(self, other: Affine) -> Affine {
        self - &other
    }
}
impl Sub for &Affine {
    type Output = Affine;
    fn sub(self, other: &Affine) -> Affine {
        self.clone() - other
    }
}
impl Neg for Affine {
    type Output = Affine;
    fn neg(self) -> Affine {
        -&self
    }
}
impl Mul<&Matrix> for Affine {
    type Output = Affine;
    fn mul(self, right: &Matrix) -> Affine {
        &self * right
    }
}
