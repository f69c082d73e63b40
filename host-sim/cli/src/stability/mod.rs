//! `cohold stability`: verdicts, limits and regions, from the code that flies.

mod rendering;
mod tune;

use std::time::Instant;

use clap::Args;
use cohold_analysis::figure4::{self, Curve};
use cohold_analysis::{Axis, Column, Effort, Hands, Mode, Range, Verdict, advice, judge, map, picture};
use cohold_core::names::Choice;
use cohold_core::num::Scalar;
use cohold_report::Columns;
use cohold_sim::scene::Scene;
use serde_json::json;

use crate::flags::{Out, choice};
use crate::ui::{Unsuccessful, and};
use crate::{Failure, SceneArgs, Ui};

super::commands! {
    pub(crate) Question {
        /// Is this scene stable, with both hands on, one, none? Spectral radii of one packet period, rest modes left out.
        Point(Point),
        /// At which values of one key does that change? All of them, pockets included.
        Limit(Limit),
        /// The region in two keys, as file and picture.
        Map(Map),
        /// Figure 4 of the cooperation paper: three ways to communicate, four delays.
        Paper(Paper),
        /// Figure 4 of the architectures paper: one device, one object, largest stiffness against delay and sampling period.
        Rendering(rendering::Rendering),
        /// The stiffest contact and coordination that leave a margin, for this device, network and loop.
        Tune(tune::Tune),
        /// Forces stay within their limits, law by law: shown for every number from the code that flies.
        Prove(crate::prove::Prove),
    }
}

#[derive(Debug, Args)]
pub(crate) struct Point {
    #[command(flatten)]
    scene: SceneArgs,
}

impl Point {
    fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let scene = self.scene.load(ui)?;
        let (judgement, _) = ui.work(1, "verdict", |_| judge(&scene))?;
        let Verdict { stable, spectral_radius, not_judged_because, .. } = judgement.worst;
        let (said, why) = match not_judged_because {
            _ if stable => ("stable", String::new()),
            Some(because) => ("not judged", format!(", because {because}")),
            None => ("unstable", format!(": spectral radius {spectral_radius:.6}")),
        };
        // Each answer is printed when it is known: the advice takes the longest.
        writeln!(ui, "{}: {said}\n", self.scene.name());
        let at_delay = |mode: &Mode| match mode.at_delay_ticks {
            Some([to_first, to_second]) => format!("{to_first} and {to_second}"),
            None => "its own".to_owned(),
        };
        let at_tautness = |mode: &Mode| mode.at_tautness.map_or("its own".to_owned(), |share| format!("{share:.2}"));
        let table = Columns::of(&judgement.modes)
            .value("mode", |mode| mode.name())
            .head("hands on")
            .value("stable", |mode| mode.verdict.stable)
            .number("spectral_radius", 9, |mode| mode.verdict.spectral_radius)
            .value("at_delay_ticks", at_delay)
            .head("at delay")
            .value("states", |mode| mode.verdict.states)
            .value("rest_modes", |mode| mode.verdict.rest_modes)
            .head("rest modes left out");
        let table = match judgement.worst.line_ticks {
            Some(_) => table.value("line_ticks", |mode| mode.verdict.line_ticks).head("line, ticks"),
            None => table,
        };
        let table = match judgement.modes.iter().any(|mode| mode.at_tautness.is_some()) {
            true => table.value("at_tautness", at_tautness).head("at tautness"),
            false => table,
        };
        let table = match judgement.worst.direction {
            Some(_) => table
                .value("direction", |mode| mode.verdict.direction.map(|direction| direction.to_string()))
                .head("worst direction"),
            None => table,
        };
        writeln!(ui, "{}\n{}", table.done(), modes(None, &scene));
        let (advice, _) = ui.work(1, "advice", |_| advice(&scene))?;
        writeln!(ui, "{advice}\nNot judged: {}.", judgement.not_judged.join("; "));
        let report = and(json!(judgement), &json!({ "advice": advice }))?;
        ui.document_of(&ui.provenance().settings(scene.settings()), &report)?;
        if stable {
            return Ok(());
        }
        Err(Unsuccessful(format!("{} is {said}{why}", self.scene.name())).into())
    }
}

