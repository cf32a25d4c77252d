//! FMUs from a design: runtimes, what is baked into them, documentation, archive.

pub mod archive;
pub mod bake;
pub mod bill;
pub mod package;
pub mod reference;
pub mod runtime;
mod slices;
pub mod system;
