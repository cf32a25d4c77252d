//! The `steerguard` command.

use std::process::ExitCode;

use clap::Parser;
use steerguard::cli;
use steerguard::cli::arguments::Cli;
use steerguard::output::temporary;

/// Exit status of a command that was interrupted.
const INTERRUPTED: i32 = 130;

fn main() -> ExitCode {
    let arguments = Cli::parse();
    // Without a handler an interrupted command leaves its temporary files to the next one.
    let _ = ctrlc::set_handler(|| {
        temporary::remove_all();
        std::process::exit(INTERRUPTED);
    });
    match cli::run(&arguments) {
        Ok(exit) => exit.into(),
        Err(failure) => {
            failure.report(arguments.json);
            failure.exit.into()
        }
    }
}
