//! A drive through the detector, as recorded and with injected faults, all in one pass of its file.

use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::Serialize;
use steerguard_drives::{
    Cause, Columns, DriveError, Finding, Reader, Resampler, Signal, Spacing, Wanted,
};

use super::detector::{Bench, Detector};
use super::error::ReplayError;
use super::fault::{FaultRequest, Injection};
use super::figure::Thinned;
use super::preparation::Preparation;
use super::tally::{Outcome, Tally};
use super::torque::Torques;
use super::trace::{Trace, TraceRow};
use crate::campaign::names::FaultName;
use crate::campaign::outcome::{Observation, Verdict};
use crate::drive::exchange::Inputs;
use crate::output;

/// What the detector takes of a drive beside what every drive has.
pub(super) const WANTED: Wanted = Wanted { lateral_acceleration: false, drive_torque: true };

/// A drive whose columns are chosen.
pub struct OpenDrive {
    reader: Reader,
    /// Name of its results, without ending.
    name: String,
}

impl OpenDrive {
    /// Opens the drive in the file at `path`, whose results get the `name`.
    ///
    /// # Errors
    /// [`DriveError`].
    pub fn open(path: &Path, columns: &Columns, name: String) -> Result<Self, DriveError> {
        Ok(Self { reader: Reader::open(path, columns, WANTED)?, name })
    }
}

/// Where results go.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Outputs {
    /// The folder, which exists.
    pub folder: PathBuf,
}

impl Outputs {
    /// Names of the results of a drive called `name`, as recorded and with the faults asked for.
    pub fn of(&self, name: &str, faults: &[FaultRequest]) -> Vec<PathBuf> {
        let runs = std::iter::once(None).chain(injections(faults).map(Some));
        let names = runs.map(|injection| run_name(name, injection.as_ref()));
        names.flat_map(|run| [self.trace(&run), self.plot(&run)]).collect()
    }

    fn trace(&self, run: &str) -> PathBuf {
        self.folder.join(format!("{run}.trace.csv"))
    }

    fn plot(&self, run: &str) -> PathBuf {
        self.folder.join(format!("{run}.svg"))
    }
}

fn injections(faults: &[FaultRequest]) -> impl Iterator<Item = Injection> {
    faults.iter().flat_map(FaultRequest::injections)
}

/// Name of a run's results.
fn run_name(drive: &str, injection: Option<&Injection>) -> String {
    match injection {
        None => drive.to_owned(),
        Some(injection) => format!("{drive}.{}", injection.label()),
    }
}

/// What became of an injected fault.
#[derive(Clone, Debug, PartialEq, JsonSchema, Serialize)]
pub struct InjectedRun {
    /// The fault.
    #[serde(flatten)]
    pub fault: Injection,
    /// What became of it.
    pub verdict: Verdict,
    /// First sample at which it acted and the detector monitored, s.
    pub exposed_s: Option<f64>,
    /// First sample of the alarm that it raised, s.
    pub alarm_s: Option<f64>,
    /// From exposure to alarm, s.
    pub delay_s: Option<f64>,
    /// The test that raised the alarm.
    pub cause: Option<&'static str>,
    /// What the second test says that the angle is, 0.2 s after exposure, deg; none where it says nothing.
    pub estimate_deg: Option<f64>,
    /// Largest J/J_th from then on.
    pub largest_ratio: Option<f64>,
}

/// What a drive showed.
#[derive(Clone, Debug, PartialEq, JsonSchema, Serialize)]
pub struct DriveReport {
    /// The file.
    pub file: PathBuf,
    /// How it was read.
    pub reading: String,
    /// Its columns: told or guessed.
    pub columns: Vec<String>,
    /// What was not taken, what is missing, and what looks wrong with the signals.
    pub warnings: Vec<String>,
    /// Rows.
    pub rows: u64,
    /// Pieces between gaps.
    pub pieces: u64,
    /// Time of its first sample in the file, s.
    pub start_s: f64,
    /// What the recorded drive showed.
    #[serde(flatten)]
    pub outcome: Outcome,
    /// What looks wrong with steering and yaw rate together.
    pub remarks: Vec<String>,
    /// The runs with an injected fault.
    pub injected: Vec<InjectedRun>,
    /// The files written.
    pub files: Vec<PathBuf>,
}

