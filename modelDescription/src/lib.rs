//! The variables of a Co-Simulation FMU, written once: the constant table that the FMU itself answers
//! from, and (feature `xml`) its rendering to the `modelDescription.xml` of FMI 2.0 and 3.0, the reader
//! an importer needs, and a lint.
//!
//! # Conventions
//! - A value reference is the variable's index in its table, unique over all types.
//! - All quantities are in SI units; display units are what a graphical importer shows first.
//! - The table holds no `start` values: they are taken from a fresh instance of the model when the
//!   description is rendered, so that the description and the binary cannot disagree.
//! - Terms are those of FMI 2.0.4, sections 2.2.7 (variables) and 4.3.1 (co-simulation).
#![cfg_attr(not(feature = "xml"), no_std)]

pub mod detector;
pub mod names;
pub mod plant;
pub mod structure;
mod table;
pub mod unit;
#[cfg(feature = "xml")]
pub mod xml;

pub use table::{
    Causality, DefaultExperiment, Dependencies, EnumerationItem, EnumerationType, Initial, Kind,
    LogCategory, ModelInfo, RealKind, Role, Value, Variability, Variable, VariableSet,
};
pub use unit::{DisplayUnit, Unit};
