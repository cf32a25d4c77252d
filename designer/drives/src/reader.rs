//! Rows of a drive in SI, one after the other.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};

use crate::choose::{Choice, Chosen};
use crate::columns::Columns;
use crate::error::{Cause, DriveError};
use crate::findings::{Finding, Sideways, Watch};
use crate::signal::{Signal, Wanted};
use crate::table::{RowError, Table};

/// Measured signals of a row.
pub(crate) const MEASURED: usize = Signal::MEASURED.len();

/// A row of a drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Its line from 1; of a Parquet file the row.
    pub line: u64,
    /// Time stamp, s.
    pub time_s: f64,
    /// The signals in the order of [`Signal::MEASURED`], in SI; NaN where the row has none.
    pub values: [f64; MEASURED],
}

/// Which signals rows have, and how late they are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layout {
    /// Whether a column is read for the signal, in the order of [`Signal::MEASURED`].
    pub present: [bool; MEASURED],
    /// How late it is, s.
    pub delays_s: [f64; MEASURED],
}

/// Rows that the unit of the time is judged by.
const FIRST_ROWS: usize = 256;
/// Time stamps beyond this either way are none, s: three thousand years.
const LATEST_S: f64 = 1e11;
/// Steps that no recording of a drive has, s: shorter, and longer.
const STEPS_S: [f64; 2] = [5e-5, 1.0];

/// Reads a drive row by row. Ends at the first error.
pub struct Reader {
    file: PathBuf,
    table: Table,
    chosen: Chosen,
    /// Place among the selected columns of each signal of [`Signal::ALL`].
    places: [Option<usize>; Signal::ALL.len()],
    cells: Vec<f64>,
    /// Rows that were read to judge them.
    first: VecDeque<Row>,
    watches: [Option<Watch>; MEASURED],
    sideways: Sideways,
    last: Option<Row>,
    rows: u64,
    repeated: Option<(u64, u64)>,
    ended: bool,
}

impl Reader {
    /// Opens the drive in the file at `path`, CSV or Parquet by its content, and chooses its columns: as
    /// told, or else by their names.
    ///
    /// # Errors
    /// [`DriveError`] if there is no such file or no drive in it, where the choice is not sure, and where the
    /// first rows show another unit of time.
    pub fn open(path: &Path, columns: &Columns, wanted: Wanted) -> Result<Self, DriveError> {
        let mut table = Table::open(path, columns.delimiter, columns.decimal_mark)?;
        let failed = |cause| DriveError::of(path, None, cause);
        if let [only] = table.headers() {
            return Err(failed(Cause::SingleColumn { name: only.name.clone() }));
        }
        let chosen = Chosen::choose(table.headers(), columns, wanted).map_err(failed)?;
        let mut places = [None; Signal::ALL.len()];
        let mut selected = Vec::new();
        for choice in chosen.choices() {
            places[choice.signal.index()] = Some(selected.len());
            selected.push(choice.column);
        }
        table.select(&selected);
        let mut reader = Self {
            file: path.to_owned(),
            table,
            places,
            cells: vec![f64::NAN; selected.len()],
            first: VecDeque::new(),
            watches: Signal::MEASURED.map(|signal| chosen.of(signal).map(Watch::new)),
            chosen,
            sideways: Sideways::default(),
            last: None,
            rows: 0,
            repeated: None,
            ended: false,
        };
        reader.read_first()?;
        Ok(reader)
    }

    /// The columns that are read.
    pub fn chosen(&self) -> &Chosen {
        &self.chosen
    }

    /// How the file is read, such as its delimiter.
    pub fn reading(&self) -> String {
        self.table.reading()
    }

    /// The file.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// Which signals its rows have, and how late they are.
    pub fn layout(&self) -> Layout {
        Layout {
            present: Signal::MEASURED.map(|signal| self.chosen.of(signal).is_some()),
            delays_s: Signal::MEASURED
                .map(|signal| self.chosen.of(signal).map_or(0.0, |choice| choice.delay_s)),
        }
    }

    /// Rows given so far.
    pub fn rows(&self) -> u64 {
        self.rows
    }

    /// What looks wrong in the rows given so far.
    pub fn findings(&self) -> Vec<Finding> {
        let mut findings: Vec<_> =
            self.watches.iter().flatten().flat_map(Watch::findings).collect();
        if let Some((line, number)) = self.repeated {
            let what = format!("{number} rows have the time of the row before, the first here");
            findings.push(Finding { line, what });
        }
        findings.sort_by_key(|finding| finding.line);
        findings
    }

    /// An error of this file.
    pub(crate) fn error(&self, line: Option<u64>, cause: Cause) -> DriveError {
        DriveError::of(&self.file, line, cause)
    }

