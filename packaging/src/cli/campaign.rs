//! `steerguard campaign`.

use std::path::{Path, PathBuf};
use std::time::Instant;

use schemars::JsonSchema;
use serde::Serialize;
use steerguard_designer::spec::UncertaintyTable;
use steerguard_designer::{Design, DesignStatus};
use steerguard_model_description::names;

use super::package::{self, caution};
use super::print::{print, print_file};
use super::{input, simulate, worst};
use crate::campaign::folder::Folder;
use crate::campaign::report::Report;
use crate::campaign::settings::{Mix, Sensors, Settings, Subject, Uncertainty};
use crate::campaign::simulation::TestBench;
use crate::campaign::{
    self, CampaignError, Manifest, drive::Drive, drive_record::DriveRecord, signals, table::Row,
};
use crate::cli::arguments::CampaignArguments;
use crate::cli::failure::{Exit, Failure};
use crate::cli::progress::Progress;
use crate::drive::cosimulation::Run;
use crate::drive::simulation::csv;
use crate::fmu::runtime::Runtimes;
use crate::output::temporary::TemporaryFolder;

/// What was driven of a campaign, and the report once that is complete.
#[derive(JsonSchema, Serialize)]
pub(super) struct DrivenPart {
    /// What the design may be called.
    status: DesignStatus,
    /// Number of blocks of this part.
    blocks: u64,
    /// Blocks of the campaign that are still missing.
    missing_blocks: Vec<u64>,
    /// How fast this run was; null where nothing was driven.
    throughput: Option<Throughput>,
    /// Results of the campaign; none until it is complete.
    files: Vec<PathBuf>,
    /// Its figures; null until it is complete.
    report: Option<Report>,
}

/// Signals that were written.
#[derive(JsonSchema, Serialize)]
pub(super) struct Signals<'a> {
    /// The table.
    files: [&'a Path; 1],
}

/// How fast this run was.
#[derive(Clone, Copy, JsonSchema, Serialize)]
struct Throughput {
    /// Number of drives.
    drives: u64,
    /// Number of workers.
    workers: usize,
    /// Time that they took, s.
    wall_s: f64,
    /// Seconds driven in a second of a worker.
    drive_seconds_per_second_per_worker: f64,
}

pub(super) fn run(arguments: &CampaignArguments, json: bool) -> Result<Exit, Failure> {
    let design = input::design(&arguments.design, &arguments.allow, &Progress::new())?;
    if arguments.worst {
        return worst::run(arguments, &design, workers(arguments), json);
    }
    let settings = settings(arguments, &design);
    if let Some(index) = arguments.drive
        && index >= settings.drives
    {
        return Err(Failure::bad(format!("there is no drive {index} in {}", settings.drives))
            .help("drives are numbered from 0; --drives N says how many there are"));
    }
    let (bench, manifest) = bench(&design, settings)?;
    match (arguments.drive, &arguments.signals) {
        (Some(index), _) => drive_one(&bench, &manifest.settings, index, json),
        (_, Some(path)) => write_signals(arguments, &bench, &manifest, path, json),
        _ => drive_part(arguments, &bench, &manifest, design.synthesis.status, json),
    }
}

/// The settings that the arguments and the design ask for.
fn settings(arguments: &CampaignArguments, design: &Design) -> Settings {
    let described = Sensors::of(&design.spec);
    let largest_deg = 4.0 * Subject::of(design).smallest_fault_deg;
    Settings {
        seed: arguments.seed,
        drives: arguments.drives,
        duration_s: arguments.duration,
        mix: arguments.mix,
        faults: arguments.faults,
        fault_deg: arguments.fault_deg.unwrap_or([0.0, largest_deg]),
        large_fault_deg: large_fault_deg(arguments, largest_deg),
        uncertainty: if arguments.nominal {
            Uncertainty::NOMINAL
        } else {
            Uncertainty { bounds: bounds(arguments, &design.spec.uncertainty), saturation: true }
        },
        sensors: Sensors {
            v_x_noise_m_per_s: arguments.v_x_noise.unwrap_or(described.v_x_noise_m_per_s),
            r_noise_rad_per_s: arguments.r_noise.unwrap_or(described.r_noise_rad_per_s),
            v_x_bias_m_per_s: arguments.v_x_bias.unwrap_or(described.v_x_bias_m_per_s),
            r_bias_rad_per_s: arguments.r_bias.unwrap_or(described.r_bias_rad_per_s),
        },
    }
}

