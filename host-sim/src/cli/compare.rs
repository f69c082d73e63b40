//! `host-sim compare`: scenes or laws beside each other, with the same seeds.

use clap::Args;
use haptic_core::num::Scalar;
use haptic_report::Provenance;
use haptic_studies::compare::Comparison;
use haptic_studies::entrant::Entrant;
use haptic_studies::study::answers::metric;
use haptic_studies::sweep::METRICS;
use serde_json::json;

use super::entrants::EntrantArgs;
use super::flags::{Out, Time};
use super::grid::run;
use super::{Failure, Ui};

#[derive(Debug, Args)]
pub(super) struct Compare {
    /// Built-in scenes, scene files, or laws, each with settings of its own; the first is what the others are compared with.
    #[arg(required = true, num_args = 2.., value_name = "SCENE|LAW[,TABLE.KEY=VALUE…]")]
    scenes: Vec<String>,
    #[command(flatten)]
    entrants: EntrantArgs,
    /// Runs of every scene, with that seed and those after it.
    #[arg(long, default_value_t = 20, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    seeds: u32,
    /// Figure of merit to show; may be repeated. The files hold all.
    #[arg(long, value_name = "NAME", value_parser = metric)]
    merit: Vec<usize>,
    #[command(flatten)]
    time: Time,
    #[command(flatten)]
    out: Out,
}

impl Compare {
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let entrants = self.entrants.load(ui, &self.scenes, self.time)?;
        let provenance = self.provenance(ui, &entrants);
        let comparison = Comparison { entrants, seeds: self.seeds, seconds: self.time.seconds };
        let done = run(ui, &comparison, "runs", None, &provenance, (1, 1))?;
        let (rows, wall_s, failed) = (&done.rows, done.wall_s, done.failed());
        let differences = comparison.differences(rows);
        let every: Vec<usize> = (0..METRICS.len()).collect();
        let usual = || every.iter().copied().filter(|at| METRICS[*at].shown).collect();
        let shown = if self.merit.is_empty() { usual() } else { self.merit.clone() };
        let all = comparison.columns(&differences, &every);
        let mut files = ui.files(&self.out, "compare", "compare", &provenance, |files| {
            files.csv(&all)?;
            files.parquet(&all)?;
            files.figure(None, &comparison.figure(&differences, &shown))
        })?;
        let runs = comparison.runs(rows);
        files.extend(ui.files(&self.out, "compare", "compare-runs", &provenance, |files| {
            files.csv(&runs)?;
            files.parquet(&runs)
        })?);
        let scenes = rows.chunk_by(|one, other| one.point == other.point);
        let grows = scenes.filter(|runs| !runs[0].every_mode_stable());
        let grow: Vec<&str> = grows.map(|runs| comparison.entrants[runs[0].point].name.as_str()).collect();
        ui.document_of(
            &provenance,
            &json!({
                "differences": all, "runs": rows.len(), "not_stable_runs": failed, "not_stable_in_every_mode": grow,
                "wall_s": wall_s, "files": files,
            }),
        )?;
        writeln!(ui, "Differences from {}\n", comparison.entrants[0].name);
        ui.table(&comparison.columns(&differences, &shown));
        writeln!(ui, "{} runs, {failed} of them not stable, in {wall_s:.1} s", rows.len());
        if !grow.is_empty() {
            let grow = grow.join(", ");
            writeln!(ui, "not stable in every mode, where a hand lets go, at another delay or a wall: {grow}");
        }
        ui.wrote(&files);
        Ok(())
    }

    /// The first scene's settings, and in what each other one is not as it.
    fn provenance(&self, ui: &Ui, entrants: &[Entrant]) -> Provenance {
        let provenance = ui.provenance().with("number_type", f64::NAME).with("seconds", self.time.seconds);
        Entrant::told(entrants, provenance.with("seeds", self.seeds))
    }
}
