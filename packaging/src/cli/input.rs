//! Reading specifications and designs.

use std::path::Path;

use steerguard_designer::{Design, DesignError, DesignFileError, Spec};

use crate::cli::failure::Failure;
use crate::cli::progress::Progress;

/// Text of the file at `path`.
pub(super) fn text(path: &Path) -> Result<String, Failure> {
    std::fs::read_to_string(path).map_err(|error| {
        Failure::bad(format!("cannot read `{}`: {error}", path.display())).help(
            "check the path; specifications are TOML, designs are made by `steerguard design`",
        )
    })
}

/// The specification in the file at `path`.
pub(super) fn spec(path: &Path) -> Result<Spec, Failure> {
    Spec::from_toml(&text(path)?).map_err(|error| {
        Failure::bad(error)
            .at(path.display())
            .help("examples/paper.toml explains every key; a key left out has its default")
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
