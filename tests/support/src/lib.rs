//! What tests share: the reference cases of `tests/cases`, an integrator, a drive as a logger records it, and
//! a cache for what is slow to make.
//!
//! Whatever fails here fails the test, by a panic at its line.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "for tests alone")]

pub mod cases;
pub mod integration;
pub mod log;
pub mod once;
