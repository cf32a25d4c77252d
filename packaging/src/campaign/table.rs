//! Tables as Parquet files, and the rows of a campaign as one of them, a row a drive.
//!
//! # Conventions
//! Columns of a campaign's rows have the names of the fields of [`DriveRecord`] and [`Outcome`], units in the
//! names. The bytes depend on rows and metadata only. Uncompressed: any reader can read it.

use std::io::Write;
use std::sync::Arc;

use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::{Type, TypePtr};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::drive_record::DriveRecord;
use super::outcome::Outcome;
use super::record::{Kind, Value};

/// Rows of a row group.
const GROUP: usize = 1 << 16;

/// A drive and what it showed.
#[derive(Clone, Debug, PartialEq, JsonSchema, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// What was driven.
    pub drive: DriveRecord,
    /// What it showed.
    pub outcome: Outcome,
}

/// Name, type and cell of a column of records `R`.
pub type Column<R> = (&'static str, Kind, Box<dyn Fn(&R) -> Value>);

fn columns() -> Vec<Column<Row>> {
    let drive = DriveRecord::COLUMNS.iter().map(|&(name, kind, cell)| -> Column<Row> {
        (name, kind, Box::new(move |row| cell(&row.drive)))
    });
    let outcome = Outcome::COLUMNS.iter().map(|&(name, kind, cell)| -> Column<Row> {
        (name, kind, Box::new(move |row| cell(&row.outcome)))
    });
    drive.chain(outcome).collect()
}

/// The bytes of the Parquet file of `rows`, with `metadata` under the key `steerguard-campaign`.
///
/// # Errors
/// [`ParquetError`], for none that rows can cause.
pub fn parquet(rows: &[Row], metadata: String) -> Result<Vec<u8>, ParquetError> {
    let mut table = Table::new(Vec::new(), "drive", columns(), metadata)?;
    for rows in rows.chunks(GROUP) {
        table.write(rows)?;
    }
    table.finish()
}

/// A table of records `R` that is being written.
pub struct Table<R, W: Write + Send> {
    columns: Vec<Column<R>>,
    file: SerializedFileWriter<W>,
}

impl<R, W: Write + Send> Table<R, W> {
    /// Begins a table of records called `name`, with `metadata` under the key `steerguard-campaign`.
    ///
    /// # Errors
    /// [`ParquetError`] if `sink` cannot be written.
    pub fn new(
        sink: W,
        name: &str,
        columns: Vec<Column<R>>,
        metadata: String,
    ) -> Result<Self, ParquetError> {
        let fields = columns.iter().map(|(name, kind, _)| field(name, *kind));
        let schema = Type::group_type_builder(name)
            .with_fields(fields.collect::<Result<_, _>>()?)
            .build()?;
        let metadata = KeyValue::new("steerguard-campaign".to_owned(), metadata);
        let properties = WriterProperties::builder()
            .set_key_value_metadata(Some(vec![metadata]))
            .set_dictionary_enabled(false)
            .build();
        let file = SerializedFileWriter::new(sink, Arc::new(schema), Arc::new(properties))?;
        Ok(Self { columns, file })
    }

    /// Adds `records` as a row group.
    ///
    /// # Errors
    /// [`ParquetError`] if the sink cannot be written.
    pub fn write(&mut self, records: &[R]) -> Result<(), ParquetError> {
        let mut group = self.file.next_row_group()?;
        for (_, kind, cell) in &self.columns {
            let Some(mut column) = group.next_column()? else { break };
            write(&mut column, *kind, records.iter().map(cell))?;
            column.close()?;
        }
        group.close()?;
        Ok(())
    }

    /// Ends the table and returns the sink.
    ///
    /// # Errors
    /// [`ParquetError`] if the sink cannot be written.
    pub fn finish(self) -> Result<W, ParquetError> {
        self.file.into_inner()
    }
}

/// The schema of a column.
fn field(name: &str, kind: Kind) -> Result<TypePtr, ParquetError> {
    let (physical, logical, repetition) = match kind {
        Kind::Integer => (Physical::INT64, None, Repetition::REQUIRED),
        Kind::Real => (Physical::DOUBLE, None, Repetition::REQUIRED),
        Kind::OptionalReal => (Physical::DOUBLE, None, Repetition::OPTIONAL),
        Kind::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String), Repetition::REQUIRED),
    };
    let field = Type::primitive_type_builder(name, physical)
        .with_logical_type(logical)
        .with_repetition(repetition)
        .build()?;
    Ok(Arc::new(field))
}

/// Writes the cells of a column.
fn write(
    column: &mut SerializedColumnWriter<'_>,
    kind: Kind,
    cells: impl Iterator<Item = Value>,
) -> Result<(), ParquetError> {
    let (mut integers, mut reals, mut texts, mut present) = (vec![], vec![], vec![], vec![]);
    for cell in cells {
        match cell {
            Value::Integer(value) => integers.push(value),
            Value::Real(value) => {
                present.push(i16::from(value.is_some()));
                reals.extend(value);
            }
            Value::Text(value) => texts.push(ByteArray::from(value)),
        }
    }
    match kind {
        Kind::Integer => column.typed::<Int64Type>().write_batch(&integers, None, None),
        Kind::Real => column.typed::<DoubleType>().write_batch(&reals, None, None),
        Kind::OptionalReal => {
            column.typed::<DoubleType>().write_batch(&reals, Some(&present), None)
        }
        Kind::Text => column.typed::<ByteArrayType>().write_batch(&texts, None, None),
    }?;
    Ok(())
}
