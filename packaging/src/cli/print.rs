//! Results on standard output, or on the standard error output where a file was written to the former.
//!
//! # Conventions
//! On a terminal, text for people has lines of at most 80 columns, or as many as `COLUMNS` says. In a pipe or a file its
//! lines stay whole, whatever `COLUMNS` says: scripts look for words in them.

use serde::Serialize;

use crate::cli::failure::Failure;
use crate::output;
use crate::output::lines::{WIDTH, fitted};

/// Narrower than this nothing can be read.
const NARROWEST: usize = 40;

/// Prints a result: the text for people, or the value as JSON.
pub fn print(json: bool, value: &impl Serialize, text: &str) -> Result<(), Failure> {
    match json {
        true => as_json(value),
        false => match width() {
            Some(width) => write(&fitted(text, width)),
            None => write(text),
        },
    }
}

/// Prints what belongs into a file, TOML or CSV, whose lines stay whole; or the value as JSON.
pub fn print_file(json: bool, value: &impl Serialize, text: &str) -> Result<(), Failure> {
    if json { as_json(value) } else { write(text) }
}

fn as_json(value: &impl Serialize) -> Result<(), Failure> {
    write(&(serde_json::to_string_pretty(value).map_err(Failure::bad)? + "\n"))
}

/// Prints a result that is text, whose lines stay whole.
pub fn write(text: &str) -> Result<(), Failure> {
    use std::io::Write as _;
    let written = match output::is_taken() {
        true => std::io::stderr().lock().write_all(text.as_bytes()),
        false => std::io::stdout().lock().write_all(text.as_bytes()),
    };
    written.map_err(|error| Failure::bad(format!("cannot write the result: {error}")))
}

/// Most characters of a line, where there is a bound.
fn width() -> Option<usize> {
    use std::io::IsTerminal as _;
    let on_terminal = match output::is_taken() {
        true => std::io::stderr().is_terminal(),
        false => std::io::stdout().is_terminal(),
    };
    let told = std::env::var("COLUMNS").ok().and_then(|columns| columns.parse().ok());
    on_terminal.then(|| told.map_or(WIDTH, |columns: usize| columns.max(NARROWEST)))
}
