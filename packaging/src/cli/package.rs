//! `steerguard package`.

use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::Serialize;
use steerguard_designer::{Design, DesignStatus};
use steerguard_fmu::BakedDesign;
use steerguard_model_description::names;

use super::input;
use super::print::print;
use crate::bounded::{self, MAX_LIBRARY_BYTES};
use crate::cli::arguments::{FmiVersion, PackageArguments};
use crate::cli::failure::{Exit, Failure};
use crate::cli::progress::Progress;
use crate::fmu::package::{PackageError, detector_fmi3, detector_fmu, plant_fmu};
use crate::fmu::runtime::{Runtimes, is_for_fmi3};
use crate::fmu::system::system_ssp;
use crate::output;
use crate::platform::Platform;
use crate::report::design_summary::{Record, baked, status};

/// An FMU that was written.
#[derive(JsonSchema, Serialize)]
pub(super) struct Packaged {
    /// The FMU, or the system.
    pub(super) file: PathBuf,
    /// Its size.
    pub(super) bytes: usize,
}

/// A design and the FMUs made of it.
#[derive(JsonSchema, Serialize)]
pub(super) struct PackagedDesign {
    /// What the design may be called.
    status: DesignStatus,
    /// What was written.
    fmus: Vec<Packaged>,
    /// Platforms that the detector has a library for, as FMI 2.0 names them.
    platforms: Vec<&'static str>,
}

pub(super) fn run(arguments: &PackageArguments, json: bool) -> Result<Exit, Failure> {
    let PackageArguments { output, fmi, plant: plant_path, system: system_path, .. } = arguments;
    let fmi2_path = (*fmi != FmiVersion::Three).then_some(output);
    let beside = beside(output);
    let fmi3_path = match fmi {
        FmiVersion::Two => None,
        FmiVersion::Three => Some(output),
        FmiVersion::Both => Some(&beside),
    };
    let outputs = [fmi2_path, fmi3_path, plant_path.as_ref(), system_path.as_ref()];
    let outputs: Vec<&PathBuf> = outputs.into_iter().flatten().collect();
    for (i, output) in outputs.iter().enumerate() {
        input::apart(&arguments.design, output)?;
        if outputs.iter().take(i).any(|other| other == output) {
            return Err(Failure::bad(format!("`{}` would be written twice", output.display()))
                .help("name another file for one of them"));
        }
    }
    let needs =
        Needs { fmi2: fmi2_path.is_some() || system_path.is_some(), fmi3: fmi3_path.is_some() };
    let [runtimes, fmi3_runtimes] = runtimes(&arguments.runtime, needs)?;
    let runtimes = match needs.fmi2 {
        true => only(runtimes, &arguments.only, names::DETECTOR)?,
        false => runtimes,
    };
    let fmi3_runtimes = match needs.fmi3 {
        true => only(fmi3_runtimes, &arguments.only, names::DETECTOR_FMI3)?,
        false => fmi3_runtimes,
    };
    let plant_runtimes = match plant_path.is_some() || system_path.is_some() {
        true => only(Runtimes::plant(), &arguments.only, names::PLANT)?,
        false => Runtimes::plant(),
    };
    let progress = Progress::new();
    let (design, verdict) = input::verified(&arguments.design, &arguments.allow, &progress)?;
    progress.say("packaging");
    let record = Record::of(&design, &verdict);
    let mut fmus = Vec::new();
    if let Some(path) = fmi2_path {
        fmus.push(detector(&design, &record, &runtimes, path)?);
    }
    if let Some(path) = fmi3_path {
        let fmu = detector_fmi3(&payload(&design)?, &record, &fmi3_runtimes);
        fmus.push(write(path, fmu)?);
    }
    if let Some(path) = plant_path {
        fmus.push(plant(&plant_runtimes, path)?);
    }
    if let Some(path) = system_path {
        fmus.push(system(&design, &record, [&runtimes, &plant_runtimes], path)?);
    }
    drop(progress);
    let used = if needs.fmi2 { &runtimes } else { &fmi3_runtimes };
    let platforms = used.0.keys().map(|platform| platform.folder()).collect();
    let status = design.synthesis.status;
    let text = caution(status) + &listed(&fmus, "") + &format!("for {}\n", used.listed());
    print(json, &PackagedDesign { status, fmus, platforms }, &text)?;
    Ok(Exit::Done)
}

