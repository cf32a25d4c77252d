//! What is said of a design: in the terminal, in the documentation inside its FMUs, and as a page of its own.
//!
//! [`DesignSummary`](design_summary::DesignSummary) and [`Record`](design_summary::Record) take out of a design what
//! is told; [`sections`] says it in HTML, figures drawn; [`page`] is the page around.

pub mod campaign;
mod chart;
pub mod design_summary;
pub mod documentation;
pub mod html;
pub mod page;
pub mod peers;
pub mod pictures;
pub mod replay;
pub mod second;
mod sections;
pub mod sight;
mod style;
