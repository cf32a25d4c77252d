//! Command line.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum, value_parser};
use steerguard_model_description::names;

use crate::campaign::Shard;
use crate::campaign::settings::{FaultMix, Mix};
use crate::cli::column_arguments::ColumnArguments;
use crate::platform::Platform;
use crate::replay::fault::FaultRequest;

const EXAMPLES: &str = "\
Without a command: designs the detector for the paper's vehicle, re-checks it,
packages it, drives the FMU against a reference vehicle with a 0.5 degree
steering fault, and prints what was detected.

Examples:
  steerguard                                     the main job
  steerguard init my-car.toml                    a specification to start from
  steerguard design my-car.toml -o design.json   gains for your vehicle
  steerguard verify design.json                  proof in exact arithmetic
  steerguard package design.json                 SteeringFaultDetector.fmu
  steerguard check SteeringFaultDetector.fmu     what importers may trip over
  steerguard simulate --detector SteeringFaultDetector.fmu --scenario drive.toml
  steerguard campaign design.json --drives 1000  what it is worth on the road
  steerguard identify log.csv --known told.toml  a car from a recorded drive
  steerguard replay design.json drive.csv        what the detector says of it
  steerguard report design.json                  a page for a browser

Exit status: 0 done; 1 the answer is no (infeasible, check failed, fault
missed); 2 bad usage or input.";

/// With what FMUs made by it run on.
const VERSION: &str =
    concat!(env!("CARGO_PKG_VERSION"), "\nFMUs for: ", env!("STEERGUARD_PLATFORMS"));

/// Designs, packages and co-simulates a steering-fault detector as an FMI 2.0 unit
#[derive(Debug, Parser)]
#[command(version, long_version = VERSION, after_help = EXAMPLES, max_term_width = 100)]
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
    /// Write a specification to start from, every key explained
    Init(InitArguments),
    /// Find vehicle and sensors from recorded drives, with standard errors, and write a specification
    Identify(Box<IdentifyArguments>),
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
    /// Drive many random drives: false alarms, detections and delays with confidence intervals
    Campaign(Box<CampaignArguments>),
    /// Take recorded drives through the packaged detector, as they are and with injected faults
    Replay(Box<ReplayArguments>),
    /// Write a page on what a design is worth: verdict, figures, proof, evidence
    Report(ReportArguments),
    /// Print the JSON Schema of what a command prints with --json
    Schema(SchemaArguments),
    /// Print what a shell needs to complete this command's arguments
    Completions(CompletionsArguments),
}

/// What a design may lack and be used all the same, if that is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Allowance {
    /// The proof of its figures
    Uncertified,
    /// The sight of its smallest fault of interest
    Blind,
}

/// Version of FMI that the detector is packaged in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum FmiVersion {
    /// FMI 2.0
    #[value(name = "2")]
    Two,
    /// FMI 3.0
    #[value(name = "3")]
    Three,
    /// FMI 2.0 as X.fmu, FMI 3.0 as X.fmi3.fmu
    Both,
}

/// Arguments of `init`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  steerguard init
  steerguard init my-car.toml

What is there already is not written over: name another file, or remove it.")]
pub struct InitArguments {
    /// Specification to write
    #[arg(value_name = "FILE", default_value = "car.toml")]
    pub output: PathBuf,
}

/// Arguments of `completions`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  steerguard completions bash > /etc/bash_completion.d/steerguard
  steerguard completions zsh > ~/.zfunc/_steerguard")]
pub struct CompletionsArguments {
    /// The shell
    pub shell: clap_complete::Shell,
}

/// What is printed with `--json`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Printed {
    /// `steerguard`, the main job
    MainJob,
    /// `steerguard init`
    Init,
    /// `steerguard identify`
    Identify,
    /// `steerguard design`
    Design,
    /// `steerguard verify`
    Verify,
    /// `steerguard package`
    Package,
    /// `steerguard check`
    Check,
    /// `steerguard simulate`
    Simulate,
    /// `steerguard simulate --print-scenario`
    Scenario,
    /// `steerguard campaign`
    Campaign,
    /// `steerguard campaign --drive`
    CampaignDrive,
    /// `steerguard campaign --signals`
    CampaignSignals,
    /// `steerguard campaign --worst`
    CampaignWorst,
    /// `steerguard replay`
    Replay,
    /// `steerguard report`
    Report,
    /// Any command that cannot do what was asked, on the standard error output
    Failure,
}

