//! FMUs from a design: runtimes, what is baked into them, documentation, archive.

pub mod archive;
pub mod bake;
pub mod documentation;
pub mod package;
pub mod platform;
pub mod plot;
pub mod reference;
pub mod runtime;
pub mod system;