/// The libraries of `model` for `platforms` alone, if any are named.
fn only(runtimes: Runtimes, platforms: &[Platform], model: &str) -> Result<Runtimes, Failure> {
    let known = runtimes.listed();
    runtimes.only(platforms).map_err(|missing| {
        let missing = missing.folder();
        Failure::bad(format!("no library of {model} for {missing}: this command has {known}")).help(
            "--runtime PLATFORM=FILE adds the detector's; a command built with STEERGUARD_RUNTIMES \
             has both models' for more platforms",
        )
    })
}

/// The file of FMI 3.0 beside that of FMI 2.0.
fn beside(path: &Path) -> PathBuf {
    let is_fmu = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("fmu"));
    let stem = if is_fmu { path.file_stem() } else { path.file_name() };
    let mut name = stem.unwrap_or_default().to_owned();
    name.push(".fmi3.fmu");
    path.with_file_name(name)
}

/// Which versions of FMI something is packaged in.
#[derive(Clone, Copy)]
struct Needs {
    fmi2: bool,
    fmi3: bool,
}

/// The detector's libraries of FMI 2.0 and 3.0: those of this machine, and those that were given.
fn runtimes(given: &[(Platform, PathBuf)], needs: Needs) -> Result<[Runtimes; 2], Failure> {
    let (mut fmi2, mut fmi3) = (Runtimes::detector(), Runtimes::detector_fmi3());
    for (platform, file) in given {
        let library = bounded::read(file, MAX_LIBRARY_BYTES).map_err(|error| {
            let help = "--runtime PLATFORM=FILE names a library that packaging/runtimes/build made";
            Failure::bad(format!("cannot read the library `{}`: {error}", file.display()))
                .help(help)
        })?;
        let (of, needed, other) = match is_for_fmi3(&library) {
            true => (&mut fmi3, needs.fmi3, "2.0"),
            false => (&mut fmi2, needs.fmi2, "3.0"),
        };
        if !needed {
            let message = format!("`{}` is not a library for FMI {other}", file.display());
            let help = "--fmi says which version is packaged: 2, 3 or both";
            return Err(Failure::bad(message).help(help));
        }
        of.0.insert(*platform, library);
    }
    Ok([fmi2, fmi3])
}

/// A line that says so where a design is not certified, or blind.
pub(super) fn caution(of: DesignStatus) -> String {
    match of {
        DesignStatus::Certified => String::new(),
        other => format!("The design is {}.\n", status(other)),
    }
}

/// Lines with files and sizes.
pub(super) fn listed(fmus: &[Packaged], indent: &str) -> String {
    let line = |fmu: &Packaged| format!("{indent}{}  {} bytes\n", fmu.file.display(), fmu.bytes);
    fmus.iter().map(line).collect()
}

/// Packages the detector, with what is on `record` in its documentation.
pub(super) fn detector(
    design: &Design,
    record: &Record,
    runtimes: &Runtimes,
    path: &Path,
) -> Result<Packaged, Failure> {
    write(path, detector_fmu(&payload(design)?, record, runtimes))
}

/// Packages the detector to be driven here and thrown away: nobody reads its documentation.
pub(super) fn detector_to_drive(design: &Design, path: &Path) -> Result<Packaged, Failure> {
    detector(design, &Record::default(), &Runtimes::detector(), path)
}

pub(super) fn payload(design: &Design) -> Result<BakedDesign, Failure> {
    baked(design).map_err(|hash| Failure::bad(format!("the design's hash `{hash}` is no SHA-256")))
}

/// Packages the reference vehicle.
pub(super) fn plant(runtimes: &Runtimes, path: &Path) -> Result<Packaged, Failure> {
    write(path, plant_fmu(runtimes))
}

/// Packages detector and reference vehicle as a connected system.
fn system(
    design: &Design,
    record: &Record,
    [detector, plant]: [&Runtimes; 2],
    path: &Path,
) -> Result<Packaged, Failure> {
    write(path, system_ssp(&payload(design)?, record, detector, plant))
}

fn write(path: &Path, fmu: Result<Vec<u8>, PackageError>) -> Result<Packaged, Failure> {
    let bytes = fmu.map_err(|error| match error {
        PackageError::Library { .. } | PackageError::NoLibrary => Failure::bad(error).help(
            "--runtime PLATFORM=FILE takes the library of steerguard-fmu-cdylib, or for FMI 3.0 of \
             steerguard-fmi3-cdylib, built for PLATFORM",
        ),
        other => Failure::bad(other),
    })?;
    output::write(path, &bytes)?;
    Ok(Packaged { file: path.to_owned(), bytes: bytes.len() })
}
