//! Gains by Theorem 4: its inequalities, their solution, and what stands in the way of one.

pub mod gains;
pub mod obstacle;
pub mod solve;
pub mod theorem4;
