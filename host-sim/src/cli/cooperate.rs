//! `host-sim cooperate`: two peers hold one object.

use std::path::PathBuf;
use std::time::Instant;

use clap::{Args, ValueEnum};
use haptic_core::num::{Fixed, Scalar};
use serde::Serialize;

use super::flags::{Out, Time};
use super::{Failure, SceneArgs, Ui};
use crate::studies::figures;
use haptic_sim::measure::{Statistics, apparent_mass};
use haptic_sim::report::Columns;
use haptic_sim::run::{ImpactTotals, Options, Outcome, PortEnergy, run};
use haptic_sim::scene::Scene;
use haptic_sim::user::User;

/// The number type the peers compute in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum ScalarName {
    /// What flies on the board.
    F32,
    /// What the analyser drives.
    #[default]
    F64,
    /// Fixed point, I32F32.
    I32f32,
}

/// Arguments of `cooperate`.
#[derive(Debug, Args)]
pub(super) struct Cooperate {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    time: Time,
    /// Number type of the peers.
    #[arg(long, value_enum, default_value_t)]
    scalar: ScalarName,
    #[command(flatten)]
    out: Out,
}

#[derive(Serialize)]
struct Report {
    scene: String,
    /// Nothing faulted or grew, and (for a linear scene) no eigenvalue lies outside the unit circle.
    stable: bool,
    /// Spectral radius of the scene in permanent contact, rest modes left out.
    spectral_radius: f64,
    fault: Option<String>,
    true_discrepancy_mm: f64,
    decoded_discrepancy_mm: f64,
    /// True discrepancy over the mean contact force.
    true_discrepancy_mm_per_n: Option<f64>,
    coordination_force_n: Statistics,
    peak_coordination_force_n: f64,
    apparent_object_mass_kg: Option<f64>,
    energy: [PortEnergy; 2],
    #[serde(skip_serializing_if = "Option::is_none")]
    impacts: Option<[ImpactTotals; 2]>,
    ticks: u64,
    wall_s: f64,
    seed: u32,
    state_hash: String,
    warnings: Vec<String>,
    files: Vec<PathBuf>,
}

/// Whether a user ever does anything.
fn pushes(user: &User) -> bool {
    let profile = &user.settings.user;
    let has_arm = profile.arm_stiffness_n_per_m != 0.0 || profile.arm_damping_n_s_per_m != 0.0;
    let forces = [profile.push_n, profile.pulse_n, profile.sine_n, profile.side_push_n];
    let reaches = [profile.reach_m, profile.tremor_m];
    user.trace.is_some() || forces.iter().any(|n| *n != 0.0) || has_arm && reaches.iter().any(|m| *m != 0.0)
}

impl Cooperate {
    /// Runs the scene and reports.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let scene = self.scene.load(ui)?;
        let period_s = scene.peer.timing.control_period_s;
        if self.time.seconds < period_s {
            let message = format!(
                "--seconds {} is not allowed: it must be a number from {period_s} (one control period) to 86400 s",
                self.time.seconds
            );
            return Err(message.into());
        }
        let folder = ui.folder(self.out.folder(), "out/cooperate");
        let options = match folder {
            Some(_) => Options::recorded(self.time.seconds, period_s),
            None => Options { duration_s: self.time.seconds, record_every: 0 },
        };
        let bar = ui.progress((self.time.seconds / period_s) as u64, "cooperate");
        let start = Instant::now();
        let (outcome, scalar) = match self.scalar {
            ScalarName::F32 => (run::<f32>(&scene, options, &|tick| bar.set_position(tick)), f32::NAME),
            ScalarName::F64 => (run::<f64>(&scene, options, &|tick| bar.set_position(tick)), f64::NAME),
            ScalarName::I32f32 => (run::<Fixed>(&scene, options, &|tick| bar.set_position(tick)), Fixed::NAME),
        };
        let (outcome, wall_s) = (outcome?, start.elapsed().as_secs_f64());
        bar.finish_and_clear();

        let mut report = Report::new(self.scene.name(), &scene, &outcome, wall_s)?;
        if options.record_every > 1 {
            let every = options.record_every;
            report
                .warnings
                .push(format!("a long run: its files hold one tick in {every}; the figures of merit are of all"));
        }
        let made = ui.made().settings(scene.settings()).with("number_type", scalar).with("seconds", self.time.seconds);
        let made = made.with("seed", report.seed).with("state_hash", report.state_hash.as_str());
        let made = made.with("recorded_every_ticks", options.record_every);
        let number = if scalar == f64::NAME { String::new() } else { format!("-{scalar}") };
        let name = self.scene.run_name(&scene) + &number;
        report.files = ui.files(folder.as_deref(), &name, &made, |files| {
            files.csv(&outcome.table)?;
            files.parquet(&outcome.table)?;
            files.figure(None, &figures::run(&name, &outcome))
        })?;
        for warning in &report.warnings {
            ui.warn(warning);
        }
        ui.document_of(&made, &report)?;
        writeln!(ui, "{}", report.columns().down(&[&report.scene]));
        ui.wrote(&report.files);
        Ok(())
    }
}

