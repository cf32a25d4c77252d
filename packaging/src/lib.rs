//! From a design to FMUs, and from FMUs to a detected fault.

pub mod archive;
pub mod output;
pub mod platform;
pub mod scenario;
