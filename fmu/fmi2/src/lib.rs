//! FMI 2.0 Co-Simulation for models written in Rust: implement [`Model`](steerguard_fmu_core::Model), call
//! [`export_fmi2!`] in a `cdylib`, and the library answers all 44 functions of the standard.
//!
//! # Conventions
//! - Terms, states and rules are those of FMI 2.0.4; `fmiVersion` is "2.0".
//! - What does not depend on the version of FMI is in [`steerguard_fmu_core`]; here are its C types and functions,
//!   the call sequence, and the way from one to the other.
//! - A refused call (wrong state, wrong argument, value out of range) logs why, returns fmi2Error
//!   and changes nothing. The instance enters the error state only where work that had begun failed.
//! - Nothing here panics, prints, spawns threads, keeps mutable statics, or allocates outside
//!   `fmi2Instantiate`, `fmi2GetFMUstate` and `fmi2DeSerializeFMUstate`.
//! - Names of C types and functions are those of the standard's headers.
#![cfg_attr(not(test), no_std)]

#[doc(hidden)]
pub mod boundary;
pub mod call_sequence;
mod environment;
mod export;
mod functions;
mod instance;
#[cfg(test)]
mod tests;
pub mod types;

pub use call_sequence::CallState;
pub use functions::{FUNCTION_COUNT, Function, pointers};
/// For [`export_fmi2!`], whose users need not depend on it.
#[doc(hidden)]
pub use steerguard_fmu_core as fmu_core;
