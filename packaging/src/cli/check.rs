//! `steerguard check`.

use std::fs::File;
use std::path::Path;

use schemars::JsonSchema;
use serde::Serialize;
use steerguard_designer::document::{self, Diagnostic};
use steerguard_model_description::xml::{Finding, Level};

use super::print::print;
use crate::check::check;
use crate::cli::arguments::CheckArguments;
use crate::cli::diagnostic;
use crate::cli::failure::{Exit, Failure};
use crate::cli::progress::Progress;

/// An FMU and what is found in it.
#[derive(JsonSchema, Serialize)]
pub(super) struct Checked<'a> {
    /// The FMU.
    file: &'a Path,
    /// How many findings are against the standard.
    errors: usize,
    /// How many importers may stumble over.
    warnings: usize,
    /// How many could be better.
    notes: usize,
    /// Each of them.
    findings: Vec<Item<'a>>,
}

/// A finding, for machines.
#[derive(JsonSchema, Serialize)]
struct Item<'a> {
    /// `error`, `warning` or `note`.
    level: &'static str,
    /// One of those that docs/checks.md explains.
    code: &'static str,
    /// What is found.
    message: &'a str,
    /// Where.
    location: &'a str,
    /// What to do.
    help: &'a str,
}

impl<'a> From<&'a Finding> for Item<'a> {
    fn from(finding: &'a Finding) -> Self {
        let Finding { level, code, message, location, help } = finding;
        Self { level: level.name(), code, message, location, help }
    }
}

pub(super) fn run(arguments: &CheckArguments, json: bool) -> Result<Exit, Failure> {
    let path = &arguments.fmu;
    let name = path.display().to_string();
    if path.is_dir() {
        return Err(Failure::bad(format!("`{name}` is a folder")).help(
            "name an FMU file: a zip archive of what an unpacked FMU has, modelDescription.xml at its root",
        ));
    }
    let progress = Progress::saying(format_args!("examining {name}"));
    let findings = File::open(path).and_then(|file| check(file, &name)).map_err(|error| {
        Failure::bad(format!("cannot read `{name}`: {error}")).help("name an FMU file")
    })?;
    drop(progress);
    let count = |level| findings.iter().filter(|finding| finding.level == level).count();
    let checked = Checked {
        file: path,
        errors: count(Level::Error),
        warnings: count(Level::Warning),
        notes: count(Level::Note),
        findings: findings.iter().map(Item::from).collect(),
    };
    print(json, &checked, &text(&checked, &findings))?;
    Ok(if checked.errors == 0 { Exit::Done } else { Exit::No })
}

fn as_diagnostic(finding: &Finding) -> Diagnostic {
    let Finding { level, code, message, location, help } = finding;
    let level = match level {
        Level::Error => document::Level::Error,
        Level::Warning => document::Level::Warning,
        Level::Note => document::Level::Note,
    };
    Diagnostic {
        code: Some(code),
        place: Some(location.clone()),
        help: vec![help.clone()],
        ..Diagnostic::new(level, message.clone())
    }
}

fn text(checked: &Checked<'_>, findings: &[Finding]) -> String {
    let drawn = findings.iter().map(|finding| diagnostic::draw(&as_diagnostic(finding)) + "\n\n");
    let mut text = anstream::adapter::strip_str(&drawn.collect::<String>()).to_string();
    let counts =
        [(checked.errors, "error"), (checked.warnings, "warning"), (checked.notes, "note")];
    let counts: Vec<String> = counts
        .into_iter()
        .filter(|(count, _)| *count > 0)
        .map(|(count, word)| format!("{count} {word}{}", if count == 1 { "" } else { "s" }))
        .collect();
    let counts = if counts.is_empty() { "no findings".to_owned() } else { counts.join(", ") };
    text += &format!("{}: {counts}\n", checked.file.display());
    // What an FMU says must not reach the terminal as a control sequence.
    text.chars().map(|c| if c.is_control() && c != '\n' { '\u{fffd}' } else { c }).collect()
}
