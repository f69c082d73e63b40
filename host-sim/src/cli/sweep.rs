//! `host-sim sweep`: a scene over a grid or a sample of its keys, and over seeds.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use clap::Args;
use haptic_report::Provenance;
use haptic_sim::user::User;
use haptic_studies::sweep;
use haptic_studies::sweep::{Axis, Design, Journal, Sample, Spread};
use serde_json::json;

use super::flags::{Out, Time, choice};
use super::{Failure, SceneArgs, Ui};

/// Most points that are printed for people.
const MOST_SHOWN: usize = 200;

#[derive(Debug, Args)]
pub(super) struct Sweep {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    time: Time,
    /// A key and its values: N from A to B, at equal ratios with :log, or those of a list; repeat it for a grid.
    #[arg(long, required_unless_present = "sample", value_name = "TABLE.KEY=A..B:N[:log]|X,Y,Z")]
    over: Vec<Axis>,
    /// A key that is drawn from a range, at equal ratios with :log, or from a list; repeat it. At each point of the grid.
    #[arg(long, requires = "points", value_name = "TABLE.KEY=A..B[:log|:whole]|X,Y,Z")]
    sample: Vec<Spread>,
    /// Points of the sample.
    #[arg(long, requires = "sample", value_name = "N")]
    points: Option<usize>,
    /// How they are spread.
    #[arg(long, requires = "sample", default_value = "sobol", value_parser = choice::<Design>())]
    design: Design,
    /// Another sample of the same design.
    #[arg(long, requires = "sample", default_value_t = 1, value_name = "N")]
    sample_seed: u32,
    /// Runs of every point, with the scene's seed and those after it.
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    seeds: u32,
    /// Only the points of shard I of N; without it all, those that shards have done in the same folder included.
    #[arg(long, default_value = "1/1", value_name = "I/N", value_parser = shard, requires = "out")]
    shard: (usize, usize),
    #[command(flatten)]
    out: Out,
}

impl Sweep {
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let scene = self.scene.load(ui)?;
        self.time.check(&scene)?;
        let (axes, seeds, seconds) = (self.over.clone(), self.seeds, self.time.seconds);
        let sample = |points| Sample::new(self.design, points, self.sample_seed, self.sample.clone());
        let sample = self.points.map(sample).transpose()?;
        let sweep = sweep::Sweep { scene, axes, sample, seeds, seconds };
        sweep.check()?;
        if !sweep.scene.users.iter().any(User::acts) && !sweep.keys().any(|key| key.starts_with("user.")) {
            ui.warn("nobody pushes: set user.1.push_n (or load a scene)");
        }
        let question = sweep.question(ui.provenance())?;
        let folder = ui.writes(&self.out).then(|| self.folder(&question));
        let (journal, there) = match &folder {
            Some(folder) => {
                Journal::open(folder, &question, self.shard).map(|(journal, rows)| (Some(journal), rows))?
            }
            None => (None, Vec::new()),
        };
        let points = || sweep.points_of(self.shard);
        let all: BTreeSet<usize> = points().collect();
        let new: usize = sweep.missing(&all, &there).iter().map(|(_, seeds)| seeds.len()).sum();
        let (rows, wall_s) = ui.work(new, "sweep", |step| {
            sweep.run(points(), there, &|row| {
                step();
                journal.as_ref().map_or(Ok(()), |journal| journal.append(row))
            })
        })?;
        let summary = sweep.summary(&rows);
        let whole = rows.len() == sweep.runs();
        let files = match &folder {
            Some(folder) if whole => sweep::write(folder, &sweep.columns(&rows), &question)?,
            _ => Vec::new(),
        };
        if let Some(journal) = journal {
            journal.finish()?;
        }
        let failed = rows.iter().filter(|row| !row.reason.is_empty()).count();
        ui.document_of(
            &question,
            &json!({
                "points": summary, "runs": rows.len(), "of_runs": sweep.runs(), "new_runs": new, "not_stable_runs": failed,
                "wall_s": wall_s, "files": files,
            }),
        )?;
        if summary.len() <= MOST_SHOWN {
            ui.table(&summary);
        } else {
            writeln!(ui, "{} points: too many to print", summary.len());
        }
        writeln!(
            ui,
            "{} runs of {}, {failed} of them not stable; {new} new ones in {wall_s:.1} s",
            rows.len(),
            sweep.runs()
        );
        let let_go = rows.chunk_by(|one, other| one.point == other.point).filter(|runs| !runs[0].every_mode_stable());
        let (let_go, points) = (let_go.count(), summary.len());
        if let_go > 0 {
            writeln!(
                ui,
                "{let_go} of {points} points are not stable in every mode (let go): runs tell of both hands on, and these \
                 grow where a hand lets go, or at another delay or a wall; `stability point` says what to change"
            );
        }
        ui.wrote(&files);
        Ok(())
    }

    /// Where it is kept: one folder for a question, so that asking again goes on.
    fn folder(&self, question: &Provenance) -> PathBuf {
        let usual = || Path::new("out/sweep").join(format!("{}-{}", self.scene.name(), sweep::tag(question)));
        self.out.out.clone().unwrap_or_else(usual)
    }
}

/// `I/N` on the command line.
fn shard(text: &str) -> Result<(usize, usize), Failure> {
    let parts = text.split_once('/').and_then(|(shard, shards)| Some((shard.parse().ok()?, shards.parse().ok()?)));
    parts.filter(|(shard, shards)| (1..=*shards).contains(shard)).ok_or_else(|| "write it as I/N, I from 1 to N".into())
}
