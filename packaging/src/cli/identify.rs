//! `steerguard identify`.

use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::Serialize;
use steerguard_designer::Spec;
use steerguard_designer::document::Source;
use steerguard_drives::{Piece, Reader, Spacing, Wanted, pieces};
use steerguard_identification::{
    Estimate, IdentificationError, Identified, Lateral, Origin, Parameter, Refused, STEPS, Scale,
    identify,
};

use super::columns::{self, unreadable};
use super::input;
use super::print::print;
use super::text::read_text;
use crate::cli::arguments::IdentifyArguments;
use crate::cli::failure::{Exit, Failure};
use crate::cli::progress::Progress;
use crate::identify::specification::{in_words, key};
use crate::identify::{known, plot, specification};
use crate::output;
use crate::output::table::aligned;

/// Grid that drives are put on, s.
const PERIOD_S: f64 = 0.01;
/// Correlation from which on it is printed.
const CORRELATED: f64 = 0.9;
/// Time that is read at most, s: a hundred megabytes.
const LONGEST_S: f64 = 4.0 * 3600.0;

/// What is said of the drives, and what was written.
#[derive(JsonSchema, Serialize)]
pub(super) struct Report {
    /// Parameters of vehicle and sensors.
    parameters: Vec<Row>,
    /// How far what two of them are depends on each other.
    correlations: Vec<Correlation>,
    /// Time that model and drives were compared over, s.
    compared_s: f64,
    /// Time driven, s.
    driven_s: f64,
    /// Lowest and highest speed of what was compared, m/s.
    speeds_m_per_s: [f64; 2],
    /// RMS of the measured less the model's yaw rate, rad/s.
    yaw_rate_left_over_rad_per_s: f64,
    /// Of what is left over of the yaw rate, after 0.1 s; 0 of white noise.
    autocorrelation: f64,
    /// `used`, `unexplained` or `not logged`.
    lateral_acceleration: &'static str,
    /// How each file was read, and which columns were taken.
    columns: Vec<String>,
    /// What was not taken, what is missing, and what looks wrong with the signals.
    findings: Vec<String>,
    /// The specification written.
    specification: PathBuf,
    /// The plot of the fit.
    plot: PathBuf,
}

/// A parameter.
#[derive(JsonSchema, Serialize)]
struct Row {
    /// Its key in the specification; null where it has none.
    key: Option<String>,
    /// What it is.
    name: &'static str,
    /// In SI units.
    value: f64,
    /// Relative, or in SI units.
    standard_error: f64,
    /// Half the interval written, relative or in SI units.
    interval: f64,
    /// `fitted`, `told`, `assumed` or `pair`.
    origin: &'static str,
    #[serde(skip)]
    estimate: Estimate,
}

