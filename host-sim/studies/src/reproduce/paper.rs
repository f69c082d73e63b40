//! The cooperation paper's experiments (§5, Figures 6–9), run again, beside what the paper printed.
//!
//! §5.1 asks for the largest stable coordination gains, §5.2 for the position discrepancy at those gains. The paper's
//! "remote SVO copy" is the one decoded at the same peer, so its discrepancy is ours by the name `decoded`; the `true` one
//! stands beside it.

use rayon::prelude::*;

use cohold_analysis::{Analysis, Conclusion, conclude};
use cohold_report::Columns;
use cohold_sim::run::{Options, Outcome, run};
use cohold_sim::{Laws, scene::Scene, scenes};

use super::readings::{TO_N_PER_M, boundary, crossings};
use crate::Error;
use crate::sweep::EVERY_MODE;

/// Simulated time of every experiment, s.
pub const DURATION_S: f64 = 20.0;

/// What the paper says of one kind of communications.
#[derive(Clone, Copy, Debug)]
pub(super) struct Printed {
    pub(super) law: &'static str,
    /// Largest coordination gain in the experiments, N/m (§5.1).
    pub(super) gain_n_per_m: f64,
    /// Mean position discrepancy at that gain, mm (Fig. 9).
    pub(super) discrepancy_mm: f64,
}

pub(super) const PRINTED: [Printed; 3] = [
    Printed { law: "power", gain_n_per_m: 310.0, discrepancy_mm: 3.5 },
    Printed { law: "wave", gain_n_per_m: 1590.0, discrepancy_mm: 0.644 },
    Printed { law: "passive-wave", gain_n_per_m: 10620.0, discrepancy_mm: 0.099 },
];

/// One experiment and what came of it.
#[derive(Clone, Debug)]
pub struct Experiment {
    /// Scene, without the folder.
    scene: &'static str,
    /// Section of the paper, or "matched-line".
    pub(crate) section: &'static str,
    /// The law of the experiment.
    pub(crate) law: &'static str,
    pub(crate) round_trip_ms: f64,
    /// Coordination stiffness K_T, N/m.
    pub(crate) coordination_stiffness_n_per_m: f64,
    analysis: Analysis,
    /// What Fig. 9 prints for the decoded discrepancy.
    pub(crate) paper_discrepancy_mm: Option<f64>,
    /// Where the scene is stable.
    apparent_object_mass_kg: Option<f64>,
    pub(crate) outcome: Outcome,
}

/// Largest coordination gain of one kind of communications at 16 ms round trip.
#[derive(Clone, Debug)]
pub struct Gain {
    printed: Printed,
    /// Where this model crosses its stability boundary up to 12,000 N/m, pockets included, N/m.
    crossings_n_per_m: Vec<f64>,
}

/// The scene of a section and a law, with 16 ms round trip.
pub(super) fn scene(section: &str, law: &str) -> Result<Scene, Error> {
    Ok(scenes::load(Laws::built_in(), &format!("paper-{section}-{law}-16ms"))?)
}

/// The boundary behind which the scene of section 5.1 with this law is unstable that is nearest to a gain, N/m.
///
/// # Errors
/// A law that the section does not have.
pub fn boundary_n_per_m(law: &str, near_n_per_m: f64) -> Result<f64, Error> {
    Ok(boundary(&crossings(&scene("5.1", law)?, TO_N_PER_M)?, near_n_per_m))
}

/// A run of the position coherency (section 5.2) with this share of the paper's gain.
///
/// # Errors
/// A law that the section does not have.
pub fn run_at(law: &str, share: f64) -> Result<Outcome, Error> {
    let mut scene = scene("5.2", law)?;
    scene.peer.coordination.stiffness_n_per_m *= share;
    Ok(run::<f64>(&scene, Options::unrecorded(DURATION_S), &|_| {})?)
}

/// Runs every experiment of the paper and the matched line, in parallel.
pub fn experiments() -> Result<Vec<Experiment>, Error> {
    let names = scenes::ALL.iter().filter_map(|(name, _)| Some((*name, section(name)?)));
    names.collect::<Vec<_>>().into_par_iter().map(experiment).collect()
}