/// Largest fault that campaigns draw, deg.
const LARGEST_FAULT_DEG: f64 = 20.0;

/// Sizes of the large faults: none where sizes are given, or of the classic mix.
fn large_fault_deg(arguments: &CampaignArguments, from_deg: f64) -> Option<[f64; 2]> {
    let drawn = arguments.mix == Mix::Standard && arguments.fault_deg.is_none();
    drawn.then_some([from_deg.min(LARGEST_FAULT_DEG), LARGEST_FAULT_DEG])
}

/// Those of the design, but for what the arguments set.
fn bounds(arguments: &CampaignArguments, described: &UncertaintyTable) -> UncertaintyTable {
    let mut bounds = *described;
    if let Some(percent) = arguments.parameters {
        for interval in [
            &mut bounds.mass_percent,
            &mut bounds.yaw_inertia_percent,
            &mut bounds.front_cornering_stiffness_percent,
            &mut bounds.rear_cornering_stiffness_percent,
        ] {
            *interval = [-percent, percent];
        }
    }
    if let Some(percent) = arguments.steering_ratio {
        bounds.steering_ratio_percent = [-percent, percent];
    }
    bounds.steering_offset_deg = arguments.steering_offset.unwrap_or(bounds.steering_offset_deg);
    bounds.v_x_scale_percent = arguments.v_x_scale.unwrap_or(bounds.v_x_scale_percent);
    bounds.load_transfer_percent = arguments.load_transfer.unwrap_or(bounds.load_transfer_percent);
    bounds.friction = arguments.friction.unwrap_or(bounds.friction);
    bounds.bank_deg = arguments.bank.unwrap_or(bounds.bank_deg);
    bounds.actuator_lag_s = arguments.actuator_lag.unwrap_or(bounds.actuator_lag_s);
    bounds.actuator_delay_s = arguments.actuator_delay.unwrap_or(bounds.actuator_delay_s);
    bounds.gust_m_per_s = arguments.gust.unwrap_or(bounds.gust_m_per_s);
    bounds
}

/// Packages both FMUs and loads them.
fn bench(design: &Design, settings: Settings) -> Result<(TestBench, Manifest), Failure> {
    let folder = TemporaryFolder::new()
        .map_err(|error| Failure::bad(format!("cannot make a temporary folder: {error}")))?;
    let detector = folder.path().join(names::DETECTOR_FILE);
    let plant = folder.path().join(names::PLANT_FILE);
    package::detector_to_drive(design, &detector)?;
    package::plant(&Runtimes::plant(), &plant)?;
    let read = |path| std::fs::read(path).map_err(Failure::bad);
    let manifest = Manifest::new(settings, design.hash.clone(), &read(&detector)?, &read(&plant)?);
    let bench = TestBench {
        detector: simulate::open(&detector)?,
        plant: simulate::open(&plant)?,
        subject: Subject::of(design),
    };
    Ok((bench, manifest))
}

/// Prints one drive: its samples as CSV, or its row as JSON.
fn drive_one(
    bench: &TestBench,
    settings: &Settings,
    index: u64,
    json: bool,
) -> Result<Exit, Failure> {
    let progress = Progress::saying(format_args!("driving drive {index}"));
    let drive = Drive::draw(settings, &bench.subject, index);
    let mut samples = Vec::new();
    let outcome = bench.run(&drive, |sample| samples.push(*sample)).map_err(Failure::bad)?;
    let run = Run {
        initial_speed_m_per_s: drive.plan.speed_m_per_s,
        step_s: bench.subject.period_s,
        samples,
    };
    let text = String::from_utf8(csv(&run).map_err(Failure::bad)?).map_err(Failure::bad)?;
    drop(progress);
    print_file(json, &Row { drive: DriveRecord::from(&drive), outcome }, &text)?;
    Ok(Exit::Done)
}

