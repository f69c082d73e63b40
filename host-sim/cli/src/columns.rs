//! `cohold recording columns`: what is in the files, column by column, from the declarations that write them.
//!
//! A kind of table is listed here with the function that makes it, called without rows. Where a table depends on what was asked,
//! it is that of an example: a sweep over `TABLE.KEY`, a hub of two lines.

use cohold_analysis::{Axis, Map, Range, figure4, rendering::maps};
use cohold_live::recording::file::ROW;
use cohold_live::recording::mcap::{Channel, log_channel};
use cohold_live::recording::{merge, ticks};
use cohold_plot::DATA_COLUMNS;
use cohold_report::{Column, Columns};
use cohold_sim::network::trace;
use cohold_sim::{run::Account, scene::Scene};
use cohold_studies::entrant::Entrant;
use cohold_studies::reproduce::paper;
use cohold_studies::study::{Network, Study, answers::Goal};
use cohold_studies::sweep;
use cohold_studies::sweep::{Kept as _, Row, Sweep};
use cohold_studies::{accuracy, bench, campaign, force, precision, reproduce, transparency};
use serde_json::{Value, json};

use super::{Failure, Ui};

/// The kinds of tables that the heart writes.
const KINDS: &str = include_str!("tables.txt");

/// The key of an example.
const KEY: &str = "TABLE.KEY";

#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// One kind of table; without it, all of them.
    #[arg(value_name = "KIND")]
    kind: Option<String>,
}

/// A kind of table.
pub struct TableKind {
    name: String,
    /// Which files it is in, or which command prints it.
    place: String,
    /// What a row is.
    row: &'static str,
    columns: Columns,
}

impl TableKind {
    /// A kind of this name, where it is to be found, what a row is, and its columns.
    pub fn new(name: &str, place: &str, row: &'static str, columns: Columns) -> Self {
        Self { name: name.to_owned(), place: place.to_owned(), row, columns }
    }

    /// What `recording convert` makes of a channel of a recording.
    pub fn of(recorded: &str, channel: Channel) -> Self {
        let leaf = channel.topic.rsplit('/').next().unwrap_or_default();
        let place = format!("channel {} of a recording, converted", channel.topic.replace("_1/", "_N/"));
        let row = match leaf {
            "exchanges" => "a question to another clock, and its answer",
            "seconds" => "a second",
            "paths" => "a change of path, or a second",
            "periods" => "a PWM period",
            "log" => "something that happened",
            _ => "a tick",
        };
        let fields = channel.fields.iter().map(|field| (field.name.as_str(), field.meaning.as_str()));
        Self::new(&format!("{recorded}-{leaf}"), &place, row, Columns::named(std::iter::once(ROW).chain(fields)))
    }

    /// Its columns as a table.
    fn table(&self) -> Columns {
        let columns: Vec<&Column> = self.columns.data().collect();
        Columns::of(&columns)
            .value("column", |column| column.name())
            .value("unit", |column| Some(column.unit()).filter(|unit| !unit.is_empty()))
            .value("meaning", |column| column.meaning())
            .done()
    }
}

