//! `cohold recording columns`, the files that it tells of, and docs/columns.csv.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::path::{Path, PathBuf};

use cohold_board_tools::recording;
use cohold_core::device::{encoder::Counts, motor::Duty};
use cohold_core::num::Motion;
use cohold_core::peer::Observed;
use cohold_core::safety::Mode;
use cohold_core::sample::{OfAxis, OfPeer, SAMPLE};
use cohold_live::recording::mcap::Channel;
use cohold_live::recording::origin::Origin;
use cohold_live::recording::recorder::Recorder;
use cohold_live::{recording::file::read, recording::ticks};
use cohold_protocol::record::{self, Record};
use cohold_report::files::write_parquet;
use cohold_report::{Columns, Provenance};
use cohold_sim::run::{Account, Accounts, Options, Ticked};
use cohold_sim::scene::Scene;
use parquet::file::reader::{FileReader, SerializedFileReader};
use serde_json::Value;

use crate::declared::{declared, has_columns_of};
use crate::program::{cohold, report};

/// An empty folder of this test's own.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("columns").join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).expect("a folder");
    folder
}

/// Runs a command line, its words apart by blanks, that writes into the folder.
fn run(folder: &Path, words: &str) -> Value {
    let folder = folder.display().to_string();
    let words: Vec<String> = words.split(' ').map(|word| word.replace("DIR", &folder)).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    report(cohold(&[&words[..], &["--json"]].concat()).spawn().expect("cohold runs"))
}

/// The one file of the folder whose name begins and ends so.
fn file(folder: &Path, begins: &str, ends: &str) -> PathBuf {
    let names = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("a file").file_name());
    let names: Vec<String> = names.map(|name| name.to_string_lossy().into_owned()).collect();
    let mut found = names.iter().filter(|name| name.starts_with(begins) && name.ends_with(ends));
    let name = found.next().unwrap_or_else(|| panic!("no {begins}…{ends} among {names:?}"));
    assert_eq!(found.next(), None);
    folder.join(name)
}

/// This Parquet file has just the columns of its kind, and says unit and meaning of each; `but` has another name and meaning there.
fn parquet_says(kind: &str, file: &Path, but: Option<&str>) {
    let reader = SerializedFileReader::new(File::open(file).expect("a file")).expect("Parquet");
    let about = reader.metadata().file_metadata();
    let names: Vec<&str> = about.schema_descr().columns().iter().map(|column| column.name()).collect();
    let told = about.key_value_metadata().expect("metadata");
    let told = |key: String| told.iter().find(|entry| entry.key == key).and_then(|entry| entry.value.clone());
    let declared = declared(kind);
    assert_eq!(names.len(), declared.len(), "{kind}");
    for (name, [column, unit, meaning]) in names.into_iter().zip(declared) {
        let [said_unit, said] = ["unit", "meaning"].map(|what| told(format!("{what}.{name}")).expect("it is told"));
        if but == Some(name) {
            assert!(column == "TABLE.KEY" && !said.is_empty() && said != meaning, "{kind}: {name} {said}");
        } else {
            assert_eq!([name, &said_unit, &said], [&column, &unit, &meaning], "{kind}");
        }
    }
}

/// This file of docs/ is what it should be; `COHOLD_BLESS=1` writes it.
pub(crate) fn is_documented(file: &str, now: &[u8]) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs").join(file);
    if std::env::var_os("COHOLD_BLESS").is_some() {
        fs::write(&path, now).unwrap_or_else(|cause| panic!("docs/{file} cannot be written: {cause}"));
    }
    let documented = fs::read(&path).unwrap_or_else(|cause| panic!("docs/{file}: {cause}"));
    assert!(documented == now, "docs/{file} is another; COHOLD_BLESS=1 writes it");
}

