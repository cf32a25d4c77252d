//! An FMI 2.0 Co-Simulation FMU in the hands of a hostile importer.
//!
//! # Conventions
//! - [`Functions`] are the 44 C functions, of a loaded library or linked into this program.
//! - What the importer of these tests gives to the FMU and gets from it, memory and log messages, is
//!   counted for each thread: see [`host`].
//! - A broken promise of the FMU is a panic here.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "this is test code")]

mod functions;
pub mod host;
pub mod random_calls;

pub use functions::Functions;
