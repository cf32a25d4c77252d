//! Reading specifications and designs. A file named `.json` is a design, any other a specification.

use std::path::Path;

use steerguard_designer::document::{Mistakes, Source};
use steerguard_designer::{Design, DesignError, DesignFileError, DesignStatus, Spec};
use steerguard_verify::Refusal;

use crate::cli::arguments::Allowance;
use crate::cli::failure::Failure;
use crate::cli::progress::Progress;
use crate::drive::scenario::Scenario;
use crate::fmu::sight;

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

/// Refuses to write over what is read.
pub(super) fn apart(input: &Path, output: &Path) -> Result<(), Failure> {
    match (input.canonicalize(), output.canonicalize()) {
        (Ok(read), Ok(written)) if read == written => {
            Err(Failure::bad(format!("`{}` would be written over itself", input.display()))
                .help("name another file (-o FILE)"))
        }
        _ => Ok(()),
    }
}

fn is_design(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json"))
}

/// The specification in the file at `path`, or inside the design there.
pub(super) fn spec(path: &Path) -> Result<Spec, Failure> {
    if is_design(path) {
        return Design::spec_from_json(&text(path)?).map_err(|error| unreadable(error, path));
    }
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

/// The design in the file at `path`, verified, or made from the specification there. It is certified
/// and sees, or is `allowed` not to.
pub(super) fn design(
    path: &Path,
    allowed: &[Allowance],
    progress: &Progress,
) -> Result<Design, Failure> {
    let design = if is_design(path) {
        progress.say("verifying the design");
        let text = text(path)?;
        steerguard_verify::verify(&text).map_err(|refusal| refused(refusal, path))?;
        Design::from_json(&text).map_err(|error| unreadable(error, path))?
    } else {
        make(&spec(path)?, progress).map_err(|failure| failure.at(path.display()))?
    };
    if let Some(missed) = &design.synthesis.unproven
        && !allowed.contains(&Allowance::Uncertified)
    {
        return Err(Failure::no(format!("the design is not certified: {missed}"))
            .at(path.display())
            .help("--allow uncertified uses it all the same; what is made of it says so"));
    }
    if design.synthesis.status == DesignStatus::Blind && !allowed.contains(&Allowance::Blind) {
        let why = design.performance.sight.as_ref().and_then(sight::blindness).unwrap_or_default();
        return Err(Failure::no(format!("the design is blind: {why}"))
            .at(path.display())
            .help("--allow blind uses it all the same; what is made of it says so"));
    }
    Ok(design)
}

/// Why a design file cannot be read.
fn unreadable(error: DesignFileError, path: &Path) -> Failure {
    match error {
        DesignFileError::Refused(refusal) => refused(refusal, path),
        other => Failure::bad(other).at(path.display()).help(
            "`steerguard design` makes design files from a specification; write that one anew",
        ),
    }
}

/// Why a design file is refused, and what to do.
pub(super) fn refused(refusal: Refusal, path: &Path) -> Failure {
    let help = match &refusal {
        Refusal::Format { .. } => format!(
            "`steerguard design {} -o NEW.json` designs anew from the specification inside",
            path.display()
        ),
        Refusal::Empty | Refusal::Truncated(_) => {
            "make it again with `steerguard design SPEC -o FILE`".into()
        }
        Refusal::Unreadable(_) | Refusal::NoFormat => {
            "a file named .json is read as a design, which `steerguard design` makes; \
             specifications are TOML, with any other name"
                .into()
        }
        _ => "do not edit designs: change the specification, and make the design again with \
              `steerguard design`"
            .into(),
    };
    let failure = match refusal.is_unreadable() {
        true => Failure::bad(refusal),
        false => Failure::no(refusal),
    };
    failure.at(path.display()).help(help)
}

/// Designs a detector.
pub(super) fn make(spec: &Spec, progress: &Progress) -> Result<Design, Failure> {
    steerguard_designer::design(spec, &mut |step| progress.say(step)).map_err(|error| match error {
        DesignError::Spec(error) => Failure::bad(error),
        other => Failure::no(other),
    })
}