/// Arguments of `schema`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  steerguard schema design > design.schema.json
  steerguard schema campaign-worst

JSON Schema, draft 2020-12. Later versions may print more keys; those that are
there keep name, unit and meaning.")]
pub struct SchemaArguments {
    /// What is printed
    #[arg(value_name = "WHAT")]
    pub printed: Printed,
}

/// Arguments of `report`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  steerguard report design.json
  steerguard report design.json --campaign campaign --replay replay

The page is one file, needs no network and no script, and says first what the
design sees and what it does not.")]
pub struct ReportArguments {
    /// Design (.json), or a specification to design for first
    pub design: PathBuf,
    /// Folder of a campaign of this design: detections by size, delays, false alarms
    #[arg(long, value_name = "DIR")]
    pub campaign: Option<PathBuf>,
    /// Folder of a replay with this design: recorded drives
    #[arg(long, value_name = "DIR")]
    pub replay: Option<PathBuf>,
    /// Comparison with other detectors, as tests/peers/run --output writes it
    #[arg(long, value_name = "FILE")]
    pub peers: Option<PathBuf>,
    /// Page to write
    #[arg(short, long, value_name = "FILE", default_value = "report.html")]
    pub output: PathBuf,
}

/// Arguments of `identify`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  steerguard identify drive.csv --known told.toml -o my-car.toml
  steerguard identify monday.csv tuesday.parquet --known told.toml
  steerguard identify log.csv --known told.toml \\
      --speed 'v [km/h]' --yaw r_deg:-deg/s --steering hw:deg

told.toml is a specification that holds at least
  [vehicle]
  mass_kg = 1476
  front_axle_distance_m = 1.13
  rear_axle_distance_m = 1.49
What it states beside is taken as it is; the rest is identified: steering ratio
and offset, yaw-rate bias, delay, stiffnesses, and with lateral acceleration yaw
inertia and height of the centre of gravity.

Drive a standstill of 10 s, half a minute of turns at 3 to 8 m/s, a sweep or
slalom from 0.2 to 2 Hz to 3 m/s^2 at 15 to 25 m/s. What the drives do not show
is refused by name.

Exit status: 1 where the drives do not show it, nothing is written; 2 for a
drive that cannot be read.")]
pub struct IdentifyArguments {
    /// Recorded drives of one car (CSV, Parquet)
    #[arg(required = true, value_name = "DRIVE")]
    pub drives: Vec<PathBuf>,
    /// What is known of the car (TOML): a specification of which mass and axle distances have to be there
    #[arg(long, value_name = "FILE")]
    pub known: Option<PathBuf>,
    /// Rows farther apart than this end a piece, s; default 0.25
    #[arg(long, value_name = "S", value_parser = gap)]
    pub gap: Option<f64>,
    /// What is told of the columns
    #[command(flatten)]
    pub columns: ColumnArguments,
    /// Specification to write; beside it a plot of the fit (.fit.svg)
    #[arg(short, long, value_name = "FILE", default_value = "car.toml")]
    pub output: PathBuf,
}

/// Arguments of `design`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  steerguard design my-car.toml -o design.json
  steerguard design old.json -o new.json      from the specification inside")]
