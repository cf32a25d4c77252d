//! What the command says when it cannot do what was asked.

use std::fmt;
use std::io::{self, ErrorKind};
use std::process::ExitCode;

use schemars::JsonSchema;
use serde::Serialize;
use steerguard_designer::document::{Diagnostic, Level, Mistakes, Source};

use crate::cli::diagnostic;

/// How the command ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// Done, or the answer is yes.
    Done,
    /// The answer is no: infeasible, check failed, fault missed.
    No,
    /// Bad usage or input.
    Bad,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(match exit {
            Exit::Done => 0,
            Exit::No => 1,
            Exit::Bad => 2,
        })
    }
}

/// Why the command cannot do what was asked: for people and machines.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failure {
    /// Exit status that belongs to it.
    pub exit: Exit,
    /// What is wrong, where, and what to do; at least one.
    pub diagnostics: Vec<Diagnostic>,
}

/// A failure as JSON.
#[derive(JsonSchema, Serialize)]
pub(super) struct Record<'a> {
    /// What is wrong, where, and what to do; at least one.
    diagnostics: Vec<diagnostic::Record<'a>>,
}

impl Failure {
    /// Bad usage or input.
    pub fn bad(what: impl fmt::Display) -> Self {
        let diagnostics = vec![Diagnostic::new(Level::Error, what.to_string())];
        Self { exit: Exit::Bad, diagnostics }
    }

    /// The answer is no.
    pub fn no(what: impl fmt::Display) -> Self {
        Self { exit: Exit::No, ..Self::bad(what) }
    }

    /// What is wrong in a document that somebody wrote.
    pub fn mistakes(mistakes: &Mistakes, source: &Source) -> Self {
        Self { exit: Exit::Bad, diagnostics: mistakes.diagnostics(source) }
    }

    /// The same with a place where it has none.
    pub fn placed(mut self, place: impl fmt::Display) -> Self {
        for diagnostic in &mut self.diagnostics {
            diagnostic.place.get_or_insert_with(|| place.to_string());
        }
        self
    }

    /// The same with another place.
    pub fn at(mut self, place: impl fmt::Display) -> Self {
        for diagnostic in &mut self.diagnostics {
            diagnostic.place = Some(place.to_string());
        }
        self
    }

    /// The same with advice.
    pub fn help(mut self, help: impl fmt::Display) -> Self {
        if let Some(last) = self.diagnostics.last_mut() {
            last.help.push(help.to_string());
        }
        self
    }

    /// Writes it to the standard error output: drawn, in colour on a terminal; or as JSON.
    pub fn report(&self, json: bool) {
        if json {
            let diagnostics = self.diagnostics.iter().map(Into::into).collect();
            match serde_json::to_string_pretty(&Record { diagnostics }) {
                Ok(text) => return anstream::eprintln!("{text}"),
                Err(error) => anstream::eprintln!("{error}"),
            }
        }
        let shown = self.diagnostics.iter().take(MOST_SHOWN);
        let mut drawn: Vec<String> = shown.map(diagnostic::draw).collect();
        let more = self.diagnostics.len() - drawn.len();
        if more > 0 {
            drawn
                .push(format!("and {more} more: mend those above first, or --json tells them all"));
        }
        anstream::eprintln!("{}", drawn.join("\n\n"));
    }
}

/// Most that people are told at once: a file of another format has a mistake a line.
const MOST_SHOWN: usize = 10;

/// What to do where the disk is full.
const FULL: &str =
    "the disk is full, or your share of it: free some space, or name a file on another disk";

/// What to do if that is why something cannot be written.
fn full(error: &io::Error) -> Option<&'static str> {
    matches!(error.kind(), ErrorKind::StorageFull | ErrorKind::QuotaExceeded).then_some(FULL)
}

impl From<crate::output::OutputError> for Failure {
    fn from(error: crate::output::OutputError) -> Self {
        let help = full(&error.source).unwrap_or(
            "name a file in an existing folder that you may write to (-o FILE, --out DIR)",
        );
        Self::bad(&error).help(help)
    }
}

impl From<crate::campaign::CampaignError> for Failure {
    fn from(error: crate::campaign::CampaignError) -> Self {
        use crate::campaign::CampaignError;
        let help = match &error {
            CampaignError::OtherCampaign { .. } => {
                "go on with the arguments and the build it was begun with (detector and plant are \
                 digests of the FMUs), or name another folder (-o DIR)"
            }
            CampaignError::Damaged { .. } => {
                "restore the file, or delete the folder; or name another one (-o DIR)"
            }
            CampaignError::Block { .. } => "delete the file: its drives are driven again",
            CampaignError::Drive { .. } => {
                "`steerguard campaign ... --drive INDEX` repeats this drive alone"
            }
            CampaignError::Output(error) if full(&error.source).is_some() => FULL,
            CampaignError::Read { source, .. } if source.kind() == ErrorKind::FileTooLarge => {
                "it is no file of a campaign: delete it, or name another folder (-o DIR)"
            }
            CampaignError::Output(_) | CampaignError::Read { .. } => {
                "name a folder that you may write to (-o DIR)"
            }
            CampaignError::Json(_) | CampaignError::Table(_) | CampaignError::Workers(_) => {
                return Self::bad(error);
            }
        };
        Self::bad(&error).help(help)
    }
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::*;
    use crate::output::OutputError;

    #[test]
    fn a_full_disk_is_told_apart_from_a_folder_that_nobody_may_write_to() {
        let help = |kind: ErrorKind| {
            let error = OutputError { path: PathBuf::from("a"), source: kind.into() };
            Failure::from(error).diagnostics[0].help[0].clone()
        };
        assert_eq!(help(ErrorKind::StorageFull), FULL);
        assert!(help(ErrorKind::PermissionDenied).contains("you may write to"));
    }
}
