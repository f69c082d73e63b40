//! Columns as text, JSON, CSV and Parquet; files of a run, and what they say of it.

use std::fs::File;
use std::io::Write;

use cohold_io::Kind;
use cohold_plot::Figure;
use cohold_report::files::{write_csv, write_parquet};
use cohold_report::{Cell, Column, Columns, Error, Files, Holds, Provenance, ROW_GROUP_ROWS};
use parquet::basic::Type as PhysicalType;
use parquet::file::metadata::KeyValue;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use serde_json::json;
use tempfile::tempdir;

struct Gain {
    comm: &'static str,
    gain: Option<f64>,
    crossings: Vec<f64>,
    force: (f64, f64),
}

fn gains() -> Columns {
    let rows = [
        Gain { comm: "power", gain: Some(310.0), crossings: vec![357.04], force: (1.0, 0.5) },
        Gain { comm: "a|b", gain: None, crossings: vec![1.0, 2.5], force: (f64::NAN, 0.1) },
    ];
    Columns::of(&rows)
        .value("comm", |row| row.comm)
        .number("gain_n_per_m", 0, |row| row.gain)
        .means("the largest")
        .number("crossings_n_per_m", 1, |row| row.crossings.clone())
        .head("boundaries")
        .number("force_n.mean", 2, |row| row.force.0)
        .head("F_T")
        .shown_in("mN", 1e3)
        .where_true(|row| row.comm == "power")
        .value("force_n.sd", |row| row.force.1)
        .data_only()
        .done()
}

#[test]
fn text_is_aligned_and_numbers_are_set_right() {
    let expected = "\
comm   gain N/m  boundaries N/m   F_T mN
-----  --------  --------------  -------
power       310  357.0           1000.00
a|b           -  1.0, 2.5              -
";
    assert_eq!(gains().to_string(), expected);
    assert_eq!(gains().meanings(&["gain_n_per_m"]), "gain: the largest.\n");
}

#[test]
fn one_row_stands_upright() {
    let rows = [(true, 0.5, None::<f64>)];
    let facts = Columns::of(&rows)
        .value("stable", |row| row.0)
        .number("peak_force_n", 3, |row| row.1)
        .value("mass_kg", |row| row.2)
        .done();
    assert_eq!(facts.down(&["a"]), "            a\n----------  -------\nstable      yes\npeak force  0.500 N\n");
}