#[derive(Debug, Args)]
pub(crate) struct Limit {
    #[command(flatten)]
    scene: SceneArgs,
    /// The key to change: any number of a scene (`--keys` lists them).
    #[arg(long, value_name = "TABLE.KEY")]
    of: String,
    /// First value.
    #[arg(long, value_name = "A")]
    from: f64,
    /// Last value.
    #[arg(long, value_name = "B")]
    to: f64,
    #[command(flatten)]
    only: Only,
}

/// Which of the modes that a scene can enter.
#[derive(Debug, Args)]
struct Only {
    /// Look at one mode only; without it the worst of all that the scene can enter decides.
    #[arg(long, value_parser = choice::<Hands>())]
    hands: Option<Hands>,
}

impl Only {
    /// What was looked at.
    fn name(&self) -> &'static str {
        self.hands.map_or("every mode", Hands::name)
    }
}

/// The modes that a printed verdict or limit holds for, in words: hands, arms, walls.
fn modes(hands: Option<Hands>, scene: &Scene) -> String {
    let hands = hands.map_or("both, one, none", Hands::name);
    let arms = match scene.users.each_ref().map(|user| user.settings.user.arm_stiffness_n_per_m) {
        [0.0, 0.0] => "no arms".to_owned(),
        [one, two] => format!("arms of {one} and {two} N/m"),
    };
    let walls = if scene.at_walls().is_some() { "; away from walls and at them" } else { "" };
    format!("Judged with hands on: {hands}; {arms}{walls}.")
}

impl Limit {
    fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let scene = self.scene.load(ui)?;
        let (of, from, to) = (self.of.as_str(), self.from, self.to);
        let effort = Effort { hands: self.only.hands, ..Effort::default() };
        let start = Instant::now();
        let limit = cohold_analysis::limit(&scene, Range { key: self.of.clone(), from, to }, effort)?;
        let report = and(json!({ "of": of, "from": from, "to": to, "hands": self.only.hands }), &limit)?;
        let report = and(report, &json!({ "wall_s": start.elapsed().as_secs_f64() }))?;
        ui.document_of(&ui.provenance().settings(scene.settings()), &report)?;
        let not_judged = limit.not_judged_because.map(|because| format!("not judged, because {because}"));
        let word = |stable: bool| if stable { "stable" } else { not_judged.as_deref().unwrap_or("unstable") };
        // Of every mode, so that each number has its name.
        let mut crossings: Vec<f64> = limit.modes.iter().flat_map(|one| one.limit.crossings.iter().copied()).collect();
        crossings.sort_by(f64::total_cmp);
        let row = |shown: String, value: f64, more: &str| {
            let modes: Vec<&str> = limit.unstable_modes(value).collect();
            (shown, format!("{}{more}", word(modes.is_empty())), modes.join("; "))
        };
        let mut rows = vec![row(from.to_string(), from, "")];
        rows.extend(crossings.iter().map(|key| row(format!("{key:.6}"), key.next_up(), " from here on")));
        rows.push(row(to.to_string(), to, ""));
        let table = Columns::of(&rows).value(of, |row| row.0.as_str()).head(of).shown_in("", 1.0);
        let table = table.value("", |row| row.1.as_str());
        writeln!(ui, "{}\n", modes(self.only.hands, &scene));
        ui.table(&table.value("unstable_with", |row| row.2.as_str()).head("unstable with hands on").done());
        Ok(())
    }
}

#[derive(Debug, Args)]
pub(crate) struct Map {
    #[command(flatten)]
    scene: SceneArgs,
    /// Horizontal axis: key, first and last value, how many.
    #[arg(long, value_name = "KEY=A..B:N")]
    x: Axis,
    /// Vertical axis; along it all crossings are found, N is the grid of the picture.
    #[arg(long, value_name = "KEY=A..B:N")]
    y: Axis,
    #[command(flatten)]
    only: Only,
    #[command(flatten)]
    out: Out,
}

