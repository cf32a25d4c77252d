//! `steerguard completions`.

use clap::CommandFactory as _;

use super::print::write;
use crate::cli::arguments::{Cli, CompletionsArguments};
use crate::cli::failure::{Exit, Failure};

pub(super) fn run(arguments: &CompletionsArguments) -> Result<Exit, Failure> {
    let mut text = Vec::new();
    clap_complete::generate(arguments.shell, &mut Cli::command(), "steerguard", &mut text);
    write(&String::from_utf8_lossy(&text))?;
    Ok(Exit::Done)
}