/// A run of a drive.
struct Pass {
    name: String,
    injection: Option<Injection>,
    detector: Detector,
    trace: Trace,
    thinned: Thinned,
    tally: Tally,
    observation: Observation,
}

impl Pass {
    fn new(
        bench: &Bench,
        drive: &str,
        injection: Option<Injection>,
        outputs: &Outputs,
    ) -> Result<Self, ReplayError> {
        let name = run_name(drive, injection.as_ref());
        Ok(Self {
            detector: Detector::new(bench, &name)?,
            trace: Trace::begin(&outputs.trace(&name))?,
            name,
            injection,
            thinned: Thinned::new(bench.period_s),
            tally: Tally::default(),
            observation: Observation::default(),
        })
    }

    /// Runs a sample at `time` of `piece`; the inputs have the recorded angle.
    fn step(
        &mut self,
        time: f64,
        piece: u64,
        starts: bool,
        recorded: &Inputs,
        bench: &Bench,
    ) -> Result<(), ReplayError> {
        let actual_rad = recorded.steering_angle - bench.zero.steering_offset_rad;
        let fault = self.injection.map_or(0.0, |fault| fault.angle_rad(time, actual_rad));
        let inputs = Inputs { steering_angle: recorded.steering_angle - fault, ..*recorded };
        let results = self.detector.step(starts, &inputs)?;
        results.finite(time)?;
        let row = TraceRow::new(time, piece, fault, &inputs, &results);
        self.tally.add(&row, starts, bench.period_s);
        if self.injection.is_some() {
            self.observation.add(&row.observed());
        }
        self.thinned.add(&row);
        self.trace.add(&row)
    }

    /// Ends the files of the run and says what it showed.
    fn finish(
        self,
        bench: &Bench,
        outputs: &Outputs,
    ) -> Result<(Option<InjectedRun>, Outcome, [PathBuf; 2]), ReplayError> {
        self.trace.finish()?;
        let files = [outputs.trace(&self.name), outputs.plot(&self.name)];
        output::write(&files[1], self.thinned.svg(&self.name)?.as_bytes())?;
        let outcome = self.tally.outcome(bench.period_s);
        let injected = self.injection.map(|fault| {
            let observed = self.observation.outcome(bench.period_s, Some(fault.onset_s));
            let raised = outcome.alarms.iter();
            let raised = raised.filter(|alarm| Some(alarm.time_s) == observed.alarm_s);
            let of_bias = |error: f64| match (fault.kind, fault.angle_deg) {
                (FaultName::Bias, Some(angle_deg)) => Some(angle_deg + error),
                _ => None,
            };
            InjectedRun {
                fault,
                verdict: observed.verdict,
                exposed_s: observed.exposed_s,
                alarm_s: observed.alarm_s,
                delay_s: observed.delay_s,
                cause: raised.map(|alarm| alarm.cause).next(),
                estimate_deg: observed.estimate_error_deg.and_then(of_bias),
                largest_ratio: observed.peak_ratio_after,
            }
        });
        Ok((injected, outcome, files))
    }
}

