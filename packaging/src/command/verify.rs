//! `steerguard verify`.

use std::path::Path;

use serde::Serialize;
use steerguard_designer::certificate::Check;
use steerguard_designer::{Design, DesignFileError};

use super::{input, print};
use crate::cli::VerifyArguments;
use crate::failure::{Exit, Failure};
use crate::recheck::recheck;

/// Result of the re-check.
#[derive(Serialize)]
pub(super) struct Outcome {
    /// Whether every condition holds.
    pub(super) holds: bool,
    hash: String,
    margins: Check,
    statement: String,
}

impl Outcome {
    /// The result on one line.
    pub(super) fn line(&self) -> String {
        let Check { disturbance_attenuation, fault_sensitivity, stability, .. } = &self.margins;
        format!(
            "  {}  smallest eigenvalues (31) {:.2e}, (32) {:.2e}, (33) {:.2e}\n",
            if self.holds { "re-check holds  " } else { "re-check FAILS  " },
            disturbance_attenuation.smallest_eigenvalue,
            fault_sensitivity.smallest_eigenvalue,
            stability.smallest_eigenvalue,
        )
    }
}

pub(super) fn run(arguments: &VerifyArguments, json: bool) -> Result<Exit, Failure> {
    let outcome = check(&arguments.design)?;
    let text = format!("{}\n{}\n", outcome.line(), wrapped(&outcome.statement));
    print(json, &outcome, &text)?;
    Ok(if outcome.holds { Exit::Done } else { Exit::No })
}

/// Re-checks the design in the file at `path`.
pub(super) fn check(path: &Path) -> Result<Outcome, Failure> {
    let design = Design::from_json(&input::text(path)?).map_err(|error| match error {
        // A sound file that is not what it says: the answer is no.
        DesignFileError::Hash { .. } | DesignFileError::Inconsistent(_) => {
            Failure { exit: Exit::No, ..input::refused(&error, path) }
        }
        _ => input::refused(&error, path),
    })?;
    let margins = recheck(&design);
    Ok(Outcome {
        holds: margins.holds(),
        hash: design.hash,
        margins,
        statement: design.certificate.statement,
    })
}

/// Lines of at most 96 columns, indented.
fn wrapped(text: &str) -> String {
    let mut lines = vec![String::from(" ")];
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + word.chars().count() < 96 => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(format!("  {word}")),
        }
    }
    lines.join("\n")
}