pub struct DesignArguments {
    /// Specification (TOML); every key left out has the value of the paper's vehicle. Or a design of this
    /// or an earlier version (.json), whose specification is taken
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
  steerguard package design.json --only linux64,win64
  steerguard package design.json --fmi both -o my-car.fmu
  steerguard package design.json --runtime win64=SteeringFaultDetector.dll")]
pub struct PackageArguments {
    /// Design file (.json), which is verified first, or a specification (any other name), which is
    /// designed
    pub design: PathBuf,
    /// Use the design although it is not certified, or blind; everything made of it says so
    #[arg(long, value_name = "WHAT", value_enum, value_delimiter = ',')]
    pub allow: Vec<Allowance>,
    /// FMU to write
    #[arg(short, long, value_name = "FILE", default_value = names::DETECTOR_FILE)]
    pub output: PathBuf,
    /// Version of FMI of the detector's FMU; both: FILE in FMI 2.0, and beside it FILE with .fmi3.fmu for .fmu
    #[arg(long, value_name = "VERSION", value_enum, default_value = "2")]
    pub fmi: FmiVersion,
    /// Write the reference vehicle's FMU as well
    #[arg(long, value_name = "FILE")]
    pub plant: Option<PathBuf>,
    /// Write detector and reference vehicle as a connected system (SSP 1.0) as well
    #[arg(long, value_name = "FILE")]
    pub system: Option<PathBuf>,
    /// Add the detector's unbaked library for a further platform: linux64, win64, darwin64,
    /// aarch64-linux; which version of FMI it is for is seen from what it exports
    #[arg(long, value_name = "PLATFORM=FILE", value_parser = runtime)]
    pub runtime: Vec<(Platform, PathBuf)>,
    /// Libraries for these platforms alone, in every file written: smaller. Without it for all that this
    /// command has (`steerguard --version`) or is given
    #[arg(long, value_name = "PLATFORM", value_delimiter = ',')]
    pub only: Vec<Platform>,
}

/// Arguments of `check`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  steerguard check SteeringFaultDetector.fmu
  steerguard check --json other.fmu")]
pub struct CheckArguments {
    /// Any FMU of FMI 2.0 or 3.0; nothing of it is written to disk or run
    pub fmu: PathBuf,
}

/// Arguments of `simulate`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  steerguard simulate
  steerguard simulate --print-scenario > drive.toml
  steerguard simulate --detector SteeringFaultDetector.fmu --scenario drive.toml")]
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

/// Arguments of `campaign`.
#[derive(Debug, Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Examples:
  steerguard campaign design.json --drives 1000 --faults none -o fault-free
  steerguard campaign design.json --faults bias --fault-deg 0..2 -o biases
  steerguard campaign design.json --parameters 10 --bank 3 -o perturbed
  steerguard campaign design.json --drive 17 > drive-17.csv
  steerguard campaign design.json --drives 1000 --shard 2/4 -o part-2
  steerguard campaign design.json --drives 1000 --signals signals.parquet
  steerguard campaign design.json --worst -o worst
  steerguard simulate --detector SteeringFaultDetector.fmu \\
      --scenario worst/worst-constant.toml

A campaign that was cut short goes on when the command is given again. Parts
driven elsewhere are merged by copying their blocks/ into one folder and giving
the command without --shard: results are the same, byte for byte, as those of
one run.

Files in DIR: results.parquet, a row a drive; report.json; campaign.json and
blocks/, to go on. With --worst: worst-FAMILY.toml, the worst drive found of
each family, which `simulate` replays."
)]
pub struct CampaignArguments {
    /// Design file (.json), which is verified first, or a specification (any other name), which is
    /// designed
    pub design: PathBuf,
    /// Use the design although it is not certified, or blind; everything made of it says so
    #[arg(long, value_name = "WHAT", value_enum, value_delimiter = ',')]
    pub allow: Vec<Allowance>,
    /// Do not drive at random: search the fault-free drives with the largest J/J_th, within all that the
    /// specification states of vehicle, road, air and sensors
    #[arg(long, conflicts_with_all = [
        "drives", "duration", "faults", "mix", "fault_deg", "nominal", "parameters", "bank", "gust",
        "actuator_lag", "actuator_delay", "steering_ratio", "steering_offset", "v_x_scale",
        "load_transfer", "friction", "v_x_noise", "r_noise", "v_x_bias", "r_bias", "drive", "shard",
        "prepare", "signals"])]
    pub worst: bool,
    /// Drives of each family that the search takes, at most; default: 16000
    #[arg(long, value_name = "N", requires = "worst",
        value_parser = value_parser!(u64).range(100..=100_000_000))]
    pub budget: Option<u64>,
    /// Number of drives
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = value_parser!(u64).range(1..=10_000_000))]
    pub drives: u64,
    /// Length of a drive, s
    #[arg(long, value_name = "S", default_value_t = 60.0, value_parser = between::<5, 3600>)]
    pub duration: f64,
    /// Seed: same seed, same drives
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    pub seed: u64,
    /// Number of workers; default: one a processor
    #[arg(long, value_name = "J", value_parser = jobs)]
    pub jobs: Option<usize>,
    /// Faults: none; all kinds and none, equally likely; a bias in every drive
    #[arg(long, value_enum, default_value = "mixed")]
    pub faults: FaultMix,
    /// Drives: standard; or classic, which compares with figures of earlier versions
    #[arg(long, value_enum, default_value = "standard")]
    pub mix: Mix,
    /// Sizes of biases, drifts and oscillations, deg at the road wheel; default: up to four times the
    /// smallest fault of the design, and of a quarter of them from there up to 20
    #[arg(long, value_name = "MIN..MAX", value_parser = sizes, allow_hyphen_values = true)]
    pub fault_deg: Option<[f64; 2]>,
    /// The design's own vehicle and actuator with linear tyres on a flat road in still air
    #[arg(long, conflicts_with_all = [
        "parameters", "bank", "gust", "actuator_lag", "actuator_delay", "steering_ratio",
        "steering_offset", "v_x_scale", "load_transfer", "friction"])]
    pub nominal: bool,
    /// Largest deviation of mass, yaw inertia and cornering stiffnesses, percent; default: the
    /// intervals of the design's [uncertainty]
    #[arg(long, value_name = "PERCENT", value_parser = between::<0, 50>)]
    pub parameters: Option<f64>,
    /// Largest road bank, deg; default: the design's
    #[arg(long, value_name = "DEG", value_parser = between::<0, 30>)]
    pub bank: Option<f64>,
    /// Fastest gust across the road, m/s; default: the design's
    #[arg(long, value_name = "M_PER_S", value_parser = between::<0, 50>)]
    pub gust: Option<f64>,
    /// Largest lag of the steering actuator beyond the specified one, s; default: the design's
    #[arg(long, value_name = "S", value_parser = between::<0, 1>)]
    pub actuator_lag: Option<f64>,
    /// Longest dead time of the steering actuator beyond the specified one, s; default: the design's
    #[arg(long, value_name = "S", value_parser = between::<0, 1>)]
    pub actuator_delay: Option<f64>,
    /// Largest error of the steering ratio, percent; default: the design's
    #[arg(long, value_name = "PERCENT", value_parser = between::<0, 50>)]
    pub steering_ratio: Option<f64>,
    /// Largest offset of the road wheel from its command, deg; default: the design's
    #[arg(long, value_name = "DEG", value_parser = between::<0, 10>)]
    pub steering_offset: Option<f64>,
    /// Largest error of the measured speed, percent; default: the design's
    #[arg(long, value_name = "PERCENT", value_parser = between::<0, 40>)]
    pub v_x_scale: Option<f64>,
    /// Largest error of the height of the centre of gravity, percent; default: the design's
    #[arg(long, value_name = "PERCENT", value_parser = between::<0, 100>)]
    pub load_transfer: Option<f64>,
    /// Friction between tyre and road where it limits the axle forces, in half of the drives; default: the
    /// design's
    #[arg(long, value_name = "MIN..MAX", value_parser = sizes)]
    pub friction: Option<[f64; 2]>,
    /// Standard deviation of the noise on v_x, m/s; default: the design's
    #[arg(long, value_name = "M_PER_S", value_parser = between::<0, 10>)]
    pub v_x_noise: Option<f64>,
    /// Standard deviation of the noise on r, rad/s; default: the design's
    #[arg(long, value_name = "RAD_PER_S", value_parser = between::<0, 1>)]
    pub r_noise: Option<f64>,
    /// Largest constant error of v_x, m/s; default: the design's
    #[arg(long, value_name = "M_PER_S", value_parser = between::<0, 10>)]
    pub v_x_bias: Option<f64>,
    /// Largest constant error of r, rad/s; default: the design's
    #[arg(long, value_name = "RAD_PER_S", value_parser = between::<0, 1>)]
    pub r_bias: Option<f64>,
    /// Only drive number INDEX, from 0: its samples as CSV, or with --json its row
    #[arg(long, value_name = "INDEX", conflicts_with_all = ["shard", "jobs", "output"])]
    pub drive: Option<u64>,
    /// Only the K-th of N parts
    #[arg(long, value_name = "K/N", default_value = "1/1", hide_default_value = true,
        value_parser = shard)]
    pub shard: Shard,
    /// Only make DIR, or find that it is this campaign's, and list the blocks that are missing
    #[arg(long, conflicts_with = "drive")]
    pub prepare: bool,
    /// Only write what the detector was given and what it said to FILE (Parquet), a row a sample
    #[arg(long, value_name = "FILE", conflicts_with_all = ["drive", "prepare", "output"])]
    pub signals: Option<PathBuf>,
    /// Folder of the campaign
    #[arg(short, long, value_name = "DIR", default_value = "steerguard-campaign")]
    pub output: PathBuf,
}

