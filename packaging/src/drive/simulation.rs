//! A scenario driven through packaged FMUs, and what is left of it: CSV files, plot, figures.

use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::Serialize;

use crate::drive::cosimulation::{self, CosimulationError, Run};
use crate::drive::detection::Detection;
use crate::drive::plot::{self, PlotError};
use crate::drive::scenario::Scenario;
use crate::importer::Fmu;
use crate::output::{self, OutputError};

/// Why a simulation has no result.
#[derive(Debug, thiserror::Error)]
pub enum SimulationError {
    /// A run ended early.
    #[error("run with v_x(0) = {initial_speed_m_per_s} m/s: {source}")]
    Run {
        /// Which run.
        initial_speed_m_per_s: f64,
        /// Why.
        source: Box<CosimulationError>,
    },
    /// A sample could not be written as CSV.
    #[error("cannot write CSV: {0}")]
    Csv(#[from] csv::Error),
    /// The plot could not be drawn.
    #[error(transparent)]
    Plot(#[from] PlotError),
    /// A file could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
}

/// All runs of a scenario with their figures.
#[derive(Clone, Debug, PartialEq)]
pub struct Simulation {
    /// One for each initial speed, in the order of the scenario.
    pub runs: Vec<(Run, Detection)>,
}

/// Files of a simulation.
#[derive(Clone, Debug, PartialEq, Eq, JsonSchema, Serialize)]
pub struct Files {
    /// One CSV file for each run.
    pub csv: Vec<PathBuf>,
    /// The plot.
    pub plot: PathBuf,
}

impl Simulation {
    /// Drives all runs; `progress` is told the initial speed of each as it begins.
    ///
    /// # Errors
    /// [`SimulationError::Run`].
    pub fn run(
        detector: &Fmu,
        plant: &Fmu,
        scenario: &Scenario,
        mut progress: impl FnMut(f64),
    ) -> Result<Self, SimulationError> {
        let run = |&initial_speed_m_per_s: &f64| {
            progress(initial_speed_m_per_s);
            let run = cosimulation::run(detector, plant, scenario, initial_speed_m_per_s).map_err(
                |source| SimulationError::Run { initial_speed_m_per_s, source: Box::new(source) },
            )?;
            let detection = Detection::of(&run);
            Ok::<_, SimulationError>((run, detection))
        };
        Ok(Self {
            runs: scenario.initial_speeds_m_per_s.iter().map(run).collect::<Result<_, _>>()?,
        })
    }

    /// Figures of all runs.
    pub fn detections(&self) -> impl Iterator<Item = &Detection> {
        self.runs.iter().map(|(_, detection)| detection)
    }

    /// Writes CSV files and plot into the existing `folder`.
    ///
    /// # Errors
    /// [`SimulationError`] if a file cannot be made or written.
    pub fn write(&self, folder: &Path) -> Result<Files, SimulationError> {
        let mut files = Files { csv: Vec::new(), plot: folder.join("detection.svg") };
        for (run, _) in &self.runs {
            let path = folder.join(format!("run-{}mps.csv", run.initial_speed_m_per_s));
            output::write(&path, &csv(run)?)?;
            files.csv.push(path);
        }
        output::write(&files.plot, plot::svg(&self.runs)?.as_bytes())?;
        Ok(files)
    }
}

/// The samples of a run, one a line, under the names of the FMU variables.
///
/// # Errors
/// None that a run in memory can cause.
pub fn csv(run: &Run) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for sample in &run.samples {
        writer.serialize(sample)?;
    }
    writer.into_inner().map_err(|error| csv::Error::from(error.into_error()))
}
