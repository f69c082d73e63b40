//! `cohold cooperate`: two peers hold one object.

use clap::Args;
use cohold_analysis::{Conclusion, conclude};
use cohold_core::num::{Fixed, Scalar};
use cohold_core::safety::Fault;
use cohold_core::settings::Refused;
use cohold_live::recording::mcap::{ERROR, INFO};
use cohold_report::Columns;
use cohold_sim::run::{self, AXIS_NAMES, EachRow, Options, Outcome, Run, run_seen};
use cohold_sim::scene::Scene;
use cohold_studies::figures;
use serde_json::json;

use super::flags::{ScalarName, Simulation};
use super::{Failure, SceneArgs, Ui, ui::Unsuccessful};

#[derive(Debug, Args)]
pub(super) struct Cooperate {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    asked: Simulation,
}

impl Cooperate {
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let scene = self.scene.load(ui)?;
        let period_s = scene.peer.timing.control_period_s;
        let Simulation { time, scalar, record, out } = &self.asked;
        time.check(&scene)?;
        let options = match ui.writes(out) {
            true => Options::recorded(time.seconds, period_s),
            false => Options { duration_s: time.seconds, record_every: 0 },
        };
        let steps = (time.seconds / period_s / 1e4) as usize;
        let provenance = ui.provenance().settings(scene.settings());
        let recorder = record.simulated(&provenance, scene.peer.axis.shared as usize)?;
        let each = |axis: usize, row: &[f64]| {
            if let Some(recorder) = &recorder {
                // There are three axes at most.
                recorder.put_all(axis as u16, (1e9 * row[0]).round() as u64, row);
            }
        };
        let each: Option<EachRow<'_>> = recorder.is_some().then_some(&each);
        let ((outcome, scalar), wall_s) = ui.work(steps, "cooperate", |step| match scalar {
            ScalarName::F32 => go::<f32>(&scene, options, step, each),
            ScalarName::F64 => go::<f64>(&scene, options, step, each),
            ScalarName::I32f32 => go::<Fixed>(&scene, options, step, each),
        })?;
        let conclusion = conclude(&scene, outcome)?;
        let mut warnings = conclusion.warnings(&scene)?;
        if let Some(recorder) = recorder {
            let of = &conclusion.outcome;
            let at_s = of.fault_time_s.unwrap_or(of.ticks as f64 * period_s);
            let level = if of.fault.is_some() { ERROR } else { INFO };
            let reason = of.reason.iter().map(ToString::to_string);
            for words in reason.chain(warnings.clone()) {
                recorder.log((1e9 * at_s).round() as u64, level, words);
            }
            ui.status(recorder.finish().summary());
        }
        if options.record_every > 1 {
            let every = options.record_every;
            warnings.push(format!("a long run: its files hold one tick in {every}; the figures of merit are of all"));
        }
        let facts = whole(&self.scene.name(), &scene, &conclusion, wall_s)?;
        let outcome = &conclusion.outcome;
        let provenance = provenance.with("number_type", scalar).with("seconds", time.seconds);
        let provenance = provenance.with("seed", scene.world.network.seed).with("state_hash", hash(outcome));
        let provenance = provenance.with("recorded_every_ticks", options.record_every);
        let number = if scalar == f64::NAME { String::new() } else { format!("-{scalar}") };
        let name = self.scene.run_name(&scene) + &number;
        let several = outcome.axes.len() > 1;
        let mut files = Vec::new();
        for (axis, along) in outcome.axes.iter().enumerate() {
            let name = if several { format!("{name}-{}", AXIS_NAMES[axis]) } else { name.clone() };
            files.extend(ui.files(out, "cooperate", &name, &provenance, |files| {
                files.csv(&along.table)?;
                files.parquet(&along.table)?;
                files.figure(None, &figures::run(&name, outcome, axis))
            })?);
        }
        warnings.iter().for_each(|warning| ui.warn(warning));
        let mut document = facts.row(0);
        (document["warnings"], document["files"]) = (json!(warnings), json!(files));
        let axes = each_axis(outcome);
        if several {
            document["axes"] = (0..axes.len()).map(|row| axes.row(row)).collect();
        }
        ui.document_of(&provenance, &document)?;
        writeln!(ui, "{}", facts.down(&[&self.scene.name()]));
        if several {
            writeln!(ui, "along each axis:\n\n{axes}");
        }
        ui.wrote(&files);
        outcome.reason.map_or(Ok(()), |reason| Err(Unsuccessful(reason.to_string()).into()))
    }
}

