//! `cohold study sweep`: a scene over a grid or a sample of its keys, and over seeds.

use clap::Args;
use cohold_sim::run::Until;
use cohold_sim::user::User;
use cohold_studies::sweep;
use cohold_studies::sweep::Plan;
use serde_json::json;

use super::flags::{Out, Time};
use super::grid::{GridArgs, run};
use super::{Failure, SceneArgs, Ui};

/// Most points that are printed for people.
const MOST_SHOWN: usize = 200;

#[derive(Debug, Args)]
#[command(mut_arg("over", |arg| arg.required_unless_present("sample")))]
pub(super) struct Sweep {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    time: Time,
    #[command(flatten)]
    grid: GridArgs,
    #[command(flatten)]
    out: Out,
}

impl Sweep {
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let scene = self.scene.load(ui)?;
        self.time.check(&scene)?;
        let (axes, seeds, sample) = (self.grid.over.clone(), self.grid.seeds, self.grid.sample()?);
        let sweep = sweep::Sweep { scene, axes, sample, seeds, seconds: self.time.seconds };
        sweep.check()?;
        if !sweep.scene.users.iter().any(User::acts) && !sweep.keys().any(|key| key.starts_with("user.")) {
            ui.warn("nobody pushes: set user.1.push_n (or load a scene)");
        }
        let question = sweep.question(ui.provenance())?;
        let folder = ui.kept(&self.out, &format!("sweep/{}-", self.scene.name()), &question);
        let until = if folder.is_some() { Until::TheEnd } else { Until::Stopped };
        let mut done = run(ui, &sweep, until, "sweep", folder, &question, self.grid.shard)?;
        let files = done.finish("sweep", &question, |rows| sweep.columns(rows))?;
        let (rows, new, wall_s, failed) = (&done.rows, done.new, done.wall_s, done.failed());
        let summary = sweep.summary(rows);
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
        writeln!(ui, "{}", done.said(sweep.runs(), ""));
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
}