/// Takes a drive through the detector, as recorded and with each of `faults`, and writes traces and plots.
/// `gap_s` is the longest gap that is bridged; `fault_free` says that nothing was wrong with the car.
///
/// # Errors
/// [`ReplayError`]; no file of the drive is there then.
pub fn drive(
    bench: &Bench,
    drive: OpenDrive,
    faults: &[FaultRequest],
    gap_s: Option<f64>,
    fault_free: bool,
    outputs: &Outputs,
) -> Result<DriveReport, ReplayError> {
    let OpenDrive { mut reader, name } = drive;
    let spacing = Spacing::of_period(bench.period_s);
    let spacing = Spacing { gap_s: gap_s.unwrap_or(spacing.gap_s), ..spacing };
    let mut passes = vec![Pass::new(bench, &name, None, outputs)?];
    for injection in injections(faults) {
        passes.push(Pass::new(bench, &name, Some(injection), outputs)?);
    }
    let mut preparation = Preparation::new(bench.vehicle, bench.speeds, bench.period_s);
    let layout = reader.layout();
    let samples = Resampler::new(reader.by_ref(), layout, spacing);
    let (mut start_s, mut pieces, mut without_torque) = (None, 0, 0_u64);
    for driven in Torques::new(samples, bench.vehicle, bench.period_s) {
        let driven = driven?;
        let sample = driven.resampled.sample;
        let start_s = *start_s.get_or_insert(sample.time_s);
        let steering_angle = sample.steering_rad / bench.steering_ratio;
        let recorded = Inputs {
            v_x: sample.speed_m_per_s,
            r: sample.yaw_rate_rad_per_s,
            drive_torque: driven.drive_torque_n_m,
            steering_angle,
        };
        pieces += u64::from(driven.starts);
        without_torque += u64::from(sample.drive_torque_n_m.is_none());
        // On the grid to its last digits: the grid began at the first sample.
        let sample_number = ((sample.time_s - start_s) / bench.period_s).round();
        let time = sample_number * bench.period_s;
        for pass in &mut passes {
            pass.step(time, driven.resampled.piece, driven.starts, &recorded, bench)?;
        }
        preparation.add(
            driven.starts,
            recorded.v_x,
            recorded.r - bench.zero.yaw_rate_bias_rad_per_s,
            steering_angle - bench.zero.steering_offset_rad,
        );
    }
    let Some(start_s) = start_s else {
        let cause = Box::new(Cause::NoPiece { gap_s: spacing.gap_s });
        return Err(DriveError { file: reader.file().to_owned(), line: None, cause }.into());
    };
    let (mut recorded, mut injected, mut files) = (None, Vec::new(), Vec::new());
    for pass in passes {
        let (run, outcome, written) = pass.finish(bench, outputs)?;
        files.extend(written);
        injected.extend(run);
        // The first pass is the recorded one.
        recorded = recorded.or(Some(outcome));
    }
    let outcome = recorded.unwrap_or_else(|| Tally::default().outcome(bench.period_s));
    let false_alarms = fault_free && !outcome.alarms.is_empty();
    Ok(DriveReport {
        file: reader.file().to_owned(),
        reading: reader.reading(),
        columns: columns(&reader),
        warnings: warnings(&reader, without_torque, outcome.driven_s / bench.period_s),
        rows: reader.rows(),
        pieces,
        start_s,
        remarks: preparation.remarks(false_alarms, bench.steering_ratio),
        outcome,
        injected,
        files,
    })
}

/// The columns, and where the torque is from.
pub(super) fn columns(reader: &Reader) -> Vec<String> {
    let mut lines: Vec<_> = reader.chosen().choices().map(ToString::to_string).collect();
    if reader.chosen().of(Signal::DriveTorque).is_none() {
        lines.push("drive torque: no column; that of the speed's course is taken".into());
    }
    lines
}

/// What looks wrong with the signals of a drive of so many samples, `without_torque` of them.
pub(super) fn warnings(reader: &Reader, without_torque: u64, samples: f64) -> Vec<String> {
    let mut warnings = reader.chosen().left.clone();
    warnings.extend(reader.findings().iter().map(Finding::to_string));
    let missing = without_torque as f64 / samples.max(1.0);
    if reader.chosen().of(Signal::DriveTorque).is_some() && without_torque > 0 {
        warnings.push(format!(
            "drive torque: none in {:.1} % of the time; that of the speed's course is taken there",
            100.0 * missing
        ));
    }
    warnings
}
