//! `host-sim cooperate`: two peers hold one object.

use clap::Args;
use haptic_analysis::{Verdict, judge};
use haptic_core::names::Choice;
use haptic_core::num::{Fixed, Scalar};
use haptic_core::settings::Refused;
use serde_json::json;

use super::flags::{ScalarName, Simulation};
use super::several::stop;
use super::{Failure, SceneArgs, Ui, several};
use crate::studies::{doubt, figures};
use haptic_sim::measure::apparent_mass;
use haptic_sim::report::Columns;
use haptic_sim::run::{EachRow, Options, Outcome, Run, run, run_seen};
use haptic_sim::scene::Scene;
use haptic_sim::user::User;

#[derive(Debug, Args)]
pub(super) struct Cooperate {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    asked: Simulation,
}

impl Cooperate {
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let scene = self.scene.load_any(ui)?;
        let period_s = scene.peer.timing.control_period_s;
        let Simulation { time, scalar, record, out } = &self.asked;
        time.check(&scene)?;
        if scene.is_shared_along_several() {
            return several::run(ui, &self.scene, &scene, &self.asked);
        }
        let options = match ui.writes(out) {
            true => Options::recorded(time.seconds, period_s),
            false => Options { duration_s: time.seconds, record_every: 0 },
        };
        let steps = (time.seconds / period_s / 1e4) as usize;
        let made = ui.made().settings(scene.settings());
        let recorder = record.simulated(&made, 1)?;
        let each = |row: &[f64]| {
            if let Some(recorder) = &recorder {
                recorder.put_all(0, (1e9 * row[0]).round() as u64, row);
            }
        };
        let ((outcome, scalar), wall_s) = ui.work(steps, "cooperate", |step| match scalar {
            ScalarName::F32 => go::<f32>(&scene, options, step, recorder.is_some().then_some(&each)),
            ScalarName::F64 => go::<f64>(&scene, options, step, recorder.is_some().then_some(&each)),
            ScalarName::I32f32 => go::<Fixed>(&scene, options, step, recorder.is_some().then_some(&each)),
        })?;
        if let Some(recorder) = recorder {
            ui.status(recorder.finish().told());
        }

        let verdict = haptic_analysis::verdict(&scene)?;
        let outcome = outcome.doubted(doubt(&scene, &verdict));
        let mut warnings = if verdict.stable { Vec::new() } else { vec![haptic_analysis::advice(&scene)?] };
        let judged = judge(&scene)?;
        if verdict.stable && !judged.worst.stable {
            let (hands, radius) = (judged.worst_mode().name(), judged.worst.spectral_radius);
            warnings.push(format!(
                "unstable where the object is let go of (hands on: {hands}, spectral radius {radius:.6}): `stability point` says \
                 what to change"
            ));
        }
        if !scene.users.iter().any(User::acts) {
            warnings.push("nobody pushes: set user.1.push_n (or load a scene)".to_owned());
        }
        if options.record_every > 1 {
            let every = options.record_every;
            warnings.push(format!("a long run: its files hold one tick in {every}; the figures of merit are of all"));
        }
        let facts = columns(&self.scene.name(), &scene, &outcome, &verdict, wall_s)?;
        let made = made.with("number_type", scalar).with("seconds", time.seconds);
        let made = made.with("seed", scene.world.network.seed).with("state_hash", hash(&outcome));
        let made = made.with("recorded_every_ticks", options.record_every);
        let number = if scalar == f64::NAME { String::new() } else { format!("-{scalar}") };
        let name = self.scene.run_name(&scene) + &number;
        let files = ui.files(out, "cooperate", &name, &made, |files| {
            files.csv(&outcome.table)?;
            files.parquet(&outcome.table)?;
            files.figure(None, &figures::run(&name, &outcome))
        })?;
        warnings.iter().for_each(|warning| ui.warn(warning));
        let mut document = facts.row(0);
        (document["warnings"], document["files"]) = (json!(warnings), json!(files));
        ui.document_of(&made, &document)?;
        writeln!(ui, "{}", facts.down(&[&self.scene.name()]));
        ui.wrote(&files);
        Ok(())
    }
}

