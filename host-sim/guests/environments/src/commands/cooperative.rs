//! `cohold shared cooperative`: many users, one object, one dynamics engine.

mod picture;

use std::time::Instant;

use clap::Args;
use cohold_cli::flags::{Out, Time, choice, number, switch};
use cohold_cli::ui::and;
use cohold_cli::{Failure, SceneArgs, Ui};
use cohold_core::names::Choice;
use cohold_report::{Columns, Provenance};
use cohold_sim::scene::Scene;
use rayon::prelude::*;
use serde::Serialize;
use serde_json::json;

use crate::cooperative::run::{Outcome, run};
use crate::cooperative::waves::Waves;
use crate::cooperative::{Collision, Engine, Setup};
use crate::{cooperative::limits, cooperative::limits::bounded_radius};

const DELAYS_MS: [f64; 10] = [0.0, 1.0, 2.0, 3.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0];

/// Forces of the cooperation paper's §5.2, which a scene may change as anything else.
const FORCES: [&str; 3] = ["user.1.push_n=1", "user.2.push_n=1", "user.2.sine_n=0.25"];

/// Keys that wave peers start from: packets of 8 ms, a mean of waves, no delay but the network's.
const WAVES: [&str; 6] = [
    "network.one_way_delay_packets=0",
    "coordination.comm=passive-mean",
    "coordination.decode=implicit",
    "coordination.stiffness_n_per_m=4000",
    "object.integrator=semi-implicit",
    "object.force_delay_ticks=0",
];

#[derive(Debug, Args)]
#[command(mut_arg("scene", |arg| {
    arg.help("Scene file (TOML) or the name of a built-in scene; without it, packets each tick, prompt forces, a device of 5 N·s/m")
}))]
#[command(mut_arg("seconds", |arg| arg.default_value("10").value_parser(number(1e-4..=3600.0, "s"))))]
pub(crate) struct Cooperative {
    #[command(flatten)]
    scene: SceneArgs,
    /// How many users push the object, 1 to 16.
    #[arg(long, default_value_t = 2, value_name = "N")]
    users: usize,
    /// Delay of every packet between a client and the server, one way, ms (instead of the scene's network.extra_delay_s);
    /// without it, a sweep from 0 to 200 ms, and the paper's limits.
    #[arg(long, value_name = "D", value_parser = number(0.0..=1000.0, "ms"))]
    delay_ms: Option<f64>,
    /// Whether stiffness and damping follow the measured round trip; without it, a sweep shows both.
    #[arg(long, value_parser = switch())]
    bounder: Option<bool>,
    /// Where contact is computed.
    #[arg(long, default_value = "client", value_parser = choice::<Collision>())]
    collision: Collision,
    /// Where the object is moved.
    #[arg(long, default_value = "server", value_parser = choice::<Engine>())]
    engine: Engine,
    /// Instead of one engine a copy for every user, held together by waves through the lossless node at the server.
    #[arg(long, conflicts_with_all = ["bounder", "collision", "engine", "out"])]
    waves: bool,
    #[command(flatten)]
    time: Time,
    #[command(flatten)]
    out: Out,
}

/// One run, as reported.
#[derive(Debug, Serialize)]
struct Row {
    users: usize,
    one_way_ms: f64,
    bounder: bool,
    collision: Collision,
    engine: Engine,
    /// Spectral radius behind a settled bounder; absent without one, with slow packets, or while the engine is at a client.
    spectral_radius: Option<f64>,
    #[serde(flatten)]
    outcome: Outcome,
}

impl Cooperative {
    /// The scene, on top of these keys where none is named, with this delay.
    fn load(&self, ui: &Ui, one_way_ms: f64, base: &[&str]) -> Result<Scene, Failure> {
        let delay = format!("network.extra_delay_s={}", 1e-3 * one_way_ms);
        let scene = self.scene.load_with(ui, &[base, &FORCES].concat(), Some(delay))?;
        scene.check_one_axis("the scene")?;
        Ok(scene)
    }

    fn setup(&self, ui: &Ui, one_way_ms: f64, bounder: bool) -> Result<Setup, Failure> {
        let mut setup = Setup::new(self.load(ui, one_way_ms, &Setup::BASE)?);
        (setup.users, setup.bounder) = (self.users, bounder);
        (setup.collision, setup.engine) = (self.collision, self.engine);
        Ok(setup)
    }

