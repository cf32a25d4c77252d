//! Results on standard output.

use serde::Serialize;

use crate::cli::failure::Failure;

/// Prints a result: the text for people, or the value as JSON.
pub fn print(json: bool, value: &impl Serialize, text: &str) -> Result<(), Failure> {
    use std::io::Write as _;
    let text = if json {
        serde_json::to_string_pretty(value).map_err(Failure::bad)? + "\n"
    } else {
        text.to_owned()
    };
    let written = std::io::stdout().lock().write_all(text.as_bytes());
    match written {
        // Whoever closed the pipe has read enough.
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Failure::bad(format!("cannot write the result: {error}")))
        }
        _ => Ok(()),
    }
}
