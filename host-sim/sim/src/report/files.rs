//! A table as a file: CSV for people, Parquet for programs.
//!
//! Both keep every number exactly. CSV writes the shortest decimal that reads back to the same `f64` (`NaN`, `inf` and
//! `-inf` by name; the payload of a NaN is not kept). Parquet stores each column as REQUIRED DOUBLE, bit for bit,
//! compressed with Snappy, in row groups of [`ROW_GROUP_ROWS`] rows. Missing folders are created; an existing file is
//! replaced.

use std::fs::File;
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{Compression, Repetition, Type as PhysicalType};
use parquet::data_type::DoubleType;
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use haptic_plot::{ReportError, create_folder};

use super::table::Table;

/// Rows in one Parquet row group: 65 s at 1 kHz, half a megabyte for each column.
pub const ROW_GROUP_ROWS: usize = 1 << 16;

/// Writes the table as CSV: one header line with the column names, then one line for each row.
pub fn write_csv(table: &Table, path: &Path) -> Result<(), ReportError> {
    create_folder(path, "CSV")?;
    csv_rows(table, path).map_err(ReportError::write(path, "CSV"))
}

/// Writes the table as Parquet.
pub fn write_parquet(table: &Table, path: &Path) -> Result<(), ReportError> {
    create_folder(path, "Parquet")?;
    parquet_groups(table, path).map_err(ReportError::write(path, "Parquet"))
}

fn csv_rows(table: &Table, path: &Path) -> Result<(), csv::Error> {
    let mut writer = csv::Writer::from_path(path)?;
    if table.columns().is_empty() {
        return Ok(writer.flush()?);
    }
    writer.write_record(table.columns().iter().map(|c| c.name.as_str()))?;
    for row in 0..table.len() {
        // `{:?}` is the shortest text that parses back to the same value; `{}` would spell out 1e300.
        writer.write_record(table.columns().iter().filter_map(|c| c.values.get(row)).map(|v| format!("{v:?}")))?;
    }
    Ok(writer.flush()?)
}

