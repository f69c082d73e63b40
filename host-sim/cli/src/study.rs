//! `cohold study`: scenes or laws over keys, networks and seeds: which is best where, under which bounds, and how sure that is.

use std::path::{Path, PathBuf};

use clap::Args;
use cohold_core::names::Choice;
use cohold_report::{Columns, Provenance};
use cohold_sim::run::Until;
use cohold_sim::user::User;
use cohold_studies::entrant::Entrant;
use cohold_studies::study::answers::{Answer, Bound, Goal, metric};
use cohold_studies::study::halving::Search;
use cohold_studies::study::{Network, OWN, Study as Asked};
use cohold_studies::sweep::{Plan, Row};
use serde_json::json;

use super::bench::Bench;
use super::campaign::{Laws, Networks};
use super::flags::{Out, Time, choice};
use super::grid::{GridArgs, run, search};
use super::sweep::Sweep;
use super::{Failure, SceneArgs, Ui};

/// Most rows of a table that are printed for people.
const MOST_SHOWN: usize = 60;

super::commands! {
    /// Studies whose plan, or whose tables, are given.
    pub(crate) StudyCommands {
        /// A scene over ranges of its keys and over seeds: a row a run, means with their intervals; goes on where it was stopped.
        Sweep(Sweep),
        /// Laws beside each other, fairly: tuned by one search under the same bounds, tested on other networks; goes on where it was stopped.
        Bench(Bench),
        /// Every kind of communications over every kind of bad network: loss, bursts, jitter, reorder, drift.
        Networks(Networks),
        /// Laws in one scene, each at the gains that it declares: what they promise, over every kind of bad network, and what a hand feels.
        Laws(Laws),
    }
}

#[derive(Debug, Args)]
#[command(mut_arg("scene", |arg| arg.help("Scene in which laws are tried, at the gains that each declares [default: the campaign's scene]")))]
#[command(mut_arg("set", |arg| arg.help("Override one key of all of them. May be repeated")))]
#[command(mut_arg("seed", |arg| arg.help("First seed [default: the first scene's]")))]
#[command(mut_arg("seeds", |arg| arg.default_value("20").help("Runs of every point, with the first seed and those after it; the first half chooses, the other half judges")))]
pub(super) struct Study {
    /// Built-in scenes, scene files, or laws, each with settings of its own.
    #[arg(required = true, value_name = "SCENE|LAW[,TABLE.KEY=VALUE…]")]
    entrants: Vec<String>,
    #[command(flatten)]
    scene: SceneArgs,
    /// A network that all are run over, by name; `own`, as each scene has it; or `all`. May be repeated; `own` without it.
    #[arg(long, value_name = "NAME|all", value_parser = networks)]
    network: Vec<OfOneName>,
    /// A network that was measured: a file of `irtt client -o`, or of `network trace` or `network measure`; may be repeated.
    #[arg(long, value_name = "FILE")]
    trace: Vec<PathBuf>,
    #[command(flatten)]
    grid: GridArgs,
    /// Figure of merit that is to be least.
    #[arg(long, value_name = "NAME", default_value = "true_discrepancy_mm", value_parser = metric)]
    best: usize,
    /// A figure of merit, and the most that it may be in any run; may be repeated.
    #[arg(long, value_name = "NAME=MOST")]
    at_most: Vec<Bound>,
    /// Which runs are done: all (`grid`), or those that decide which point is best under these bounds (`halving`). Runs that are there are
    /// taken by either.
    #[arg(long, value_name = "SEARCH", default_value = "grid", value_parser = choice::<Search>())]
    search: Search,
    #[command(flatten)]
    time: Time,
    #[command(flatten)]
    out: Out,
}

/// Networks of a name.
type OfOneName = Box<[Network]>;

fn networks(text: &str) -> Result<OfOneName, cohold_studies::Error> {
    Network::of(text).map(Vec::into_boxed_slice)
}

