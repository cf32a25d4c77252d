//! The command: its arguments, its subcommands, and what they print.

pub mod arguments;
mod campaign;
mod check;
pub mod column_arguments;
mod columns;
mod completions;
mod design;
mod detection_table;
mod diagnostic;
pub mod failure;
mod identify;
mod init;
mod input;
mod main_job;
mod package;
mod print;
pub mod progress;
mod replay;
mod report;
mod schema;
mod simulate;
mod text;
mod verify;
mod worst;

use crate::cli::arguments::{Cli, Command};
use crate::cli::failure::{Exit, Failure};

/// Runs what the command line asks for.
///
/// # Errors
/// [`Failure`], which the caller reports.
pub fn run(cli: &Cli) -> Result<Exit, Failure> {
    match &cli.command {
        None => main_job::run(&cli.out, cli.json),
        Some(Command::Init(arguments)) => init::run(arguments, cli.json),
        Some(Command::Completions(arguments)) => completions::run(arguments),
        Some(Command::Identify(arguments)) => identify::run(arguments, cli.json),
        Some(Command::Design(arguments)) => design::run(arguments, cli.json),
        Some(Command::Verify(arguments)) => verify::run(arguments, cli.json),
        Some(Command::Package(arguments)) => package::run(arguments, cli.json),
        Some(Command::Check(arguments)) => check::run(arguments, cli.json),
        Some(Command::Simulate(arguments)) => simulate::run(arguments, cli.json),
        Some(Command::Campaign(arguments)) => campaign::run(arguments, cli.json),
        Some(Command::Replay(arguments)) => replay::run(arguments, cli.json),
        Some(Command::Report(arguments)) => report::run(arguments, cli.json),
        Some(Command::Schema(arguments)) => schema::run(arguments),
    }
}
