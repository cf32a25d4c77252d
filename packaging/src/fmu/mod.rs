//! FMUs from a design: runtimes, what is baked into them, documentation, archive.

pub mod archive;
pub mod bake;
pub mod design_summary;
pub mod documentation;
pub mod package;
pub mod reference;
pub mod runtime;
pub mod second;
pub mod sight;
mod slices;
pub mod system;
