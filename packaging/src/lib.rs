//! From a design to FMUs, and from FMUs to a detected fault.

pub mod archive;
pub mod bake;
pub mod campaign;
pub mod check;
pub mod cli;
pub mod command;
pub mod cosimulation;
pub mod design_summary;
pub mod detection;
pub mod documentation;
pub mod failure;
pub mod importer;
pub mod output;
pub mod package;
pub mod platform;
pub mod plot;
pub mod progress;
pub mod reference;
pub mod report;
pub mod runtime;
pub mod scenario;
pub mod simulation;
pub mod system;
pub mod table;