/// A run in this number type, and what that is called.
fn go<S: Run>(
    scene: &Scene,
    options: Options,
    step: &(dyn Fn() + Sync),
    each: Option<EachRow<'_>>,
) -> Result<(Outcome, &'static str), Refused<'static>> {
    let outcome = match each {
        Some(each) => run_seen::<S>(scene, options, &|_| step(), each),
        None => run::<S>(scene, options, &|_| step()),
    };
    outcome.map(|outcome| (outcome, S::NAME))
}

/// Of both peers' states over every tick.
fn hash(outcome: &Outcome) -> String {
    format!("{:016x}", outcome.hash)
}

/// What a run gave, with what the analyser says of the scene.
fn columns(name: &str, scene: &Scene, outcome: &Outcome, verdict: &Verdict, wall_s: f64) -> Result<Columns, Failure> {
    let mass = if outcome.is_stable() && verdict.stable {
        Some(apparent_mass::measure(scene)?).filter(|mass| mass.is_finite())
    } else {
        None
    };
    let per_n = |o: &Outcome| (o.contact_force_n > 0.0).then(|| o.true_discrepancy_mm / o.contact_force_n);
    let mut columns = Columns::of(&[()])
        .value("scene", |()| name)
        .data_only()
        .value("stable", |()| outcome.is_stable())
        .value("verdict", |()| outcome.verdict().name())
        .data_only()
        .value("reason", |()| outcome.reason.map(|reason| reason.to_string()))
        .value("fault", |()| outcome.fault.map(stop))
        .data_only()
        .number("spectral_radius", 6, |()| verdict.spectral_radius)
        .number("true_discrepancy_mm", 4, |()| outcome.whole(|o| o.true_discrepancy_mm))
        .head("true discrepancy |x_o1 - x_o2|")
        .number("true_discrepancy_mm_per_n", 4, |()| outcome.merit(per_n).flatten())
        .head("true discrepancy per newton of contact")
        .number("decoded_discrepancy_mm", 4, |()| outcome.merit(|o| o.decoded_discrepancy_mm))
        .head("decoded discrepancy |x_o - x_d|, peer 2")
        .number("coordination_force_n.mean", 4, |()| outcome.merit(|o| o.coordination_force_n.mean))
        .head("coordination force, peer 2: mean")
        .number("coordination_force_n.sd", 4, |()| outcome.merit(|o| o.coordination_force_n.sd))
        .head("coordination force, peer 2: standard deviation")
        .number("peak_coordination_force_n", 4, |()| outcome.whole(|o| o.peak_coordination_force_n))
        .number("apparent_object_mass_kg", 3, |()| mass)
        .head("apparent mass of the shared object")
        .number("energy_out_over_in", 4, |()| outcome.whole(Outcome::energy_out_over_in))
        .head("energy out/in, channel")
        .number("peer_energy_out_over_in", 4, |()| outcome.whole(Outcome::peer_energy_out_over_in).flatten())
        .head("energy out/in, peer");
    for (at, energy) in outcome.energy.iter().enumerate() {
        let peer = at + 1;
        columns = columns
            .number(format!("energy.{at}.received_j"), 4, |()| energy.received_j)
            .head(&format!("energy from the network, peer {peer}"))
            .number(format!("energy.{at}.sent_j"), 4, |()| energy.sent_j)
            .head(&format!("energy to the network, peer {peer}"))
            .number(format!("energy.{at}.to_object_j"), 4, |()| energy.to_object_j)
            .data_only()
            .number(format!("energy.{at}.from_object_j"), 4, |()| energy.from_object_j)
            .data_only()
            .number(format!("energy.{at}.stored_j"), 6, |()| energy.stored_j)
            .data_only();
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
    let columns = columns.value("seed", |()| scene.world.network.seed).data_only();
    Ok(columns.value("state_hash", |()| hash(outcome)).done())
}