/// Drives a part and writes nothing but its signals.
fn write_signals(
    arguments: &CampaignArguments,
    bench: &TestBench,
    manifest: &Manifest,
    path: &Path,
    json: bool,
) -> Result<Exit, Failure> {
    let drives = arguments.shard.drives(manifest.settings.drives);
    let (progress, jobs) = (Progress::bar(drives.end - drives.start), workers(arguments));
    let advance = |drives| progress.advance(drives);
    signals::write(bench, manifest, drives, jobs, path, advance)?;
    drop(progress);
    print(json, &Signals { files: [path] }, &format!("  {}\n", path.display()))?;
    Ok(Exit::Done)
}

/// Drives what is missing of a part, and merges if that completes the campaign.
fn drive_part(
    arguments: &CampaignArguments,
    bench: &TestBench,
    manifest: &Manifest,
    status: DesignStatus,
    json: bool,
) -> Result<Exit, Failure> {
    let folder = Folder::open(&arguments.output, manifest.settings.drives, manifest)?;
    let blocks = arguments.shard.blocks(folder.blocks());
    let mut part = DrivenPart {
        status,
        blocks: blocks.end - blocks.start,
        missing_blocks: Vec::new(),
        throughput: None,
        files: Vec::new(),
        report: None,
    };
    if !arguments.prepare {
        let missing = folder.missing(blocks)?;
        part.throughput = drive(bench, &manifest.settings, &folder, &missing, workers(arguments))?;
        if let Some(rows) = folder.rows()? {
            let report = Report::of(&rows, bench.subject.armed_v_x);
            part.files = folder.write_results(&rows, &report)?.into();
            part.report = Some(report);
        }
    }
    if part.report.is_none() {
        part.missing_blocks = folder.missing(0..folder.blocks())?;
    }
    print(json, &part, &text(&part))?;
    Ok(Exit::Done)
}

/// Number of workers.
fn workers(arguments: &CampaignArguments) -> usize {
    let available = || std::thread::available_parallelism().map_or(1, usize::from);
    arguments.jobs.unwrap_or_else(available)
}

/// Drives `blocks`.
fn drive(
    bench: &TestBench,
    settings: &Settings,
    folder: &Folder,
    blocks: &[u64],
    workers: usize,
) -> Result<Option<Throughput>, CampaignError> {
    if blocks.is_empty() {
        return Ok(None);
    }
    let drives = blocks.iter().map(|&block| folder.drives_of(block)).map(|d| d.end - d.start).sum();
    let progress = Progress::bar(drives);
    let begin = Instant::now();
    campaign::run(bench, settings, folder, blocks, workers, |drives| progress.advance(drives))?;
    let wall_s = begin.elapsed().as_secs_f64();
    let drive_s = drives as f64 * settings.duration_s;
    Ok(Some(Throughput {
        drives,
        workers,
        wall_s,
        drive_seconds_per_second_per_worker: drive_s / wall_s / workers as f64,
    }))
}

/// The same for people.
fn text(part: &DrivenPart) -> String {
    let mut text = caution(part.status);
    text += &match &part.report {
        Some(report) => report.text() + "\n",
        None => format!(
            "{} blocks of the campaign missing: run the other parts here, or copy their blocks/ here \
             and run the command once more\n",
            part.missing_blocks.len()
        ),
    };
    if let Some(t) = &part.throughput {
        text += &format!(
            "{} drives in {:.1} s, {} workers: {:.0} drive-seconds per second per worker\n",
            t.drives, t.wall_s, t.workers, t.drive_seconds_per_second_per_worker
        );
    }
    for file in &part.files {
        text += &format!("  {}\n", file.display());
    }
    text
}
