//! `steerguard package`.

use std::path::{Path, PathBuf};

use serde::Serialize;
use steerguard_designer::{Design, DesignStatus};
use steerguard_fmu::BakedDesign;
use steerguard_model_description::names;

use super::input;
use super::print::print;
use crate::cli::arguments::PackageArguments;
use crate::cli::failure::{Exit, Failure};
use crate::cli::progress::Progress;
use crate::fmu::design_summary::{Record, baked, status};
use crate::fmu::package::{PackageError, detector_fmu, plant_fmu};
use crate::fmu::runtime::Runtimes;
use crate::fmu::system::system_ssp;
use crate::output;
use crate::platform::Platform;

/// An FMU that was written.
#[derive(Serialize)]
pub(super) struct Packaged {
    pub(super) file: PathBuf,
    pub(super) bytes: usize,
}

/// A design and the FMUs made of it.
#[derive(Serialize)]
struct PackagedDesign {
    /// What the design may be called.
    status: DesignStatus,
    fmus: Vec<Packaged>,
    platforms: Vec<&'static str>,
}

pub(super) fn run(arguments: &PackageArguments, json: bool) -> Result<Exit, Failure> {
    for output in [Some(&arguments.output), arguments.plant.as_ref(), arguments.system.as_ref()] {
        output.map_or(Ok(()), |output| input::apart(&arguments.design, output))?;
    }
    let mut runtimes = Runtimes::detector();
    for (platform, file) in &arguments.runtime {
        runtimes.add(*platform, file).map_err(|error| {
            Failure::bad(format!("cannot read the library `{}`: {error}", file.display()))
        })?;
    }
    let runtimes = only(runtimes, &arguments.only, names::DETECTOR)?;
    let with_plant = arguments.plant.is_some() || arguments.system.is_some();
    let plant_runtimes = if with_plant {
        only(Runtimes::plant(), &arguments.only, names::PLANT)?
    } else {
        Runtimes::plant()
    };
    let design = {
        let progress = Progress::new();
        input::design(&arguments.design, &arguments.allow, &progress)?
    };
    let mut fmus = vec![detector(&design, &runtimes, &arguments.output)?];
    if let Some(path) = &arguments.plant {
        fmus.push(plant(&plant_runtimes, path)?);
    }
    if let Some(path) = &arguments.system {
        fmus.push(system(&design, &runtimes, &plant_runtimes, path)?);
    }
    let platforms = runtimes.0.keys().map(|platform| platform.folder()).collect();
    let status = design.synthesis.status;
    let text = caution(status) + &listed(&fmus, "") + &format!("for {}\n", runtimes.listed());
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

/// Packages the detector.
pub(super) fn detector(
    design: &Design,
    runtimes: &Runtimes,
    path: &Path,
) -> Result<Packaged, Failure> {
    write(path, detector_fmu(&payload(design)?, &Record::of(design), runtimes))
}

fn payload(design: &Design) -> Result<BakedDesign, Failure> {
    baked(design).map_err(|hash| Failure::bad(format!("the design's hash `{hash}` is no SHA-256")))
}

/// Packages the reference vehicle.
pub(super) fn plant(runtimes: &Runtimes, path: &Path) -> Result<Packaged, Failure> {
    write(path, plant_fmu(runtimes))
}

/// Packages detector and reference vehicle as a connected system.
fn system(
    design: &Design,
    detector: &Runtimes,
    plant: &Runtimes,
    path: &Path,
) -> Result<Packaged, Failure> {
    write(path, system_ssp(&payload(design)?, &Record::of(design), detector, plant))
}

fn write(path: &Path, fmu: Result<Vec<u8>, PackageError>) -> Result<Packaged, Failure> {
    let bytes = fmu.map_err(|error| match error {
        PackageError::Library { .. } | PackageError::NoLibrary => Failure::bad(error).help(
            "--runtime PLATFORM=FILE takes the library of steerguard-fmu-cdylib built for PLATFORM",
        ),
        other => Failure::bad(other),
    })?;
    output::write(path, &bytes)?;
    Ok(Packaged { file: path.to_owned(), bytes: bytes.len() })
}
