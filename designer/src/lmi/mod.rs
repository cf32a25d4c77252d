//! Linear matrix inequalities: matrix expressions affine in decision variables, and a minimum
//! subject to them.
//!
//! Expressions are written as on paper. With variables they are assembled into the solver's cones;
//! without (all terms constant), the same formula yields numbers to check a solution by.
//!
//! # Conventions
//! An inequality is a symmetric expression X that shall be positive semidefinite, `X >= 0`; strict
//! inequalities are the caller's margins.

pub mod affine;
pub mod matrix;
pub mod solve;
