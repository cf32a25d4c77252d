//! From recorded drives to a specification: what is told, and what the drives show, with its interval.

pub mod known;
pub mod plot;
pub mod specification;
