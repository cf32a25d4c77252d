//! CSV: any delimiter, either decimal mark.

use std::fs::File;
use std::io::{Read as _, Seek as _, SeekFrom};

use super::bounded::{Bounded, MAX_ROW_BYTES};
use super::dialect::{Dialect, is_none, number};
use super::row::{Header, RowError};
use crate::error::Cause;
use crate::stamp::{Stamp, Stamps};

/// Bytes that the dialect is found by.
const BEGIN: u64 = 1 << 17;

/// An open CSV file.
pub(crate) struct Text {
    /// The columns.
    pub(super) headers: Vec<Header>,
    delimiter: u8,
    decimal_mark: u8,
    lines_before: u64,
    reader: csv::Reader<Bounded>,
    record: csv::ByteRecord,
    /// Columns, and what stamps they hold.
    selected: Vec<(usize, Option<Stamps>)>,
}

impl Text {
    /// Finds out how `file` is a table.
    pub(super) fn new(
        mut file: File,
        delimiter: Option<u8>,
        decimal_mark: Option<u8>,
    ) -> Result<Self, Cause> {
        let mut begin = Vec::new();
        file.by_ref().take(BEGIN).read_to_end(&mut begin)?;
        if begin.starts_with(b"\xff\xfe") || begin.starts_with(b"\xfe\xff") {
            return Err(Cause::Format("text in UTF-16 (save it as UTF-8)"));
        }
        if begin.contains(&0) {
            return Err(Cause::Format("a binary file"));
        }
        if begin.len() as u64 == BEGIN {
            let Some(end) = begin.iter().rposition(|&byte| byte == b'\n') else {
                return Err(Cause::LongRow { from_line: 1, most: BEGIN });
            };
            begin.truncate(end);
        }
        let dialect = Dialect::find(&begin, delimiter, decimal_mark)?;
        file.seek(SeekFrom::Start(dialect.bytes_before))?;
        let reader = csv::ReaderBuilder::new()
            .delimiter(dialect.delimiter)
            .has_headers(false)
            .flexible(true)
            .quoting(dialect.quoted)
            .comment(Some(b'#'))
            .buffer_capacity(1 << 16)
            .from_reader(Bounded::new(file));
        Ok(Self {
            headers: dialect.headers,
            delimiter: dialect.delimiter,
            decimal_mark: dialect.decimal_mark,
            lines_before: dialect.lines_before,
            reader,
            record: csv::ByteRecord::new(),
            selected: Vec::new(),
        })
    }

    pub(super) fn reading(&self) -> String {
        let delimiter = match self.delimiter {
            b'\t' => "tab".into(),
            b' ' => "blank".into(),
            other => format!("`{}`", char::from(other)),
        };
        format!("CSV, delimiter {delimiter}, decimal mark `{}`", char::from(self.decimal_mark))
    }

    pub(super) fn select(&mut self, columns: &[usize]) {
        let stamps = |column: usize| self.headers[column].stamps.map(Stamps::new);
        self.selected = columns.iter().map(|&column| (column, stamps(column))).collect();
    }

    pub(super) fn next(&mut self, cells: &mut [f64]) -> Result<Option<u64>, RowError> {
        let from_line = self.reader.position().line() + self.lines_before;
        self.reader.get_mut().begin_row();
        match self.reader.read_byte_record(&mut self.record) {
            Ok(true) => {}
            Ok(false) => return Ok(None),
            Err(_) if self.reader.get_ref().is_exhausted() => {
                return Err(Cause::LongRow { from_line, most: MAX_ROW_BYTES }.into());
            }
            Err(error) => return Err(error.into()),
        }
        let line = self.record.position().map_or(0, csv::Position::line) + self.lines_before;
        for (place, (cell, (column, stamps))) in
            cells.iter_mut().zip(&mut self.selected).enumerate()
        {
            // A row that ends early has none of the rest.
            let bytes = self.record.get(*column).unwrap_or_default();
            let read = match stamps {
                None => number(bytes, self.decimal_mark),
                Some(_) if is_none(bytes) => Some(f64::NAN),
                Some(stamps) => Stamp::parse(bytes).and_then(|stamp| stamps.seconds(stamp)),
            };
            *cell = read.ok_or_else(|| RowError::Cell {
                line,
                place,
                text: String::from_utf8_lossy(bytes).trim().chars().take(40).collect(),
            })?;
        }
        Ok(Some(line))
    }
}
