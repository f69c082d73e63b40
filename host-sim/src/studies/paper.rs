//! The cooperation paper's experiments (§5, Figures 6–9), run again, beside what the paper printed.
//!
//! §5.1 asks for the largest stable coordination gains, §5.2 for the position discrepancy at those gains. The paper's
//! "remote SVO copy" is the one decoded at the same peer, so its discrepancy is ours by the name `decoded`; the `true` one
//! stands beside it.

use rayon::prelude::*;

use haptic_analysis::{Effort, Range};
use haptic_sim::measure::{Statistics, apparent_mass};
use haptic_sim::report::Columns;
use haptic_sim::run::{Options, Outcome, run};
use haptic_sim::scene::Scene;
use haptic_sim::scenes;

/// Simulated time of every experiment, s.
pub const DURATION_S: f64 = 20.0;

/// What the paper says of one kind of communications.
#[derive(Clone, Copy, Debug)]
struct Printed {
    comm: &'static str,
    /// Largest coordination gain in the experiments, N/m (§5.1).
    gain_n_per_m: f64,
    /// Mean position discrepancy at that gain, mm (Fig. 9).
    discrepancy_mm: f64,
}

const PRINTED: [Printed; 3] = [
    Printed { comm: "power", gain_n_per_m: 310.0, discrepancy_mm: 3.5 },
    Printed { comm: "wave", gain_n_per_m: 1590.0, discrepancy_mm: 0.644 },
    Printed { comm: "passive-wave", gain_n_per_m: 10620.0, discrepancy_mm: 0.099 },
];

/// One experiment and what came of it.
#[derive(Clone, Debug)]
pub struct Experiment {
    /// Scene, without the folder.
    pub scene: String,
    /// Section of the paper, or "matched-line".
    pub section: String,
    /// What is sent.
    pub comm: String,
    /// Round trip, ms.
    pub round_trip_ms: f64,
    /// K_T, N/m.
    pub coordination_stiffness_n_per_m: f64,
    /// Nothing faulted or grew, and no eigenvalue lies outside the unit circle.
    pub stable: bool,
    /// Largest eigenvalue but the rest modes.
    pub spectral_radius: f64,
    /// Mean |x_o − x_d| at peer 2 over the last half, mm.
    pub decoded_discrepancy_mm: f64,
    /// What Fig. 9 prints for it, mm.
    pub paper_discrepancy_mm: Option<f64>,
    /// Mean |x_o1 − x_o2| over the last half, mm.
    pub true_discrepancy_mm: f64,
    /// The same over the mean contact force, mm/N.
    pub true_discrepancy_mm_per_n: f64,
    /// F_T at peer 2 over the last half.
    pub coordination_force_n: Statistics,
    /// Apparent mass of the shared object, kg, where the scene is stable.
    pub apparent_object_mass_kg: Option<f64>,
    /// What was recorded.
    pub outcome: Outcome,
}

/// Largest coordination gain of one kind of communications at 16 ms round trip.
#[derive(Clone, Debug)]
pub struct Gain {
    /// What is sent.
    pub comm: String,
    /// What the paper's experiments reached, N/m.
    pub paper_n_per_m: f64,
    /// Where this model crosses its stability boundary up to 12,000 N/m, pockets included, N/m.
    pub crossings_n_per_m: Vec<f64>,
}

/// Runs every experiment of the paper and the matched line, in parallel.
pub fn experiments() -> Result<Vec<Experiment>, Box<dyn std::error::Error + Send + Sync>> {
    let names: Vec<&str> = scenes::ALL.iter().map(|(name, _)| *name).filter(|name| section(name).is_some()).collect();
    names.into_par_iter().map(experiment).collect()
}

fn section(name: &str) -> Option<&str> {
    name.strip_prefix("paper-")
        .and_then(|rest| rest.split('-').next())
        .or_else(|| (name == "matched-line").then_some(name))
}