/// Arguments of `replay`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  steerguard replay design.json drive.csv --fault-free
  steerguard replay design.json monday.csv tuesday.parquet -o replayed
  steerguard replay design.json drive.csv --fault bias=0.5@30s --fault bias=1@30s
  steerguard replay design.json drive.csv --fault drift=1,rise_s=5@30s
  steerguard replay design.json drive.csv --fault loss=0.3@30s
  steerguard replay design.json log.csv \\
      --speed 'v [km/h]' --yaw r_deg:-deg/s --steering hw:deg
  steerguard replay design.json log.csv --columns columns.toml

A drive is a CSV or Parquet file (docs/drive-files.md: formats, columns, units,
what is guessed and what is found wrong). The design's sensors.steering_ratio,
steering_offset_deg and yaw_rate_bias_deg_per_s are those of the car.

Files in DIR: summary.json; for each drive NAME.trace.csv, what the detector was
told and said a line a sample, and NAME.svg, J and J_th over time; the same for
each injected fault.

Exit status: 1 where a drive that is said to be --fault-free alarms; 2 for a
drive that cannot be read.")]
pub struct ReplayArguments {
    /// Design file (.json), which is verified first, or a specification (any other name), which is
    /// designed
    pub design: PathBuf,
    /// Recorded drives (CSV, Parquet)
    #[arg(required = true, value_name = "DRIVE")]
    pub drives: Vec<PathBuf>,
    /// Use the design although it is not certified, or blind; everything made of it says so
    #[arg(long, value_name = "WHAT", value_enum, value_delimiter = ',')]
    pub allow: Vec<Allowance>,
    /// Nothing was wrong with the car: an alarm is a false one
    #[arg(long)]
    pub fault_free: bool,
    /// Also run the drives with this fault, to both sides; several are runs each. KIND is bias, drift
    /// (with rise_s, 5), oscillation (with frequency_hz, 1), in deg at the road wheel, or loss (share of the
    /// command); TIME counts from the drive's first sample
    #[arg(long, value_name = "KIND=SIZE[,KEY=VALUE]@TIME")]
    pub fault: Vec<FaultRequest>,
    /// Rows farther apart than this end a piece, and the detector starts anew, s; default: 0.25, or five
    /// sampling periods
    #[arg(long, value_name = "S", value_parser = gap)]
    pub gap: Option<f64>,
    /// Folder for summary, traces and plots
    #[arg(short, long, value_name = "DIR", default_value = "steerguard-replay")]
    pub output: PathBuf,
    /// What is told of their columns
    #[command(flatten)]
    pub columns: ColumnArguments,
}