impl Study {
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let study = self.study(ui)?;
        let question = study.question(ui.provenance())?;
        let folder = ui.kept(&self.out, "study/", &question);
        let goal = Goal { metric: self.best, bounds: self.at_most.clone() };
        // What is run depends on the goal where not all is: then the files say both.
        let (mut done, left_out, answers, asked, told) = match self.search {
            Search::Grid => {
                let done = run(ui, &study, Until::TheEnd, "study", folder.clone(), &question, self.grid.shard)?;
                let answers = study.answers(&done.rows, &goal);
                (done, Vec::new(), answers, question.clone(), question.clone())
            }
            Search::Halving => {
                let (done, left_out) = search(ui, &study, &goal, folder.clone(), &question, self.grid.shard)?;
                let answers = study.searched_answers(&done.rows, &left_out, &goal);
                let asked = question.clone().with("search", self.search.name());
                let told = goal.told(asked.clone());
                (done, left_out, answers, asked, told)
            }
        };
        let points = study.summary(&done.rows, &left_out);
        let mut files = done.finish("study", &told, |rows| study.columns(rows))?;
        if let Some(folder) = folder.filter(|_| done.whole) {
            files.extend(self.files(ui, &folder, &asked, &study, &done.rows, &answers, &points, &goal)?);
        }
        let pairs = study.pairs(&done.rows, &answers, &goal);
        let (best, beside) = (study.answer_columns(&answers, &goal), study.pair_columns(&pairs));
        ui.document_of(
            &question,
            &json!({
                "best": best, "pairs": beside, "points": points, "points_not_run": left_out.len(), "runs": done.rows.len(),
                "of_runs": study.runs(), "new_runs": done.new, "not_stable_runs": done.failed(), "wall_s": done.wall_s,
                "files": files,
            }),
        )?;
        writeln!(ui, "Least {}, judged on seeds that did not choose\n", goal.what());
        for table in [best, beside].iter().filter(|table| !table.is_empty()) {
            if table.len() <= MOST_SHOWN {
                ui.table(table);
            } else {
                writeln!(ui, "{} rows: too many to print\n", table.len());
            }
        }
        let spared = study.runs() - done.rows.len();
        let mut spared = if done.whole && spared > 0 { format!(", {spared} spared") } else { String::new() };
        if !left_out.is_empty() {
            spared += &format!(", {} points not run because not stable in every mode", left_out.len());
        }
        writeln!(ui, "{}", done.said(study.runs(), &spared));
        ui.wrote(&files);
        Ok(())
    }

    /// What is asked.
    fn study(&self, ui: &Ui) -> Result<Asked, Failure> {
        let (scene, set) = self.scene.parts();
        let of = |text: &String| Entrant::of(ui.laws, text, scene, &set);
        let mut entrants = self.entrants.iter().map(of).collect::<Result<Vec<_>, _>>()?;
        for entrant in &mut entrants {
            let network = &mut entrant.scene.world.network;
            network.seed = self.scene.seed.unwrap_or(network.seed);
            self.time.check(&entrant.scene)?;
            if !entrant.scene.users.iter().any(User::acts) {
                ui.warn(format_args!("{}: nobody pushes: set user.1.push_n", entrant.name));
            }
        }
        let mut networks: Vec<Network> = self.network.iter().flatten().cloned().collect();
        for trace in &self.trace {
            networks.push(Network::of_trace(trace).map_err(|error| format!("--trace: {error}"))?);
        }
        if networks.is_empty() {
            networks = Network::of(OWN)?;
        }
        let (grid, sample) = (&self.grid, self.grid.sample()?);
        let study = Asked::new(entrants, networks, &grid.over, sample.as_ref(), grid.seeds, self.time.seconds)?;
        study.check()?;
        Ok(study)
    }

    /// Tables and figures of the answers, in the folder of the study.
    #[allow(clippy::too_many_arguments)]
    fn files(
        &self,
        ui: &Ui,
        folder: &Path,
        question: &Provenance,
        study: &Asked,
        rows: &[Row],
        answers: &[Answer],
        points: &Columns,
        goal: &Goal,
    ) -> Result<Vec<PathBuf>, Failure> {
        let out = self.out.in_folder(folder.to_owned());
        let goal_told = goal.told(question.clone());
        let best = study.answer_columns(answers, goal);
        let mut files = ui.files(&out, "study", "study-best", &goal_told, |files| {
            files.csv(&best)?;
            files.parquet(&best)?;
            for (number, figure) in (1..).zip(study.figures(rows, answers, goal)) {
                let name = if number > 1 { Some(format!("study-best-figure-{number}")) } else { None };
                files.figure(name.as_deref(), &figure)?;
            }
            Ok(())
        })?;
        let pairs = study.pair_columns(&study.pairs(rows, answers, goal));
        for (name, table) in [("study-pairs", &pairs), ("study-points", points)] {
            files.extend(ui.files(&out, "study", name, &goal_told, |files| {
                files.csv(table)?;
                files.parquet(table)
            })?);
        }
        Ok(files)
    }
}
