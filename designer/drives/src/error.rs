//! Why a drive cannot be read.

use std::path::{Path, PathBuf};

use crate::signal::Signal;
use crate::stamp::StampForm;
use crate::unit::Unit;

/// Why a drive cannot be read, and where.
#[derive(Debug, thiserror::Error)]
#[error("`{}`{}: {cause}", file.display(), at(*line))]
pub struct DriveError {
    /// The file.
    pub file: PathBuf,
    /// The line from 1; of a Parquet file the row.
    pub line: Option<u64>,
    /// What is wrong.
    pub cause: Box<Cause>,
}

fn at(line: Option<u64>) -> String {
    line.map_or(String::new(), |line| format!(" line {line}"))
}

impl DriveError {
    /// `cause` in `file`.
    pub(crate) fn of(file: &Path, line: Option<u64>, cause: impl Into<Cause>) -> Self {
        Self { file: file.to_owned(), line, cause: Box::new(cause.into()) }
    }
}

/// What is wrong with a drive.
#[derive(Debug, thiserror::Error)]
pub enum Cause {
    /// The file cannot be read.
    #[error("cannot be read: {0}")]
    Read(#[from] std::io::Error),
    /// The text is not made of rows.
    #[error("is no table of text: {0}")]
    Csv(#[from] csv::Error),
    /// The Parquet file is damaged, or has what is not read here.
    #[error("is no Parquet file that can be read: {0}")]
    Parquet(#[from] parquet::errors::ParquetError),
    /// Another format.
    #[error("is {0}, not CSV or Parquet")]
    Format(&'static str),
    /// What is no file of bytes.
    #[error("is {0}")]
    NoFile(&'static str),
    /// A row without end.
    #[error(
        "has more than {most} bytes in the row from line {from_line} on, the most that is read of one"
    )]
    LongRow {
        /// Its first line.
        from_line: u64,
        /// What is read.
        most: u64,
    },
    /// Nothing in it.
    #[error("is empty")]
    Empty,
    /// A header without rows.
    #[error("has no rows of numbers")]
    NoRows,
    /// One column only.
    #[error("has a single column, `{name}`: no delimiter is found")]
    SingleColumn {
        /// Its name.
        name: String,
    },
    /// A column that is told is not there.
    #[error("{signal}: there is no column `{name}`; there are {}", listed(columns))]
    NoColumn {
        /// Of what.
        signal: Signal,
        /// What is told.
        name: String,
        /// Names of the columns.
        columns: Vec<String>,
    },
    /// No column looks like a signal.
    #[error("{signal}: no column is surely it; there are {}", listed(columns))]
    NotFound {
        /// Of what.
        signal: Signal,
        /// Names of the columns.
        columns: Vec<String>,
    },
    /// Several columns look like a signal.
    #[error("{signal}: it may be any of {}", listed(columns))]
    Ambiguous {
        /// Of what.
        signal: Signal,
        /// Names of the columns.
        columns: Vec<String>,
    },
    /// Nothing says the unit.
    #[error("{signal}: nothing says the unit of column `{name}`")]
    NoUnit {
        /// Of what.
        signal: Signal,
        /// The column.
        name: String,
    },
    /// Its name or the file says a unit of something else.
    #[error("{signal}: column `{name}` is in {unit}, which is no unit of it")]
    OtherUnit {
        /// Of what.
        signal: Signal,
        /// The column.
        name: String,
        /// Its unit.
        unit: Unit,
    },
    /// A column of time stamps that is told to be another signal, or to have a unit.
    #[error(
        "{signal}: column `{name}` holds stamps of {form}, {}",
        unit.map_or("which are the time".into(), |unit| format!("not numbers in {unit}"))
    )]
    Stamps {
        /// Of what.
        signal: Signal,
        /// The column.
        name: String,
        /// What it holds.
        form: StampForm,
        /// What is told.
        unit: Option<Unit>,
    },
    /// Two signals of one column.
    #[error("{signal} and {other} are told to be the same column `{name}`")]
    Twice {
        /// A signal.
        signal: Signal,
        /// Another.
        other: Signal,
        /// The column.
        name: String,
    },
    /// A column of a Parquet file that holds no numbers.
    #[error("column `{name}` holds no numbers")]
    NoNumbers {
        /// The column.
        name: String,
    },
    /// A cell that is no number.
    #[error("{signal}: `{text}` in column `{name}` is no number")]
    NotANumber {
        /// Of what.
        signal: Signal,
        /// The column.
        name: String,
        /// The cell.
        text: String,
    },
    /// A cell that is no time stamp as those before it.
    #[error("time: `{text}` in column `{name}` is no stamp of {form}")]
    NotAStamp {
        /// The column.
        name: String,
        /// The cell.
        text: String,
        /// What stamps the column holds.
        form: StampForm,
    },
    /// A signal without any number.
    #[error("{signal}: column `{name}` has no number at all")]
    NothingInColumn {
        /// Of what.
        signal: Signal,
        /// The column.
        name: String,
    },
    /// A time stamp that is none.
    #[error("the time stamp is missing")]
    NoTime,
    /// Time that runs back.
    #[error("time runs back, from {from_s} s to {to_s} s")]
    RunsBack {
        /// Before.
        from_s: f64,
        /// After.
        to_s: f64,
    },
    /// Time that stands.
    #[error("time never changes from {time_s} s")]
    TimeStands {
        /// The time.
        time_s: f64,
    },
    /// Rows too far from each other, or too near.
    #[error(
        "time goes by {step_s} s a row, read in {unit}: it {}",
        likely.map_or("is no recording of a drive".into(), |unit| format!("looks like {unit}"))
    )]
    Step {
        /// Median.
        step_s: f64,
        /// What the time was read in.
        unit: Unit,
        /// What it is likely to be in.
        likely: Option<&'static str>,
    },
    /// A value that no car has.
    #[error("{signal}: {value} {} is not possible{hint}", signal.quantity().si())]
    Impossible {
        /// Of what.
        signal: Signal,
        /// In SI.
        value: f64,
        /// What it looks like, after a colon; or nothing.
        hint: String,
    },
    /// Speed and yaw rate that no tyre holds.
    #[error(
        "speed and yaw rate make {acceleration_m_per_s2:.0} m/s^2 to the side for a second: one of their \
         units is wrong{hint}"
    )]
    Sideways {
        /// v_x r.
        acceleration_m_per_s2: f64,
        /// What it looks like, after a colon; or nothing.
        hint: String,
    },
    /// More than is taken at once.
    #[error("there are more than {:.1} h of drive: so much is not taken at once", longest_s / 3600.0)]
    TooLong {
        /// What is, s.
        longest_s: f64,
    },
    /// Gaps everywhere.
    #[error("nowhere are two rows with all signals less than {gap_s} s apart")]
    NoPiece {
        /// The longest gap that is bridged.
        gap_s: f64,
    },
}

