//! `host-sim cooperate`: two peers hold one object.

use std::path::PathBuf;
use std::time::Instant;

use clap::{Args, ValueEnum};
use haptic_core::num::Fixed;
use serde::Serialize;

use super::{Failure, SceneArgs, Ui};
use crate::studies::figures;
use haptic_sim::measure::apparent_mass;
use haptic_sim::report::files;
use haptic_sim::report::text::TextTable;
use haptic_sim::run::{Options, Outcome, PortEnergy, Spread, Struck, run};
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
    /// Simulated time, s.
    #[arg(long, default_value_t = 20.0, value_name = "S", allow_negative_numbers = true)]
    duration_s: f64,
    /// Number type of the peers.
    #[arg(long, value_enum, default_value_t)]
    scalar: ScalarName,
    /// Folder for CSV, Parquet and pictures.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
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
    coordination_force_n: Spread,
    peak_coordination_force_n: f64,
    apparent_object_mass_kg: Option<f64>,
    energy: [PortEnergy; 2],
    #[serde(skip_serializing_if = "Option::is_none")]
    impacts: Option<[Struck; 2]>,
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
    ///
    /// # Errors
    /// A bad scene or duration, or a file that cannot be written.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let scene = self.scene.load()?;
        let period_s = scene.peer.timing.control_period_s;
        // A day at 1 kHz: beyond that, sums of ticks in f64 begin to round.
        if !(self.duration_s >= period_s && self.duration_s <= 86_400.0) {
            let message = format!(
                "--duration-s {} is not allowed: it must be a number from {period_s} (one control period) to 86400 s",
                self.duration_s
            );
            return Err(message.into());
        }
        let folder = ui.folder(self.out.as_deref(), "out/cooperate");
        let mut options = Options::recorded(self.duration_s, period_s);
        if folder.is_none() {
            options.record_every = 0;
        }
        let bar = ui.progress((self.duration_s / period_s) as u64, "cooperate");
        let start = Instant::now();
        let outcome = match self.scalar {
            ScalarName::F32 => run::<f32>(&scene, options, &|tick| bar.set_position(tick)),
            ScalarName::F64 => run::<f64>(&scene, options, &|tick| bar.set_position(tick)),
            ScalarName::I32f32 => run::<Fixed>(&scene, options, &|tick| bar.set_position(tick)),
        }?;
        let wall_s = start.elapsed().as_secs_f64();
        bar.finish_and_clear();

        let mut report = Report::new(self.scene.name(), &scene, &outcome, wall_s)?;
        if let Some(folder) = folder {
            let name = self.scene.name();
            let base = folder.join(&name);
            // Appended, not replaced: a scene's name may contain a dot.
            report.files = ["csv", "parquet"].map(|kind| folder.join(format!("{name}.{kind}"))).to_vec();
            files::write_csv(&outcome.table, &report.files[0])?;
            files::write_parquet(&outcome.table, &report.files[1])?;
            report.files.extend(figures::run(&name, &outcome, &base)?);
        }
        for warning in &report.warnings {
            ui.warn(warning);
        }
        ui.document(&report)?;
        report.print(ui);
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

    fn print(&self, ui: &Ui) {
        let mut table = TextTable::new(["", self.scene.as_str()]);
        let mut line = |name: &str, value: String| table.push([name.to_owned(), value]);
        line("stable", if self.stable { "yes" } else { "no" }.to_owned());
        if let Some(fault) = &self.fault {
            line("fault", fault.clone());
        }
        line("spectral radius", format!("{:.6}", self.spectral_radius));
        line("true discrepancy |x_o1 - x_o2|", format!("{:.4} mm", self.true_discrepancy_mm));
        if let Some(per_newton) = self.true_discrepancy_mm_per_n {
            line("true discrepancy per newton of contact", format!("{per_newton:.4} mm/N"));
        }
        line("decoded discrepancy |x_o - x_d|, peer 2", format!("{:.4} mm", self.decoded_discrepancy_mm));
        let Spread { mean, sd } = self.coordination_force_n;
        line("coordination force, peer 2", format!("{mean:.4} N, standard deviation {sd:.4} N"));
        line("peak coordination force", format!("{:.4} N", self.peak_coordination_force_n));
        if let Some(mass) = self.apparent_object_mass_kg {
            line("apparent mass of the shared object", format!("{mass:.3} kg"));
        }
        let [first, second] = self.energy;
        line("energy from / to the network, peer 1", format!("{:.4} / {:.4} J", first.received_j, first.sent_j));
        line("energy from / to the network, peer 2", format!("{:.4} / {:.4} J", second.received_j, second.sent_j));
        for (at, struck) in self.impacts.iter().flatten().enumerate() {
            let Struck { count, wanted_n_s, delivered_n_s, lost_j } = struck;
            let text = format!("{count}, {delivered_n_s:.4} of {wanted_n_s:.4} N s, {lost_j:.5} J lost");
            line(&format!("impacts at peer {}, impulse delivered", at + 1), text);
        }
        line("ticks, wall time", format!("{}, {:.3} s", self.ticks, self.wall_s));
        line("state hash", self.state_hash.clone());
        ui.table(&table);
        ui.wrote(&self.files);
    }
}