#[test]
fn json_keeps_order_nests_and_has_no_nan() {
    let json = serde_json::to_string(&gains()).unwrap();
    assert_eq!(
        json,
        r#"[{"comm":"power","gain_n_per_m":310.0,"crossings_n_per_m":[357.04],"force_n":{"mean":1.0,"sd":0.5}},"#
            .to_owned()
            + r#"{"comm":"a|b","gain_n_per_m":null,"crossings_n_per_m":[1.0,2.5],"force_n":{"mean":null,"sd":0.1}}]"#
    );
    let pair = Columns::of(&[()]).value("energy.0.j", |()| 1_u8).value("energy.1.j", |()| 2_u8).done();
    assert_eq!(serde_json::to_string(&pair).unwrap(), r#"[{"energy":[{"j":1},{"j":2}]}]"#);
    assert_eq!(serde_json::to_string(&Columns::default()).unwrap(), "[]");
}

/// What a document says is a table as well: fields within are named by both, what is nowhere filled is no column.
#[test]
fn documents_are_rows() {
    let one = json!({ "line": 1, "energy": { "sent_j": 0.1234567 }, "said": null, "log": [[0.5, "up"]], "names": ["a", "b"] });
    let two = json!({ "line": 2, "energy": { "sent_j": 2.0 }, "said": null, "up": true, "score": [1, 2] });
    let expected = "\
line  energy sent J  log  names  up   score
----  -------------  ---  -----  ---  -----
   1       0.123457    1  a, b   -    -
   2              2    -  -      yes  1, 2
";
    assert_eq!(Columns::of_documents(&[one, two]).to_string(), expected);
}

#[test]
fn curves_are_columns_over_another() {
    let mut columns = Columns::named([("time_s", "since the start"), ("x_m", "a place")]);
    columns.push_row(&[0.5, 2.0]);
    assert_eq!(columns.points("time_s", "x_m", 1e3), [(0.5, 2000.0)]);
    assert_eq!(columns.points("time_s", "y_m", 1e3), []);
}

#[test]
fn rows_of_numbers_are_added_and_found() {
    let mut columns = Columns::named([("time_s", "since the start"), ("x_m", "a place")]);
    assert!(columns.is_empty());
    columns.push_row(&[0.0, 1.5]);
    columns.push_row(&[1.0, f64::NAN]);
    assert_eq!((columns.len(), columns.column("time_s")), (2, Some(&[0.0, 1.0][..])));
    assert_eq!(columns.column("z_m"), None);
}

#[test]
#[should_panic(expected = "one value for each column")]
fn a_row_that_does_not_fit_is_a_mistake() {
    Columns::named([("time_s", "since the start"), ("x_m", "a place")]).push_row(&[1.0]);
}

#[test]
fn names_end_with_their_unit() {
    let names =
        ["true_discrepancy_mm_per_n", "drag_n_s_per_m", "loss", "s", "force_n.mean", "energy.0.sent_j", "rests_mm.1"];
    let columns = Columns::named(names.map(|name| (name, "")));
    let heads = "true discrepancy mm/N  drag N·s/m  loss  s  force mean N  energy 0 sent J  rests 1 mm";
    assert_eq!(columns.to_string().lines().next(), Some(heads));
    let units: Vec<&str> = columns.data().map(Column::unit).collect();
    assert_eq!(units, ["mm/N", "N·s/m", "", "", "N", "J", "mm"]);
    let numbered = ["object_m", "object_m_per_s", "loss"].map(|name| cohold_report::numbered(name, 2));
    assert_eq!(numbered, ["object_2_m", "object_2_m_per_s", "loss_2"]);
}

fn awkward() -> Columns {
    let values = vec![0.0, -0.0, 0.1 + 0.2, 1e300, f64::MIN_POSITIVE / 8.0, -1.0 / 3.0, f64::INFINITY, f64::NAN];
    let mut columns = Columns::named([("time_s", "since the start")]);
    (0..values.len()).for_each(|i| columns.push_row(&[i as f64 * 1e-3]));
    columns.push(Column::numbers("force, \"odd\"_n", "what is felt", values));
    columns
}

fn bits(columns: &Columns) -> Vec<(String, Vec<u64>)> {
    let values = |column: &Column| columns.column(column.name()).unwrap().iter().map(|v| v.to_bits()).collect();
    columns.data().map(|column| (column.name().to_owned(), values(column))).collect()
}

fn csv(columns: &Columns) -> Result<Vec<u8>, Error> {
    let folder = tempdir().unwrap();
    let path = folder.path().join("x.csv");
    write_csv(columns, &path, Kind::Named).map(|()| std::fs::read(path).unwrap())
}

fn parquet(columns: &Columns, provenance: &Provenance) -> Result<Vec<u8>, Error> {
    let folder = tempdir().unwrap();
    let mut files = Files::new(folder.path(), "x", provenance.clone());
    files.parquet(columns)?;
    files.write().map(|paths| std::fs::read(&paths[0]).unwrap())
}

fn read_csv(bytes: &[u8]) -> Columns {
    let mut reader = csv::Reader::from_reader(bytes);
    let mut columns = Columns::named(reader.headers().unwrap().iter().map(|name| (name, "")));
    for record in reader.records() {
        columns.push_row(&record.unwrap().iter().map(|v| v.parse().unwrap()).collect::<Vec<f64>>());
    }
    columns
}

fn reader(bytes: &[u8]) -> SerializedFileReader<File> {
    let mut file = tempfile::tempfile().unwrap();
    file.write_all(bytes).unwrap();
    SerializedFileReader::new(file).unwrap()
}

fn read_parquet(bytes: &[u8]) -> (Columns, Option<Vec<KeyValue>>) {
    let reader = reader(bytes);
    assert_eq!(
        reader.num_row_groups(),
        (reader.metadata().file_metadata().num_rows() as usize).div_ceil(ROW_GROUP_ROWS)
    );
    let about = reader.metadata().file_metadata();
    let mut columns = Columns::named(about.schema_descr_ptr().columns().iter().map(|c| (c.name().to_owned(), "")));
    for row in reader.get_row_iter(None).unwrap() {
        let row = row.unwrap();
        let values = row.get_column_iter().map(|(name, field)| match field {
            Field::Double(value) => *value,
            other => panic!("{name} is {other:?}"),
        });
        columns.push_row(&values.collect::<Vec<_>>());
    }
    (columns, about.key_value_metadata().cloned())
}

fn provenance() -> Provenance {
    let settings = vec![("coordination.comm".to_owned(), "\"wave\"".to_owned())];
    Provenance::now("1.2.3", "abc").with("seed", 7_u32).with("number_type", "f64").settings(settings)
}

#[test]
fn csv_round_trips_every_bit() {
    let written = csv(&awkward()).unwrap();
    assert_eq!(bits(&read_csv(&written)), bits(&awkward()));
    assert!(String::from_utf8(written).unwrap().contains("0.002,0.30000000000000004\n"));
}

#[test]
fn parquet_round_trips_every_bit_and_says_what_made_it() {
    let mut long = Columns::named([("x_m", "a place")]);
    (0..ROW_GROUP_ROWS + 3).for_each(|i| long.push_row(&[(i as f64).sin()]));
    for columns in [awkward(), long, Columns::named([("time_s", "since the start")]), Columns::default()] {
        let (read, about) = read_parquet(&parquet(&columns, &provenance()).unwrap());
        assert_eq!(bits(&read), bits(&columns));
        let printed =
            about.unwrap().into_iter().find(|entry| entry.key == "made").and_then(|entry| entry.value).unwrap();
        let table: toml::Table = printed.parse().unwrap();
        assert_eq!(
            (table["made"]["seed"].as_integer(), table["coordination"]["comm"].as_str()),
            (Some(7), Some("wave"))
        );
    }
}

#[test]
fn parquet_says_unit_and_meaning_of_every_column() {
    let columns = gains();
    let folder = tempdir().unwrap();
    let path = folder.path().join("gains.parquet");
    write_parquet(&columns, &path, "", Kind::Named).unwrap();
    let reader = SerializedFileReader::new(File::open(path).unwrap()).unwrap();
    let printed = reader.metadata().file_metadata().key_value_metadata().unwrap();
    let about = |key: String| printed.iter().find(|entry| entry.key == key)?.value.clone();
    for (column, unit) in columns.data().zip(["", "N/m", "N/m", "N", "N"]) {
        // In text one of them is in mN; the file keeps what its name says.
        assert_eq!(about(format!("unit.{}", column.name())).as_deref(), Some(unit));
        assert_eq!(about(format!("meaning.{}", column.name())).as_deref(), Some(column.meaning()));
    }
    assert_eq!(about("meaning.gain_n_per_m".to_owned()).as_deref(), Some("the largest"));
}

#[test]
fn words_and_nothing_are_written_too() {
    let rows = [("a", Some(true), Some(1.5)), ("b, c", None, None)];
    let columns = Columns::of(&rows).value("name", |r| r.0).value("stable", |r| r.1).value("x_m", |r| r.2).done();
    assert_eq!(String::from_utf8(csv(&columns).unwrap()).unwrap(), "name,stable,x_m\na,1,1.5\n\"b, c\",,\n");
    assert_eq!(csv(&Columns::default()).unwrap(), b"");
}

/// Physical type of each column of a Parquet file, and all its cells.
fn stored(columns: &Columns) -> (Vec<PhysicalType>, Vec<Vec<Field>>) {
    let reader = reader(&parquet(columns, &provenance()).unwrap());
    let types = reader.metadata().file_metadata().schema_descr().columns().iter().map(|column| column.physical_type());
    let rows = reader.get_row_iter(None).unwrap();
    let cells = rows.map(|row| row.unwrap().get_column_iter().map(|(_, field)| field.clone()).collect());
    (types.collect(), cells.collect())
}

/// A column is what it is declared as: the same type where all is there, some, nothing, and where there are no rows.
#[test]
fn a_column_of_parquet_is_what_it_is_declared_as() {
    type Row = (&'static str, Option<&'static str>, Option<bool>, Option<u32>, Option<f64>, Vec<f64>);
    let full: Row = ("a", Some("fell"), Some(true), Some(3), Some(0.5), vec![1.0, 2.5]);
    let bare: Row = ("", None, None, None, None, vec![]);
    for rows in [vec![full.clone(), bare.clone()], vec![bare.clone()], vec![full.clone()], vec![]] {
        let columns = Columns::of(&rows)
            .value("name", |row| row.0)
            .value("reason", |row| row.1)
            .value("judged", |row| row.2)
            .value("seeds", |row| row.3)
            .number("x_m", 1, |row| row.4)
            .value("edges_m", |row| row.5.clone())
            .cells("key", Holds::Flags, |row| row.2.into())
            .done();
        let (types, cells) = stored(&columns);
        use PhysicalType::{BOOLEAN, BYTE_ARRAY, DOUBLE, INT64};
        assert_eq!(types, [BYTE_ARRAY, BYTE_ARRAY, BOOLEAN, INT64, DOUBLE, BYTE_ARRAY, BOOLEAN]);
        let text = |text: &str| Field::Str(text.to_owned());
        let told = |row: &Row| match row.1 {
            Some(reason) => vec![
                text("a"),
                text(reason),
                Field::Bool(true),
                Field::Long(3),
                Field::Double(0.5),
                text("1.0 2.5"),
                Field::Bool(true),
            ],
            None => vec![text(""), Field::Null, Field::Null, Field::Null, Field::Null, text(""), Field::Null],
        };
        assert_eq!(cells, rows.iter().map(told).collect::<Vec<_>>());
    }
}

/// A cell of another sort than its column is no file with a hole in it.
#[test]
fn a_cell_of_another_sort_is_refused() {
    let columns = Columns::of(&[1.5]).cells("count", Holds::Counts, |row| Cell::Number(*row)).done();
    let text = parquet(&columns, &provenance()).unwrap_err().to_string();
    assert!(text.contains("column `count`: Number(1.5) is of another sort than the column"), "{text}");
}

#[test]
fn two_columns_of_one_name_are_refused() {
    let folder = tempdir().unwrap();
    let twice = Columns::named([("x_m", "a place"), ("x_m", "another")]);
    let text = write_csv(&twice, &folder.path().join("x.csv"), Kind::Named).unwrap_err().to_string();
    assert!(text.contains("two columns are named `x_m`: every column needs a name of its own"), "{text}");
}

/// The same data keep their files; other data get the next number, and nothing is overwritten.
#[test]
fn nothing_is_overwritten() {
    let folder = tempdir().unwrap();
    let write = |value: f64| {
        let mut columns = Columns::named([("x_m", "a place")]);
        columns.push_row(&[value]);
        let mut files = Files::new(&folder.path().join("new folder"), "a.b", provenance());
        files.csv(&columns).unwrap();
        files.parquet(&columns).unwrap();
        files.figure(Some("picture"), &Figure::default()).unwrap();
        let paths = files.write().unwrap();
        paths.iter().map(|path| path.file_name().unwrap().to_str().unwrap().to_owned()).collect::<Vec<_>>()
    };
    let first = ["a.b.csv", "a.b.parquet", "picture.svg", "picture.pdf", "picture.png", "a.b.toml"];
    let second = ["a.b-2.csv", "a.b-2.parquet", "picture-2.svg", "picture-2.pdf", "picture-2.png", "a.b-2.toml"];
    assert_eq!(
        (write(1.0), write(1.0), write(2.0)),
        (first.map(str::to_owned).to_vec(), first.map(str::to_owned).to_vec(), second.map(str::to_owned).to_vec())
    );
    assert_eq!(std::fs::read_to_string(folder.path().join("new folder/a.b.csv")).unwrap(), "x_m\n1.0\n");
    assert_eq!(write(2.0), second);
}

#[test]
fn an_error_names_the_path_and_the_cause() {
    let folder = tempdir().unwrap();
    let file = folder.path().join("a-file");
    std::fs::write(&file, "").unwrap();
    let text = write_csv(&awkward(), &file.join("x.csv"), Kind::Named).unwrap_err().to_string();
    assert!(text.starts_with("cannot write ") && text.contains(&*folder.path().to_string_lossy()), "{text}");
}
