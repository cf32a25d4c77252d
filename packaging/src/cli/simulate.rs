//! `steerguard simulate`.

use std::path::Path;

use schemars::JsonSchema;
use serde::Serialize;
use steerguard_designer::Spec;

use super::print::{print, print_file};
use super::{input, package};
use steerguard_model_description::names;

use crate::cli::arguments::SimulateArguments;
use crate::cli::detection_table::detection_table;
use crate::cli::failure::{Exit, Failure};
use crate::cli::progress::Progress;
use crate::drive::cosimulation::CosimulationError;
use crate::drive::detection::Detection;
use crate::drive::scenario::{DOCUMENTED, Scenario};
use crate::drive::simulation::{Files, Simulation, SimulationError};
use crate::fmu::runtime::Runtimes;
use crate::importer::Fmu;
use crate::output;
use crate::output::temporary::TemporaryFolder;

/// What simulated drives showed, and where they are recorded.
#[derive(JsonSchema, Serialize)]
pub(super) struct Simulated {
    /// What was detected, a drive each.
    detections: Vec<Detection>,
    /// Where the drives are recorded.
    files: Files,
}

pub(super) fn run(arguments: &SimulateArguments, json: bool) -> Result<Exit, Failure> {
    if arguments.print_scenario {
        print_file(json, &Scenario::default(), DOCUMENTED)?;
        return Ok(Exit::Done);
    }
    let scenario = match &arguments.scenario {
        None => Scenario::default(),
        Some(path) => input::scenario(path)?,
    };
    let progress = Progress::new();
    let folder = TemporaryFolder::new()
        .map_err(|error| Failure::bad(format!("cannot make a temporary folder: {error}")))?;
    let detector = match &arguments.detector {
        Some(path) => open(path)?,
        None => {
            let path = folder.path().join(names::DETECTOR_FILE);
            let design = input::make(&Spec::default(), Path::new(""), &progress)?;
            package::detector_to_drive(&design, &path)?;
            open(&path)?
        }
    };
    let plant = match &arguments.plant {
        Some(path) => open(path)?,
        None => {
            let path = folder.path().join(names::PLANT_FILE);
            package::plant(&Runtimes::plant(), &path)?;
            open(&path)?
        }
    };
    output::create_folder(&arguments.output)?;
    let simulation = simulate(&detector, &plant, &scenario, &progress)?;
    let files = write(&simulation, &arguments.output)?;
    drop(progress);

    let text =
        format!("Detection\n{}\n{}", detection_table(simulation.detections()), listed(&files));
    let detections = simulation.detections().cloned().collect();
    print(json, &Simulated { detections, files }, &text)?;
    Ok(Exit::Done)
}

/// Opens an FMU.
pub(super) fn open(path: &Path) -> Result<Fmu, Failure> {
    Fmu::open(path).map_err(|error| {
        Failure::bad(error)
            .help(
                "name an FMI 2.0 Co-Simulation FMU with a library for this machine; `steerguard check` says \
                 what is wrong with a file",
            )
    })
}

/// Drives all runs.
pub(super) fn simulate(
    detector: &Fmu,
    plant: &Fmu,
    scenario: &Scenario,
    progress: &Progress,
) -> Result<Simulation, Failure> {
    let say = |speed| progress.say(format!("driving at {speed} m/s"));
    Simulation::run(detector, plant, scenario, say).map_err(failure)
}

/// Writes CSV files and plot.
pub(super) fn write(simulation: &Simulation, folder: &Path) -> Result<Files, Failure> {
    simulation.write(folder).map_err(failure)
}

fn failure(error: SimulationError) -> Failure {
    match error {
        SimulationError::Output(error) => error.into(),
        SimulationError::Run { ref source, .. }
            if matches!(**source, CosimulationError::NotFinite(_)) =>
        {
            Failure::bad(error).help(
                "the FMU has a fault, or is driven beyond what it is made for: its documentation says how far",
            )
        }
        SimulationError::Run { ref source, .. } => {
            let keys = keys_behind(&source.to_string());
            let failure = Failure::bad(error);
            match keys {
                Some(help) => failure.help(help),
                None => failure.help("`steerguard simulate --print-scenario` shows every key with its default"),
            }
        }
        other => Failure::bad(other),
    }
}

/// Where the scenario says what a variable of the plant is, if an FMU's message names one.
fn keys_behind(message: &str) -> Option<String> {
    let (variable, keys) = [
        (
            "u.T_eng",
            "drive_torque_n_m, on top of the torque that holds the initial speed, or [manoeuvre]",
        ),
        ("u.delta", "steering_angle_rad or [manoeuvre]"),
        ("fault", "steering_fault_deg or [fault]"),
        ("disturbance.side_force", "side_wind_m_per_s2, wind_m_per_s and road_bank_deg"),
        (
            "disturbance.yaw_moment",
            "side_wind_m_per_s2 and wind_m_per_s with side_wind_lever_arm_m",
        ),
        ("initial.v_x", "initial_speeds_m_per_s"),
        ("initial.v_y", "initial_lateral_speed_m_per_s"),
        ("initial.r", "initial_yaw_rate_rad_per_s"),
    ]
    .into_iter()
    .find(|(variable, _)| message.contains(&format!("\"{variable}\"")))?;
    Some(format!("the scenario says what {variable} is by {keys}: keep it within the limits"))
}

/// The files, one a line.
pub(super) fn listed(files: &Files) -> String {
    let files = files.csv.iter().chain([&files.plot]);
    files.map(|file| format!("  {}\n", file.display())).collect()
}