/// A run in this number type, and what that is called.
fn go<S: Run>(
    scene: &Scene,
    options: Options,
    step: &(dyn Fn() + Sync),
    each: Option<EachRow<'_>>,
) -> Result<(Outcome, &'static str), Refused<'static>> {
    run_seen::<S>(scene, options, &|_| step(), each).map(|outcome| (outcome, S::NAME))
}

/// Of both peers' states over every tick.
fn hash(outcome: &Outcome) -> String {
    format!("{:016x}", outcome.hash)
}

/// Who stopped, and why.
fn stop((peer, fault): (usize, Fault)) -> String {
    format!("peer {peer} stopped with fault {}: {}", fault.number(), fault.explain())
}

/// What a run gave of all axes together, with what the analyser says of the scene.
fn whole(name: &str, scene: &Scene, conclusion: &Conclusion, wall_s: f64) -> Result<Columns, Failure> {
    let Conclusion { outcome, analysis } = conclusion;
    let mass = conclusion.apparent_mass_kg(scene)?;
    let per_n = |o: &Outcome| {
        let whole = &o.whole;
        (whole.contact_force_n > 0.0).then(|| whole.true_discrepancy_mm / whole.contact_force_n)
    };
    let mut columns = Columns::of(&[()])
        .data("scene", |()| name)
        .value("stable", |()| outcome.is_stable())
        .head("this run is stable")
        .data("verdict", |()| outcome.verdict().name())
        .value("reason", |()| outcome.reason.map(|reason| reason.to_string()))
        .data("fault", |()| outcome.fault.map(stop))
        .number("spectral_radius", 6, |()| analysis.verdict.spectral_radius)
        .head("spectral radius of the scene, both hands on")
        .value("every_mode_stable", |()| analysis.judged.worst.stable)
        .head("stable in every mode, hands let go too")
        .data("unstable_modes", |()| {
            Some(analysis.judged.unstable_modes().join("; ")).filter(|modes| !modes.is_empty())
        })
        .number("true_discrepancy_mm", 4, |()| outcome.metric(|o| o.whole.true_discrepancy_mm))
        .head("true discrepancy |x_o1 - x_o2|")
        .number("true_discrepancy_mm_per_n", 4, |()| outcome.metric(per_n).flatten())
        .head("true discrepancy per newton of contact")
        .number("decoded_discrepancy_mm", 4, |()| outcome.metric(|o| o.whole.decoded_discrepancy_mm))
        .head("decoded discrepancy |x_o - x_d|, peer 2")
        .number("coordination_force_n.mean", 4, |()| outcome.metric(|o| o.whole.coordination_force_n.mean))
        .head("coordination force, peer 2: mean")
        .number("coordination_force_n.sd", 4, |()| outcome.metric(|o| o.whole.coordination_force_n.sd))
        .head("coordination force, peer 2: standard deviation")
        .number("peak_coordination_force_n", 4, |()| outcome.metric(|o| o.whole.peak_coordination_force_n))
        .number("apparent_object_mass_kg", 3, |()| mass)
        .head("apparent mass of the shared object")
        .number("energy_made_mj", 3, |()| outcome.metric(Outcome::energy_made_mj))
        .head("energy made, channel")
        .number("peer_energy_made_mj", 3, |()| outcome.metric(Outcome::peer_energy_made_mj).flatten())
        .head("energy made, peer");
    for (at, energy) in outcome.whole.energy.iter().enumerate() {
        let peer = at + 1;
        columns = columns
            .number(format!("energy.{at}.received_j"), 4, |()| energy.received_j)
            .head(&format!("energy from the network, peer {peer}"))
            .number(format!("energy.{at}.sent_j"), 4, |()| energy.sent_j)
            .head(&format!("energy to the network, peer {peer}"))
            .data(format!("energy.{at}.to_object_j"), |()| energy.to_object_j)
            .data(format!("energy.{at}.from_object_j"), |()| energy.from_object_j)
            .data(format!("energy.{at}.stored_j"), |()| energy.stored_j);
    }
    for (at, impacts) in outcome.impacts.iter().flatten().enumerate() {
        let peer = at + 1;
        columns = columns
            .value(format!("impacts.{at}.count"), |()| impacts.count)
            .head(&format!("impacts at peer {peer}"))
            .number(format!("impacts.{at}.wanted_n_s"), 4, |()| impacts.wanted_n_s)
            .head(&format!("impulse that the impacts ask for, peer {peer}"))
            .number(format!("impacts.{at}.delivered_n_s"), 4, |()| impacts.delivered_n_s)
            .head(&format!("impulse that object and device took, peer {peer}"))
            .number(format!("impacts.{at}.lost_j"), 5, |()| impacts.lost_j)
            .head(&format!("energy that restitution took, peer {peer}"));
    }
    let columns = columns.value("ticks", |()| outcome.ticks).number("wall_s", 3, |()| wall_s).head("wall time");
    let columns = columns.data("seed", |()| scene.world.network.seed);
    Ok(columns.value("state_hash", |()| hash(outcome)).done())
}

/// What a run gave along each axis, a row for each.
fn each_axis(outcome: &Outcome) -> Columns {
    let rows: Vec<_> = AXIS_NAMES.into_iter().zip(&outcome.axes).map(|(name, along)| (name, along.figures)).collect();
    let known = outcome.verdict() != run::Verdict::Unstable;
    Columns::of(&rows)
        .value("axis", |(axis, _)| *axis)
        .number("true_discrepancy_mm", 4, |(_, of)| known.then_some(of.true_discrepancy_mm))
        .head("true")
        .number("decoded_discrepancy_mm", 4, |(_, of)| known.then_some(of.decoded_discrepancy_mm))
        .head("decoded")
        .number("coordination_force_n.mean", 4, |(_, of)| known.then_some(of.coordination_force_n.mean))
        .head("F_T, peer 2: mean")
        .number("coordination_force_n.sd", 4, |(_, of)| known.then_some(of.coordination_force_n.sd))
        .head("standard deviation")
        .number("peak_coordination_force_n", 4, |(_, of)| known.then_some(of.peak_coordination_force_n))
        .head("peak F_T")
        .done()
}
