//! `cohold accuracy`: speed against error, for every numerical choice; and what each model adds to a scene.

use std::path::{Path, PathBuf};

use clap::Args;
use cohold_sim::{scene::Scene, scenes};
use cohold_studies::accuracy;
use cohold_studies::accuracy::counts::{Processor, SCALARS, cost_columns, costs};
use cohold_studies::accuracy::{picture, rigid, timed};
use cohold_studies::precision::{columns, measure};
use cohold_studies::{force, transparency};
use rayon::prelude::*;
use serde_json::json;

use super::flags::{Out, SCENE, Time, choice, number};
use super::{Failure, SceneArgs, Ui, ui::pictures};

/// Width of the figures of every numerical choice: names of dots in eight panels need a page of a journal, mm.
const PAGE_MM: f64 = 180.0;

#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true)]
pub(crate) struct Accuracy {
    #[command(subcommand)]
    question: Option<Question>,
    /// Whose instructions.
    #[arg(long, default_value = "cortex-m7", value_parser = choice::<Processor>(), value_name = "NAME")]
    processor: Processor,
    #[command(flatten)]
    out: Out,
}

super::commands! {
    pub(crate) Question {
        /// How far f32 and fixed point stray from f64, scene by scene.
        Precision(Precision),
        /// Error and time of every integrator, decode and control rate, on this machine.
        Time(Timing),
        /// What a free rigid body keeps of energy and angular momentum, by number type and step.
        Rigid(Rigid),
        /// The force that is commanded beside the force that comes: a duty alone, and the current loop, with the hand moving.
        Force(Force),
        /// What a leader and a follower feel of each other: impedance, position and force error over frequency, Z-width.
        Transparency(Transparency),
    }
}

impl Accuracy {
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        if let Some(question) = &self.question {
            return question.run(ui);
        }
        ui.only_built_in("accuracy compares");
        let ((families, cost_per_scene), _) =
            ui.work(1, "errors", |_| Ok::<_, Failure>((accuracy::families(self.processor)?, costs(self.processor))))?;
        let provenance = ui.provenance().with("instructions_of", self.processor.label());
        let files = ui.files(&self.out.unless_told(PAGE_MM), "accuracy", "accuracy", &provenance, |files| {
            files.csv(&accuracy::columns(&families, true))?;
            let figures = picture::all(&families, &cost_per_scene, self.processor);
            figures.iter().try_for_each(|(name, figure)| files.figure(Some(name), figure))
        })?;
        let pictures = pictures(files);
        ui.document_of(
            &provenance,
            &json!({
                "processor": self.processor, "families": families, "scalars": SCALARS,
                "cost_per_scene": cost_per_scene, "pictures": pictures,
            }),
        )?;
        writeln!(ui, "Speed against error; instructions of {}\n", self.processor.label());
        for family in &families {
            writeln!(ui, "{}\n\n  {}\n  Against {}.\n", family.title, family.motion, family.reference);
            writeln!(ui, "{}\n{}\n", accuracy::columns([family], false), family.insight);
        }
        writeln!(
            ui,
            "Cost per scene: instructions of one tick, and what the scene adds to the one it is compared with\n"
        );
        ui.table(&cost_columns(&cost_per_scene));
        ui.pictures(&pictures);
        Ok(())
    }
}

#[derive(Debug, Args)]
#[command(mut_arg("seconds", |arg| arg.default_value("60").help("How long in simulated time, s; a row after a minute, an hour, ten")))]
pub(crate) struct Precision {
    #[command(flatten)]
    scene: SceneArgs,
    /// Every built-in scene instead of one, and `any-network` with the pushes of the cooperation paper's §5.2.
    #[arg(long, conflicts_with_all = ["scene", "set"])]
    all: bool,
    /// The paper's passive wave line, `matched-line` and `any-network`, all with the pushes of §5.2: what may go on for hours.
    #[arg(long, conflicts_with_all = ["scene", "set", "all"])]
    coupled: bool,
    #[command(flatten)]
    time: Time,
}

/// What those scenes are for which a long time is asked, and the one of them whose users push without the sine of §5.2.
const COUPLED: [&str; 2] = ["paper-5.2-passive-wave-16ms", "matched-line"];
const PUSHED: &str = "any-network";
const SINE: [&str; 2] = ["user.2.sine_n=0.25", "user.2.sine_rad_per_s=3"];

impl Precision {
    fn scenes(&self, ui: &Ui) -> Result<Vec<(String, Scene)>, Failure> {
        if !(self.all || self.coupled) {
            return Ok(vec![(self.scene.name(), self.scene.load(ui)?)]);
        }
        let named = scenes::ALL.iter().map(|(name, _)| *name).filter(|name| self.all || COUPLED.contains(name));
        let pushed = scenes::find(ui.laws, Some(Path::new(PUSHED)), &SINE.map(str::to_owned))?;
        let scenes = named.map(|name| Ok((name.to_owned(), scenes::load(ui.laws, name)?)));
        scenes.chain([Ok((PUSHED.to_owned(), pushed))]).collect()
    }

    fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let scenes = self.scenes(ui)?;
        let (rows, _) = ui.work(scenes.len(), "scenes", |step| {
            let of = |(name, scene): &(String, Scene)| measure(name, scene, self.time.seconds).inspect(|_| step());
            scenes.par_iter().map(of).collect::<Result<Vec<_>, _>>()
        })?;
        let rows = rows.concat();
        writeln!(ui, "Largest difference from f64 so far; steps are of the number type at the largest position\n");
        ui.result(&columns(&rows))
    }
}

