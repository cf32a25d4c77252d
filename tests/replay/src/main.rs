//! Says how the detector differs from its frozen traces, and renews them.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use steerguard_replay::{Table, Trace, TraceError};

/// Replays recorded drives and compares the detector's outputs with those stored, bit for bit.
///
/// Answers 0 if nothing differs or `--renew` is given, 1 if something does, 2 if it cannot compare.
#[derive(Parser)]
struct Arguments {
    /// Store the outputs as they are now. Commit that change alone, and say why it is meant
    #[arg(long)]
    renew: bool,
    /// Folder of the traces
    #[arg(long, default_value = concat!(env!("CARGO_MANIFEST_DIR"), "/recorded"))]
    recorded: PathBuf,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    match replay(&arguments) {
        Ok(same) if same || arguments.renew => ExitCode::SUCCESS,
        Ok(_) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

/// Whether all is as stored.
fn replay(Arguments { renew, recorded }: &Arguments) -> Result<bool, TraceError> {
    let mut same = true;
    for trace in Trace::all(recorded)? {
        let now = Table::of(&trace.run()?);
        let differences = trace.differences(&now)?;
        same &= differences.found.is_empty();
        println!("{differences}");
        if *renew {
            trace.store(&now)?;
        }
    }
    Ok(same)
}
