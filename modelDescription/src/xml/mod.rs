//! `modelDescription.xml` of FMI 2.0 and 3.0: rendering, what an importer needs to read, and a lint.

mod header;
mod lint;
mod read;
mod render;
mod tree;

pub use header::{Header, Implementation, InterfaceType, header};
pub use lint::{Finding, Findings, Level, lint, lint_terminals};
pub use read::{CoSimulation, Description, Experiment, ReadError, ScalarVariable, Start, read};
pub use render::{Rendered, describe, digest, fmi3, render};
