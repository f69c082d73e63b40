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
    let simulated = "a control period; in a long run one of several";
    let crossing = "a crossing from stable to unstable or back";
    let mut kinds = vec![
        TableKind::new("cooperate", "SCENE.csv, SCENE.parquet", simulated, Columns::named(Account::columns())),
        TableKind::new("sweep", "sweep.csv, sweep.parquet", "a run", swept.columns(&[])),
        TableKind::new("sweep-rows", "rows-I-of-N.csv", "a run, as they ended", Row::columns()),
        TableKind::new("sweep-points", "`study sweep --json`, points", "a point", swept.summary(&[])),
        TableKind::new("study", "study.csv, study.parquet", "a run", studied(|study| study.columns(&[]))),
        TableKind::new(
            "study-points",
            "study-points.csv, study-points.parquet; `study --json`, points",
            "an entrant over a network at a point of the grid",
            studied(|study| study.summary(&[], &[])),
        ),
        TableKind::new(
            "study-best",
            "study-best.csv, study-best.parquet; `study --json`, best",
            "an entrant on a network",
            studied(|study| study.answer_columns(&[], &GOAL)),
        ),
        TableKind::new(
            "study-pairs",
            "study-pairs.csv, study-pairs.parquet; `study --json`, pairs",
            "two entrants on a network, or on all that they have in common",
            studied(|study| study.pair_columns(&[])),
        ),
        TableKind::new(
            "bench",
            "gains.csv, gains.parquet of `study bench`; `study bench --json`, points",
            "the gains of a law",
            bench::tables::points(&[]),
        ),
        TableKind::new(
            "bench-fronts",
            "fronts.csv, fronts.parquet of `study bench`",
            "a law",
            bench::tables::fronts(&bench::Found::default()),
        ),
        TableKind::new(
            "bench-nearest",
            "nearest.csv, nearest.parquet of `study bench`; `study bench --json`, nearest",
            "a bound of what a hand feels, and which laws",
            bench::chooser::nearest(&bench::Found::default()),
        ),
        TableKind::new(
            "bench-runs",
            "all-runs.csv, all-runs.parquet of `study bench`; runs-1-of-1.csv",
            "a run",
            bench::tables::runs(&[]),
        ),
        TableKind::new(
            "bench-tunings",
            "all-tunings.csv, all-tunings.parquet of `study bench`; tunings-1-of-1.csv",
            "a tuning of a law",
            bench::tables::tunings(&[]),
        ),
        TableKind::new(
            "campaign",
            "`study networks --json`; laws-networks.csv, laws-networks.parquet",
            "a way to hold the copies together, and a network",
            campaign::columns(&[]),
        ),
        TableKind::new(
            "campaign-costs",
            "`study networks --costs --json`",
            "a network, and a way to hold the copies together",
            campaign::cost_columns(&[]),
        ),
        TableKind::new("laws", "laws.csv, laws.parquet", "a law", campaign::laws::tables::columns(&[])),
        TableKind::new(
            "laws-impedance",
            "laws-impedance.csv, laws-impedance.parquet",
            "a law, and a frequency",
            campaign::laws::tables::impedance_columns(&[]),
        ),
        TableKind::new(
            "paper",
            "paper.csv, reproduce-experiments.csv",
            "an experiment",
            paper::experiment_columns(&[]),
        ),
        TableKind::new(
            "paper-gains",
            "reproduce-gains.csv; `paper --json`, gains",
            "a way to hold the copies together",
            paper::gain_columns(&[]),
        ),
        TableKind::new("reproduce", "reproduce.csv", "a claim", reproduce::columns(&[])),
        TableKind::new("stability-paper", "figure4.csv, reproduce-figure-4.csv", crossing, figure4::table(&[])),
        TableKind::new("stability-map", "map-SCENE-KEY-KEY.csv", crossing, map.table()),
        TableKind::new("stability-rendering", "rendering.csv, reproduce-rendering.csv", crossing, maps::table(&[])),
        TableKind::new("accuracy", "accuracy.csv", "a choice", accuracy::columns([], true)),
        TableKind::new(
            "accuracy-precision",
            "`accuracy precision --json`",
            "a scene, until a time",
            precision::columns(&[]),
        ),
        TableKind::new(
            "accuracy-time",
            "`accuracy time --json`",
            "a scheme at a control rate",
            accuracy::timed::columns(&[]),
        ),
        TableKind::new(
            "accuracy-rigid",
            "`accuracy rigid --json`",
            "a number type at a step",
            accuracy::rigid::columns(&[]),
        ),
        TableKind::new(
            "force-response",
            "`accuracy force --json`, response",
            "a frequency",
            force::response_columns(&[]),
        ),
        TableKind::new("force-moving", "`accuracy force --json`, moving", "a command", force::moving_columns(&[])),
        TableKind::new(
            "transparency",
            "`accuracy transparency --json`, ends",
            "an end at a delay",
            transparency::columns(&[]),
        ),
        TableKind::new(
            "transparency-responses",
            "transparency.csv, transparency.parquet",
            "an end at a delay, and a frequency",
            transparency::response_columns(&[]),
        ),
        TableKind::new(
            "network-trace",
            "the FILE of `network trace`",
            "a copy of a packet, or a packet that is lost",
            Columns::named(trace::COLUMNS),
        ),
        TableKind::new("merge", "the OUT of `recording merge`", "an instant", Columns::named(merge::COLUMNS)),
        TableKind::new(
            "merge-axes",
            "the OUT of `recording merge` of several shared axes, behind the columns of one",
            "an instant",
            Columns::named(merge::columns(3).skip(merge::COLUMNS.len())),
        ),
        TableKind::new(
            "board",
            "the FILE.csv of `board operator --record`",
            "a tick that came",
            Columns::named(cohold_board_tools::recording::COLUMNS),
        ),
        TableKind::new("figure", "SVG and PDF: the data inside", "a point of a figure", Columns::named(DATA_COLUMNS)),
        TableKind::of("cooperate", both),
    ];
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
    kinds.extend(ui.tables.iter().flat_map(|tables| tables()));
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
