//! What can be wrong in a document that people write, said by key, value and allowed range.

use std::fmt;
use std::ops::Range;

use super::{Allowed, place};

/// A mistake at a key.
#[derive(Clone, Debug, PartialEq)]
pub struct Mistake {
    /// Path of the key, such as `fault[1].smallest_deg`; empty where the text is no TOML.
    pub key: String,
    /// What is wrong.
    pub kind: MistakeKind,
    /// What to do; may be empty.
    pub help: String,
    /// Paths of other keys that the mistake follows from.
    pub because_of: Vec<String>,
    /// What the key is where it is left out, in TOML.
    pub default: Option<String>,
}

/// What can be wrong.
#[derive(Clone, Debug, PartialEq)]
pub enum MistakeKind {
    /// Not TOML.
    Syntax {
        /// What the parser said.
        message: String,
        /// Where, in bytes.
        at: Range<usize>,
        /// Line and column, from 1.
        position: [usize; 2],
    },
    /// A key that the table has not.
    UnknownKey {
        /// Nearest known key, if one is near.
        nearest: Option<String>,
        /// All known keys.
        known: Vec<String>,
    },
    /// A key that the table lacks.
    MissingKey,
    /// A value of the wrong type.
    Type {
        /// What was found.
        found: String,
        /// What was expected.
        expected: String,
    },
    /// A value that is not possible.
    Value {
        /// The value.
        value: String,
        /// What is allowed.
        allowed: String,
    },
}

impl Mistake {
    /// Something is wrong at `key`.
    pub(super) fn new(key: impl Into<String>, kind: MistakeKind) -> Self {
        let key = key.into();
        Self { key, kind, help: String::new(), because_of: Vec::new(), default: None }
    }

    /// `key` is missing, though it may be left out elsewhere.
    pub fn missing(key: impl Into<String>) -> Self {
        Self::new(key, MistakeKind::MissingKey)
    }

    /// The `value` at `key` is not possible.
    pub fn value(
        key: impl Into<String>,
        value: impl fmt::Debug,
        allowed: impl fmt::Display,
    ) -> Self {
        let (value, allowed) = (format!("{value:?}"), allowed.to_string());
        Self::new(key, MistakeKind::Value { value, allowed })
    }

    /// The same with what to do.
    pub fn help(self, help: impl Into<String>) -> Self {
        Self { help: help.into(), ..self }
    }

    /// The same, as it follows from the value of `key` too.
    pub fn because_of(mut self, key: &str) -> Self {
        self.because_of.push(key.into());
        self
    }

    /// What is wrong, without the value's allowed range and what to do.
    pub(super) fn title(&self) -> String {
        let key = &self.key;
        match &self.kind {
            MistakeKind::Syntax { message, .. } => format!("not valid TOML: {message}"),
            MistakeKind::UnknownKey { .. } => format!("unknown key `{key}`"),
            MistakeKind::MissingKey => format!("`{key}` is missing"),
            MistakeKind::Type { .. } => format!("`{key}` is of the wrong type"),
            MistakeKind::Value { value, .. } => format!("`{key}` = {value} is not possible"),
        }
    }
}

impl fmt::Display for Mistake {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { key, kind, help, .. } = self;
        match kind {
            MistakeKind::Syntax { message, position: [line, column], .. } => {
                write!(f, "not valid TOML at line {line}, column {column}: {message}")?;
            }
            MistakeKind::UnknownKey { nearest: Some(nearest), .. } => {
                write!(f, "unknown key `{key}`: did you mean `{nearest}`?")?;
            }
            MistakeKind::UnknownKey { nearest: None, known } => {
                write!(f, "unknown key `{key}`: known here are {}", known.join(", "))?;
            }
            MistakeKind::MissingKey => write!(f, "`{key}` is missing")?,
            MistakeKind::Type { found, expected } => {
                write!(f, "`{key}` is {found}: expected {expected}")?;
            }
            MistakeKind::Value { value, allowed } => {
                write!(f, "`{key}` = {value}: allowed is {allowed}")?;
            }
        }
        if help.is_empty() { Ok(()) } else { write!(f, "; {help}") }
    }
}

/// Every mistake that was found, at least one where it is an error.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mistakes {
    list: Vec<Mistake>,
}

impl Mistakes {
    /// The mistakes, in the order in which they were found.
    pub fn list(&self) -> &[Mistake] {
        &self.list
    }

    /// Adds a mistake, unless one beneath its key is known: what contains a mistake is not told to be
    /// wrong once more.
    pub fn add(&mut self, mistake: Mistake) {
        if mistake.key.is_empty() || self.sound(&mistake.key) {
            self.list.push(mistake);
        }
    }

    /// Adds a mistake unless the condition `holds`.
    pub fn unless(&mut self, holds: bool, mistake: impl FnOnce() -> Mistake) {
        if !holds {
            self.add(mistake());
        }
    }

    /// Adds a mistake unless `value`, at `key`, is one of the `allowed`.
    pub fn number(&mut self, key: &str, value: f64, allowed: Allowed) {
        self.unless(allowed.holds(value), || Mistake::value(key, value, allowed));
    }

    /// Whether no mistake is known at `key` or beneath it.
    pub fn sound(&self, key: &str) -> bool {
        !self.list.iter().any(|mistake| is_beneath(&mistake.key, key))
    }

    /// States what keys of values that are not possible are by default.
    pub(super) fn state_defaults(&mut self, defaults: &toml::Table) {
        for mistake in &mut self.list {
            if matches!(mistake.kind, MistakeKind::Type { .. } | MistakeKind::Value { .. }) {
                mistake.default = place::default_of(defaults, &mistake.key);
            }
        }
    }

    /// Nothing, or the mistakes as an error.
    ///
    /// # Errors
    /// The mistakes, where there are any.
    pub fn into_result(self) -> Result<(), Self> {
        if self.list.is_empty() { Ok(()) } else { Err(self) }
    }
}

/// Whether `path` is `of` or the path of something in it.
fn is_beneath(path: &str, of: &str) -> bool {
    path.strip_prefix(of).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
}

impl From<Mistake> for Mistakes {
    fn from(mistake: Mistake) -> Self {
        Self { list: vec![mistake] }
    }
}

impl fmt::Display for Mistakes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, mistake) in self.list.iter().enumerate() {
            let line_break = if index == 0 { "" } else { "\n" };
            write!(f, "{line_break}{mistake}")?;
        }
        Ok(())
    }
}

impl std::error::Error for Mistakes {}
