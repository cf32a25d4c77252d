//! Reading specifications and designs. A file named `.json` is a design, any other a specification.

use std::path::Path;

use steerguard_designer::document::{Mistakes, Source};
use steerguard_designer::threshold::recorded::RecordedDrive;
use steerguard_designer::{
    Design, DesignError, DesignFileError, DesignStatus, Spec, design_with_drives,
};
use steerguard_drives::Columns;
use steerguard_verify::{Refusal, Verdict, verify};

use super::columns;
use super::text::read_text;
use crate::cli::arguments::Allowance;
use crate::cli::failure::Failure;
use crate::cli::progress::Progress;
use crate::drive::scenario::Scenario;
use crate::replay::recording::{self, Recording};
use crate::report::sight;

/// Most samples of recorded drives, which are held in memory: 1 GB of them.
const MOST_RECORDED_SAMPLES: usize = 20_000_000;

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

/// The folder of the file at `path`.
pub(super) fn folder_of(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new(""))
}

fn is_design(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json"))
}

/// The specification in the file at `path`, or inside the design there.
pub(super) fn spec(path: &Path) -> Result<Spec, Failure> {
    if is_design(path) {
        return Design::spec_from_json(&read_text(path)?).map_err(|error| unreadable(error, path));
    }
    let help = "`steerguard init` writes a file that explains every key and states its default";
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
    let text = read_text(path)?;
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
    Ok(verified(path, allowed, progress)?.0)
}

/// The same, and what the check of it said.
pub(super) fn verified(
    path: &Path,
    allowed: &[Allowance],
    progress: &Progress,
) -> Result<(Design, Verdict), Failure> {
    let (design, verdict) = if is_design(path) {
        progress.say("verifying the design");
        let text = read_text(path)?;
        let verdict = verify(&text).map_err(|refusal| refused(refusal, path))?;
        (Design::from_json(&text).map_err(|error| unreadable(error, path))?, verdict)
    } else {
        let design = make(&spec(path)?, folder_of(path), progress)
            .map_err(|failure| failure.placed(path.display()))?;
        let text = design.to_json().map_err(Failure::bad)?;
        let verdict = verify(&text).map_err(|refusal| refused(refusal, path))?;
        (design, verdict)
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
    Ok((design, verdict))
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

/// Designs a detector for `spec`, whose recorded drives are named relative to `folder`.
pub(super) fn make(spec: &Spec, folder: &Path, progress: &Progress) -> Result<Design, Failure> {
    let drives = recorded(spec, folder, progress)?;
    design_with_drives(spec, &drives, &mut |step| progress.say(step)).map_err(|error| match error {
        DesignError::Spec(error) => Failure::bad(error),
        infeasible @ DesignError::Infeasible(_) => match decay_in_words(spec) {
            Some(words) => Failure::no(infeasible).help(words),
            None => Failure::no(infeasible),
        },
        other => Failure::no(other),
    })
}

/// What a stated decay a sample is in time, which the sampling period decides.
fn decay_in_words(spec: &Spec) -> Option<String> {
    let decay = spec.design.decay?;
    let per_s = -decay.ln() / spec.sampling.period_s;
    Some(format!(
        "design.decay = {decay} a sample of {} s is a rate of {per_s:.1} per second; leave it out, and a \
         rate is searched from 1 to 5 per second, or state one as design.decay_per_s",
        spec.sampling.period_s
    ))
}

/// Reads the drives of `evaluation.calibration.drives`, and says on the standard error output how.
fn recorded(
    spec: &Spec,
    folder: &Path,
    progress: &Progress,
) -> Result<Vec<RecordedDrive>, Failure> {
    let calibration = &spec.evaluation.calibration;
    let columns = match &calibration.columns {
        Some(file) => columns::of_file(&folder.join(file))?,
        None => Columns::default(),
    };
    let mut left = MOST_RECORDED_SAMPLES;
    let mut drives = Vec::new();
    for name in &calibration.drives {
        progress.say(format_args!("reading {name}"));
        let path = folder.join(name);
        let read = recording::read(&path, name, &columns, spec, left)
            .map_err(|error| columns::unreadable(&error))?;
        let Some(Recording { drive, reading, warnings }) = read else {
            let hours = MOST_RECORDED_SAMPLES as f64 * spec.sampling.period_s / 3600.0;
            return Err(Failure::bad(format!(
                "evaluation.calibration.drives: more than {hours:.0} h in all with {name:?}"
            ))
            .help("leave drives out; `steerguard replay` takes any number"));
        };
        left -= drive.samples.len();
        let warnings = warnings.into_iter().map(|warning| format!("warning: {warning}"));
        let lines: Vec<_> = reading.into_iter().chain(warnings).collect();
        progress.note(&format!("{}: {}", path.display(), lines.join("\n  ")));
        drives.push(drive);
    }
    Ok(drives)
}
