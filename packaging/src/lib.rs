//! From a design to FMUs, and from FMUs to a detected fault.

mod bounded;
pub mod campaign;
pub mod check;
pub mod cli;
pub mod digest;
pub mod drive;
pub mod fmu;
pub mod identify;
pub mod importer;
mod mach_o;
pub mod output;
pub mod platform;
pub mod replay;
pub mod report;
