//! Reading specifications and designs.

use std::path::Path;

use steerguard_designer::document::{Mistakes, Source};
use steerguard_designer::{Design, DesignError, DesignFileError, Spec};

use crate::cli::failure::Failure;
use crate::cli::progress::Progress;
use crate::drive::scenario::Scenario;

/// Text of the file at `path`.
pub(super) fn text(path: &Path) -> Result<String, Failure> {
    let bytes = std::fs::read(path).map_err(|error| {
        Failure::bad(format!("cannot read `{}`: {error}", path.display())).help(
            "check the path; specifications and scenarios are TOML, designs are made by `steerguard \
             design`",
        )
    })?;
    decoded(bytes).map_err(|failure| failure.at(path.display()))
}

/// UTF-8 as text.
fn decoded(bytes: Vec<u8>) -> Result<String, Failure> {
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        return Err(Failure::bad("the file is UTF-16").help("save it as UTF-8"));
    }
    String::from_utf8(bytes).map_err(|error| {
        let valid = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let line = valid.iter().filter(|&&byte| byte == b'\n').count() + 1;
        let byte = error.as_bytes()[valid.len()];
        Failure::bad(format!("the file is not UTF-8: byte 0x{byte:02x} in line {line}"))
            .help("save it as UTF-8")
    })
}

/// The specification in the file at `path`.
pub(super) fn spec(path: &Path) -> Result<Spec, Failure> {
    let help = "examples/paper.toml explains every key and states its default";
    document(path, help, Spec::from_toml)
}

/// The scenario in the file at `path`.
pub(super) fn scenario(path: &Path) -> Result<Scenario, Failure> {
    let help = "`steerguard simulate --print-scenario` shows every key with its default";
    document(path, help, Scenario::parse)
}

/// What `read` makes of the file at `path`.
fn document<T>(
    path: &Path,
    help: &str,
    read: impl FnOnce(&str) -> Result<T, Mistakes>,
) -> Result<T, Failure> {
    let text = text(path)?;
    read(&text).map_err(|mistakes| {
        let source = Source { name: path.display().to_string(), text: text.into() };
        Failure::mistakes(&mistakes, &source).help(help)
    })
}

/// The design in the file at `path`, or made from the specification there.
pub(super) fn design(path: &Path, progress: &Progress) -> Result<Design, Failure> {
    let text = text(path)?;
    if text.trim_start().starts_with('{') {
        return Design::from_json(&text).map_err(|error| refused(&error, path));
    }
    make(&spec(path)?, progress).map_err(|failure| failure.at(path.display()))
}

/// Why a design file is refused.
pub(super) fn refused(error: &DesignFileError, path: &Path) -> Failure {
    Failure::bad(error)
        .at(path.display())
        .help("make the file again with `steerguard design`; it is not meant to be edited")
}

/// Designs a detector.
pub(super) fn make(spec: &Spec, progress: &Progress) -> Result<Design, Failure> {
    steerguard_designer::design(spec, &mut |step| progress.say(step)).map_err(|error| match error {
        DesignError::Spec(error) => Failure::bad(error),
        other => Failure::no(other),
    })
}