impl Map {
    fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let scene = self.scene.load(ui)?;
        let effort = Effort { steps: (2 * self.y.count).max(200), hands: self.only.hands, ..Effort::default() };
        let axes = [self.x.clone(), self.y.clone()];
        let (found, wall_s) = ui.work(self.x.count, "columns", |step| map(&scene, axes, effort, step))?;
        let provenance = ui.provenance().settings(scene.settings()).with("hands", self.only.name());
        let name = format!("map-{}-{}-{}", self.scene.run_name(&scene), self.x.range.key, self.y.range.key);
        let files = ui.files(&self.out, "stability", &name, &provenance, |files| {
            files.csv(&found.table())?;
            files.figure(
                None,
                &picture::region(
                    &format!("Stability region of {}, hands on: {}", self.scene.name(), self.only.name()),
                    &found,
                ),
            )
        })?;
        let (Range { key: x, .. }, Range { key: y, from, to }) = (&self.x.range, &self.y.range);
        let evaluations = found.evaluations();
        ui.document_of(
            &provenance,
            &json!({
                "x": x, "y": y, "y_from": from, "y_to": to, "hands": self.only.hands,
                "columns": found.columns, "evaluations": evaluations, "wall_s": wall_s, "files": files,
            }),
        )?;
        let table = Columns::of(&found.columns)
            .number(x, 5, |column| column.x)
            .head(x)
            .shown_in("", 1.0)
            .value("start", |column| match column.limit {
                cohold_analysis::Limit { stable_at_start: true, .. } => "stable",
                cohold_analysis::Limit { not_judged_because: Some(_), .. } => "not judged",
                _ => "unstable",
            })
            .head("at the lowest")
            .number(y, 5, |column| column.limit.crossings.clone())
            .head(y)
            .shown_in("", 1.0)
            .done();
        writeln!(ui, "{table}\n{}\n{evaluations} spectral radii in {wall_s:.2} s", modes(self.only.hands, &scene));
        ui.wrote(&files);
        Ok(())
    }
}

#[derive(Debug, Args)]
pub(crate) struct Paper {
    #[command(flatten)]
    out: Out,
}

impl Paper {
    fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let points = figure4::COMMS.len() * figure4::DELAYS.len() * figure4::POINTS;
        let (curves, wall_s) = ui.work(points, "Figure 4", |step| figure4::curves(step))?;
        let provenance = ui.provenance().with("number_type", f64::NAME);
        let files = ui.files(&self.out, "stability", "figure4", &provenance, |files| {
            files.csv(&figure4::table(&curves))?;
            files.figure(None, &picture::figure4(&curves))
        })?;
        let evaluations: usize = curves.iter().map(|(_, map)| map.evaluations()).sum();
        let curves: Vec<Curve> = curves.into_iter().map(|(curve, _)| curve).collect();
        let report = json!({ "curves": curves, "evaluations": evaluations, "wall_s": wall_s, "files": files });
        ui.document_of(&provenance, &report)?;
        writeln!(
            ui,
            "Largest stable K_T (N/m) with both hands on, up to 12000, from 0 upwards, and further crossings\n"
        );
        let near = |curve: &Curve, stiffness: f64| {
            let distance = |column: &Column| (column.x - stiffness).abs();
            let nearest = curve.columns.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
            nearest.map(|column| column.limit.crossings.clone())
        };
        let mut table = Columns::of(&curves)
            .value("comm", |curve| curve.comm)
            .value("n_t", |curve| curve.one_way_delay_packets)
            .head("n_t");
        for stiffness in [250.0, 500.0, 1000.0, 1500.0] {
            let head = format!("K_LC {stiffness}");
            table = table.number(head.clone(), 0, |curve| near(curve, stiffness)).head(&head);
        }
        writeln!(ui, "{}\n{evaluations} spectral radii in {wall_s:.2} s", table.done());
        ui.wrote(&files);
        Ok(())
    }
}
