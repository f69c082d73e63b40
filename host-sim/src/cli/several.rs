//! `host-sim cooperate` of an object that is shared along several axes: one row of figures for each.

use haptic_analysis::Verdict;
use haptic_core::num::{Fixed, Scalar};
use haptic_core::safety::Fault;
use haptic_core::settings::Refused;
use serde_json::json;

use super::flags::{ScalarName, Simulation};
use super::{Failure, SceneArgs, Ui};
use crate::studies::figures;
use haptic_sim::report::Columns;
use haptic_sim::run::{Options, Outcome};
use haptic_sim::scene::Scene;
use haptic_sim::shared::{self, EachRow, NAMES, Shared};
use haptic_sim::user::User;

pub(super) fn run(ui: &Ui, args: &SceneArgs, scene: &Scene, asked: &Simulation) -> Result<(), Failure> {
    let Simulation { time, scalar: in_type, record, out } = asked;
    let period_s = scene.peer.timing.control_period_s;
    let options = match ui.writes(out) {
        true => Options::recorded(time.seconds, period_s),
        false => Options { duration_s: time.seconds, record_every: 0 },
    };
    let steps = (time.seconds / period_s / 1e4) as usize;
    let made = ui.made().settings(scene.settings());
    let recorder = record.simulated(&made, scene.peer.axis.shared as usize)?;
    let each = |axis: usize, row: &[f64]| {
        if let Some(recorder) = &recorder {
            // There are three axes at most.
            recorder.put_all(axis as u16, (1e9 * row[0]).round() as u64, row);
        }
    };
    let each: Option<EachRow<'_>> = recorder.is_some().then_some(&each);
    let ((outcome, scalar), wall_s) = ui.work(steps, "cooperate", |step| match in_type {
        ScalarName::F32 => go::<f32>(scene, options, step, each),
        ScalarName::F64 => go::<f64>(scene, options, step, each),
        ScalarName::I32f32 => go::<Fixed>(scene, options, step, each),
    })?;
    if let Some(recorder) = recorder {
        ui.status(recorder.finish().told());
    }
    // Of all axes at once.
    let verdict = haptic_analysis::verdict(scene)?;
    let mut warnings = if verdict.stable { Vec::new() } else { vec![haptic_analysis::advice(scene)?] };
    if !scene.users.iter().any(User::acts) {
        warnings.push("nobody pushes: set user.1.push_n and user.1.direction_rad (or load a scene)".to_owned());
    }
    let rows: Vec<_> = NAMES.into_iter().zip(&outcome.axes).collect();
    let axes = columns(&rows, &verdict);
    let hash = format!("{:016x}", outcome.hash);
    let made = made.with("number_type", scalar).with("seconds", time.seconds);
    let made = made.with("seed", scene.world.network.seed).with("state_hash", hash.clone());
    let made = made.with("recorded_every_ticks", options.record_every);
    let number = if scalar == f64::NAME { String::new() } else { format!("-{scalar}") };
    let name = args.run_name(scene) + &number;
    let mut files = Vec::new();
    for (axis, outcome) in &rows {
        let name = format!("{name}-{axis}");
        files.extend(ui.files(out, "cooperate", &name, &made, |files| {
            files.csv(&outcome.table)?;
            files.parquet(&outcome.table)?;
            files.figure(None, &figures::run(&name, outcome))
        })?);
    }
    warnings.iter().for_each(|warning| ui.warn(warning));
    let each: Vec<_> = (0..axes.len()).map(|row| axes.row(row)).collect();
    let apart_mm = outcome.is_stable().then_some(outcome.true_discrepancy_mm);
    let document = json!({
        "scene": args.name(),
        "stable": outcome.is_stable(),
        "true_discrepancy_mm": apart_mm,
        "axes": each,
        "ticks": outcome.axes.first().map(|axis| axis.ticks),
        "wall_s": wall_s,
        "seed": scene.world.network.seed,
        "state_hash": hash,
        "warnings": warnings,
        "files": files,
    });
    ui.document_of(&made, &document)?;
    writeln!(ui, "{axes}");
    match apart_mm {
        Some(apart_mm) => writeln!(ui, "true discrepancy of all axes together: {apart_mm:.4} mm"),
        None => writeln!(ui, "not stable"),
    }
    ui.wrote(&files);
    Ok(())
}

fn go<S: shared::Run>(
    scene: &Scene,
    options: Options,
    step: &(dyn Fn() + Sync),
    each: Option<EachRow<'_>>,
) -> Result<(Shared, &'static str), Refused<'static>> {
    let go_on = |_| {
        step();
        true
    };
    let outcome = match each {
        Some(each) => shared::run_seen::<S>(scene, options, &go_on, each),
        None => shared::run::<S>(scene, options, &go_on),
    };
    outcome.map(|outcome| (outcome, S::NAME))
}

/// Who stopped, and why.
pub(super) fn stop((peer, fault): (usize, Fault)) -> String {
    format!("peer {peer} stopped with fault {}: {}", fault.number(), fault.explain())
}

/// What a run gave, a row for each axis.
fn columns(rows: &[(&str, &Outcome)], verdict: &Verdict) -> Columns {
    Columns::of(rows)
        .value("axis", |(axis, _)| *axis)
        .value("stable", |(_, o)| o.is_stable())
        .value("verdict", |(_, o)| o.verdict().name())
        .data_only()
        .value("reason", |(_, o)| o.reason.map(|reason| reason.to_string()))
        .data_only()
        .value("fault", |(_, o)| o.fault.map(stop))
        .data_only()
        .number("spectral_radius", 6, |_| verdict.spectral_radius)
        .number("true_discrepancy_mm", 4, |(_, o)| o.whole(|o| o.true_discrepancy_mm))
        .head("true")
        .number("decoded_discrepancy_mm", 4, |(_, o)| o.merit(|o| o.decoded_discrepancy_mm))
        .head("decoded")
        .number("coordination_force_n.mean", 4, |(_, o)| o.merit(|o| o.coordination_force_n.mean))
        .head("F_T, peer 2: mean")
        .number("coordination_force_n.sd", 4, |(_, o)| o.merit(|o| o.coordination_force_n.sd))
        .head("standard deviation")
        .number("peak_coordination_force_n", 4, |(_, o)| o.whole(|o| o.peak_coordination_force_n))
        .head("peak F_T")
        .number("energy_out_over_in", 4, |(_, o)| o.whole(Outcome::energy_out_over_in))
        .head("energy out/in")
        .done()
}