fn experiment(name: &str) -> Result<Experiment, Box<dyn std::error::Error + Send + Sync>> {
    let scene = scenes::load(haptic_sim::Laws::built_in(), name)?;
    let timing = &scene.peer.timing;
    let packet_s = timing.packet_period_s();
    let outcome = run::<f64>(&scene, Options::recorded(DURATION_S, timing.control_period_s), &|_| {})?;
    let verdict = haptic_analysis::verdict(&scene)?;
    let section = section(name).unwrap_or(name);
    let comm = comm(&scene);
    Ok(Experiment {
        scene: name.to_owned(),
        section: section.to_owned(),
        round_trip_ms: 2e3 * packet_s * f64::from(scene.world.network.one_way_delay_packets),
        coordination_stiffness_n_per_m: scene.peer.coordination.stiffness_n_per_m,
        stable: outcome.bounded && verdict.stable,
        spectral_radius: verdict.spectral_radius,
        decoded_discrepancy_mm: outcome.decoded_discrepancy_mm,
        paper_discrepancy_mm: PRINTED
            .iter()
            .find(|printed| printed.comm == comm && section == "5.2")
            .map(|printed| printed.discrepancy_mm),
        true_discrepancy_mm: outcome.true_discrepancy_mm,
        true_discrepancy_mm_per_n: outcome.true_discrepancy_mm / outcome.contact_force_n,
        coordination_force_n: outcome.coordination_force_n,
        apparent_object_mass_kg: if verdict.stable { Some(apparent_mass::measure(&scene)?) } else { None },
        comm,
        outcome,
    })
}

fn comm(scene: &Scene) -> String {
    scene.peer.coordination.comm.to_owned()
}

/// The paper's largest gains beside the boundaries of this model, in the experiments' configuration.
pub fn gains() -> Result<Vec<Gain>, Box<dyn std::error::Error + Send + Sync>> {
    PRINTED
        .iter()
        .map(|printed| {
            let scene = scenes::load(haptic_sim::Laws::built_in(), &format!("paper-5.1-{}-16ms", printed.comm))?;
            let range = Range { key: "coordination.stiffness_n_per_m".to_owned(), from: 1.0, to: 12_000.0 };
            let limit = haptic_analysis::limit(&scene, range, Effort::default())?;
            Ok(Gain {
                comm: printed.comm.to_owned(),
                paper_n_per_m: printed.gain_n_per_m,
                crossings_n_per_m: limit.crossings,
            })
        })
        .collect()
}

/// The experiments as a table.
pub fn experiment_columns(experiments: &[Experiment]) -> Columns {
    Columns::of(experiments)
        .value("scene", |one| one.scene.as_str())
        .data_only()
        .value("section", |one| one.section.as_str())
        .head("experiment")
        .value("comm", |one| one.comm.as_str())
        .number("round_trip_ms", 0, |one| one.round_trip_ms)
        .number("coordination_stiffness_n_per_m", 0, |one| one.coordination_stiffness_n_per_m)
        .head("K_T")
        .value("stable", |one| one.stable)
        .value("spectral_radius", |one| one.spectral_radius)
        .data_only()
        .number("decoded_discrepancy_mm", 4, |one| one.decoded_discrepancy_mm)
        .head("decoded")
        .where_true(|one| one.stable)
        .means("|x_o - x_d| at peer 2, what the paper plots")
        .value("paper_discrepancy_mm", |one| one.paper_discrepancy_mm)
        .head("paper")
        .number("true_discrepancy_mm", 4, |one| one.true_discrepancy_mm)
        .head("true")
        .where_true(|one| one.stable)
        .means("|x_o1 - x_o2| at one instant")
        .number("true_discrepancy_mm_per_n", 3, |one| one.true_discrepancy_mm_per_n)
        .head("true")
        .where_true(|one| one.stable)
        .number("coordination_force_n.mean", 3, |one| one.coordination_force_n.mean)
        .head("F_T N")
        .where_true(|one| one.stable)
        .number("coordination_force_n.sd", 3, |one| one.coordination_force_n.sd)
        .head("sd N")
        .where_true(|one| one.stable)
        .number("apparent_object_mass_kg", 3, |one| one.apparent_object_mass_kg)
        .head("object")
        .means("apparent mass of the shared object, copies and line together")
        .done()
}

/// The gains as a table.
pub fn gain_columns(gains: &[Gain]) -> Columns {
    Columns::of(gains)
        .value("comm", |gain| gain.comm.as_str())
        .number("paper_n_per_m", 0, |gain| gain.paper_n_per_m)
        .head("paper's experiment")
        .number("crossings_n_per_m", 0, |gain| gain.crossings_n_per_m.clone())
        .head("this model's boundaries")
        .done()
}
