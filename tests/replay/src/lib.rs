//! Frozen traces: what the detector gives for recorded inputs, every output of every sample, exact.
//!
//! Each folder of `recorded` holds a configuration as it was once designed and drives: inputs, and the
//! outputs that the detector had for them. Nothing here is designed anew, so a difference is a change of
//! the detector's own behaviour.
//!
//! # Conventions
//! - Numbers are written as the shortest text that reads back bit for bit: equal text is equal bits.
//! - `configuration.json` is a [`Configuration`], the key `detector` of a design file.

use std::collections::BTreeMap;
use std::fmt;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use steerguard_detector::{
    Configuration, ConfigurationError, Detector, FaultEstimate, Input, Measurement, Output,
};

/// Columns of a drive's inputs.
pub const INPUTS: [&str; 4] = ["v_x_m_per_s", "r_rad_per_s", "t_eng_n_m", "delta_rad"];

const INPUTS_ENDING: &str = ".inputs.csv";
const OUTPUTS_ENDING: &str = ".outputs.csv";

/// Why traces cannot be read, run or written: the file, and the reason.
#[derive(Debug, thiserror::Error)]
#[error("{}: {reason}", file.display())]
pub struct TraceError {
    file: PathBuf,
    reason: Reason,
}

#[derive(Debug, thiserror::Error)]
enum Reason {
    #[error(transparent)]
    Io(#[from] io::Error),
    #[error(transparent)]
    Json(#[from] serde_json::Error),
    #[error(transparent)]
    Csv(#[from] csv::Error),
    #[error(transparent)]
    Configuration(#[from] ConfigurationError),
    #[error("columns {found:?} instead of {expected:?}")]
    Columns { found: Vec<String>, expected: Vec<String> },
}

impl Reason {
    fn of(self, file: &Path) -> TraceError {
        TraceError { file: file.to_path_buf(), reason: self }
    }
}

/// Adds the file to an error.
fn at<T, E: Into<Reason>>(file: &Path, result: Result<T, E>) -> Result<T, TraceError> {
    result.map_err(|reason| reason.into().of(file))
}

/// A table of texts: outputs as they are stored.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Table {
    /// Names of the columns.
    pub columns: Vec<String>,
    /// A row for each sample.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// The table of `outputs`.
    pub fn of(outputs: &[Output]) -> Self {
        Self {
            columns: fields(&Output::default()).map(|(column, _)| column.to_owned()).to_vec(),
            rows: outputs.iter().map(|output| fields(output).map(|(_, x)| x).to_vec()).collect(),
        }
    }
}

/// An output's fields by name, exact.
fn fields(output: &Output) -> [(&'static str, String); 16] {
    let Output {
        residual,
        v_y_hat,
        j_rms,
        j_th,
        detectability,
        alarm,
        alarm_cause,
        monitor,
        state_cause,
        first_alarm,
        second_ratio,
        estimate,
    } = output;
    let Measurement { v_x_m_per_s, r_rad_per_s } = residual;
    let real = |x: &f64| format!("{x:?}");
    let estimated =
        |of: fn(&FaultEstimate) -> String| estimate.as_ref().map_or_else(String::new, of);
    [
        ("residual_v_x_m_per_s", real(v_x_m_per_s)),
        ("residual_r_rad_per_s", real(r_rad_per_s)),
        ("v_y_hat_m_per_s", real(v_y_hat)),
        ("j_rms", real(j_rms)),
        ("j_th", real(j_th)),
        ("detectability", real(detectability)),
        ("alarm", alarm.to_string()),
        ("alarm_cause", format!("{alarm_cause:?}")),
        ("monitor", format!("{monitor:?}")),
        ("state_cause", format!("{state_cause:?}")),
        ("first_alarm", first_alarm.map_or_else(String::new, |sample| sample.to_string())),
        ("second_ratio", real(second_ratio)),
        ("fault_estimate_rad", estimated(|x| format!("{:?}", x.fault_rad))),
        ("fault_estimate_bound_rad", estimated(|x| format!("{:?}", x.bound_rad))),
        ("fault_onset", estimated(|x| x.onset.to_string())),
        ("fault_hypothesis", estimated(|x| format!("{:?}", x.hypothesis))),
    ]
}

/// A drive and its stored outputs.
#[derive(Clone, Debug)]
pub struct Trace {
    /// Folder of the configuration.
    pub configuration_name: String,
    /// Name of the drive.
    pub drive: String,
    /// What the detector is told.
    pub configuration: Configuration,
    /// [`INPUTS`] of each sample.
    pub inputs: Vec<[f64; 4]>,
    /// Where the outputs are stored.
    outputs_file: PathBuf,
}

impl Trace {
    /// All traces of the folder `recorded`, by name.
    ///
    /// # Errors
    /// [`TraceError`] for the first file that cannot be read.
    pub fn all(recorded: &Path) -> Result<Vec<Self>, TraceError> {
        let mut traces = BTreeMap::new();
        for folder in at(recorded, fs::read_dir(recorded))? {
            let folder = at(recorded, folder)?.path();
            if !folder.is_dir() {
                continue;
            }
            let configuration = read_configuration(&folder.join("configuration.json"))?;
            let configuration_name = name(&folder);
            for file in at(&folder, fs::read_dir(&folder))? {
                let file = at(&folder, file)?.path();
                if let Some(drive) = name(&file).strip_suffix(INPUTS_ENDING) {
                    let trace = Self {
                        configuration_name: configuration_name.clone(),
                        drive: drive.to_owned(),
                        configuration,
                        inputs: read_inputs(&file)?,
                        outputs_file: folder.join(format!("{drive}{OUTPUTS_ENDING}")),
                    };
                    traces.insert((configuration_name.clone(), drive.to_owned()), trace);
                }
            }
        }
        Ok(traces.into_values().collect())
    }

    /// The detector's outputs.
    ///
    /// # Errors
    /// [`TraceError`] if the detector refuses the configuration.
    pub fn run(&self) -> Result<Vec<Output>, TraceError> {
        let mut detector = at(&self.outputs_file, Detector::new(&self.configuration))?;
        let run = |&[v_x_m_per_s, r_rad_per_s, t_eng_n_m, delta_rad]: &[f64; 4]| {
            let y = Measurement { v_x_m_per_s, r_rad_per_s };
            *detector.sample(y, Input { t_eng_n_m, delta_rad })
        };
        Ok(self.inputs.iter().map(run).collect())
    }

    /// The outputs as stored; an empty table for a drive that has none yet.
    ///
    /// # Errors
    /// [`TraceError`] if they cannot be read.
    pub fn stored(&self) -> Result<Table, TraceError> {
        let file = &self.outputs_file;
        if !file.exists() {
            return Ok(Table::default());
        }
        let mut reader = at(file, csv::Reader::from_path(file))?;
        let columns = at(file, reader.headers())?.iter().map(str::to_owned).collect();
        let rows = reader.records().map(|row| Ok(row?.iter().map(str::to_owned).collect()));
        Ok(Table { columns, rows: at(file, rows.collect::<Result<_, csv::Error>>())? })
    }

    /// Stores `outputs`.
    ///
    /// # Errors
    /// [`TraceError`] if they cannot be written.
    pub fn store(&self, outputs: &Table) -> Result<(), TraceError> {
        let file = &self.outputs_file;
        let mut writer = at(file, csv::Writer::from_path(file))?;
        for row in std::iter::once(&outputs.columns).chain(&outputs.rows) {
            at(file, writer.write_record(row))?;
        }
        at(file, writer.flush())
    }

    /// Where what is stored differs from `now`.
    ///
    /// # Errors
    /// [`TraceError`] if it cannot be read.
    pub fn differences(&self, now: &Table) -> Result<Differences, TraceError> {
        Ok(Differences {
            trace: format!("{}/{}", self.configuration_name, self.drive),
            found: differences(&self.stored()?, now),
        })
    }
}

/// How a trace differs from what is stored, readable.
#[derive(Clone, Debug, PartialEq)]
pub struct Differences {
    /// Configuration and drive.
    pub trace: String,
    /// Each variable that differs, or the shape.
    pub found: Vec<Difference>,
}

/// A difference between tables.
#[derive(Clone, Debug, PartialEq)]
pub enum Difference {
    /// Other columns or another number of rows.
    Shape {
        /// Columns and number of rows stored.
        stored: (Vec<String>, usize),
        /// The same now.
        now: (Vec<String>, usize),
    },
    /// A variable.
    Variable {
        /// Name.
        name: String,
        /// First sample that differs.
        sample: usize,
        /// Value stored for that sample.
        stored: String,
        /// Value now.
        now: String,
        /// Number of samples that differ.
        count: usize,
        /// Of how many.
        of: usize,
        /// Largest `|now - stored| / |stored|` and its sample; None where no two values are both finite
        /// numbers.
        largest_relative: Option<(f64, usize)>,
    },
}

fn differences(stored: &Table, now: &Table) -> Vec<Difference> {
    if stored.columns != now.columns || stored.rows.len() != now.rows.len() {
        let shape = |table: &Table| (table.columns.clone(), table.rows.len());
        return vec![Difference::Shape { stored: shape(stored), now: shape(now) }];
    }
    let variable = |(column, name): (usize, &String)| {
        let pairs: Vec<(usize, &str, &str)> = stored
            .rows
            .iter()
            .zip(&now.rows)
            .enumerate()
            .filter_map(|(sample, (old, new))| Some((sample, old.get(column)?, new.get(column)?)))
            .filter(|(_, old, new)| old != new)
            .map(|(sample, old, new)| (sample, old.as_str(), new.as_str()))
            .collect();
        let &(sample, old, new) = pairs.first()?;
        let relative = |&(sample, old, new): &(usize, &str, &str)| {
            let (old, new) = (old.parse::<f64>().ok()?, new.parse::<f64>().ok()?);
            let relative = (new - old).abs() / old.abs();
            relative.is_finite().then_some((relative, sample))
        };
        Some(Difference::Variable {
            name: name.clone(),
            sample,
            stored: old.to_owned(),
            now: new.to_owned(),
            count: pairs.len(),
            of: now.rows.len(),
            largest_relative: pairs.iter().filter_map(relative).max_by(|a, b| a.0.total_cmp(&b.0)),
        })
    };
    now.columns.iter().enumerate().filter_map(variable).collect()
}

impl fmt::Display for Differences {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:", self.trace)?;
        if self.found.is_empty() {
            return f.write_str(" as stored");
        }
        self.found.iter().try_for_each(|difference| write!(f, "\n  {difference}"))
    }
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Shape { stored: (stored_columns, stored_rows), now: (columns, rows) } => write!(
                f,
                "stored {stored_rows} samples of {}, now {rows} of {}",
                stored_columns.join(", "),
                columns.join(", ")
            ),
            Self::Variable { name, sample, stored, now, count, of, largest_relative } => {
                write!(
                    f,
                    "{name}: {count} of {of} samples differ, first {sample}: \
                     stored \"{stored}\", now \"{now}\""
                )?;
                match largest_relative {
                    Some((relative, sample)) => {
                        write!(f, "; largest relative difference {relative:.1e}, at {sample}")
                    }
                    None => Ok(()),
                }
            }
        }
    }
}

fn name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

fn read_configuration(file: &Path) -> Result<Configuration, TraceError> {
    let configuration = at(file, fs::read_to_string(file))?;
    at(file, serde_json::from_str(&configuration))
}

fn read_inputs(file: &Path) -> Result<Vec<[f64; 4]>, TraceError> {
    let mut reader = at(file, csv::Reader::from_path(file))?;
    let columns = at(file, reader.headers())?;
    if columns != INPUTS.as_slice() {
        let owned = |texts: &mut dyn Iterator<Item = &str>| texts.map(str::to_owned).collect();
        let (found, expected) = (owned(&mut columns.iter()), owned(&mut INPUTS.into_iter()));
        return Err(Reason::Columns { found, expected }.of(file));
    }
    at(file, reader.deserialize().collect::<Result<_, _>>())
}