/// docs/columns.csv is what `cohold recording columns --json` says, a line for each column of each kind of table. To write it anew:
/// `COHOLD_BLESS=1 cargo test -p cohold --test suite -- columns::every_column`
#[test]
fn every_column_has_a_meaning_and_a_line_of_the_documentation() {
    let told = report(cohold(&["recording", "columns", "--json"]).spawn().expect("cohold runs"));
    let mut lines = csv::Writer::from_writer(Vec::new());
    lines.write_record(["kind", "place", "row", "column", "unit", "meaning"]).expect("a line");
    let kinds = told.as_object().expect("kinds");
    for (kind, about) in kinds {
        let [place, row] = ["in", "row"].map(|field| about[field].as_str().unwrap_or_default());
        let columns = about["columns"].as_array().expect("columns");
        assert!(!columns.is_empty() && !place.is_empty() && !row.is_empty(), "{kind}");
        let names: BTreeSet<&str> = columns.iter().filter_map(|column| column["column"].as_str()).collect();
        assert_eq!(names.len(), columns.len(), "{kind}: each has a name of its own");
        for about in columns {
            let [column, unit, meaning] =
                ["column", "unit", "meaning"].map(|field| about[field].as_str().unwrap_or_default());
            assert!(meaning.len() > 2 && !meaning.ends_with('.'), "{kind}: {about}");
            lines.write_record([kind.as_str(), place, row, column, unit, meaning]).expect("a line");
        }
    }
    assert_eq!(kinds.len(), 63);
    is_documented("columns.csv", &lines.into_inner().expect("all lines"));
}

/// One name for one quantity: what a live peer or a board tells, the simulator tells of both peers with their numbers.
#[test]
fn the_same_quantity_has_the_same_name() {
    let of = |kind: &str| declared(kind).into_iter().map(|[name, unit, _]| (name, unit)).collect::<Vec<_>>();
    let (simulated, live, board) = (of("cooperate"), of("peer-ticks"), of("board-ticks"));
    let shared = ["device", "object", "decoded", "contact", "coordination", "energy_received", "energy_sent"];
    for quantity in shared {
        let named = |columns: &[(String, String)], stem: &str| {
            let of = |(name, unit): &&(String, String)| unit != "m/s" && name.starts_with(&format!("{stem}_"));
            columns.iter().find(of).map(|(name, unit)| (name.replacen(stem, "", 1), unit.clone()))
        };
        let found = named(&board, quantity);
        assert!(found.is_some() && found == named(&live, quantity), "{quantity}");
        for peer in 1..=2 {
            assert_eq!(named(&simulated, &format!("{quantity}_{peer}")), found, "{quantity}");
        }
    }
    assert!(simulated.contains(&("object_1_m_per_s".to_owned(), "m/s".to_owned())));
    assert!([live, board].iter().all(|columns| columns.contains(&("object_m_per_s".to_owned(), "m/s".to_owned()))));
}

/// [`cohold_core::sample::SAMPLE`] with one line more.
mod more {
    cohold_core::quantities! {
        27 spring_m "m" Steps: "x_d - x_o", |axis| axis.observed.desired.position - axis.observed.object.position;
    }
}

