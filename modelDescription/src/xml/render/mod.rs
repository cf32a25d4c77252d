//! Rendering to the schemas of FMI 2.0 and 3.0.

mod common;
mod fmi2;
pub mod fmi3;

pub use common::{Rendered, digest};
pub use fmi2::{describe, render};
