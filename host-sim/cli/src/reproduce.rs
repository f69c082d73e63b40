//! `cohold paper reproduce`: every table and figure of both papers, with a verdict on each claim.

use clap::Args;
use cohold_analysis::rendering::{identify, maps, picture as rendering};
use cohold_analysis::{figure4, picture};
use cohold_core::num::Scalar;
use cohold_studies::figures;
use cohold_studies::reproduce::paper::{DURATION_S, experiment_columns, experiments, gain_columns, gains};
use cohold_studies::reproduce::{Computed, Reproduced, columns, cooperation, counted, counts, page};
use serde_json::json;

use super::{Failure, Ui, flags::Out};

/// Device and object of the architectures paper's maps, which names neither: those of `stability rendering`.
const DEVICE_KG: f64 = 0.1;
const OBJECT_KG: f64 = 0.3;

#[derive(Debug, Args)]
pub(super) struct Reproduce {
    #[command(flatten)]
    out: Out,
}

impl Reproduce {
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let device = identify::device(DEVICE_KG, OBJECT_KG)?;
        let sweeps = maps::sweeps(&device);
        let points = figure4::COMMS.len() * figure4::DELAYS.len() * figure4::POINTS;
        let others: usize = ui.papers.iter().map(|paper| paper.steps).sum();
        let steps = points + others + sweeps.len() * maps::POINTS;
        let (found, wall_s) = ui.work(steps, "both papers", |step| {
            let (experiments, gains) = (experiments()?, gains()?);
            let curves = figure4::curves(step)?;
            let others = ui.papers.iter().map(|paper| (paper.reproduce)(step)).collect::<Result<Vec<_>, _>>()?;
            let curve = |(base, sweep)| maps::curve(&base, sweep, None, step);
            let maps = sweeps.into_iter().map(curve).collect::<Result<Vec<_>, _>>()?;
            let claims = cooperation(&Computed { experiments: &experiments, curves: &curves })?;
            Ok::<_, Failure>((experiments, gains, curves, others, maps, claims))
        })?;
        let (experiments, gains, curves, others, maps, mut claims) = found;
        let provenance =
            ui.provenance().with("number_type", f64::NAME).with("seconds", DURATION_S).with("scenes", "built in");
        let mut tables = vec![
            ("reproduce-experiments", experiment_columns(&experiments)),
            ("reproduce-gains", gain_columns(&gains)),
            ("reproduce-figure-4", figure4::table(&curves)),
            ("reproduce-rendering", maps::table(&maps)),
        ];
        let mut drawn = vec![("figure-4", picture::figure4(&curves))];
        drawn.extend(figures::paper(&experiments));
        drawn.push(("rendering", rendering::figure(&device, &maps)));
        for Reproduced { claims: more, tables: its, figures } in others {
            claims.extend(more);
            tables.extend(its);
            drawn.extend(figures);
        }
        let table = columns(&claims);
        let titles: Vec<(&str, String)> = drawn.iter().map(|(name, figure)| (*name, figure.title.clone())).collect();
        let mut files = ui.files(&self.out, "reproduce", "reproduce", &provenance, |files| {
            files.csv(&table)?;
            files.text("md", page(&claims, &titles, &tables[0].1));
            drawn.iter().try_for_each(|(name, figure)| files.figure(Some(name), figure))
        })?;
        for (name, table) in &tables {
            files.extend(ui.files(&self.out, "reproduce", name, &provenance, |files| files.csv(table))?);
        }
        let mut document = json!({
            "claims": table, "experiments": tables[0].1, "gains": tables[1].1, "wall_s": wall_s, "files": files,
        });
        for (name, count) in counts(&claims) {
            document[name.replace(' ', "_")] = count.into();
        }
        ui.document_of(&provenance, &document)?;
        writeln!(ui, "{}", page(&claims, &[], &tables[0].1));
        writeln!(ui, "{}, in {wall_s:.1} s", counted(&claims));
        ui.wrote(&files);
        Ok(())
    }
}
