//! `host-sim stability`: verdicts, limits and regions, from the code that flies.

mod rendering;
mod tune;

use std::time::Instant;

use clap::Args;
use serde_json::json;

use crate::cli::flags::Out;
use crate::cli::ui::and;
use crate::cli::{Failure, SceneArgs, Ui};
use haptic_analysis::figure4::{self, Curve};
use haptic_analysis::{Agreement, Axis, Column, Effort, Range, advice, agreement, map, picture, speed, verdict};
use haptic_core::num::Scalar;
use haptic_sim::report::{Cell, Columns};

super::commands! {
    Question {
        /// Is this scene stable? Spectral radius of one packet period, rest modes left out.
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
        /// Spectral radii per second.
        Bench(Bench),
    }
}

#[derive(Debug, Args)]
pub(in crate::cli) struct Point {
    #[command(flatten)]
    scene: SceneArgs,
}

impl Point {
    fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let scene = self.scene.load(ui)?;
        let (verdict, second, advice) = (verdict(&scene)?, agreement(&scene.linear())?, advice(&scene)?);
        let report = and(json!(verdict), &json!({ "constructions": second, "advice": advice }))?;
        ui.document_of(&ui.made().settings(scene.settings()), &report)?;
        // How far apart the two constructions of the lifted matrix are.
        let apart = |_: &_| match &second {
            Some(Agreement { matrix, spectral_radius }) => Cell::Number(matrix.max(*spectral_radius)),
            None => "none: it has no equations for one of this scene's models".into(),
        };
        let table = Columns::of(std::slice::from_ref(&verdict))
            .value("stable", |verdict| verdict.stable)
            .number("spectral_radius", 9, |verdict| verdict.spectral_radius)
            .value("states", |verdict| verdict.states)
            .value("rest_modes_left_out", |verdict| verdict.rest_modes)
            .value("taken_apart_into_sum_and_difference", |verdict| verdict.symmetric)
            .power("second_construction_differs_by", 1, apart)
            .done();
        writeln!(ui, "{}\n{advice}", table.down(&[&self.scene.name()]));
        Ok(())
    }
}

#[derive(Debug, Args)]
pub(in crate::cli) struct Limit {
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
}

impl Limit {
    fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let scene = self.scene.load(ui)?;
        let (of, from, to) = (self.of.as_str(), self.from, self.to);
        let start = Instant::now();
        let limit = haptic_analysis::limit(&scene, Range { key: self.of.clone(), from, to }, Effort::default())?;
        let report = and(json!({ "of": of, "from": from, "to": to }), &limit)?;
        let report = and(report, &json!({ "wall_s": start.elapsed().as_secs_f64() }))?;
        ui.document_of(&ui.made().settings(scene.settings()), &report)?;
        let word = |stable: bool| if stable { "stable" } else { "unstable" };
        let crossings = &limit.crossings;
        let after = |at: usize| limit.stable_at_start != (at % 2 == 1);
        let mut rows = vec![(from.to_string(), word(after(0)).to_owned())];
        rows.extend(
            (1..).zip(crossings).map(|(at, key)| (format!("{key:.6}"), format!("{} from here on", word(after(at))))),
        );
        rows.push((to.to_string(), word(after(crossings.len())).to_owned()));
        let table = Columns::of(&rows).value(of, |row| row.0.as_str()).head(of).shown_in("", 1.0);
        ui.table(&table.value("", |row| row.1.as_str()).done());
        Ok(())
    }
}

#[derive(Debug, Args)]
pub(in crate::cli) struct Map {
    #[command(flatten)]
    scene: SceneArgs,
    /// Horizontal axis: key, first and last value, how many.
    #[arg(long, value_name = "KEY=A..B:N")]
    x: Axis,
    /// Vertical axis; along it all crossings are found, N is the grid of the picture.
    #[arg(long, value_name = "KEY=A..B:N")]
    y: Axis,
    #[command(flatten)]
    out: Out,
}

impl Map {
    fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let scene = self.scene.load(ui)?;
        let effort = Effort { steps: (2 * self.y.count).max(200), ..Effort::default() };
        let axes = [self.x.clone(), self.y.clone()];
        let (found, wall_s) = ui.work(self.x.count, "columns", |step| map(&scene, axes, effort, step))?;
        let made = ui.made().settings(scene.settings());
        let name = format!("map-{}-{}-{}", self.scene.run_name(&scene), self.x.range.key, self.y.range.key);
        let files = ui.files(&self.out, "stability", &name, &made, |files| {
            files.csv(&found.table())?;
            files.figure(None, &picture::region(&format!("Stability region of {}", self.scene.name()), &found))
        })?;
        let (Range { key: x, .. }, Range { key: y, from, to }) = (&self.x.range, &self.y.range);
        let evaluations = found.evaluations();
        ui.document_of(
            &made,
            &json!({
                "x": x, "y": y, "y_from": from, "y_to": to,
                "columns": found.columns, "evaluations": evaluations, "wall_s": wall_s, "files": files,
            }),
        )?;
        let table = Columns::of(&found.columns)
            .number(x, 5, |column| column.x)
            .head(x)
            .shown_in("", 1.0)
            .value("start", |column| if column.limit.stable_at_start { "stable" } else { "unstable" })
            .head("at the lowest")
            .number(y, 5, |column| column.limit.crossings.clone())
            .head(y)
            .shown_in("", 1.0)
            .done();
        writeln!(ui, "{table}\n{evaluations} spectral radii in {wall_s:.2} s");
        ui.wrote(&files);
        Ok(())
    }
}

#[derive(Debug, Args)]
pub(in crate::cli) struct Paper {
    #[command(flatten)]
    out: Out,
}

impl Paper {
    fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let points = figure4::COMMS.len() * figure4::DELAYS.len() * figure4::POINTS;
        let (curves, wall_s) = ui.work(points, "Figure 4", |step| figure4::curves(step))?;
        let made = ui.made().with("number_type", f64::NAME);
        let files = ui.files(&self.out, "stability", "figure4", &made, |files| {
            files.csv(&figure4::table(&curves))?;
            files.figure(None, &picture::figure4(&curves))
        })?;
        let evaluations: usize = curves.iter().map(|(_, map)| map.evaluations()).sum();
        let curves: Vec<Curve> = curves.into_iter().map(|(curve, _)| curve).collect();
        let report = json!({ "curves": curves, "evaluations": evaluations, "wall_s": wall_s, "files": files });
        ui.document_of(&made, &report)?;
        writeln!(ui, "Largest stable K_T (N/m) up to 12000, from 0 upwards, and further crossings\n");
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

#[derive(Debug, Args)]
pub(in crate::cli) struct Bench {
    /// Radii on each thread.
    #[arg(long, default_value_t = 20_000, value_parser = clap::value_parser!(u32).range(1..=100_000_000))]
    radii: u32,
}

impl Bench {
    fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let measure = |threads| speed::measure(self.radii as usize, threads);
        let speeds = if cores > 1 { vec![measure(1)?, measure(cores)?] } else { vec![measure(1)?] };
        let table = Columns::of(&speeds)
            .value("threads", |speed| speed.threads)
            .value("states", |speed| speed.states)
            .number("radii_per_s", 0, |speed| speed.radii_per_s)
            .number("radii_per_s_and_core", 0, |speed| speed.radii_per_s_and_core)
            .head("radii/s and core")
            .number("checksum", 9, |speed| speed.checksum)
            .done();
        ui.result(&table)?;
        writeln!(ui, "The same work in NumPy: python3 tests/oracle/numpy_speed.py");
        Ok(())
    }
}
