//! What the command says when it cannot do what was asked.

use std::fmt;
use std::process::ExitCode;

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

/// An error for people: what is wrong, where, and what to do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failure {
    /// Exit status that belongs to it.
    pub exit: Exit,
    /// What is wrong.
    pub what: String,
    /// File, key or function.
    pub place: Option<String>,
    /// What to do.
    pub help: Option<String>,
}

impl Failure {
    /// Bad usage or input.
    pub fn bad(what: impl fmt::Display) -> Self {
        Self { exit: Exit::Bad, what: what.to_string(), place: None, help: None }
    }

    /// The answer is no.
    pub fn no(what: impl fmt::Display) -> Self {
        Self { exit: Exit::No, ..Self::bad(what) }
    }

    /// The same with a place.
    pub fn at(self, place: impl fmt::Display) -> Self {
        Self { place: Some(place.to_string()), ..self }
    }

    /// The same with advice.
    pub fn help(self, help: impl fmt::Display) -> Self {
        Self { help: Some(help.to_string()), ..self }
    }

    /// Writes it to the standard error output, in colour on a terminal.
    pub fn report(&self) {
        let error = anstyle::AnsiColor::Red.on_default().bold();
        let help = anstyle::AnsiColor::Cyan.on_default().bold();
        anstream::eprintln!("{error}error{error:#}: {}", self.what);
        if let Some(place) = &self.place {
            anstream::eprintln!("  in {place}");
        }
        if let Some(text) = &self.help {
            anstream::eprintln!("{help}help{help:#}: {text}");
        }
    }
}

impl From<crate::output::OutputError> for Failure {
    fn from(error: crate::output::OutputError) -> Self {
        Self::bad(&error)
            .help("name a file in an existing folder that you may write to (-o FILE, --out DIR)")
    }
}

impl From<crate::drive::scenario::ScenarioError> for Failure {
    fn from(error: crate::drive::scenario::ScenarioError) -> Self {
        use crate::drive::scenario::ScenarioError;
        let help = match &error {
            ScenarioError::Read { .. } => {
                "check the path; without --scenario the paper's is driven"
            }
            _ => "`steerguard simulate --print-scenario` shows every key with its default",
        };
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
            CampaignError::Block { .. } => "delete the file: its drives are driven again",
            CampaignError::Drive { .. } => {
                "`steerguard campaign ... --drive INDEX` repeats this drive alone"
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
