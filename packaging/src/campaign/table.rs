//! The rows of a campaign as one Parquet file, a row a drive.
//!
//! # Conventions
//! Columns have the names of the fields of [`Drive`] and [`Outcome`], units in the names. The bytes
//! depend on rows and metadata only. Uncompressed: rows are few, and any reader can read it.

use std::sync::Arc;

use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::{Type, TypePtr};
use serde::{Deserialize, Serialize};

use super::drive::Drive;
use super::outcome::Outcome;
use super::record::{Kind, Value};

/// Rows of a row group.
const GROUP: usize = 1 << 16;

/// A drive and what it showed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// What was driven.
    pub drive: Drive,
    /// What it showed.
    pub outcome: Outcome,
}

/// Name, type and cell of a column.
type Column = (&'static str, Kind, Box<dyn Fn(&Row) -> Value>);

fn columns() -> Vec<Column> {
    let drive = Drive::COLUMNS.iter().map(|&(name, kind, cell)| -> Column {
        (name, kind, Box::new(move |row| cell(&row.drive)))
    });
    let outcome = Outcome::COLUMNS.iter().map(|&(name, kind, cell)| -> Column {
        (name, kind, Box::new(move |row| cell(&row.outcome)))
    });
    drive.chain(outcome).collect()
}

/// The bytes of the Parquet file of `rows`, with `metadata` under the key `steerguard-campaign`.
///
/// # Errors
/// [`ParquetError`], for none that rows can cause.
pub fn parquet(rows: &[Row], metadata: String) -> Result<Vec<u8>, ParquetError> {
    let columns = columns();
    let fields = columns.iter().map(|(name, kind, _)| field(name, *kind));
    let schema =
        Type::group_type_builder("drive").with_fields(fields.collect::<Result<_, _>>()?).build()?;
    let metadata = KeyValue::new("steerguard-campaign".to_owned(), metadata);
    let properties = WriterProperties::builder()
        .set_key_value_metadata(Some(vec![metadata]))
        .set_dictionary_enabled(false)
        .build();
    let mut writer = SerializedFileWriter::new(Vec::new(), Arc::new(schema), Arc::new(properties))?;
    for rows in rows.chunks(GROUP) {
        let mut group = writer.next_row_group()?;
        for (_, kind, cell) in &columns {
            let Some(mut column) = group.next_column()? else { break };
            write(&mut column, *kind, rows.iter().map(cell))?;
            column.close()?;
        }
        group.close()?;
    }
    writer.into_inner()
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
