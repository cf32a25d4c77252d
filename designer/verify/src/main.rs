//! `steerguard-verify FILE`: proves a design file or says what is broken.

use std::ffi::OsStr;
use std::fs::File;
use std::io::{self, Read as _, Write as _};
use std::process::ExitCode;

use steerguard_verify::verify;

const USAGE: &str = "usage: steerguard-verify FILE

Proves every inequality behind the certified figures of a design file (design.json), for the gains
as stored, in exact arithmetic, and recomputes what follows from the rest of the file. Exit status:
0 proven; 1 not proven or blind, be it that the design says so itself, or changed; 2 unreadable.";

/// Largest file that is read, bytes; a design file has a hundred thousand.
const MAX_BYTES: u64 = 64 << 20;

/// The text of `file`.
fn read(file: &OsStr) -> io::Result<String> {
    let file = File::open(file)?;
    if file.metadata()?.is_dir() {
        return Err(io::Error::other("it is a folder; name a design file in it"));
    }
    let mut bytes = Vec::new();
    file.take(MAX_BYTES + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > MAX_BYTES {
        let message = format!(
            "it has more than {MAX_BYTES} bytes, the most that is read; a design file, which \
             `steerguard design` writes, has a hundred thousand"
        );
        return Err(io::Error::other(message));
    }
    String::from_utf8(bytes).map_err(|error| {
        let message = format!("it is no design file, which is UTF-8: {}", error.utf8_error());
        io::Error::other(message)
    })
}

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
    let text = match read(&file) {
        Ok(text) => text,
        Err(error) => {
            eprintln!("error: cannot read {shown}: {error}");
            return ExitCode::from(2);
        }
    };
    match verify(&text) {
        Ok(verdict) => {
            // Whoever closed the pipe has read enough.
            let _ = write!(io::stdout(), "{verdict}");
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