/// How far two parameters depend on each other.
#[derive(JsonSchema, Serialize)]
struct Correlation {
    /// Which two.
    parameters: [&'static str; 2],
    /// -1 to 1.
    correlation: f64,
}

/// What is read of drive files.
#[derive(Default)]
struct Drives {
    pieces: Vec<Piece>,
    columns: Vec<String>,
    findings: Vec<String>,
}

pub(super) fn run(arguments: &IdentifyArguments, json: bool) -> Result<Exit, Failure> {
    let plot_path = arguments.output.with_extension("fit.svg");
    let inputs = arguments.drives.iter().chain(&arguments.known).chain(&arguments.columns.columns);
    for input in inputs {
        input::apart(input, &plot_path)?;
        input::apart(input, &arguments.output)?;
    }
    let known = match &arguments.known {
        Some(path) => read_text(path)?,
        None => String::new(),
    };
    let told = known::told(&known).map_err(|mistakes| match &arguments.known {
        Some(path) => {
            let source = Source { name: path.display().to_string(), text: known.clone().into() };
            Failure::mistakes(&mistakes, &source)
        }
        None => Failure::bad("drives show neither the mass of the car nor where its axles are")
            .help(
                "write them into a file and give it as --known FILE: [vehicle] mass_kg, \
             front_axle_distance_m and rear_axle_distance_m (from the centre of gravity)",
            ),
    })?;
    let drives = read(arguments)?;

    let progress = Progress::bar(STEPS);
    let found = identify(&drives.pieces, &told, &|| progress.advance(1));
    drop(progress);
    let identified = found.map_err(failure)?;

    let names: Vec<String> = arguments.drives.iter().map(|path| name(path)).collect();
    let text = specification::text(&known, &told, &identified, &names).map_err(Failure::bad)?;
    if let Err(mistakes) = Spec::from_toml(&text) {
        let name = format!("{} (not written)", arguments.output.display());
        let failure = Failure::mistakes(&mistakes, &Source { name, text: text.into() });
        return Err(Failure { exit: Exit::No, ..failure }
            .help("state what is refused in the file of --known, and identify again"));
    }
    let figure = plot::svg(&identified).map_err(Failure::bad)?;
    output::write(&arguments.output, text.as_bytes())?;
    output::write(&plot_path, figure.as_bytes())?;

    let report = Report::new(&identified, drives, arguments.output.clone(), plot_path);
    print(json, &report, &report.text())?;
    Ok(Exit::Done)
}

/// Reads the drives onto a grid.
fn read(arguments: &IdentifyArguments) -> Result<Drives, Failure> {
    let columns = columns::told(&arguments.columns)?;
    let mut drives = Drives::default();
    let mut spacing = Spacing::of_period(PERIOD_S);
    spacing.gap_s = arguments.gap.unwrap_or(spacing.gap_s);
    let wanted = Wanted { lateral_acceleration: true, drive_torque: false };
    let mut left_s = LONGEST_S;
    let progress = Progress::new();
    for path in &arguments.drives {
        progress.say(format_args!("reading {}", path.display()));
        let mut reader =
            Reader::open(path, &columns, wanted).map_err(|error| unreadable(&error))?;
        drives.columns.push(format!("{}: {}", path.display(), reader.reading()));
        drives.columns.extend(reader.chosen().choices().map(|choice| format!("  {choice}")));
        let read = pieces(&mut reader, spacing, left_s).map_err(|error| unreadable(&error))?;
        let findings = reader.findings();
        drives
            .findings
            .extend(findings.iter().map(|finding| format!("{}: {finding}", path.display())));
        left_s -= read.iter().map(|piece| piece.samples.len() as f64 * PERIOD_S).sum::<f64>();
        drives.pieces.extend(read);
    }
    Ok(drives)
}

fn name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// Why there is no answer, and what to do.
fn failure(error: IdentificationError) -> Failure {
    match &error {
        IdentificationError::NotShown(refused, _) => {
            let mut diagnostics = Vec::new();
            for refused in refused {
                diagnostics.extend(not_shown(refused).diagnostics);
            }
            Failure { exit: Exit::No, diagnostics }
        }
        IdentificationError::TurnedAxis { .. } => Failure::no(error).help(
            "left is positive (ISO 8855): a minus before the unit turns a column, as in --yaw NAME:-deg/s",
        ),
        IdentificationError::ImpossibleRatio { .. } => {
            Failure::no(error).help("--steering NAME:UNIT and --yaw NAME:UNIT say the units")
        }
        IdentificationError::LateSteering { late_s } => {
            let help = format!("--delay steering={late_s:.3} takes it back");
            Failure::no(error).help(help)
        }
        IdentificationError::TooShort { .. } => {
            Failure::no(error).help("drive longer, or give several drives")
        }
        IdentificationError::NoExcitation(_) => {
            Failure::no(error).help("name the right column, or drive turns")
        }
        IdentificationError::NoFit => {
            Failure::no(error).help("compare the columns that are printed with what the log's makers say")
        }
    }
}

/// A parameter that is not shown.
fn not_shown(refused: &Refused) -> Failure {
    let Refused { parameter, standard_error } = *refused;
    let scale = parameter.scale();
    let largest = parameter.largest_error().unwrap_or_default();
    let why = match parameter {
        _ if standard_error > largest => format!("at most {} is enough", in_words(scale, largest)),
        Parameter::SteeringRatio => "it goes with stiffnesses that are not shown either".to_owned(),
        _ => "offset and bias are not shown apart from each other".to_owned(),
    };
    let failure = Failure::no(format!(
        "the drives do not show the {}: its standard error is {}, and {why}",
        parameter.name(),
        in_words(scale, standard_error),
    ));
    let failure = failure.help(format!("drive {}", parameter.manoeuvre()));
    match key(parameter) {
        Some(key) => failure.help(format!("or tell it: `{key}` in the file of --known")),
        None => failure,
    }
}

impl Report {
    fn new(found: &Identified, drives: Drives, specification: PathBuf, plot: PathBuf) -> Self {
        let row = |estimate: &Estimate| Row {
            key: key(estimate.parameter),
            name: estimate.parameter.name(),
            value: estimate.value,
            standard_error: estimate.standard_error,
            interval: estimate.interval(),
            origin: match estimate.origin {
                Origin::Identified => "fitted",
                Origin::Told => "told",
                Origin::Assumed => "assumed",
                Origin::Pair => "pair",
            },
            estimate: *estimate,
        };
        let correlations = found.correlations.iter().map(|&(of, with, correlation)| Correlation {
            parameters: [of.name(), with.name()],
            correlation,
        });
        Self {
            parameters: found.estimates.iter().map(row).collect(),
            correlations: correlations.collect(),
            compared_s: found.compared_s,
            driven_s: found.driven_s,
            speeds_m_per_s: found.speeds_m_per_s,
            yaw_rate_left_over_rad_per_s: found.yaw_rate_left_over,
            autocorrelation: found.autocorrelation,
            lateral_acceleration: match found.lateral_acceleration {
                Lateral::NotLogged => "not logged",
                Lateral::Used { .. } => "used",
                Lateral::Unexplained { .. } => "unexplained",
            },
            columns: drives.columns,
            findings: drives.findings,
            specification,
            plot,
        }
    }

