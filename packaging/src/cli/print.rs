//! Results on standard output, or on the standard error output where a file was written to the former.

use serde::Serialize;

use crate::cli::failure::Failure;
use crate::output;

/// Prints a result: the text for people, or the value as JSON.
pub fn print(json: bool, value: &impl Serialize, text: &str) -> Result<(), Failure> {
    if json {
        write(&(serde_json::to_string_pretty(value).map_err(Failure::bad)? + "\n"))
    } else {
        write(text)
    }
}

/// Prints a result that is text.
pub fn write(text: &str) -> Result<(), Failure> {
    use std::io::Write as _;
    let written = match output::is_taken() {
        true => std::io::stderr().lock().write_all(text.as_bytes()),
        false => std::io::stdout().lock().write_all(text.as_bytes()),
    };
    written.map_err(|error| Failure::bad(format!("cannot write the result: {error}")))
}
