//! The design that needs no solver.

#[path = "../../../packaging/tests/common/mod.rs"]
mod common;

use std::sync::LazyLock;

use steerguard_fmu_core::Block;

/// GUID of [`BLOCK`].
pub const GUID: &std::ffi::CStr = c"{fuzz}";

/// The design's numbers.
pub static PAYLOAD: LazyLock<Vec<u8>> =
    LazyLock::new(|| common::design().encode().unwrap().to_vec());

/// The design, baked.
pub static BLOCK: LazyLock<Block> = LazyLock::new(|| Block::sealed("{fuzz}", &PAYLOAD).unwrap());
