//! The C side: raw pointers in, checked values out. One generic function for each function that is provided,
//! with its name and signature, and one for all others; [`export_fmi3!`](crate::export_fmi3) gives them their
//! symbols.
//!
//! # Safety
//! For all functions here, as the standard demands of an importer: `instance` is NULL or comes from
//! [`fmi3InstantiateCoSimulation`] of the same `F` and was not freed; no other call on the same instance is
//! under way; pointers are NULL or valid for as many elements as the call says; strings are
//! NUL-terminated; a state is NULL or comes from an instance of the same `F` and was not freed;
//! callbacks are what the standard says they are.
#![allow(non_snake_case)]
#![allow(missing_docs, reason = "the standard documents these functions")]
#![allow(clippy::missing_safety_doc, reason = "one contract for all, above")]
#![allow(clippy::too_many_arguments, reason = "the standard's")]

mod call;
mod life_cycle;
mod states;
mod steps;
mod values;

pub use call::{Fmi3, absent};
pub use life_cycle::*;
pub use states::*;
pub use steps::*;
pub use values::*;
