//! `cohold study bench`: coordination laws tuned by one search under the same bounds, and tested on other networks.

use std::path::{Path, PathBuf};

use clap::Args;
use cohold_core::law::Sends;
use cohold_report::Provenance;
use cohold_studies::bench;
use cohold_studies::bench::chooser::{self, CHOOSER};
use cohold_studies::bench::page::{BENCH, PICTURE, sections};
use cohold_studies::bench::{Found, figure, tables};
use cohold_studies::campaign::laws::asked_for;
use cohold_studies::networks::{Network, TEST};
use serde_json::json;

use super::flags::Out;
use super::{Failure, Ui};

#[derive(Debug, Args)]
pub(super) struct Bench {
    /// A law to bench; may be repeated. Without it, every law that sends something.
    #[arg(long, value_name = "NAME")]
    law: Vec<String>,
    /// Tunings of each law; a small one is a rehearsal.
    #[arg(long, default_value_t = 240, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    budget: u32,
    /// Runs over each network that draws random numbers, from seed 1 on.
    #[arg(long, default_value_t = 4, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    seeds: u32,
    /// Searches of each law, with seeds from 1 on; how far apart they end is shown.
    #[arg(long, default_value_t = 3, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100))]
    searches: u32,
    /// A network that was measured, as one more to test on: a file of `irtt client -o`, or of `network trace` or `network measure`; may be repeated.
    #[arg(long, value_name = "FILE")]
    trace: Vec<PathBuf>,
    /// Also write into this page what belongs between its lines: the bench, with its picture beside the page, and which law is nearest; may be repeated.
    #[arg(long, value_name = "FILE")]
    page: Vec<PathBuf>,
    #[command(flatten)]
    out: Out,
}

impl Bench {
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        Ui::have(&self.page, &[&[CHOOSER], &BENCH[..]].concat())?;
        let bench = self.bench(ui)?;
        let question = bench.question(ui.provenance())?;
        let folder = ui.kept(&self.out, "bench/", &question);
        let kept = folder.as_deref().map(|folder| (folder, &question));
        let (found, wall_s) = ui.work(bench.steps(), "bench", |step| bench.run(kept, &|| step()))?;
        let mut files = match &folder {
            Some(folder) => self.files(ui, folder, &question, &found)?,
            None => Vec::new(),
        };
        let parts = [&[(CHOOSER, chooser::section(&found))], &sections(&bench, &found)[..]].concat();
        files.extend(Ui::rewrite(&self.page, &parts, Some((PICTURE, &figure::fronts(&found))))?);
        let (fronts, points) = (tables::fronts(&found), tables::points(&found.points));
        ui.document_of(&question, &json!({ "fronts": fronts, "nearest": chooser::nearest(&found), "points": points, "wall_s": wall_s, "files": files }))?;
        let [moved, felt] = tables::parts(&found);
        writeln!(
            ui,
            "True discrepancy of the worst test network, mm/N, at a law's own gains and at the best within each bound of what a hand feels\n"
        );
        ui.table(&fronts);
        ui.table(&chooser::nearest(&found));
        ui.table(&moved);
        ui.table(&felt);
        let runs: usize = found.points.iter().map(|point| point.runs.len()).sum();
        writeln!(ui, "{} tunings and {runs} runs in {wall_s:.0} s", found.tunings.len());
        ui.wrote(&files);
        Ok(())
    }

    /// What is asked.
    fn bench(&self, ui: &Ui) -> Result<bench::Bench, Failure> {
        let chosen = match self.law.as_slice() {
            [] => ui.laws.all().iter().filter(|law| law.sends != Sends::Nothing).collect(),
            names => asked_for(ui.laws, &names.join(",")).map_err(|error| format!("--law: {error}"))?,
        };
        let mut networks = Network::named(TEST);
        for trace in &self.trace {
            networks.push(Network::of_trace(trace).map_err(|error| format!("--trace: {error}"))?);
        }
        Ok(bench::Bench {
            laws: ui.laws,
            chosen,
            budget: self.budget as usize,
            seeds: self.seeds,
            searches: self.searches,
            networks,
            traces: self.trace.clone(),
        })
    }

    /// Tables and figure in the folder of the bench.
    fn files(&self, ui: &Ui, folder: &Path, question: &Provenance, found: &Found) -> Result<Vec<PathBuf>, Failure> {
        let out = self.out.in_folder(folder.to_owned());
        let runs: Vec<_> = found.points.iter().flat_map(|point| &point.runs).collect();
        let tables = [
            ("fronts", tables::fronts(found)),
            ("nearest", chooser::nearest(found)),
            ("gains", tables::points(&found.points)),
            ("all-runs", tables::runs(&runs)),
            ("all-tunings", tables::tunings(&found.tunings)),
        ];
        let mut files = Vec::new();
        for (name, table) in &tables {
            files.extend(ui.files(&out, "bench", name, question, |files| {
                files.csv(table)?;
                files.parquet(table)?;
                if *name == "fronts" { files.figure(None, &figure::fronts(found)) } else { Ok(()) }
            })?);
        }
        Ok(files)
    }
}
