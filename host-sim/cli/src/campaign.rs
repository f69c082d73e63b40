//! `cohold study networks` and `cohold study laws`: every kind of communications, one scene, or laws, over every kind of bad network.

use std::path::PathBuf;

use clap::Args;
use cohold_core::num::Scalar;
use cohold_studies::campaign::laws::page::{LAWS, PICTURE, sections};
use cohold_studies::campaign::laws::{asked_for, bench, figures, law_scenes, tables};
use cohold_studies::campaign::{Cell, campaign, columns, cost_columns, costs, of_scene};
use serde_json::json;

use super::flags::Out;
use super::{Failure, SceneArgs, Ui};

/// What the page tells beside the usual packets.
const EACH_TICK: [&str; 2] = ["timing.ticks_per_packet=1", "network.one_way_delay_packets=8"];

#[derive(Debug, Args)]
pub(super) struct Networks {
    #[command(flatten)]
    scene: SceneArgs,
    /// Instead: what every way to hold the copies together costs in delay, true discrepancy and transparency.
    #[arg(long, conflicts_with_all = ["scene", "set", "seed"])]
    costs: bool,
}

impl Networks {
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let (table, _) = ui.work(1, "runs over every network", |_| {
            Ok::<_, Failure>(match self.scene.is_given() {
                _ if self.costs => cost_columns(&costs(ui.laws)?),
                true => columns(&of_scene(ui.laws, &self.scene.name(), &self.scene.load(ui)?)?),
                false => columns(&campaign(ui.laws)?),
            })
        })?;
        ui.result(&table)
    }
}

#[derive(Debug, Args)]
pub(super) struct Laws {
    /// Which laws.
    #[arg(value_name = "all|LAW,…", default_value = "all")]
    names: String,
    #[command(flatten)]
    scene: SceneArgs,
    /// Also write the tables between their lines of this page, and the picture beside the page that shows it. May be repeated.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["scene", "set", "seed"])]
    page: Vec<PathBuf>,
    #[command(flatten)]
    out: Out,
}

impl Laws {
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        Ui::have(&self.page, &LAWS)?;
        let chosen = asked_for(ui.laws, &self.names)?;
        let (file, set) = self.scene.parts();
        let scenes = law_scenes(ui.laws, &chosen, file, &set)?;
        let (rows, wall_s) = ui.work(chosen.len(), "laws", |step| bench(ui.laws, &scenes, &|| step()))?;
        let cells: Vec<Cell> = rows.iter().flat_map(|row| row.cells.clone()).collect();
        let (table, networks, impedance) = (tables::columns(&rows), columns(&cells), tables::impedance_columns(&rows));
        let provenance = ui.provenance().with("number_type", f64::NAME).settings(scenes[0].settings());
        let mut files = Vec::new();
        // The impedance is drawn once: for a page if there is one.
        for (name, table, figure) in [
            ("laws", &table, None),
            ("laws-networks", &networks, None),
            ("laws-impedance", &impedance, self.page.is_empty().then(|| figures::impedance(&rows))),
        ] {
            files.extend(ui.files(&self.out, "laws", name, &provenance, |files| {
                files.csv(table)?;
                files.parquet(table)?;
                figure.map_or(Ok(()), |figure| files.figure(None, &figure))
            })?);
        }
        if !self.page.is_empty() {
            let scenes = law_scenes(ui.laws, &chosen, None, &EACH_TICK.map(str::to_owned))?;
            let (each_tick, _) = ui.work(chosen.len(), "laws", |step| bench(ui.laws, &scenes, &|| step()))?;
            let picture = (PICTURE, &figures::impedance(&rows));
            files.extend(Ui::rewrite(&self.page, &sections(&rows, &each_tick), Some(picture))?);
        }
        ui.document_of(
            &provenance,
            &json!({ "laws": table, "networks": networks, "impedance": impedance, "wall_s": wall_s, "files": files }),
        )?;
        ui.table(&table);
        writeln!(ui, "{} laws over {} networks in {wall_s:.0} s", rows.len(), cells.len() / rows.len().max(1));
        ui.wrote(&files);
        Ok(())
    }
}