    /// The same for people.
    fn text(&self) -> String {
        let mut text = String::from("Drives\n");
        text += &self.columns.iter().map(|line| format!("  {line}\n")).collect::<String>();
        text += &self.findings.iter().map(|line| format!("  {line}\n")).collect::<String>();
        let [slowest, fastest] = self.speeds_m_per_s;
        text += &format!(
            "  {:.1} s, of which {:.1} s compared, {slowest:.1} to {fastest:.1} m/s\n\nVehicle and sensors\n",
            self.driven_s, self.compared_s
        );
        let head = ["", "value", "", "standard error", "interval"];
        let mut rows = vec![head.map(String::from).to_vec()];
        rows.extend(self.parameters.iter().map(|row| {
            let scale = row.estimate.parameter.scale();
            let (value, unit) = stated(row.estimate.parameter, row.value);
            let or_none = |size: f64| match size > 0.0 {
                true => in_words(scale, size),
                false => "-".to_owned(),
            };
            let interval = or_none(row.interval);
            let interval = if interval == "-" { interval } else { format!("+-{interval}") };
            // What is told or assumed has no standard error.
            let standard_error = match row.standard_error > 0.0 {
                true => or_none(row.standard_error),
                false => row.origin.to_owned(),
            };
            [row.name, &value, unit, &standard_error, &interval].map(String::from).to_vec()
        }));
        text += &aligned(&rows, "  ");
        let correlated: Vec<String> = self
            .correlations
            .iter()
            .filter(|of| of.correlation.abs() >= CORRELATED)
            .map(|of| {
                format!("  {} with {}: {:.2}\n", of.parameters[0], of.parameters[1], of.correlation)
            })
            .collect();
        if !correlated.is_empty() {
            text += &format!("\nCorrelated beyond {CORRELATED}\n{}", correlated.concat());
        }
        let white = if self.autocorrelation.abs() < 0.1 { "white" } else { "not white" };
        text += &format!(
            "\nLeft over of the yaw rate: {:.3} deg/s, {white} (autocorrelation {:.2} after 0.1 s)\n",
            self.yaw_rate_left_over_rad_per_s.to_degrees(),
            self.autocorrelation
        );
        text += match self.lateral_acceleration {
            "unexplained" => {
                "Lateral acceleration is not used: more is left over of it than the sensor's noise (the body \
                 rolls, roads are banked).\n"
            }
            "not logged" => "Lateral acceleration is not logged: it would show the yaw inertia.\n",
            _ => "",
        };
        if self.parameters.iter().any(|row| row.estimate.origin == Origin::Pair) {
            text += "Offset and bias fit as a pair only: the other pairs along their line fit as well.\n";
        }
        text += &format!(
            "\n  {}\n  {}\n\nNext: steerguard design {}\n",
            self.specification.display(),
            self.plot.display(),
            self.specification.display()
        );
        text
    }
}

/// A value for people, and its unit.
fn stated(parameter: Parameter, value: f64) -> (String, &'static str) {
    match parameter.scale() {
        Scale::Degrees => (format!("{:.3}", value.to_degrees()), "deg"),
        Scale::DegreesPerSecond => (format!("{:.3}", value.to_degrees()), "deg/s"),
        Scale::Seconds => (format!("{:.1}", 1e3 * value), "ms"),
        Scale::Metres => (format!("{value:.2}"), "m"),
        Scale::MetresPerSecondSquared => (format!("{value:.3}"), "m/s^2"),
        Scale::Share => (format!("{value:.3}"), ""),
        Scale::Relative => match parameter {
            Parameter::SteeringRatio => (format!("{value:.2}"), ""),
            Parameter::YawInertia => (format!("{value:.0}"), "kg m^2"),
            _ => (format!("{value:.0}"), "N/rad"),
        },
    }
}