    fn row(&self, ui: &Ui, one_way_ms: f64, bounder: bool) -> Result<Row, Failure> {
        let setup = self.setup(ui, one_way_ms, bounder)?;
        let outcome = run(&setup, self.time.seconds)?;
        let network = setup.scene.world.network;
        // What the sampled map can hold.
        let seen = bounder
            && self.engine == Engine::Server
            && setup.scene.peer.timing.ticks_per_packet == 1
            && setup.scene.is_linear()
            && (1..=200).contains(&((1e3 * network.extra_delay_s) as u32));
        let radius = if seen { Some(bounded_radius(&setup, 2.0 * network.extra_delay_s)?) } else { None };
        let (collision, engine) = (self.collision, self.engine);
        Ok(Row { users: self.users, one_way_ms, bounder, collision, engine, spectral_radius: radius, outcome })
    }

    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let start = Instant::now();
        let period_s = self.setup(ui, self.delay_ms.unwrap_or(0.0), true)?.scene.peer.timing.control_period_s;
        if self.time.seconds < 8.0 * period_s {
            let least = 8.0 * period_s;
            let message =
                format!("--seconds {} is not allowed: it must be a number from {least} to 3600 s", self.time.seconds);
            return Err(message.into());
        }
        if self.waves {
            return self.run_waves(ui);
        }
        let switches: &[bool] = match self.bounder {
            Some(true) => &[true],
            Some(false) => &[false],
            None if self.delay_ms.is_some() => &[true],
            None => &[false, true],
        };
        let delays = self.delay_ms.map_or_else(|| DELAYS_MS.to_vec(), |delay| vec![delay]);
        let points: Vec<(bool, f64)> =
            switches.iter().flat_map(|switch| delays.iter().map(|delay| (*switch, *delay))).collect();
        let (rows, _) = ui.work(points.len(), "cooperative", |step| {
            let row = |(bounder, delay)| {
                let row = self.row(ui, delay, bounder);
                step();
                row
            };
            points.into_par_iter().map(row).collect::<Result<Vec<_>, _>>()
        })?;
        let limits = if self.delay_ms.is_none() { limits::table()? } else { Vec::new() };
        let provenance = self.provenance(ui)?;
        let files = ui.files(&self.out, "cooperative", "cooperative", &provenance, |files| match &rows[..] {
            [row] => {
                files.csv(&row.outcome.table)?;
                files.figure(None, &picture::over_time(row))
            }
            rows => files.figure(None, &picture::sweep(rows)),
        })?;
        let wall_s = start.elapsed().as_secs_f64();
        ui.document_of(&provenance, &json!({ "rows": rows, "limits": limits, "wall_s": wall_s, "files": files }))?;
        ui.table(&columns(&rows));
        if !limits.is_empty() {
            let paper = "the paper: 5 to 10 ms for stiff objects, 30 ms for soft ones";
            writeln!(ui, "\nStiffest object without the bounder; {paper}\n");
            ui.text("", &limits)?;
        }
        ui.wrote(&files);
        Ok(())
    }

    /// Wave peers around the node, at one delay or at all of the sweep's.
    fn run_waves(&self, ui: &Ui) -> Result<(), Failure> {
        let delays = self.delay_ms.map_or_else(|| DELAYS_MS.to_vec(), |delay| vec![delay]);
        let mut rows = Vec::new();
        for one_way_ms in delays {
            let outcome = Waves::new(&self.load(ui, one_way_ms, &WAVES)?, self.users)?.run(self.time.seconds);
            rows.push(and(json!({ "users": self.users, "one_way_ms": one_way_ms }), &outcome)?);
        }
        ui.report("", &rows)
    }

    fn provenance(&self, ui: &Ui) -> Result<Provenance, Failure> {
        let scene = self.load(ui, self.delay_ms.unwrap_or(0.0), &Setup::BASE)?;
        let provenance =
            ui.provenance().settings(scene.settings()).with("users", self.users).with("seconds", self.time.seconds);
        let provenance = provenance.with("seed", scene.world.network.seed).with("sweep", self.delay_ms.is_none());
        Ok(provenance.with("collision", self.collision.name()).with("engine", self.engine.name()))
    }
}

fn columns(rows: &[Row]) -> Columns {
    let stable = |row: &Row| row.outcome.stable;
    Columns::of(rows)
        .value("users", |row| row.users)
        .value("one_way_ms", |row| row.one_way_ms)
        .value("bounder", |row| if row.bounder { "on" } else { "off" })
        .value("stable", |row| row.outcome.stable)
        .number("radius", 6, |row| row.spectral_radius)
        .number("round_trip_ms", 1, |row| row.outcome.round_trip_ms)
        .significant("stiffness_n_per_m", 3, |row| row.outcome.stiffness_n_per_m)
        .head("K")
        .significant("drag_n_s_per_m", 3, |row| row.outcome.drag_n_s_per_m)
        .significant("true_mm", 3, |row| row.outcome.true_discrepancy_mm)
        .where_true(stable)
        .significant("felt_n", 3, |row| row.outcome.felt_n)
        .where_true(stable)
        .significant("peak_n", 3, |row| row.outcome.peak_n)
        .where_true(stable)
        .significant("jump_n", 3, |row| row.outcome.largest_jump_n)
        .where_true(stable)
        .number("engine_at_client", 0, |row| row.outcome.engine_ticks[2] as f64 / row.outcome.ticks.max(1) as f64)
        .shown_in("%", 1e2)
        .significant("up_bytes_per_s", 3, |row| row.outcome.up_bytes_per_s)
        .shown_in("kB/s", 1e-3)
        .significant("down_bytes_per_s", 3, |row| row.outcome.down_bytes_per_s)
        .shown_in("kB/s", 1e-3)
        .done()
}