/// A quantity that is declared stands in tables of runs, recordings, a board's record and files, and moves nothing that was there before.
#[test]
fn a_quantity_more_is_one_line() {
    let (folder, more) = (folder("more"), &more::SAMPLE);
    let without = |table: &Columns, name: &str| {
        let at = table.data().position(|column| column.name() == name).expect("it is there");
        let mut row: Vec<f64> = table.data().map(|column| table.column(column.name()).expect("numbers")[0]).collect();
        (row.remove(at), row)
    };
    let object = Motion { position: 0.5, velocity: -1.0 };
    let seen = Observed { object, desired: Motion::at(0.75), coordination_force: 2.0, ..Observed::default() };

    // A run has it of each peer.
    let mut accounts = Accounts::<1>::new(&Scene::default(), 1, Options::recorded(1.0, 1e-3));
    for at in 0..2 {
        accounts.ticked(at, [Ticked::new(&seen, [3.0, 4.0], Mode::Armed, true)]);
    }
    accounts.period();
    let [account] = accounts.axes();
    let mut run = Columns::named(Account::columns_of(more));
    run.push_row(&account.row_of(more));
    let (second_m, _) = without(&run, "spring_2_m");
    let (first_m, row) = without(&run.clone().without("spring_2_m"), "spring_1_m");
    assert_eq!(([first_m, second_m], row), ([0.25; 2], account.row()));

    // So have a recording of a peer, and a board's.
    let axis = OfAxis { observed: &seen, received_j: 3.0, sent_j: 4.0 };
    let peer = OfPeer::new(7, Mode::Armed);
    let ticks = ticks::tick_columns::<{ ticks::TICK.len() + 1 }>(more);
    let tick: [f64; ticks::TICK.len() + 1] = ticks::tick_of(more, 5, peer, &axis, true);
    let mut live = Columns::named(ticks);
    live.push_row(&tick);
    assert_eq!(without(&live, "spring_m"), (0.25, ticks::tick(5, peer, &seen, [3.0, 4.0], true).to_vec()));
    let (mut wider, mut record) = (Record::<1>::default(), Record::default());
    let (single, of) = (
        seen.map(|number| number as f32),
        record::Tick {
            tick: 7,
            axis: 0,
            counts: [Counts(1), Counts(2)],
            duties: [Duty(3), Duty(4)],
            stage: None,
            mode: record::mode_code(Mode::Armed),
            flags: record::ENABLED,
            digest: 5,
        },
    );
    let axis = OfAxis { observed: &single, received_j: 3.0, sent_j: 4.0 };
    record.fill(&of, None, &axis);
    wider.fill_with::<f32>(&of, None, |record| more::each(&axis, |word, number| record.put(word, number)));
    assert_eq!((wider.0, wider.1), (record.0, [0.25_f32.to_bits()]));
    let columns = recording::columns_of::<{ recording::COLUMNS.len() + 1 }>(more);
    let row: [f64; recording::COLUMNS.len() + 1] = recording::row_of(more, &wider, 1e-3);
    let mut told = Columns::named(columns);
    told.push_row(&row);
    let wanted = recording::row(&record.bytes(), 1e-3).expect("a record").1;
    assert_eq!(without(&told, "spring_m"), (0.25, wanted.to_vec()));

    // Files say what it is.
    let (parquet, mcap) = (folder.join("run.parquet"), folder.join("ticks.mcap"));
    write_parquet(&run, &parquet, "", cohold_io::Kind::Named).expect("a file");
    let reader = SerializedFileReader::new(File::open(parquet).expect("a file")).expect("Parquet");
    let about = reader.metadata().file_metadata().key_value_metadata().expect("metadata");
    let said = |key: &str| about.iter().find(|entry| entry.key == key).and_then(|entry| entry.value.as_deref());
    assert_eq!([said("unit.spring_2_m"), said("meaning.spring_2_m")], [Some("m"), Some("peer 2: x_d - x_o")]);
    let recorder = Recorder::create(
        &mcap,
        &Origin::simulated(&Provenance::now("0", ""), "peer 1"),
        vec![Channel::new("/peer/ticks", "Tick", ticks)],
    );
    let recorder = recorder.expect("a file");
    recorder.put_all(0, 0, &tick);
    recorder.finish();
    let recording = read(&mcap).expect("a recording");
    let rows = &recording.channels[0];
    assert_eq!((rows.column("spring_m"), rows.meaning("spring_m")), (Some(&[0.25][..]), "x_d - x_o"));
}

/// Every quantity has a name that ends in its unit, and a name and a word of its own.
#[test]
fn quantities_are_told_apart() {
    let of_peer = SAMPLE.peer.iter().map(|quantity| (quantity.named(), quantity.unit));
    let all: Vec<_> = of_peer.chain(SAMPLE.axis.iter().map(|quantity| (quantity.named(), quantity.unit))).collect();
    let table = Columns::named(all.iter().map(|(named, _)| *named));
    assert!(table.data().zip(&all).all(|(column, (_, unit))| column.unit() == *unit));
    let names: BTreeSet<&str> = all.iter().map(|((name, _), _)| *name).collect();
    let words: BTreeSet<usize> = SAMPLE.axis.iter().map(|quantity| quantity.word).collect();
    assert_eq!((names.len(), words.len()), (all.len(), SAMPLE.axis.len()));
    assert!(SAMPLE.recorded.is_sorted_by_key(|quantity| quantity.word));
}

