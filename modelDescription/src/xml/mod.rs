//! `modelDescription.xml`: rendering, what an importer needs to read, and a lint.

mod header;
mod lint;
mod read;
mod render;
mod tree;

pub use header::{Header, Implementation, header};
pub use lint::{Finding, Level, lint};
pub use read::{CoSimulation, Description, Experiment, ReadError, ScalarVariable, Start, read};
pub use render::{Rendered, describe, digest, render};