/// All kinds of tables, in the order of docs/columns.csv.
fn kinds(ui: &Ui) -> Vec<TableKind> {
    let scene = Scene::new(ui.laws);
    let axes = vec![sweep::Axis { key: KEY.to_owned(), values: Vec::new() }];
    let example = Entrant { name: String::new(), scene: scene.clone() };
    let studied = Study::new(vec![example], vec![Network::own()], &axes, None, 1, 0.0).ok();
    let studied = |table: fn(&Study) -> Columns| studied.as_ref().map_or(Columns::default(), table);
    const GOAL: Goal = Goal { metric: 0, bounds: Vec::new() };
    let swept = Sweep { scene, axes, sample: None, seeds: 1, seconds: 0.0 };
    let axis = |of: &str| Axis { range: Range { key: format!("{KEY} of {of}"), from: 0.0, to: 0.0 }, count: 0 };
    let map = Map { axes: [axis("x"), axis("y")], units: [""; 2], columns: Vec::new() };
    let both = Channel::new("/both/ticks", "Tick", Account::columns());
    let made = [
        ("cooperate", Columns::named(Account::columns())),
        ("sweep", swept.columns(&[])),
        ("sweep-rows", Row::columns()),
        ("sweep-points", swept.summary(&[])),
        ("study", studied(|study| study.columns(&[]))),
        ("study-points", studied(|study| study.summary(&[], &[]))),
        ("study-best", studied(|study| study.answer_columns(&[], &GOAL))),
        ("study-pairs", studied(|study| study.pair_columns(&[]))),
        ("bench", bench::tables::points(&[])),
        ("bench-fronts", bench::tables::fronts(&bench::Found::default())),
        ("bench-nearest", bench::chooser::nearest(&bench::Found::default())),
        ("bench-runs", bench::tables::runs(&[])),
        ("bench-tunings", bench::tables::tunings(&[])),
        ("campaign", campaign::columns(&[])),
        ("campaign-costs", campaign::cost_columns(&[])),
        ("laws", campaign::laws::tables::columns(&[])),
        ("laws-impedance", campaign::laws::tables::impedance_columns(&[])),
        ("paper", paper::experiment_columns(&[])),
        ("paper-gains", paper::gain_columns(&[])),
        ("reproduce", reproduce::columns(&[])),
        ("stability-paper", figure4::table(&[])),
        ("stability-map", map.table()),
        ("stability-rendering", maps::table(&[])),
        ("accuracy", accuracy::columns([], true)),
        ("accuracy-precision", precision::columns(&[])),
        ("accuracy-time", accuracy::timed::columns(&[])),
        ("accuracy-rigid", accuracy::rigid::columns(&[])),
        ("force-response", force::response_columns(&[])),
        ("force-moving", force::moving_columns(&[])),
        ("transparency", transparency::columns(&[])),
        ("transparency-responses", transparency::response_columns(&[])),
        ("network-trace", Columns::named(trace::COLUMNS)),
        ("merge", Columns::named(merge::COLUMNS)),
        ("merge-axes", Columns::named(merge::columns(3).skip(merge::COLUMNS.len()))),
        ("board", Columns::named(cohold_board_tools::recording::COLUMNS)),
        ("figure", Columns::named(DATA_COLUMNS)),
    ];
    let listed = KINDS.lines().filter_map(|line| {
        let (name, rest) = line.split_once(" | ")?;
        let (place, row) = rest.split_once(" | ")?;
        let (_, columns) = made.iter().find(|(known, _)| *known == name)?;
        Some(TableKind::new(name, place, row, columns.clone()))
    });
    let mut kinds: Vec<_> = listed.chain([TableKind::of("cooperate", both)]).collect();
    let channels = [
        ("recording", vec![log_channel()]),
        ("peer", ticks::channels("peer_1", 1)),
        ("peer", vec![ticks::path_channel("peer_1")]),
        ("hub", ticks::hub_channels(2, 1)),
        ("board", ticks::board_channels(1, 1)),
    ];
    for (of, all) in channels {
        kinds.extend(all.into_iter().map(|channel| TableKind::of(of, channel)));
    }
    kinds.extend(ui.tables.iter().flat_map(|tables| tables(ui)));
    kinds
}

impl Args {
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let mut kinds = kinds(ui);
        if let Some(asked) = &self.kind {
            let names: Vec<&str> = kinds.iter().map(|kind| kind.name.as_str()).collect();
            if !names.contains(&asked.as_str()) {
                return Err(format!("KIND {asked} is not allowed: they are {}", names.join(", ")).into());
            }
            kinds.retain(|kind| kind.name == *asked);
        }
        let document = |kind: &TableKind| {
            (kind.name.clone(), json!({ "in": kind.place, "row": kind.row, "columns": kind.table() }))
        };
        ui.document(&kinds.iter().map(document).collect::<serde_json::Map<String, Value>>())?;
        for kind in &kinds {
            writeln!(ui, "{}: {}; a row is {}\n", kind.name, kind.place, kind.row);
            ui.table(&kind.table());
        }
        Ok(())
    }
}
