//! A message to people about what they wrote: plain data, drawn elsewhere.

use std::ops::Range;
use std::sync::Arc;

use toml::de::DeTable;

use super::mistake::{Mistake, MistakeKind, Mistakes};
use super::place::{self, Place};

/// How grave it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// It has to be mended.
    Error,
    /// It should be.
    Warning,
    /// Good to know.
    Note,
}

impl Level {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Error => "error",
            Self::Warning => "warning",
            Self::Note => "note",
        }
    }
}

/// A text and what it is called.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// Name of the file.
    pub name: String,
    /// What is in it.
    pub text: Arc<str>,
}

/// A place in a [`Source`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Label {
    /// From which byte to before which.
    pub span: Range<usize>,
    /// What to say there.
    pub text: String,
}

/// A message: what is wrong, where, what would be right and what to do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// How grave it is.
    pub level: Level,
    /// Name of the rule, if it has one.
    pub code: Option<&'static str>,
    /// What is wrong.
    pub message: String,
    /// Where it is wrong, of which the first label is the very place; none where that is unknown.
    pub labels: Vec<Label>,
    /// The text that the labels are in.
    pub source: Option<Source>,
    /// File, function or the like, where there is no text to show.
    pub place: Option<String>,
    /// What is allowed, and what else helps to understand.
    pub notes: Vec<String>,
    /// What to do.
    pub help: Vec<String>,
}

impl Diagnostic {
    /// A message without a place.
    pub fn new(level: Level, message: impl Into<String>) -> Self {
        Self {
            level,
            code: None,
            message: message.into(),
            labels: Vec::new(),
            source: None,
            place: None,
            notes: Vec::new(),
            help: Vec::new(),
        }
    }
}

impl Mistakes {
    /// The mistakes as messages about `source`, in the order of their places; what has no place there
    /// comes last.
    pub fn diagnostics(&self, source: &Source) -> Vec<Diagnostic> {
        let (document, _) = DeTable::parse_recoverable(&source.text);
        let mut diagnostics: Vec<_> = self
            .list()
            .iter()
            .map(|mistake| diagnostic(mistake, document.get_ref(), source))
            .collect();
        diagnostics.sort_by_key(|diagnostic| {
            diagnostic.labels.first().map_or(usize::MAX, |label| label.span.start)
        });
        diagnostics
    }
}

fn diagnostic(mistake: &Mistake, document: &DeTable<'_>, source: &Source) -> Diagnostic {
    let mut diagnostic = Diagnostic::new(Level::Error, mistake.title());
    let locate = |path| place::locate(document, path).filter(|place| place.whole);
    let place = match mistake.kind {
        MistakeKind::MissingKey => locate(place::parent(&mistake.key)),
        _ => locate(&mistake.key),
    };
    let text = match &mistake.kind {
        MistakeKind::Syntax { .. } => String::new(),
        MistakeKind::UnknownKey { nearest: Some(nearest), .. } => {
            format!("did you mean `{nearest}`?")
        }
        MistakeKind::UnknownKey { nearest: None, known } => {
            diagnostic.notes.push(format!("known here are {}", known.join(", ")));
            String::new()
        }
        MistakeKind::MissingKey if place.is_some() => "in this table".into(),
        MistakeKind::MissingKey => String::new(),
        MistakeKind::Type { found, expected } => format!("expected {expected}, found {found}"),
        MistakeKind::Value { allowed, .. } => format!("allowed is {allowed}"),
    };
    let span = match (&mistake.kind, place) {
        (MistakeKind::Syntax { at, .. }, _) => Some(at.clone()),
        (MistakeKind::UnknownKey { .. }, Some(Place { key, .. })) => Some(key),
        (_, Some(Place { value, .. })) => Some(value),
        (_, None) => None,
    };
    match span {
        Some(span) => diagnostic.labels.push(Label { span, text }),
        None if text.is_empty() => {}
        None => diagnostic.notes.push(text),
    }
    for key in &mistake.because_of {
        match locate(key) {
            Some(place) => {
                let text = "because of this".into();
                diagnostic.labels.push(Label { span: place.value, text });
            }
            None => diagnostic.notes.push(format!("`{key}` has its default")),
        }
    }
    if let Some(default) = &mistake.default {
        diagnostic.notes.push(format!("left out, it is {default}"));
    }
    if !mistake.help.is_empty() {
        diagnostic.help.push(mistake.help.clone());
    }
    diagnostic.source = Some(source.clone());
    diagnostic
}