impl Report {
    fn new(name: String, scene: &Scene, outcome: &Outcome, wall_s: f64) -> Result<Self, Failure> {
        let verdict = haptic_analysis::verdict(scene)?;
        let stable = outcome.bounded && (verdict.stable || !scene.is_linear());
        let mut warnings = if verdict.stable { Vec::new() } else { vec![haptic_analysis::advice(scene)?] };
        if !scene.users.iter().any(pushes) {
            warnings.push("nobody pushes: set user.1.push_n (or load a scene)".to_owned());
        }
        let moved =
            if verdict.stable { Some(apparent_mass::measure(scene)?).filter(|mass| mass.is_finite()) } else { None };
        Ok(Self {
            scene: name,
            stable,
            spectral_radius: verdict.spectral_radius,
            fault: outcome
                .fault
                .map(|(peer, fault)| format!("peer {peer} stopped with fault {}: {}", fault.number(), fault.explain())),
            true_discrepancy_mm: outcome.true_discrepancy_mm,
            decoded_discrepancy_mm: outcome.decoded_discrepancy_mm,
            true_discrepancy_mm_per_n: (outcome.contact_force_n > 0.0)
                .then(|| outcome.true_discrepancy_mm / outcome.contact_force_n),
            coordination_force_n: outcome.coordination_force_n,
            peak_coordination_force_n: outcome.peak_coordination_force_n,
            apparent_object_mass_kg: moved,
            energy: outcome.energy,
            impacts: outcome.impacts,
            ticks: outcome.ticks,
            wall_s,
            seed: scene.world.network.seed,
            state_hash: format!("{:016x}", outcome.hash),
            warnings,
            files: Vec::new(),
        })
    }

    /// Line by line, for people.
    fn columns(&self) -> Columns {
        let mut columns = Columns::of(std::slice::from_ref(self))
            .value("stable", |one| one.stable)
            .value("fault", |one| one.fault.clone())
            .number("spectral_radius", 6, |one| one.spectral_radius)
            .number("true_discrepancy_mm", 4, |one| one.true_discrepancy_mm)
            .head("true discrepancy |x_o1 - x_o2|")
            .number("true_discrepancy_mm_per_n", 4, |one| one.true_discrepancy_mm_per_n)
            .head("true discrepancy per newton of contact")
            .number("decoded_discrepancy_mm", 4, |one| one.decoded_discrepancy_mm)
            .head("decoded discrepancy |x_o - x_d|, peer 2")
            .number("coordination_force.mean_n", 4, |one| one.coordination_force_n.mean)
            .head("coordination force, peer 2: mean")
            .number("coordination_force.sd_n", 4, |one| one.coordination_force_n.sd)
            .head("coordination force, peer 2: standard deviation")
            .number("peak_coordination_force_n", 4, |one| one.peak_coordination_force_n)
            .number("apparent_object_mass_kg", 3, |one| one.apparent_object_mass_kg)
            .head("apparent mass of the shared object");
        for (peer, at) in [(1, 0), (2, 1)] {
            columns = columns
                .number("received_j", 4, move |one| one.energy[at].received_j)
                .head(&format!("energy from the network, peer {peer}"))
                .number("sent_j", 4, move |one| one.energy[at].sent_j)
                .head(&format!("energy to the network, peer {peer}"));
        }
        for (peer, at) in [(1, 0), (2, 1)] {
            let of = move |one: &Self| one.impacts.map(|impacts| impacts[at]);
            columns = columns
                .value("impacts", move |one| of(one).map(|impacts| impacts.count))
                .head(&format!("impacts at peer {peer}"))
                .number("wanted_n_s", 4, move |one| of(one).map(|impacts| impacts.wanted_n_s))
                .head(&format!("impulse exchanged with the object, peer {peer}"))
                .number("delivered_n_s", 4, move |one| of(one).map(|impacts| impacts.delivered_n_s))
                .head(&format!("impulse delivered to the device, peer {peer}"))
                .number("lost_j", 5, move |one| of(one).map(|impacts| impacts.lost_j))
                .head(&format!("energy that restitution took, peer {peer}"));
        }
        let columns = columns.value("ticks", |one| one.ticks).number("wall_s", 3, |one| one.wall_s).head("wall time");
        columns.value("state_hash", |one| one.state_hash.as_str()).done()
    }
}
