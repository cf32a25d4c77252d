//! Results on standard output, or on the standard error output where a file was written to the former.
//!
//! # Conventions
//! Text for people fits a terminal of 80 columns; `COLUMNS` names another number. In a pipe or a file its lines stay
//! whole, unless `COLUMNS` is set.

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
    let told = std::env::var("COLUMNS").ok().and_then(|columns| columns.parse().ok());
    match told {
        Some(columns) => Some(NARROWEST.max(columns)),
        None if output::is_taken() => std::io::stderr().is_terminal().then_some(WIDTH),
        None => std::io::stdout().is_terminal().then_some(WIDTH),
    }
}