fn gap(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(gap_s) if (1e-3..=60.0).contains(&gap_s) => Ok(gap_s),
        _ => Err("expected a number from 0.001 to 60".into()),
    }
}

/// A number from MIN to MAX.
fn between<const MIN: i64, const MAX: i64>(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().map_err(|error| error.to_string())?;
    let (min, max) = (MIN as f64, MAX as f64);
    if (min..=max).contains(&value) {
        Ok(value)
    } else {
        Err(format!("{value} is not from {MIN} to {MAX}"))
    }
}

fn jobs(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(jobs @ 1..=1024) => Ok(jobs),
        _ => Err("expected a whole number from 1 to 1024".into()),
    }
}

fn sizes(text: &str) -> Result<[f64; 2], String> {
    let (min, max) = text.split_once("..").ok_or("expected MIN..MAX, such as 0.1..2")?;
    let sizes = [between::<0, 90>(min)?, between::<0, 90>(max)?];
    if sizes[0] <= sizes[1] { Ok(sizes) } else { Err("MIN is larger than MAX".into()) }
}

fn shard(text: &str) -> Result<Shard, String> {
    let parse = || {
        let (number, of) = text.split_once('/')?;
        Some(Shard { number: number.parse().ok()?, of: of.parse().ok()? })
    };
    match parse() {
        Some(shard) if 1 <= shard.number && shard.number <= shard.of => Ok(shard),
        _ => Err("expected K/N with 1 <= K <= N, such as 2/4".into()),
    }
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

    #[test]
    fn sizes_below_zero_are_told_with_what_is_allowed() {
        let arguments = ["steerguard", "campaign", "a.json", "--fault-deg", "-5..1"];
        let error = super::Cli::command().try_get_matches_from(arguments).unwrap_err().to_string();
        assert!(error.contains("-5 is not from 0 to 90"), "{error}");
    }
}
