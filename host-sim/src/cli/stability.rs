//! `host-sim stability`: verdicts, limits and regions, from the code that flies.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::{Args, Subcommand};
use serde::Serialize;

use super::{Failure, SceneArgs, print_json, progress_bar};
use crate::analysis::figure4::{self, Curve};
use crate::analysis::lifted::agreement::{Agreement, agreement};
use crate::analysis::limit::{Effort, Limit as Crossings, limit};
use crate::analysis::map::{Axis, Column, map};
use crate::analysis::sweep::Range;
use crate::analysis::{Verdict, advice, picture, speed, verdict};
use crate::report::plot::draw;
use crate::report::table::Table;
use crate::report::text::TextTable;
use crate::report::{ReportError, files};

/// Arguments of `stability`.
#[derive(Debug, Args)]
pub(super) struct Stability {
    #[command(subcommand)]
    question: Question,
}

#[derive(Debug, Subcommand)]
enum Question {
    /// Is this scene stable? Spectral radius of one packet period, rest modes left out.
    Point(Point),
    /// At which values of one key does that change? All of them, pockets included.
    Limit(Limit),
    /// The region in two keys, as file and picture.
    Map(Map),
    /// Figure 4 of the cooperation paper: three ways to communicate, four delays.
    Paper(Paper),
    /// Figure 4 of the architectures paper: one device, one object, largest stiffness against delay and sampling period.
    Rendering(super::rendering::Rendering),
    /// The stiffest contact and coordination that leave a margin, for this device, network and loop.
    Tune(super::tune::Tune),
    /// Spectral radii per second.
    Bench(Bench),
}

impl Stability {
    /// Answers the question.
    ///
    /// # Errors
    /// A bad scene, key or range; a file that cannot be written.
    pub(super) fn run(&self) -> Result<(), Failure> {
        match &self.question {
            Question::Point(point) => point.run(),
            Question::Limit(limit) => limit.run(),
            Question::Map(map) => map.run(),
            Question::Paper(paper) => paper.run(),
            Question::Rendering(rendering) => rendering.run(),
            Question::Tune(tune) => tune.run(),
            Question::Bench(bench) => bench.run(),
        }
    }
}

