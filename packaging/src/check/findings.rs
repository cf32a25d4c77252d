//! What is read of an FMU, and what was found so far.

use std::collections::BTreeMap;

use steerguard_model_description::xml::{self, Finding, Level};

/// Path of the description.
pub const DESCRIPTION: &str = "modelDescription.xml";

/// What was read of an FMU.
#[derive(Debug, Default)]
pub struct Contents {
    /// Names of all entries.
    pub names: Vec<String>,
    /// Description, icon, bill of materials and libraries by name.
    pub files: BTreeMap<String, Vec<u8>>,
}

/// The findings so far.
pub struct Findings {
    /// What findings call the file.
    pub file: String,
    /// In the order in which they were found.
    pub list: xml::Findings,
}

impl Findings {
    pub fn add(&mut self, level: Level, code: &'static str, message: String, at: &str, help: &str) {
        let location = if at.is_empty() { self.file.clone() } else { at.to_owned() };
        self.list.add(Finding { level, code, message, location, help: help.to_owned() });
    }

    pub fn error(&mut self, code: &'static str, message: impl Into<String>, at: &str, help: &str) {
        self.add(Level::Error, code, message.into(), at, help);
    }

    pub fn warning(
        &mut self,
        code: &'static str,
        message: impl Into<String>,
        at: &str,
        help: &str,
    ) {
        self.add(Level::Warning, code, message.into(), at, help);
    }

    pub fn note(&mut self, code: &'static str, message: impl Into<String>, at: &str, help: &str) {
        self.add(Level::Note, code, message.into(), at, help);
    }
}
