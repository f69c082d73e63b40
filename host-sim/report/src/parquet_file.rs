//! A table as Parquet: every column of the sort that it was declared as ([`Holds`]), with its unit and its meaning.
//!
//! A column of numbers and nothing else (most of a run over time) is REQUIRED DOUBLE; any other may lack values, which are null: BOOLEAN, INT64,
//! DOUBLE, or text. So the file of a study has the same schema whatever was found.

use std::borrow::Cow;
use std::sync::Arc;

use cohold_columns::{Cell, Column, Columns, Holds, Values};
use parquet::basic::{Compression, LogicalType, Repetition, Type as PhysicalType};
use parquet::data_type::{BoolType, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::{
    errors::ParquetError, file::metadata::KeyValue, file::properties::WriterProperties, schema::types::Type,
};

/// Rows in one Parquet row group: 65 s at 1 kHz, half a megabyte for each column.
pub const ROW_GROUP_ROWS: usize = 1 << 16;

/// The table with what made it (`made`), and unit and meaning of every column (`unit.NAME`, `meaning.NAME`).
pub(super) fn parquet(columns: &Columns, provenance: &str) -> Result<Vec<u8>, ParquetError> {
    let data = columns.distinct().map_err(ParquetError::General)?;
    let typed: Vec<_> = data.iter().map(|column| (column.name(), column.typed())).collect();
    let field = |(name, values): &(&str, Cow<'_, Values>)| field(name, values).map(Arc::new);
    let fields = typed.iter().map(field).collect::<Result<Vec<_>, _>>()?;
    let schema = Arc::new(Type::group_type_builder("table").with_fields(fields).build()?);
    let described = |column: &&Column| {
        let about = [("unit", column.unit()), ("meaning", column.meaning())];
        about.map(|(what, text)| KeyValue::new(format!("{what}.{}", column.name()), text.to_owned()))
    };
    let metadata =
        std::iter::once(KeyValue::new("made".to_owned(), provenance.to_owned())).chain(data.iter().flat_map(described));
    let properties = WriterProperties::builder().set_compression(Compression::SNAPPY);
    let properties = properties.set_key_value_metadata(Some(metadata.collect())).build();
    let mut writer = SerializedFileWriter::new(Vec::new(), schema, Arc::new(properties))?;
    for start in (0..columns.len()).step_by(ROW_GROUP_ROWS) {
        let mut group = writer.next_row_group()?;
        for (name, values) in &typed {
            let Some(mut chunk) = group.next_column()? else { continue };
            let rows = start..columns.len().min(start + ROW_GROUP_ROWS);
            match &**values {
                Values::Numbers(numbers) => chunk.typed::<DoubleType>().write_batch(&numbers[rows], None, None)?,
                Values::Cells(holds, cells) => put_all(&mut chunk, name, *holds, &cells[rows])?,
            };
            chunk.close()?;
        }
        group.close()?;
    }
    writer.into_inner()
}

/// How a column is stored.
fn field(name: &str, values: &Values) -> Result<Type, ParquetError> {
    let (repetition, holds) = match values {
        Values::Numbers(_) => (Repetition::REQUIRED, Holds::Numbers),
        Values::Cells(holds, _) => (Repetition::OPTIONAL, *holds),
    };
    let (kind, logical) = match holds {
        Holds::Flags => (PhysicalType::BOOLEAN, None),
        Holds::Counts => (PhysicalType::INT64, None),
        Holds::Numbers => (PhysicalType::DOUBLE, None),
        Holds::Lists | Holds::Texts => (PhysicalType::BYTE_ARRAY, Some(LogicalType::String)),
    };
    let field = Type::primitive_type_builder(name, kind).with_repetition(repetition);
    field.with_logical_type(logical).build()
}

/// Cells of a column; returns how many.
fn put_all(
    chunk: &mut SerializedColumnWriter<'_>,
    name: &str,
    holds: Holds,
    cells: &[Cell],
) -> Result<usize, ParquetError> {
    match holds {
        Holds::Flags => put::<BoolType>(chunk, name, cells, |cell| match cell {
            Cell::Flag(flag) => Some(*flag),
            _ => None,
        }),
        Holds::Counts => put::<Int64Type>(chunk, name, cells, |cell| match cell {
            Cell::Whole(count) => Some(*count),
            _ => None,
        }),
        Holds::Numbers => put::<DoubleType>(chunk, name, cells, |cell| match cell {
            Cell::Number(number) => Some(*number),
            _ => None,
        }),
        Holds::Lists | Holds::Texts => {
            put::<ByteArrayType>(chunk, name, cells, |cell| Some(cell.clone().csv().into_bytes().into()))
        }
    }
}

/// Cells of a column as values of this type, null where there is nothing.
fn put<T: DataType>(
    chunk: &mut SerializedColumnWriter<'_>,
    name: &str,
    cells: &[Cell],
    value: impl Fn(&Cell) -> Option<T::T>,
) -> Result<usize, ParquetError> {
    let filled: Vec<i16> = cells.iter().map(|cell| i16::from(*cell != Cell::Empty)).collect();
    let other =
        |cell: &Cell| ParquetError::General(format!("column `{name}`: {cell:?} is of another sort than the column"));
    let values = cells.iter().filter(|cell| **cell != Cell::Empty).map(|cell| value(cell).ok_or_else(|| other(cell)));
    chunk.typed::<T>().write_batch(&values.collect::<Result<Vec<_>, _>>()?, Some(&filled), None)
}