/// Arguments of `stability point`.
#[derive(Debug, Args)]
struct Point {
    #[command(flatten)]
    scene: SceneArgs,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct PointReport {
    #[serde(flatten)]
    verdict: Verdict,
    /// How far apart the two constructions of the lifted matrix are; absent where there is only one.
    constructions: Option<Agreement>,
    advice: String,
}

impl Point {
    fn run(&self) -> Result<(), Failure> {
        let scene = self.scene.load()?;
        let report = PointReport {
            verdict: verdict(&scene)?,
            constructions: agreement(&scene.linear())?,
            advice: advice(&scene)?,
        };
        if self.json {
            return print_json(&report);
        }
        let Verdict { spectral_radius, stable, states, rest_modes, symmetric } = report.verdict;
        let mut table = TextTable::new(["", &self.scene.name()]);
        table.push(["stable", if stable { "yes" } else { "no" }]);
        table.push(["spectral radius".to_owned(), format!("{spectral_radius:.9}")]);
        table.push(["states".to_owned(), states.to_string()]);
        table.push(["rest modes left out".to_owned(), rest_modes.to_string()]);
        table.push(["taken apart into sum and difference", if symmetric { "yes" } else { "no" }]);
        if let Some(Agreement { matrix, spectral_radius }) = report.constructions {
            table.push(["second construction differs by".to_owned(), format!("{:.1e}", matrix.max(spectral_radius))]);
        }
        println!("{table}\n{}", report.advice);
        Ok(())
    }
}

/// Arguments of `stability limit`.
#[derive(Debug, Args)]
struct Limit {
    #[command(flatten)]
    scene: SceneArgs,
    /// The key to change: any number of a scene (`host-sim keys` lists them).
    #[arg(long, value_name = "TABLE.KEY")]
    of: String,
    /// First value.
    #[arg(long, value_name = "A", allow_negative_numbers = true)]
    from: f64,
    /// Last value.
    #[arg(long, value_name = "B", allow_negative_numbers = true)]
    to: f64,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct LimitReport<'a> {
    of: &'a str,
    from: f64,
    to: f64,
    #[serde(flatten)]
    limit: Crossings,
    wall_s: f64,
}

impl Limit {
    fn run(&self) -> Result<(), Failure> {
        let scene = self.scene.load()?;
        let (of, from, to) = (self.of.as_str(), self.from, self.to);
        let start = Instant::now();
        let limit = limit(&scene, Range { key: self.of.clone(), from, to }, Effort::default())?;
        let report = LimitReport { of, from, to, limit, wall_s: start.elapsed().as_secs_f64() };
        if self.json {
            return print_json(&report);
        }
        let word = |stable: bool| if stable { "stable" } else { "unstable" };
        let mut table = TextTable::new([of, ""]);
        table.push([from.to_string(), word(report.limit.stable_at_start).to_owned()]);
        let mut stable = report.limit.stable_at_start;
        for crossing in &report.limit.crossings {
            stable = !stable;
            table.push([format!("{crossing:.6}"), format!("{} from here on", word(stable))]);
        }
        table.push([to.to_string(), word(stable).to_owned()]);
        println!("{table}");
        Ok(())
    }
}

/// Arguments of `stability map`.
#[derive(Debug, Args)]
struct Map {
    #[command(flatten)]
    scene: SceneArgs,
    /// Horizontal axis: key, first and last value, how many.
    #[arg(long, value_name = "KEY=A..B:N")]
    x: Axis,
    /// Vertical axis; along it all crossings are found, N is the grid of the picture.
    #[arg(long, value_name = "KEY=A..B:N")]
    y: Axis,
    /// Folder for CSV and picture.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print JSON; files are written only with --out.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct MapReport<'a> {
    x: &'a str,
    y: &'a str,
    y_from: f64,
    y_to: f64,
    columns: &'a [Column],
    evaluations: usize,
    wall_s: f64,
    files: Vec<PathBuf>,
}

impl Map {
    fn run(&self) -> Result<(), Failure> {
        let scene = self.scene.load()?;
        let bar = progress_bar(self.x.count as u64, "columns");
        let start = Instant::now();
        let effort = Effort { steps: self.y.count.max(100), ..Effort::default() };
        let found = map(&scene, [self.x.clone(), self.y.clone()], effort, || bar.inc(1))?;
        let wall_s = start.elapsed().as_secs_f64();
        bar.finish_and_clear();
        let mut written = Vec::new();
        if let Some(folder) = folder(self.out.as_deref(), self.json, "out/stability") {
            let base = folder.join(format!("map-{}", self.scene.name()));
            let title = format!("Stability region of {}", self.scene.name());
            written = write(&base, &found.table()?, || draw(&picture::region(&title, &found), &base))?;
        }
        let report = MapReport {
            x: &self.x.range.key,
            y: &self.y.range.key,
            y_from: self.y.range.from,
            y_to: self.y.range.to,
            columns: &found.columns,
            evaluations: found.evaluations(),
            wall_s,
            files: written,
        };
        if self.json {
            return print_json(&report);
        }
        let mut table = TextTable::new([report.x, "at the lowest", report.y]);
        for Column { x, limit } in report.columns {
            let crossings: Vec<String> = limit.crossings.iter().map(|crossing| format!("{crossing:.5}")).collect();
            let start = if limit.stable_at_start { "stable" } else { "unstable" };
            table.push([format!("{x:.5}"), start.to_owned(), crossings.join(" ")]);
        }
        println!("{table}\n{} spectral radii in {wall_s:.2} s", report.evaluations);
        tell(&report.files);
        Ok(())
    }
}

/// Arguments of `stability paper`.
#[derive(Debug, Args)]
struct Paper {
    /// Folder for CSV and picture.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print JSON; files are written only with --out.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct PaperReport {
    curves: Vec<Curve>,
    evaluations: usize,
    wall_s: f64,
    files: Vec<PathBuf>,
}

impl Paper {
    fn run(&self) -> Result<(), Failure> {
        let points = figure4::COMMS.len() * figure4::DELAYS.len() * figure4::POINTS;
        let bar = progress_bar(points as u64, "Figure 4");
        let start = Instant::now();
        let curves = figure4::curves(|| bar.inc(1))?;
        let wall_s = start.elapsed().as_secs_f64();
        bar.finish_and_clear();
        let mut written = Vec::new();
        if let Some(folder) = folder(self.out.as_deref(), self.json, "out/stability") {
            let base = folder.join("figure4");
            let table = figure4::table(&curves)?;
            written = write(&base, &table, || draw(&picture::figure4(&curves), &base))?;
        }
        let evaluations = curves.iter().map(|(_, map)| map.evaluations()).sum();
        let curves = curves.into_iter().map(|(curve, _)| curve).collect();
        let report = PaperReport { curves, evaluations, wall_s, files: written };
        if self.json {
            return print_json(&report);
        }
        println!("Largest stable K_T (N/m) up to 12000, from 0 upwards, and further crossings\n");
        let mut table = TextTable::new(["comm", "n_t", "K_LC 250", "500", "1000", "1500"]);
        for Curve { comm, one_way_delay_packets, columns } in &report.curves {
            let near = |stiffness: f64| {
                let nearest = columns.iter().min_by(|a, b| (a.x - stiffness).abs().total_cmp(&(b.x - stiffness).abs()));
                let crossings = nearest.map(|column| column.limit.crossings.as_slice()).unwrap_or_default();
                crossings.iter().map(|crossing| format!("{crossing:.0}")).collect::<Vec<_>>().join(" ")
            };
            let row = [250.0, 500.0, 1000.0, 1500.0].map(near);
            table.push([(*comm).to_owned(), one_way_delay_packets.to_string()].into_iter().chain(row));
        }
        println!("{table}\n{evaluations} spectral radii in {wall_s:.2} s");
        tell(&report.files);
        Ok(())
    }
}

/// Arguments of `stability bench`.
#[derive(Debug, Args)]
struct Bench {
    /// Radii on each thread.
    #[arg(long, default_value_t = 20_000, value_parser = clap::value_parser!(u32).range(1..=100_000_000))]
    radii: u32,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

impl Bench {
    fn run(&self) -> Result<(), Failure> {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let mut counts = vec![1, cores];
        counts.dedup();
        let speeds = counts
            .into_iter()
            .map(|threads| speed::measure(self.radii as usize, threads))
            .collect::<Result<Vec<_>, _>>()?;
        if self.json {
            return print_json(&speeds);
        }
        let mut table = TextTable::new(["threads", "states", "radii/s", "radii/s and core", "checksum"]);
        for speed in speeds {
            table.push([
                speed.threads.to_string(),
                speed.states.to_string(),
                format!("{:.0}", speed.radii_per_s),
                format!("{:.0}", speed.radii_per_s_and_core),
                format!("{:.9}", speed.checksum),
            ]);
        }
        println!("{table}\nThe same work in NumPy: python3 tests/oracle/numpy_speed.py");
        Ok(())
    }
}

/// Where files go: the folder asked for, or a usual one when the result is for a person.
pub(super) fn folder(out: Option<&Path>, json: bool, usual: &str) -> Option<PathBuf> {
    match (out, json) {
        (None, true) => None,
        (out, _) => Some(out.map_or_else(|| PathBuf::from(usual), Path::to_path_buf)),
    }
}

/// Writes the table beside the picture and names all files.
pub(super) fn write(
    base: &Path,
    table: &Table,
    draw: impl FnOnce() -> Result<Vec<PathBuf>, ReportError>,
) -> Result<Vec<PathBuf>, Failure> {
    let csv = base.with_extension("csv");
    files::write_csv(table, &csv)?;
    let mut written = vec![csv];
    written.extend(draw()?);
    Ok(written)
}

pub(super) fn tell(files: &[PathBuf]) {
    for file in files {
        println!("wrote {}", file.display());
    }
}
