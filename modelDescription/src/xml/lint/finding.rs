//! What a rule reports, as a compiler would.

use std::fmt;

/// How bad a finding is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// Nothing is wrong, but it could be better.
    Note,
    /// Importers may well cope.
    Warning,
    /// Against the standard.
    Error,
}

impl Level {
    /// The word for it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Note => "note",
            Self::Warning => "warning",
            Self::Error => "error",
        }
    }
}

/// A finding about an FMU.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finding {
    /// How bad.
    pub level: Level,
    /// Name of the rule.
    pub code: &'static str,
    /// What is wrong, with the values.
    pub message: String,
    /// File, and line where there is one.
    pub location: String,
    /// What to do.
    pub help: String,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}[{}]: {}", self.level.name(), self.code, self.message)?;
        writeln!(f, "  --> {}", self.location)?;
        write!(f, "  = help: {}", self.help)
    }
}
