//! `steerguard-verify FILE`: proves a design file or says what is broken.

use std::io::Write as _;
use std::process::ExitCode;

use steerguard_verify::verify;

const USAGE: &str = "usage: steerguard-verify FILE

Proves every inequality behind the certified figures of a design file (design.json), for the gains
as stored, in exact arithmetic, and recomputes what follows from the rest of the file. Exit status:
0 proven; 1 not proven or blind, be it that the design says so itself, or changed; 2 unreadable.";

fn main() -> ExitCode {
    let mut arguments = std::env::args_os().skip(1);
    let (Some(file), None) = (arguments.next(), arguments.next()) else {
        eprintln!("{USAGE}");
        return ExitCode::from(2);
    };
    if file == "--help" || file == "-h" {
        println!("{USAGE}");
        return ExitCode::SUCCESS;
    }
    let shown = file.to_string_lossy();
    let text = match std::fs::read_to_string(&file) {
        Ok(text) => text,
        Err(error) => {
            eprintln!("error: {shown}: {error}");
            return ExitCode::from(2);
        }
    };
    match verify(&text) {
        Ok(verdict) => {
            // Whoever closed the pipe has read enough.
            let _ = write!(std::io::stdout(), "{verdict}");
            let good = verdict.is_certified() && !verdict.is_blind();
            if good { ExitCode::SUCCESS } else { ExitCode::FAILURE }
        }
        Err(refusal) if refusal.is_unreadable() => {
            eprintln!("error: {shown}: {refusal}");
            ExitCode::from(2)
        }
        Err(refusal) => {
            eprintln!("not certified: {shown}: {refusal}");
            ExitCode::FAILURE
        }
    }
}
