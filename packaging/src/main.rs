//! The `steerguard` command.

use std::process::ExitCode;

use clap::Parser;
use steerguard::cli::Cli;
use steerguard::command;

fn main() -> ExitCode {
    match command::run(&Cli::parse()) {
        Ok(exit) => exit.into(),
        Err(failure) => {
            failure.report();
            failure.exit.into()
        }
    }
}
