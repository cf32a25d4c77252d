//! Parquet: the selected columns, a few rows at a time.

use std::fs::File;

use parquet::basic::{LogicalType, TimeUnit};
use parquet::column::reader::ColumnReader;
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader as _, SerializedFileReader};
use parquet::schema::types::ColumnDescriptor;

use super::row::{Header, RowError};
use crate::error::Cause;
use crate::unit::Unit;

/// Rows that are read together.
const ROWS: usize = 4096;

/// An open Parquet file.
pub(crate) struct Binary {
    /// The columns.
    pub(super) headers: Vec<Header>,
    file: SerializedFileReader<File>,
    selected: Vec<usize>,
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
        self.selected = columns.to_vec();
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
            let readers = self.selected.iter().map(|&column| group.get_column_reader(column));
            self.readers = readers.collect::<Result<_, _>>()?;
        }
        let columns = self.file.metadata().file_metadata().schema_descr();
        for (reader, (cells, &column)) in
            self.readers.iter_mut().zip(self.read.iter_mut().zip(&self.selected))
        {
            let column = columns.column(column);
            let is_list = column.max_rep_level() > 0;
            if is_list || !read(reader, column.max_def_level(), cells)? {
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
    let unit = match column.logical_type_ref() {
        Some(LogicalType::Timestamp(timestamp)) => Unit::parse(match timestamp.unit {
            TimeUnit::MILLIS => "ms",
            TimeUnit::MICROS => "us",
            TimeUnit::NANOS => "ns",
        }),
        _ => None,
    };
    Header { name: column.path().string(), unit }
}

/// Reads some cells of a column; false if it holds no numbers.
fn read(
    reader: &mut ColumnReader,
    max_level: i16,
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
    match reader {
        ColumnReader::DoubleColumnReader(reader) => numbers!(reader, |x: f64| x),
        ColumnReader::FloatColumnReader(reader) => numbers!(reader, f64::from),
        ColumnReader::Int32ColumnReader(reader) => numbers!(reader, f64::from),
        ColumnReader::Int64ColumnReader(reader) => numbers!(reader, |x: i64| x as f64),
        _ => return Ok(false),
    }
    Ok(true)
}
