//! What reads what others wrote, given any bytes: files by their content, the FMU by its C functions.
//!
//! # Conventions
//! - A target takes bytes and returns; a broken promise is a panic.
//! - `tests/fuzz` looks for bytes that break one, by coverage; `corpus/TARGET/` holds what it has found, one input a
//!   file, which `tests/replay.rs` gives to the targets again.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "this is test code")]

mod block;
mod files;
mod fmi2;
mod fmi3;
mod state;
mod unsolved;

/// Takes bytes, and panics where a promise is broken.
pub type Target = fn(&[u8]);

/// What is fuzzed, by name.
pub const TARGETS: [(&str, Target); 10] = [
    ("specification", files::specification),
    ("scenario", files::scenario),
    ("design", files::design),
    ("drive", files::drive),
    ("xml", files::xml),
    ("archive", files::archive),
    ("block", block::run),
    ("state", state::run),
    ("fmi2", fmi2::run),
    ("fmi3", fmi3::run),
];

/// The target of that name.
///
/// # Panics
/// If there is none.
pub fn target(name: &str) -> Target {
    let found = TARGETS.iter().find(|(of, _)| *of == name);
    found.unwrap_or_else(|| panic!("there is no target `{name}`")).1
}
