//! The `steerguard` command.

use std::process::ExitCode;

use clap::Parser;
use steerguard::cli;
use steerguard::cli::arguments::Cli;

fn main() -> ExitCode {
    let arguments = Cli::parse();
    match cli::run(&arguments) {
        Ok(exit) => exit.into(),
        Err(failure) => {
            failure.report(arguments.json);
            failure.exit.into()
        }
    }
}
