//! FMI 3.0 Co-Simulation for models written in Rust: implement [`Model`](steerguard_fmu_core::Model) and, for its
//! variables, [`Structure`](steerguard_model_description::structure::Structure), call [`export_fmi3!`] in a
//! `cdylib`, and the library answers all 75 functions of the standard.
//!
//! # Conventions
//! - Terms, states and rules are those of FMI 3.0.2; `fmi3GetVersion` says "3.0".
//! - What does not depend on the version of FMI is in [`steerguard_fmu_core`]; here are its C types and functions,
//!   the call sequence, and the way from one to the other.
//! - Events: where the importer uses Event Mode and allows early return, `fmi3DoStep` returns at the sample after
//!   which the clock's variable has changed; where it uses Event Mode alone, the step is done whole and the clock
//!   ticks at its end; where neither, the step is done whole and nothing is said.
//! - The time of an early return may be that of the communication point itself: a sample falls on it.
//! - A refused call (wrong state, wrong argument, value out of range) logs why, returns fmi3Error and changes
//!   nothing; the standard would have the importer reset or free the instance then, and it need not. Where work
//!   that had begun failed, the instance is Terminated.
//! - Nothing here panics, prints, spawns threads, keeps mutable statics, or allocates outside
//!   `fmi3InstantiateCoSimulation`, `fmi3GetFMUState` and `fmi3DeserializeFMUState`.
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
pub use functions::{FUNCTION_COUNT, Function, PROVIDED_COUNT, pointers};
/// For [`export_fmi3!`], whose users need not depend on it.
#[doc(hidden)]
pub use steerguard_fmu_core as fmu_core;