#[derive(Debug, Args)]
pub(crate) struct Timing {
    /// Also write the table into this page, between the lines that are there for it.
    #[arg(long, value_name = "FILE")]
    page: Option<PathBuf>,
}

impl Timing {
    fn run(&self, ui: &Ui) -> Result<(), Failure> {
        Ui::have(self.page.as_slice(), &[timed::LINES])?;
        ui.only_built_in("accuracy time compares");
        let (rows, _) = ui.work(1, "schemes", |_| Ok::<_, Failure>(timed::study()?))?;
        let table = timed::columns(&rows);
        writeln!(ui, "A millisecond of control of one peer in f32: how wrong it is, and how long it takes here\n");
        ui.result(&table)?;
        ui.wrote(&Ui::rewrite(self.page.as_slice(), &[(timed::LINES, format!("```text\n{table}```"))], None)?);
        Ok(())
    }
}

#[derive(Debug, Args)]
pub(crate) struct Rigid {
    /// How long the body tumbles, s.
    #[arg(long, default_value = "3600", value_name = "S", value_parser = number(1.0..=36_000.0, "s"))]
    seconds: f64,
    /// Steps, ms.
    #[arg(long, default_value = "0.25,0.5,1,2,4", value_name = "MS,…", value_delimiter = ',', value_parser = number(0.05..=20.0, "ms"))]
    periods_ms: Vec<f64>,
}

impl Rigid {
    fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let steps = rigid::TYPES * self.periods_ms.len();
        let work = |step: &(dyn Fn() + Sync)| Ok::<_, Failure>(rigid::study(self.seconds, &self.periods_ms, step));
        let (rows, _) = ui.work(steps, "tumbling", work)?;
        writeln!(ui, "A free rigid body, nobody pushing: relative changes over {} s\n", self.seconds);
        ui.result(&rigid::columns(&rows))
    }
}

#[derive(Debug, Args)]
pub(crate) struct Force {
    #[command(flatten)]
    scene: SceneArgs,
    /// Root mean square of the commands, N.
    #[arg(long, default_value_t = 3.0, value_name = "N", value_parser = newtons)]
    command: f64,
}

fn newtons(text: &str) -> Result<f64, Failure> {
    let allowed = "it must be a number from 0.01 to 200 N";
    text.parse().ok().filter(|newtons| (0.01..=200.0).contains(newtons)).ok_or_else(|| allowed.into())
}

impl Force {
    fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let scene = self.scene.load(ui)?;
        let (found, _) = ui.work(1, "forces", |_| force::measure(&scene, self.command))?;
        let (response, moving) = (force::response_columns(&found.response), force::moving_columns(&found.moving));
        let (within, in_time_hz) = (found.within(), found.in_time_hz());
        ui.document(&json!({
            "response": response, "moving": moving, "delay_ticks": found.delay_ticks, "within": within, "in_time_hz": in_time_hz
        }))?;
        let motor = &scene.peer.motor;
        writeln!(
            ui,
            "{} N/A, {} ohm, {} mH, {} V; loop of {} Hz, whose force is {:.3} control periods late\n",
            motor.newton_or_newton_metre_per_a,
            motor.resistance_ohm,
            1e3 * motor.inductance_h,
            scene.world.plant.supply_v,
            motor.current_loop_hz,
            found.delay_ticks
        );
        writeln!(
            ui,
            "The joint held: force over command, and error in % of the command; late: against the command so late\n"
        );
        ui.table(&response);
        writeln!(
            ui,
            "The hand moving {} mm either way at {} Hz: error, N; allowed: {} % of the command and {} mN\n",
            1e3 * force::HAND_M,
            force::HAND_HZ,
            100.0 * force::SHARE,
            1e3 * force::FLOOR_N
        );
        ui.table(&moving);
        let (right, to) = (if within { "is" } else { "is NOT" }, force::BAND_HZ);
        writeln!(
            ui,
            "The loop's force {right} within what is allowed over 0-{to} Hz, but for its delay; with its delay up to {in_time_hz} Hz.\n"
        );
        Ok(())
    }
}

#[derive(Debug, Args)]
#[command(mut_arg("scene", |scene| scene.default_value("leader-follower").help(SCENE)))]
pub(crate) struct Transparency {
    #[command(flatten)]
    scene: SceneArgs,
    /// Delays there and back, ms.
    #[arg(long, default_value = "0,80,160", value_name = "MS,…", value_delimiter = ',', value_parser = number(0.0..=2000.0, "ms"))]
    round_trips_ms: Vec<f64>,
    #[command(flatten)]
    out: Out,
}

impl Transparency {
    fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let scene = self.scene.load(ui)?;
        let delays = &self.round_trips_ms;
        let (curves, wall_s) =
            ui.work(2 * delays.len(), "curves", |step| transparency::study(&scene, delays, &|| step()))?;
        let (table, responses) = (transparency::columns(&curves), transparency::response_columns(&curves));
        let provenance = ui.provenance().settings(scene.settings()).with("round_trips_ms", format!("{delays:?}"));
        let files = ui.files(&self.out, "accuracy", "transparency", &provenance, |files| {
            files.csv(&responses)?;
            files.parquet(&responses)?;
            files.figure(None, &transparency::figure(&curves))
        })?;
        let document = json!({ "ends": table, "responses": responses, "wall_s": wall_s, "files": files });
        ui.document_of(&provenance, &document)?;
        writeln!(ui, "{}: what each end feels of the other, in the world's units\n", self.scene.name());
        ui.table(&table);
        writeln!(ui, "{wall_s:.1} s");
        ui.wrote(&files);
        Ok(())
    }
}