#[test]
fn a_run_writes_what_is_declared() {
    let folder = folder("run");
    run(&folder, "cooperate --scene paper-5.2-wave-16ms --seconds 0.1 --out DIR --record DIR/run.mcap");
    has_columns_of("cooperate", &file(&folder, "paper", ".csv"));
    parquet_says("cooperate", &file(&folder, "paper", ".parquet"), None);
    let picture = fs::read_to_string(file(&folder, "paper", ".svg")).expect("a figure");
    let names: Vec<String> = declared("figure").into_iter().map(|[name, ..]| name).collect();
    assert!(picture.lines().any(|line| line == names.join(",")), "the data in a figure");
    run(&folder, "recording convert DIR/run.mcap DIR/ticks.csv");
    has_columns_of("cooperate-ticks", &folder.join("ticks.csv"));
    run(&folder, "recording convert DIR/run.mcap DIR/ticks.parquet");
    parquet_says("cooperate-ticks", &folder.join("ticks.parquet"), None);
    // What cannot be written leaves nothing that would be in the way of the next one.
    fs::create_dir(folder.join("taken.csv")).expect("a folder");
    let [from, to] = ["run.mcap", "taken.csv"].map(|name| folder.join(name).display().to_string());
    let failed = cohold(&["recording", "convert", &from, &to]).output().expect("cohold runs");
    assert!(!failed.status.success() && !folder.join("taken.toml").exists(), "{failed:?}");
    run(&folder, "recording merge DIR/run.mcap DIR/apart.csv");
    has_columns_of("merge", &folder.join("apart.csv"));
    run(&folder, "recording merge DIR/run.mcap DIR/apart.parquet");
    parquet_says("merge", &folder.join("apart.parquet"), None);
    run(&folder, "network trace --seconds 0.1 DIR/trace.csv");
    has_columns_of("network-trace", &folder.join("trace.csv"));
}

#[test]
fn a_sweep_writes_what_is_declared() {
    let folder = folder("sweep");
    run(&folder, "study sweep --scene paper-5.2-wave-16ms --over network.loss=0,0.1 --seconds 0.1 --out DIR");
    parquet_says("sweep", &folder.join("sweep.parquet"), Some("network.loss"));
    has_columns_of("sweep-rows", &folder.join("rows-1-of-1.csv"));
    let heading = fs::read_to_string(folder.join("sweep.csv")).expect("a table");
    let heading: Vec<&str> = heading.lines().next().unwrap_or_default().split(',').collect();
    let names: Vec<String> =
        declared("sweep").into_iter().map(|[name, ..]| name.replace("TABLE.KEY", "network.loss")).collect();
    assert_eq!(heading, names);
}

#[test]
fn stability_and_shared_environments_write_what_is_declared() {
    let folder = folder("others");
    let keys = "--x contact.stiffness_n_per_m=100..2000:2 --y coordination.stiffness_n_per_m=100..2000:2";
    run(&folder, &format!("stability map --scene paper-5.2-wave-16ms {keys} --out DIR"));
    let heading = fs::read_to_string(file(&folder, "map-", ".csv")).expect("a table");
    let example = declared("stability-map").into_iter().map(|[name, ..]| match name.as_str() {
        "TABLE.KEY of x" => "contact.stiffness_n_per_m".to_owned(),
        "TABLE.KEY of y" => "coordination.stiffness_n_per_m".to_owned(),
        _ => name,
    });
    assert!(heading.lines().next().unwrap_or_default().split(',').eq(example), "{heading}");
    run(&folder, "shared cooperative --delay-ms 10 --seconds 0.1 --out DIR");
    has_columns_of("shared-cooperative", &folder.join("cooperative.csv"));
    run(&folder, "shared world stroke --out DIR");
    has_columns_of("shared-stroke", &folder.join("shape.csv"));
}

/// What is printed as JSON and in no file has these columns as its fields.
#[test]
fn rows_in_json_have_what_is_declared() {
    let folder = folder("json");
    let sweep = run(&folder, "study sweep --scene paper-5.2-wave-16ms --over network.loss=0 --seconds 0.1 --out DIR");
    let force = run(&folder, "accuracy force");
    let precision = run(&folder, "accuracy precision --seconds 0.1 --set axis.count=2 --set axis.shared=2");
    let rigid = run(&folder, "accuracy rigid --seconds 1");
    let rows = [
        ("sweep-points", &sweep["points"][0]),
        ("force-response", &force["response"][0]),
        ("force-moving", &force["moving"][0]),
        ("accuracy-precision", &precision[0]),
        ("accuracy-rigid", &rigid[0]),
    ];
    for (kind, row) in rows {
        for [name, ..] in declared(kind) {
            let keys = if name == "TABLE.KEY" { "network.loss" } else { &name };
            let found = keys.split('.').try_fold(row, |at, key| at.as_object()?.get(key));
            assert!(found.is_some(), "{kind}: {name} in {row}");
        }
    }
}
