//! `steerguard design`.

use schemars::JsonSchema;
use serde::Serialize;
use std::path::Path;
use steerguard_designer::{Design, DesignStatus};

use super::input;
use super::print::print;
use crate::cli::arguments::DesignArguments;
use crate::cli::failure::{Exit, Failure};
use crate::cli::progress::Progress;
use crate::output;
use crate::report::design_summary::DesignSummary;

/// A design and its file.
#[derive(JsonSchema, Serialize)]
pub(super) struct Designed<'a> {
    /// Its figures.
    design: DesignSummary,
    /// The design file.
    file: &'a Path,
}

pub(super) fn run(arguments: &DesignArguments, json: bool) -> Result<Exit, Failure> {
    input::apart(&arguments.spec, &arguments.output)?;
    let spec = input::spec(&arguments.spec)?;
    let design = {
        let progress = Progress::new();
        let folder = input::folder_of(&arguments.spec);
        let at = |failure: Failure| failure.placed(arguments.spec.display());
        input::make(&spec, folder, &progress).map_err(at)?
    };
    write(&design, &arguments.output)?;
    let designed = Designed { design: DesignSummary::of(&design), file: &arguments.output };
    let file = arguments.output.display();
    let exit = exit(&design);
    let missed = design.synthesis.unproven.as_ref();
    let missed = missed.map_or(String::new(), |missed| format!("Not certified: {missed}\n"));
    print(json, &designed, &format!("Design\n{}\n  {file}\n{missed}", designed.design.text(None)))?;
    Ok(exit)
}

/// Writes the design file.
pub(super) fn write(design: &Design, path: &Path) -> Result<(), Failure> {
    let text = design.to_json().map_err(Failure::bad)?;
    Ok(output::write(path, text.as_bytes())?)
}

/// Only a certified design that sees is a yes.
pub(super) fn exit(design: &Design) -> Exit {
    match design.synthesis.status {
        DesignStatus::Certified => Exit::Done,
        DesignStatus::Uncertified | DesignStatus::AlmostSolved | DesignStatus::Blind => Exit::No,
    }
}
