//! `steerguard package`.

use std::path::{Path, PathBuf};

use serde::Serialize;
use steerguard_designer::{Design, DesignStatus};
use steerguard_fmu::BakedDesign;

use super::input;
use super::print::print;
use crate::cli::arguments::PackageArguments;
use crate::cli::failure::{Exit, Failure};
use crate::cli::progress::Progress;
use crate::fmu::design_summary::{baked, causes, status};
use crate::fmu::package::{PackageError, detector_fmu, plant_fmu};
use crate::fmu::runtime::Runtimes;
use crate::fmu::system::system_ssp;
use crate::output;

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
    let design = {
        let progress = Progress::new();
        input::design(&arguments.design, &arguments.allow, &progress)?
    };
    let mut fmus = vec![detector(&design, &runtimes, &arguments.output)?];
    if let Some(path) = &arguments.plant {
        fmus.push(plant(path)?);
    }
    if let Some(path) = &arguments.system {
        fmus.push(system(&design, &runtimes, path)?);
    }
    let platforms = runtimes.0.keys().map(|platform| platform.folder()).collect();
    let status = design.synthesis.status;
    let text = caution(status) + &listed(&fmus, "");
    print(json, &PackagedDesign { status, fmus, platforms }, &text)?;
    Ok(Exit::Done)
}

/// A line that says so where a design is not certified.
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
    write(path, detector_fmu(&payload(design)?, &causes(&design.threshold), runtimes))
}

fn payload(design: &Design) -> Result<BakedDesign, Failure> {
    baked(design).map_err(|hash| Failure::bad(format!("the design's hash `{hash}` is no SHA-256")))
}

/// Packages the reference vehicle.
pub(super) fn plant(path: &Path) -> Result<Packaged, Failure> {
    write(path, plant_fmu(&Runtimes::plant()))
}

/// Packages detector and reference vehicle as a connected system.
fn system(design: &Design, runtimes: &Runtimes, path: &Path) -> Result<Packaged, Failure> {
    write(
        path,
        system_ssp(&payload(design)?, &causes(&design.threshold), runtimes, &Runtimes::plant()),
    )
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
