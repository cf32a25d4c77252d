//! Command line.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

use crate::platform::Platform;

const EXAMPLES: &str = "\
Without a command: designs the detector for the paper's vehicle, re-checks it, packages it, drives
the FMU against a reference vehicle with a 0.5 degree steering fault, and prints what was detected.

Examples:
  steerguard                                     the main job, into steerguard-out/
  steerguard design my-car.toml -o design.json   gains for your vehicle
  steerguard verify design.json                  independent proof in exact arithmetic
  steerguard package design.json                 SteeringFaultDetector.fmu
  steerguard check SteeringFaultDetector.fmu     what importers may trip over
  steerguard simulate --detector SteeringFaultDetector.fmu --scenario drive.toml

Exit status: 0 done; 1 the answer is no (infeasible, check failed, fault missed); 2 bad usage or input.";

/// Designs, packages and co-simulates a steering-fault detector as an FMI 2.0 unit
#[derive(Debug, Parser)]
#[command(version, after_help = EXAMPLES, max_term_width = 100)]
pub struct Cli {
    /// What to do
    #[command(subcommand)]
    pub command: Option<Command>,

    /// Folder for the results of the main job
    #[arg(long, value_name = "DIR", default_value = "steerguard-out")]
    pub out: PathBuf,

    /// Print the result as JSON
    #[arg(long, global = true)]
    pub json: bool,
}

/// A subcommand.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Compute the gains and the threshold for a vehicle and specification
    Design(DesignArguments),
    /// Prove a design file in exact arithmetic, without the solver
    Verify(VerifyArguments),
    /// Package a design as SteeringFaultDetector.fmu
    Package(PackageArguments),
    /// Examine an FMU: archive, description, binaries
    Check(CheckArguments),
    /// Co-simulate a detector FMU with a plant FMU
    Simulate(SimulateArguments),
}

/// Arguments of `design`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  steerguard design my-car.toml -o design.json")]
pub struct DesignArguments {
    /// Specification (TOML); every key left out has the value of the paper's vehicle
    pub spec: PathBuf,
    /// Design file to write
    #[arg(short, long, value_name = "FILE", default_value = "design.json")]
    pub output: PathBuf,
}

/// Arguments of `verify`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  steerguard verify design.json")]
pub struct VerifyArguments {
    /// Design file
    pub design: PathBuf,
}

/// Arguments of `package`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  steerguard package design.json -o SteeringFaultDetector.fmu
  steerguard package my-car.toml --plant VehiclePlant.fmu
  steerguard package design.json --system SteeringFaultSystem.ssp
  steerguard package design.json --runtime win64=SteeringFaultDetector.dll")]
pub struct PackageArguments {
    /// Design file (.json), or a specification (.toml) to be designed first
    pub design: PathBuf,
    /// FMU to write
    #[arg(short, long, value_name = "FILE", default_value = "SteeringFaultDetector.fmu")]
    pub output: PathBuf,
    /// Write the reference vehicle's FMU as well
    #[arg(long, value_name = "FILE")]
    pub plant: Option<PathBuf>,
    /// Write detector and reference vehicle as a connected system (SSP 1.0) as well
    #[arg(long, value_name = "FILE")]
    pub system: Option<PathBuf>,
    /// Add the detector's unbaked library for a further platform: linux64, win64, darwin64,
    /// aarch64-linux
    #[arg(long, value_name = "PLATFORM=FILE", value_parser = runtime)]
    pub runtime: Vec<(Platform, PathBuf)>,
}

/// Arguments of `check`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  steerguard check SteeringFaultDetector.fmu
  steerguard check --json other.fmu")]
pub struct CheckArguments {
    /// Any FMI 2.0 FMU; nothing of it is written to disk or run
    pub fmu: PathBuf,
}

/// Arguments of `simulate`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  steerguard simulate
  steerguard simulate --print-scenario > drive.toml
  steerguard simulate --detector SteeringFaultDetector.fmu --scenario drive.toml -o results")]
pub struct SimulateArguments {
    /// Detector FMU; without it the paper's vehicle is designed and packaged on the fly
    #[arg(long, value_name = "FMU")]
    pub detector: Option<PathBuf>,
    /// Plant FMU; without it the reference vehicle
    #[arg(long, value_name = "FMU")]
    pub plant: Option<PathBuf>,
    /// What is driven (TOML); without it the scenario of the paper's Fig. 1
    #[arg(long, value_name = "FILE")]
    pub scenario: Option<PathBuf>,
    /// Folder for CSV files and plot
    #[arg(short, long, value_name = "DIR", default_value = "steerguard-out")]
    pub output: PathBuf,
    /// Print the default scenario file and do nothing else
    #[arg(long)]
    pub print_scenario: bool,
}

fn runtime(text: &str) -> Result<(Platform, PathBuf), String> {
    let (platform, file) = text.split_once('=').ok_or("expected PLATFORM=FILE")?;
    Ok((platform.parse()?, PathBuf::from(file)))
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    #[test]
    fn definition_is_consistent() {
        super::Cli::command().debug_assert();
    }
}