fn section(name: &'static str) -> Option<&'static str> {
    let paper = name.strip_prefix("paper-").and_then(|rest| rest.split('-').next());
    paper.or_else(|| (name == "matched-line").then_some(name))
}

fn experiment((name, section): (&'static str, &'static str)) -> Result<Experiment, Error> {
    let scene = scenes::load(Laws::built_in(), name)?;
    let timing = &scene.peer.timing;
    let outcome = run::<f64>(&scene, Options::recorded(DURATION_S, timing.control_period_s), &|_| {})?;
    let conclusion = conclude(&scene, outcome)?;
    let apparent_object_mass_kg = conclusion.apparent_mass_kg(&scene)?;
    let Conclusion { outcome, analysis } = conclusion;
    let law = scene.peer.coordination.comm;
    let printed = PRINTED.iter().find(|printed| printed.law == law && section == "5.2");
    Ok(Experiment {
        scene: name,
        section,
        law,
        round_trip_ms: 2e3 * timing.packet_period_s() * f64::from(scene.world.network.one_way_delay_packets),
        coordination_stiffness_n_per_m: scene.peer.coordination.stiffness_n_per_m,
        paper_discrepancy_mm: printed.map(|printed| printed.discrepancy_mm),
        apparent_object_mass_kg,
        analysis,
        outcome,
    })
}

/// The paper's largest gains beside the boundaries of this model, in the experiments' configuration.
pub fn gains() -> Result<Vec<Gain>, Error> {
    let gain = |printed: &Printed| {
        let found = crossings(&scene("5.1", printed.law)?, TO_N_PER_M)?;
        Ok(Gain { printed: *printed, crossings_n_per_m: found.crossings })
    };
    PRINTED.iter().map(gain).collect()
}

/// The experiments as a table.
pub fn experiment_columns(experiments: &[Experiment]) -> Columns {
    let metric = |of: fn(&Outcome) -> f64| move |one: &Experiment| one.outcome.metric(of);
    Columns::of(experiments)
        .data("scene", |one| one.scene)
        .means("built-in scene")
        .value("section", |one| one.section)
        .means("section of the cooperation paper, or matched-line")
        .head("experiment")
        .value("comm", |one| one.law)
        .means("how the copies are held together")
        .number("round_trip_ms", 0, |one| one.round_trip_ms)
        .means("network's round trip")
        .number("coordination_stiffness_n_per_m", 0, |one| one.coordination_stiffness_n_per_m)
        .means("coordination gain K_T")
        .head("K_T")
        .value("stable", |one| one.outcome.is_stable())
        .means("whether nobody stopped, nothing grew, the copies stayed together, and no eigenvalue says otherwise")
        .data("verdict", |one| one.outcome.verdict().name())
        .means("stable, apart or NO")
        .data("reason", |one| one.outcome.reason.map(|reason| reason.to_string()))
        .means("why it is not stable")
        .data("spectral_radius", |one| one.analysis.verdict.spectral_radius)
        .means("largest |eigenvalue| over a packet period, both hands on")
        .data("every_mode_stable", |one| one.analysis.judged.worst.stable)
        .means(EVERY_MODE)
        .number("decoded_discrepancy_mm", 4, metric(|o| o.whole.decoded_discrepancy_mm))
        .head("decoded")
        .means("|x_o - x_d| at peer 2, what the paper plots")
        .value("paper_discrepancy_mm", |one| one.paper_discrepancy_mm)
        .means("what the paper prints for the decoded discrepancy (Fig. 9)")
        .head("paper")
        .number("true_discrepancy_mm", 4, |one| one.outcome.metric(|o| o.whole.true_discrepancy_mm))
        .head("true")
        .means("|x_o1 - x_o2| at one instant")
        .number("true_discrepancy_mm_per_n", 3, metric(|o| o.whole.true_discrepancy_mm / o.whole.contact_force_n))
        .means("true discrepancy over the mean contact force")
        .head("true")
        .number("coordination_force_n.mean", 3, metric(|o| o.whole.coordination_force_n.mean))
        .means("mean of F_T at peer 2 over the last half")
        .head("F_T")
        .number("coordination_force_n.sd", 3, metric(|o| o.whole.coordination_force_n.sd))
        .means("standard deviation of F_T at peer 2 over the last half")
        .head("sd")
        .number("apparent_object_mass_kg", 3, |one| one.apparent_object_mass_kg)
        .head("object")
        .means("apparent mass of the shared object, copies and line together")
        .done()
}

/// The gains as a table.
pub fn gain_columns(gains: &[Gain]) -> Columns {
    Columns::of(gains)
        .value("comm", |gain| gain.printed.law)
        .means("how the copies are held together")
        .number("paper_n_per_m", 0, |gain| gain.printed.gain_n_per_m)
        .means("largest gain in the paper's experiments")
        .head("paper's experiment")
        .number("crossings_n_per_m", 0, |gain| gain.crossings_n_per_m.clone())
        .means("gains at which this model turns unstable or stable again, up to 12,000 N/m")
        .head("this model's boundaries")
        .done()
}
