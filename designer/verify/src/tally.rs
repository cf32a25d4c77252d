//! The count of a family's inequalities, each proven by exact elimination.

use crate::exact::Matrix;
use crate::family::{Combination, Family};
use crate::read::{RULES, Rows3};
use crate::refusal::Refusal;

/// The smallest margin of a family.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Margin {
    /// Which.
    pub family: Family,
    /// Number of inequalities, all proven.
    pub inequalities: usize,
    /// Smallest pivot of their eliminations relative to its diagonal element, in (0, 1], rounded
    /// for print: the proof is its exact sign.
    pub smallest_pivot: f64,
}

/// Counts the inequalities of a family and keeps the smallest margin.
pub struct Tally {
    /// What was counted.
    pub margin: Margin,
}

impl Tally {
    /// Nothing proven yet.
    pub fn new(family: Family) -> Self {
        Self { margin: Margin { family, inequalities: 0, smallest_pivot: f64::INFINITY } }
    }

    /// Proves `X > 0`.
    pub fn prove(&mut self, x: &Matrix, combination: Combination) -> Result<(), Refusal> {
        let family = self.margin.family;
        let pivot = x.positive_definite().map_err(|reason| Refusal::Broken {
            family,
            combination,
            reason,
        })?;
        self.margin.inequalities += 1;
        self.margin.smallest_pivot = self.margin.smallest_pivot.min(pivot);
        Ok(())
    }

    /// The exact values of a stored symmetric matrix.
    pub fn symmetric(&self, rows: &Rows3, matrix: &'static str) -> Result<Matrix, Refusal> {
        let x = Matrix::exactly(rows);
        if x.is_symmetric() {
            return Ok(x);
        }
        Err(Refusal::NotSymmetric { family: self.margin.family, matrix })
    }

    /// The exact values of stored symmetric matrices P_i.
    pub fn p(&self, p: &[Rows3; RULES]) -> Result<Vec<Matrix>, Refusal> {
        p.iter().map(|p| self.symmetric(p, "P")).collect()
    }
}
