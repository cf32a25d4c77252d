//! The style sheet of the pages: light, dark, on paper, on a phone.

/// Nothing is fetched, and nothing is told by colour alone.
pub(super) const STYLE: &str = include_str!("../../assets/report.css");
