//! The C side: raw pointers in, checked values out. One generic function for each function of the
//! standard, with its name and signature; [`export_fmi2!`](crate::export_fmi2) gives them their
//! symbols.
//!
//! # Safety
//! For all functions here, as the standard demands of an importer: `c` is NULL or comes from
//! [`fmi2Instantiate`] of the same `F` and was not freed; no other call on the same instance is
//! under way; pointers are NULL or valid for as many elements as the call says; strings are
//! NUL-terminated; a state is NULL or comes from an instance of the same `F` and was not freed;
//! callbacks are what the standard says they are.
#![allow(non_snake_case)]
#![allow(missing_docs, reason = "the standard documents these functions")]
#![allow(clippy::missing_safety_doc, reason = "one contract for all, above")]

mod call;
mod co_simulation;
mod life_cycle;
mod model_exchange;
mod states;
mod values;

pub use co_simulation::*;
pub use life_cycle::*;
pub use model_exchange::*;
pub use states::*;
pub use values::*;
