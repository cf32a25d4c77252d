//! `steerguard init`.

use std::path::Path;

use schemars::JsonSchema;
use serde::Serialize;

use super::print::print;
use crate::cli::arguments::InitArguments;
use crate::cli::failure::{Exit, Failure};
use crate::output;

/// The default specification, every key explained.
pub const CAR: &str = include_str!("../../assets/car.toml");

/// A specification that was written.
#[derive(JsonSchema, Serialize)]
pub(super) struct Begun<'a> {
    /// The specification.
    file: &'a Path,
}

pub(super) fn run(arguments: &InitArguments, json: bool) -> Result<Exit, Failure> {
    let path = &arguments.output;
    if path.symlink_metadata().is_ok_and(|found| found.is_file() || found.is_dir()) {
        return Err(Failure::bad(format!("`{}` is there already", path.display()))
            .help("name another file, or remove it: what is written in it would be lost"));
    }
    output::write(path, CAR.as_bytes())?;
    let file = path.display();
    let text = format!(
        "{file}: put in what you know of the car, then\n\
         \x20 steerguard design {file} -o design.json\n\
         \x20 steerguard report design.json\n\
         \x20 steerguard package design.json\n"
    );
    print(json, &Begun { file: path }, &text)?;
    Ok(Exit::Done)
}
