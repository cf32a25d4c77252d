//! What an FMU is whatever version of FMI it speaks: a sampled model on its clock, its variables, the
//! block its numbers are baked into, saved states, memory and log.
//!
//! # Conventions
//! - A model is sampled: it runs at `start time + k T`, k an integer, T its sample period. A
//!   communication step of any length runs every sample that falls into it.
//! - What is refused (a step, a value, a saved state) comes back as the reason, with nothing changed;
//!   the layer of a version turns it into that version's status and log message.
//! - Nothing here panics, prints, spawns threads, keeps mutable statics, or allocates but through
//!   [`Memory`].
#![cfg_attr(not(test), no_std)]

pub mod access;
pub mod baked;
mod call_states;
pub mod clock;
mod decimal;
mod derivatives;
mod export;
pub mod fields;
pub mod foreign;
mod guid;
mod log;
mod memory;
mod model;
mod refusal;
mod run;
pub mod saved_state;
mod status;
mod text;

pub use baked::{BLOCK_SIZE, Baked, BakedError, Block, PAYLOAD_CAPACITY, SealError, seal};
pub use call_states::States;
pub use clock::{Clock, RunRefusal, Step, StepRefusal};
pub use derivatives::{MAX_INPUTS, MAX_ORDER};
pub use fields::Archive;
pub use guid::{GUID_LENGTH, Guid};
pub use log::{Categories, Log, Logger};
pub use memory::Memory;
pub use model::{Fmu, Model};
pub use refusal::AccessRefusal;
pub use run::Run;
pub use status::Status;
pub use text::Text;