    /// Reads the first rows and judges the unit of the time by them.
    fn read_first(&mut self) -> Result<(), DriveError> {
        let mut failure = None;
        while self.first.len() < FIRST_ROWS {
            match self.read() {
                Ok(Some(row)) => self.first.push_back(row),
                Ok(None) => break,
                // Rows before it are judged first: a wrong unit of the time is what to say then.
                Err(error) => {
                    failure = Some(error);
                    break;
                }
            }
        }
        let Some(Row { line, time_s, .. }) = self.first.front().copied() else {
            return Err(failure.unwrap_or_else(|| self.error(None, Cause::NoRows)));
        };
        let times = self.first.iter().map(|row| row.time_s);
        let mut steps: Vec<_> = times.clone().zip(times.skip(1)).map(|(a, b)| b - a).collect();
        steps.retain(|&step_s| step_s > 0.0);
        steps.sort_by(f64::total_cmp);
        if self.first.len() > 1 && steps.is_empty() && failure.is_none() {
            return Err(self.error(Some(line), Cause::TimeStands { time_s }));
        }
        let Some(&step_s) = steps.get(steps.len() / 2) else {
            return failure.map_or(Ok(()), Err);
        };
        let [shortest_s, longest_s] = STEPS_S;
        if !(shortest_s..=longest_s).contains(&step_s) {
            let time = self.chosen.of(Signal::Time);
            let unit = time.map_or(crate::Unit::SECOND, |time| time.unit);
            let likely = likely_unit(step_s / unit.in_si);
            // Stamps leave no choice of a unit.
            let is_number = time.is_none_or(|time| time.stamps.is_none());
            let likely = likely.filter(|&likely| is_number && likely != unit.symbol);
            return Err(self.error(Some(line), Cause::Step { step_s, unit, likely }));
        }
        failure.map_or(Ok(()), Err)
    }

    /// Reads a row of the file.
    fn read(&mut self) -> Result<Option<Row>, DriveError> {
        // Lines of blanks or delimiters alone are no rows.
        let next = loop {
            let next = self.table.next(&mut self.cells);
            if !matches!(next, Ok(Some(_))) || self.cells.iter().any(|cell| !cell.is_nan()) {
                break next;
            }
        };
        let line = match next {
            Ok(Some(line)) => line,
            Ok(None) => return Ok(None),
            Err(RowError::Other(cause)) => return Err(self.error(None, cause)),
            Err(RowError::Cell { line, place, text }) => {
                let cause = match self.chosen.choices().nth(place) {
                    Some(Choice { name, stamps: Some(form), .. }) => {
                        Cause::NotAStamp { name: name.clone(), text, form: *form }
                    }
                    Some(Choice { signal, name, .. }) => {
                        Cause::NotANumber { signal: *signal, name: name.clone(), text }
                    }
                    None => Cause::NotANumber { signal: Signal::Time, name: String::new(), text },
                };
                return Err(self.error(Some(line), cause));
            }
        };
        let value = |signal: Signal| match (self.places[signal.index()], self.chosen.of(signal)) {
            (Some(place), Some(choice)) => choice.in_si(self.cells[place]),
            _ => f64::NAN,
        };
        let time_s = value(Signal::Time);
        if time_s.is_nan() {
            return Err(self.error(Some(line), Cause::NoTime));
        }
        if time_s.abs() > LATEST_S {
            let (signal, hint) = (Signal::Time, String::new());
            return Err(self.error(Some(line), Cause::Impossible { signal, value: time_s, hint }));
        }
        Ok(Some(Row { line, time_s, values: Signal::MEASURED.map(value) }))
    }

    /// Looks at a row before it is given.
    fn watch(&mut self, row: &Row) -> Result<(), DriveError> {
        let Row { line, time_s, values } = *row;
        if let Some(last) = self.last.replace(*row) {
            if time_s < last.time_s {
                let cause = Cause::RunsBack { from_s: last.time_s, to_s: time_s };
                return Err(self.error(Some(line), cause));
            }
            // Rows of different messages may share a time.
            let shares = |(a, b): (&f64, &f64)| !a.is_nan() && !b.is_nan();
            if time_s == last.time_s && values.iter().zip(&last.values).any(shares) {
                let (_, number) = self.repeated.get_or_insert((line, 0));
                *number += 1;
            }
        }
        let watched = self.watches.iter_mut().zip(values).try_for_each(|(watch, value)| {
            watch.as_mut().map_or(Ok(()), |watch| watch.follow(time_s, line, value))
        });
        let together = match &self.watches {
            [Some(speed), Some(yaw_rate), ..] => self.sideways.follow(time_s, speed, yaw_rate),
            _ => Ok(()),
        };
        watched.and(together).map_err(|cause| self.error(Some(line), cause))
    }

    /// Whether every needed signal had a number.
    fn end(&self) -> Result<(), DriveError> {
        let needed =
            self.watches.iter().flatten().filter(|watch| watch.choice().signal.is_needed());
        let empty = needed.filter(|watch| watch.is_empty()).map(Watch::choice).next();
        match empty {
            Some(choice) => {
                let cause =
                    Cause::NothingInColumn { signal: choice.signal, name: choice.name.clone() };
                Err(self.error(None, cause))
            }
            None => Ok(()),
        }
    }
}

/// The unit of time in which recordings have a step like this.
fn likely_unit(step: f64) -> Option<&'static str> {
    [("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)]
        .into_iter()
        .find(|(_, in_s)| (9e-4..=0.5).contains(&(step * in_s)))
        .map(|(unit, _)| unit)
}

impl Iterator for Reader {
    type Item = Result<Row, DriveError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.ended {
            return None;
        }
        let row = match self.first.pop_front() {
            Some(row) => Ok(Some(row)),
            None => self.read(),
        };
        let watched = row.and_then(|row| match row {
            Some(row) => self.watch(&row).map(|()| Some(row)),
            None => self.end().map(|()| None),
        });
        self.ended = !matches!(watched, Ok(Some(_)));
        self.rows += u64::from(!self.ended);
        watched.transpose()
    }
}
