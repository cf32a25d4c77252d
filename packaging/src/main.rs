//! The `steerguard` command.

use std::process::ExitCode;

use clap::Parser;
use steerguard::cli;
use steerguard::cli::arguments::Cli;

fn main() -> ExitCode {
    match cli::run(&Cli::parse()) {
        Ok(exit) => exit.into(),
        Err(failure) => {
            failure.report();
            failure.exit.into()
        }
    }
}