fn parquet_groups(table: &Table, path: &Path) -> Result<(), ParquetError> {
    let field = |name: &str| {
        let builder = Type::primitive_type_builder(name, PhysicalType::DOUBLE).with_repetition(Repetition::REQUIRED);
        builder.build().map(Arc::new)
    };
    let fields = table.columns().iter().map(|c| field(&c.name)).collect::<Result<Vec<_>, _>>()?;
    let schema = Arc::new(Type::group_type_builder("table").with_fields(fields).build()?);
    let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
    let mut writer = SerializedFileWriter::new(File::create(path)?, schema, Arc::new(properties))?;
    for start in (0..table.len()).step_by(ROW_GROUP_ROWS) {
        let mut group = writer.next_row_group()?;
        for column in table.columns() {
            let values: Vec<f64> = column.values.iter().skip(start).take(ROW_GROUP_ROWS).copied().collect();
            if let Some(mut chunk) = group.next_column()? {
                chunk.typed::<DoubleType>().write_batch(&values, None, None)?;
                chunk.close()?;
            }
        }
        group.close()?;
    }
    writer.close()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::table::Column;
    use super::*;
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::Field;
    use tempfile::tempdir;

    fn awkward() -> Table {
        let values = vec![0.0, -0.0, 0.1 + 0.2, 1e300, f64::MIN_POSITIVE / 8.0, -1.0 / 3.0, f64::INFINITY, f64::NAN];
        let time = (0..values.len()).map(|i| i as f64 * 1e-3).collect();
        Table::new(vec![Column::new("time_s", time), Column::new("force, \"odd\"_n", values)]).unwrap()
    }

    fn bits(table: &Table) -> Vec<(String, Vec<u64>)> {
        table.columns().iter().map(|c| (c.name.clone(), c.values.iter().map(|v| v.to_bits()).collect())).collect()
    }

    fn read_csv(path: &Path) -> Table {
        let mut reader = csv::Reader::from_path(path).unwrap();
        let names: Vec<String> = reader.headers().unwrap().iter().map(str::to_owned).collect();
        let mut table = Table::with_names(&names.iter().map(String::as_str).collect::<Vec<_>>()).unwrap();
        for record in reader.records() {
            table.push_row(&record.unwrap().iter().map(|v| v.parse().unwrap()).collect::<Vec<f64>>()).unwrap();
        }
        table
    }

    fn read_parquet(path: &Path) -> Table {
        let reader = SerializedFileReader::new(File::open(path).unwrap()).unwrap();
        let schema = reader.metadata().file_metadata().schema_descr_ptr();
        let names: Vec<String> = schema.columns().iter().map(|c| c.name().to_owned()).collect();
        let mut table = Table::with_names(&names.iter().map(String::as_str).collect::<Vec<_>>()).unwrap();
        for row in reader.get_row_iter(None).unwrap() {
            let row = row.unwrap();
            let values = row.get_column_iter().map(|(name, field)| match field {
                Field::Double(value) => *value,
                other => panic!("{name} is {other:?}"),
            });
            table.push_row(&values.collect::<Vec<_>>()).unwrap();
        }
        table
    }

    #[test]
    fn csv_round_trips_every_bit() {
        let folder = tempdir().unwrap();
        let folder = folder.path();
        let path = folder.join("new folder/awkward.csv");
        write_csv(&awkward(), &path).unwrap();
        assert_eq!(bits(&read_csv(&path)), bits(&awkward()));
        assert!(std::fs::read_to_string(&path).unwrap().contains("0.002,0.30000000000000004\n"));
    }

    #[test]
    fn parquet_round_trips_every_bit() {
        let folder = tempdir().unwrap();
        let folder = folder.path();
        let path = folder.join("new folder/awkward.parquet");
        write_parquet(&awkward(), &path).unwrap();
        assert_eq!(bits(&read_parquet(&path)), bits(&awkward()));
    }

    #[test]
    fn parquet_starts_a_new_row_group_after_its_limit() {
        let values: Vec<f64> = (0..ROW_GROUP_ROWS + 3).map(|i| (i as f64).sin()).collect();
        let table = Table::new(vec![Column::new("x_m", values)]).unwrap();
        let folder = tempdir().unwrap();
        let folder = folder.path();
        let path = folder.join("long.parquet");
        write_parquet(&table, &path).unwrap();
        assert_eq!(SerializedFileReader::new(File::open(&path).unwrap()).unwrap().num_row_groups(), 2);
        assert_eq!(bits(&read_parquet(&path)), bits(&table));
    }

    #[test]
    fn the_same_table_gives_the_same_bytes() {
        let folder = tempdir().unwrap();
        let folder = folder.path();
        for (name, write) in [("same.csv", write_csv as fn(&Table, &Path) -> _), ("same.parquet", write_parquet)] {
            let read = || {
                write(&awkward(), &folder.join(name)).unwrap();
                std::fs::read(folder.join(name)).unwrap()
            };
            assert_eq!(read(), read(), "{name}");
        }
    }

    #[test]
    fn tables_without_rows_or_columns_are_written() {
        let folder = tempdir().unwrap();
        let folder = folder.path();
        let no_rows = Table::with_names(&["time_s"]).unwrap();
        for (i, table) in [no_rows, Table::default()].iter().enumerate() {
            write_csv(table, &folder.join(format!("{i}.csv"))).unwrap();
            write_parquet(table, &folder.join(format!("{i}.parquet"))).unwrap();
            assert_eq!(&read_parquet(&folder.join(format!("{i}.parquet"))), table);
        }
    }

    #[test]
    fn an_error_names_the_path_and_the_cause() {
        let folder = tempdir().unwrap();
        let folder = folder.path();
        let file = folder.join("a-file");
        std::fs::write(&file, "").unwrap();
        for result in [write_csv(&awkward(), &file.join("x.csv")), write_parquet(&awkward(), folder)] {
            let text = result.unwrap_err().to_string();
            assert!(text.starts_with("cannot write ") && text.contains(&*folder.to_string_lossy()), "{text}");
        }
    }
}