/// Names of columns, of many the first.
fn listed(columns: &[String]) -> String {
    const SHOWN: usize = 40;
    let names: Vec<_> = columns.iter().take(SHOWN).map(|name| format!("`{name}`")).collect();
    match columns.len() - names.len() {
        0 => names.join(", "),
        more => format!("{} and {more} more", names.join(", ")),
    }
}

impl Cause {
    /// What to do about it.
    pub fn help(&self) -> Option<String> {
        let flag = |signal: Signal, name: &str| {
            let unit = signal.quantity().units().collect::<Vec<_>>().join(", ");
            format!("--{} '{name}:UNIT', with one of {unit}", signal.flag())
        };
        Some(match self {
            Self::Format(_) => {
                "docs/drive-files.md has recipes that make CSV of MDF4 and MAT files".into()
            }
            Self::NoFile(_) => {
                "name a file, CSV or Parquet: drives are read twice, which pipes do not allow"
                    .into()
            }
            Self::LongRow { .. } => {
                "end each row with a new line, and close each quotation mark in its row".into()
            }
            Self::SingleColumn { .. } => "--delimiter says what stands between cells".into(),
            Self::NoColumn { signal, name, columns } => {
                let nearest = columns
                    .iter()
                    .map(|column| (strsim::normalized_damerau_levenshtein(column, name), column))
                    .max_by(|a, b| a.0.total_cmp(&b.0))
                    .filter(|(likeness, _)| *likeness > 0.6);
                match nearest {
                    Some((_, column)) => format!("--{} '{column}'?", signal.flag()),
                    None => format!("--{} NAME:UNIT names another", signal.flag()),
                }
            }
            Self::NotFound { signal, .. } | Self::Ambiguous { signal, .. } => flag(*signal, "NAME"),
            Self::NoUnit { signal, name } | Self::OtherUnit { signal, name, .. } => {
                flag(*signal, name)
            }
            Self::Twice { signal, .. } => format!("--{} names another column", signal.flag()),
            Self::NotANumber { text, .. } if text.contains(',') => {
                "--decimal-mark , reads numbers with a decimal comma".into()
            }
            Self::NotANumber { signal: Signal::Time, .. } => {
                "time stamps are numbers in s, ms, us or ns, or all such as 2026-03-01T12:00:00.010 or \
                 12:00:00.010; --time NAME:UNIT names another column"
                    .into()
            }
            Self::NotAStamp { form, .. } => format!(
                "stamps are all as the first one, such as {}",
                match form {
                    StampForm::Zoned => "2026-03-01T12:00:00.010+01:00",
                    StampForm::Dated => "2026-03-01 12:00:00.010",
                    StampForm::Clock => "12:00:00.010",
                }
            ),
            Self::Stamps { signal: Signal::Time, name, .. } => format!("--time '{name}' without a unit"),
            Self::Stamps { signal, .. } => format!("--{} names another column", signal.flag()),
            Self::RunsBack { .. } => {
                "sort the rows by time, or split the file where another recording begins".into()
            }
            Self::Step { likely: Some(unit), .. } => {
                format!("--time NAME:{unit} says so")
            }
            Self::Impossible { signal, .. } => flag(*signal, "NAME"),
            Self::Sideways { .. } => "--speed NAME:UNIT and --yaw NAME:UNIT say the units".into(),
            Self::TooLong { .. } => {
                "give less: an hour with standstill, slow turns and quick steering says as much"
                    .into()
            }
            Self::NoPiece { .. } => "--gap S bridges longer gaps".into(),
            _ => return None,
        })
    }
}
