//! `host-sim compare`: scenes or laws beside each other, with the same seeds.

use std::path::{Path, PathBuf};

use clap::Args;
use haptic_core::num::Scalar;
use haptic_report::Provenance;
use haptic_sim::scenes;
use haptic_sim::user::User;
use haptic_studies::campaign::laws::law_scene;
use haptic_studies::compare::{Comparison, Entrant};
use haptic_studies::sweep::METRICS;
use serde_json::json;

use super::flags::{Out, Time};
use super::{Failure, Ui};

#[derive(Debug, Args)]
pub(super) struct Compare {
    /// Built-in scenes, scene files, or laws, each with settings of its own; the first is what the others are compared with.
    #[arg(required = true, num_args = 2.., value_name = "SCENE|LAW[,TABLE.KEY=VALUE…]")]
    scenes: Vec<String>,
    /// Scene in which laws are tried, at the gains that each declares; without it, that of the campaign.
    #[arg(long, value_name = "NAME|FILE")]
    scene: Option<PathBuf>,
    /// Override one key of all of them; may be repeated.
    #[arg(long = "set", value_name = "TABLE.KEY=VALUE")]
    set: Vec<String>,
    /// First seed; without it, the first scene's.
    #[arg(long, value_name = "N")]
    seed: Option<u32>,
    /// Runs of every scene, with that seed and those after it.
    #[arg(long, default_value_t = 20, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    seeds: u32,
    /// Figure of merit to show; may be repeated. The files hold all.
    #[arg(long, value_name = "NAME", value_parser = merit)]
    merit: Vec<usize>,
    #[command(flatten)]
    time: Time,
    #[command(flatten)]
    out: Out,
}

impl Compare {
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let entrants = self.scenes.iter().map(|text| self.entrant(ui, text)).collect::<Result<Vec<_>, _>>()?;
        for entrant in &entrants {
            self.time.check(&entrant.scene)?;
            if !entrant.scene.users.iter().any(User::acts) {
                ui.warn(format_args!("{}: nobody pushes: set user.1.push_n", entrant.name));
            }
        }
        let provenance = self.provenance(ui, &entrants);
        let comparison = Comparison { entrants, seeds: self.seeds, seconds: self.time.seconds };
        let jobs = comparison.entrants.len() * self.seeds as usize;
        let (rows, wall_s) = ui.work(jobs, "runs", |step| comparison.run(&|| step()))?;
        let differences = comparison.differences(&rows);
        let every: Vec<usize> = (0..METRICS.len()).collect();
        let usual = || every.iter().copied().filter(|at| METRICS[*at].shown).collect();
        let shown = if self.merit.is_empty() { usual() } else { self.merit.clone() };
        let all = comparison.columns(&differences, &every);
        let mut files = ui.files(&self.out, "compare", "compare", &provenance, |files| {
            files.csv(&all)?;
            files.parquet(&all)?;
            files.figure(None, &comparison.figure(&differences, &shown))
        })?;
        let runs = comparison.runs(&rows);
        files.extend(ui.files(&self.out, "compare", "compare-runs", &provenance, |files| {
            files.csv(&runs)?;
            files.parquet(&runs)
        })?);
        let failed = rows.iter().filter(|row| !row.reason.is_empty()).count();
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

    /// A scene, or a law in the scene for laws, with the settings of all and then its own.
    fn entrant(&self, ui: &Ui, text: &str) -> Result<Entrant, Failure> {
        let mut parts = text.split(',').map(str::trim);
        let name = parts.next().unwrap_or_default();
        let own = parts.map(str::to_owned);
        let seed = self.seed.map(|seed| format!("network.seed={seed}"));
        let settings: Vec<String> = self.set.iter().cloned().chain(own).chain(seed).collect();
        let law = ui.laws.all().iter().find(|law| law.name == name);
        let scene = match law {
            Some(law) => law_scene(ui.laws, law, self.scene.as_deref(), &settings).map_err(Failure::from),
            None => scenes::find(ui.laws, Some(Path::new(name)), &settings).map_err(Failure::from),
        };
        let laws = || ui.laws.all().iter().map(|law| law.name).collect::<Vec<_>>().join(", ");
        let scene = scene.map_err(|error| match law {
            None if !Path::new(name).exists() && scenes::text(name).is_none() => {
                format!("{error}; the laws are {}", laws())
            }
            _ => format!("{text}: {error}"),
        })?;
        Ok(Entrant { name: text.to_owned(), scene })
    }

    /// The first scene's settings, and in what each other one is not as it.
    fn provenance(&self, ui: &Ui, entrants: &[Entrant]) -> Provenance {
        let first = entrants[0].scene.settings();
        let mut provenance = ui.provenance().with("number_type", f64::NAME).with("seconds", self.time.seconds);
        provenance = provenance.with("seeds", self.seeds).with("scene_1", entrants[0].name.as_str());
        for (number, entrant) in (2..).zip(&entrants[1..]) {
            let other = entrant.scene.settings();
            let changed = other.iter().filter(|setting| !first.contains(setting));
            let gone = first.iter().filter(|(key, _)| !other.iter().any(|(known, _)| known == key));
            let texts = changed.map(|(key, value)| format!("{key}={value}"));
            let texts: Vec<String> = texts.chain(gone.map(|(key, _)| format!("{key} as usual"))).collect();
            provenance = provenance.with(&format!("scene_{number}"), entrant.name.as_str());
            provenance = provenance.with(&format!("scene_{number}_differs"), texts.join(", "));
        }
        provenance.settings(first)
    }
}

/// The number of a figure of merit with this name.
fn merit(text: &str) -> Result<usize, Failure> {
    let names: Vec<String> = METRICS.iter().map(|merit| merit.name()).collect();
    names.iter().position(|name| name == text).ok_or_else(|| format!("they are {}", names.join(", ")).into())
}
