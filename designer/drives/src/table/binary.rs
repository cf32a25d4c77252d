//! Parquet: the selected columns, a few rows at a time.

use std::fs::File;

use parquet::basic::{ConvertedType, LogicalType, TimeUnit, Type};
use parquet::column::reader::ColumnReader;
use parquet::data_type::Int96;
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader as _, SerializedFileReader};
use parquet::schema::types::ColumnDescriptor;

use super::row::{Header, RowError};
use crate::error::Cause;
use crate::stamp::{Stamp, StampForm, Stamps};

/// Rows that are read together.
const ROWS: usize = 4096;

/// An open Parquet file.
pub(crate) struct Binary {
    /// The columns.
    pub(super) headers: Vec<Header>,
    file: SerializedFileReader<File>,
    /// Columns, and what counts the stamps of those that hold some.
    selected: Vec<(usize, Option<Counter>)>,
    /// The row group that is read next.
    group: usize,
    /// Readers of the selected columns in the row group that is read.
    readers: Vec<ColumnReader>,
    /// Cells of the selected columns, column by column.
    read: Vec<Vec<f64>>,
    /// The row of `read` that is next.
    next: usize,
    rows: u64,
}

impl Binary {
    /// Reads what `file` says of itself.
    pub(super) fn new(file: File) -> Result<Self, Cause> {
        let file = SerializedFileReader::new(file)?;
        let metadata = file.metadata().file_metadata();
        if metadata.num_rows() == 0 {
            return Err(Cause::NoRows);
        }
        let columns = metadata.schema_descr().columns().iter();
        let headers = columns.map(|column| header(column)).collect();
        Ok(Self {
            headers,
            file,
            selected: Vec::new(),
            group: 0,
            readers: Vec::new(),
            read: Vec::new(),
            next: 0,
            rows: 0,
        })
    }

    pub(super) fn select(&mut self, columns: &[usize]) {
        let schema = self.file.metadata().file_metadata().schema_descr();
        let counter = |column: usize| Counter::of(&schema.column(column));
        self.selected = columns.iter().map(|&column| (column, counter(column))).collect();
        self.read = vec![Vec::new(); columns.len()];
    }

    pub(super) fn next(&mut self, cells: &mut [f64]) -> Result<Option<u64>, RowError> {
        while self.read.first().is_none_or(|column| self.next >= column.len()) {
            if !self.read_more()? {
                return Ok(None);
            }
        }
        for (cell, column) in cells.iter_mut().zip(&self.read) {
            let read = column.get(self.next).copied().unwrap_or(f64::NAN);
            *cell = if read.is_finite() { read } else { f64::NAN };
        }
        self.next += 1;
        self.rows += 1;
        Ok(Some(self.rows))
    }

    /// Reads some rows; false at the end.
    fn read_more(&mut self) -> Result<bool, Cause> {
        self.next = 0;
        self.read.iter_mut().for_each(Vec::clear);
        if self.readers.is_empty() {
            if self.group == self.file.num_row_groups() || self.selected.is_empty() {
                return Ok(false);
            }
            let group = self.file.get_row_group(self.group)?;
            self.group += 1;
            let readers = self.selected.iter().map(|(column, _)| group.get_column_reader(*column));
            self.readers = readers.collect::<Result<_, _>>()?;
        }
        let columns = self.file.metadata().file_metadata().schema_descr();
        for (reader, (cells, (column, counter))) in
            self.readers.iter_mut().zip(self.read.iter_mut().zip(&mut self.selected))
        {
            let column = columns.column(*column);
            let is_list = column.max_rep_level() > 0;
            if is_list || !read(reader, column.max_def_level(), counter, cells)? {
                return Err(Cause::NoNumbers { name: column.path().string() });
            }
        }
        if self.read.iter().all(Vec::is_empty) {
            self.readers.clear();
        }
        Ok(true)
    }
}

/// What the schema says of a column.
fn header(column: &ColumnDescriptor) -> Header {
    let stamps = Counter::of(column).map(|counter| counter.form);
    Header { name: column.path().string(), unit: None, stamps }
}

/// What makes times of the counts that a column of time stamps holds.
struct Counter {
    form: StampForm,
    /// Nanoseconds of one.
    unit_ns: i64,
    stamps: Stamps,
}

impl Counter {
    /// That of a column, if it holds time stamps.
    fn of(column: &ColumnDescriptor) -> Option<Self> {
        let ns = |unit: &TimeUnit| match unit {
            TimeUnit::MILLIS => 1_000_000,
            TimeUnit::MICROS => 1000,
            TimeUnit::NANOS => 1,
        };
        let dated = |zoned: bool| if zoned { StampForm::Zoned } else { StampForm::Dated };
        // Older files have the converted type alone, or 96 bits.
        let (form, unit_ns) = match (column.logical_type_ref(), column.converted_type()) {
            (Some(LogicalType::Timestamp(stamp)), _) => {
                (dated(stamp.is_adjusted_to_u_t_c), ns(&stamp.unit))
            }
            (Some(LogicalType::Time(clock)), _) => (StampForm::Clock, ns(&clock.unit)),
            (None, ConvertedType::TIMESTAMP_MILLIS) => (StampForm::Zoned, 1_000_000),
            (None, ConvertedType::TIMESTAMP_MICROS) => (StampForm::Zoned, 1000),
            (None, ConvertedType::TIME_MILLIS) => (StampForm::Clock, 1_000_000),
            (None, ConvertedType::TIME_MICROS) => (StampForm::Clock, 1000),
            _ if column.physical_type() == Type::INT96 => (StampForm::Dated, 1),
            _ => return None,
        };
        Some(Self { form, unit_ns, stamps: Stamps::new(form) })
    }

    /// The time of a count, s.
    fn seconds(&mut self, count: i64) -> f64 {
        let stamp = count.checked_mul(self.unit_ns).map(|ns| Stamp::of_ns(self.form, ns));
        stamp.and_then(|stamp| self.stamps.seconds(stamp)).unwrap_or(f64::NAN)
    }
}

/// Reads some cells of a column; false if it holds no numbers.
fn read(
    reader: &mut ColumnReader,
    max_level: i16,
    counter: &mut Option<Counter>,
    cells: &mut Vec<f64>,
) -> Result<bool, ParquetError> {
    // A macro, as the readers of the types are no trait.
    macro_rules! numbers {
        ($reader:expr, $as_number:expr) => {{
            let (mut levels, mut values) = (Vec::new(), Vec::new());
            let defined = (max_level > 0).then_some(&mut levels);
            $reader.read_records(ROWS, defined, None, &mut values)?;
            let mut values = values.into_iter().map($as_number);
            if max_level > 0 {
                let cell = |&level: &i16| {
                    if level == max_level { values.next().unwrap_or(f64::NAN) } else { f64::NAN }
                };
                cells.extend(levels.iter().map(cell));
            } else {
                cells.extend(values);
            }
        }};
    }
    let mut count = |count: i64| match counter {
        Some(counter) => counter.seconds(count),
        None => count as f64,
    };
    match reader {
        ColumnReader::DoubleColumnReader(reader) => numbers!(reader, |x: f64| x),
        ColumnReader::FloatColumnReader(reader) => numbers!(reader, f64::from),
        ColumnReader::Int32ColumnReader(reader) => numbers!(reader, |x: i32| count(x.into())),
        ColumnReader::Int64ColumnReader(reader) => numbers!(reader, count),
        ColumnReader::Int96ColumnReader(reader) => numbers!(reader, |x: Int96| count(x.to_nanos())),
        _ => return Ok(false),
    }
    Ok(true)
}
