//! FMI 2.0 Co-Simulation for models written in Rust: implement [`Model`], call [`export_fmi2!`] in a
//! `cdylib`, and the library answers all 44 functions of the standard.
//!
//! # Conventions
//! - Terms, states and rules are those of FMI 2.0.4; `fmiVersion` is "2.0".
//! - A model is sampled: it runs at `start time + k T`, k an integer, T its sample period. A
//!   communication step of any length runs every sample that falls into it.
//! - A refused call (wrong state, wrong argument, value out of range) logs why, returns fmi2Error
//!   and changes nothing. The instance enters the error state only where work that had begun failed.
//! - Nothing here panics, prints, spawns threads, keeps mutable statics, or allocates outside
//!   `fmi2Instantiate`, `fmi2GetFMUstate` and `fmi2DeSerializeFMUstate`.
//! - Names of C types and functions are those of the standard's headers.
#![cfg_attr(not(test), no_std)]

pub mod archive;
pub mod baked;
#[doc(hidden)]
pub mod boundary;
pub mod call_sequence;
mod clock;
mod export;
mod functions;
mod instance;
mod log;
mod memory;
mod model;
#[cfg(test)]
mod tests;
mod text;
pub mod types;

pub use archive::Archive;
pub use baked::{BLOCK_SIZE, Baked, BakedError, Block, PAYLOAD_CAPACITY, SealError, seal};
pub use call_sequence::{CallState, States};
pub use functions::{FUNCTION_COUNT, Function};
pub use log::Log;
pub use model::{Fmu, Model};
pub use text::Text;
