//! How far f32 and fixed point stray from f64 in the same scene.
//!
//! The three pairs run side by side, each with its own device in f64, on the same pushes. What is expected: a position is
//! stored to a step (ulp) of the number type at its size, so the coordination spring feels steps of K_T times that; this
//! force noise moves the pair along its rest modes, which nothing pulls back, and the difference walks away at random.
//! Sums of ticks do not add to it: they are compensated (`haptic_core::sum`).

use haptic_core::{num::Fixed, settings::Refused};

use haptic_sim::{pair::Pair, peers::Number, report::Columns, scene::Scene};

/// Largest differences from f64 over a run.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Differences {
    /// Largest difference of either copy's position, m.
    pub(crate) position_m: f64,
    /// Largest difference of either coordination force, N.
    pub(crate) force_n: f64,
    /// Step of the number type at the largest position seen, m.
    pub(crate) position_step_m: f64,
    /// K_T times that step: what one step of position is worth in force, N.
    pub(crate) force_step_n: f64,
}

/// What a run of a scene in three number types gave.
#[derive(Clone, Debug)]
pub(crate) struct Precision {
    pub(crate) scene: String,
    pub(crate) duration_s: f64,
    /// Largest position of either copy in f64, m.
    pub(crate) largest_position_m: f64,
    pub(crate) f32: Differences,
    pub(crate) i32f32: Differences,
    /// Where f64 itself faulted: differences were taken until then.
    pub(crate) faulted_after_s: Option<f64>,
    /// Why the differences are what they are.
    pub(crate) explanation: String,
}

/// Runs the scene for `duration_s` in f64, f32 and I32F32.
pub(crate) fn measure(name: &str, scene: &Scene, duration_s: f64) -> Result<Precision, Refused<'static>> {
    let (mut double, mut single, mut fixed) =
        (Pair::<f64>::new(scene)?, Pair::<f32>::new(scene)?, Pair::<Fixed>::new(scene)?);
    let ticks = (duration_s / scene.peer.timing.control_period_s).round() as u64;
    let (mut f32, mut i32f32, mut largest) = (Differences::default(), Differences::default(), 0.0_f64);
    let mut faulted_after_s = None;
    for _ in 0..ticks {
        double.step();
        if double.fault().is_some() {
            faulted_after_s = Some(double.time_s());
            break;
        }
        single.step();
        fixed.step();
        for side in double.sides() {
            largest = largest.max(side.peer.observed().object.position.abs());
        }
        f32.see(&double, &single);
        i32f32.see(&double, &fixed);
    }
    let stiffness = scene.peer.coordination.stiffness_n_per_m;
    // Steps: 2^(exponent − 23) for f32, 2^−32 for I32F32.
    f32.position_step_m = if largest > 0.0 { (largest.log2().floor() - 23.0).exp2() } else { 0.0 };
    i32f32.position_step_m = (-32.0_f64).exp2();
    for differences in [&mut f32, &mut i32f32] {
        differences.force_step_n = stiffness * differences.position_step_m;
    }
    Ok(Precision {
        scene: name.to_owned(),
        duration_s,
        largest_position_m: largest,
        explanation: explain(scene, &f32, &i32f32, faulted_after_s),
        f32,
        i32f32,
        faulted_after_s,
    })
}

impl Differences {
    fn see<S: Number>(&mut self, reference: &Pair<f64>, other: &Pair<S>) {
        for (exact, rounded) in reference.sides().into_iter().zip(other.sides()) {
            let (exact, rounded) = (exact.peer.observed(), rounded.peer.observed());
            let position = (exact.object.position - rounded.object.position.to_f64()).abs();
            let force = (exact.coordination_force - rounded.coordination_force.to_f64()).abs();
            self.position_m = self.position_m.max(position);
            self.force_n = self.force_n.max(force);
        }
    }

    /// Position difference in steps of the number type.
    fn steps(&self) -> f64 {
        if self.position_step_m > 0.0 { self.position_m / self.position_step_m } else { 0.0 }
    }
}

fn explain(scene: &Scene, f32: &Differences, i32f32: &Differences, faulted_after_s: Option<f64>) -> String {
    if let Some(time_s) = faulted_after_s {
        return format!("unstable: rounding grows with the oscillation until the peers fault at {time_s:.2} s");
    }
    if !scene.is_linear() {
        return format!(
            "contact that begins or ends a tick apart in two number types separates the runs: {:.0} steps in f32, {:.0} in I32F32",
            f32.steps(),
            i32f32.steps()
        );
    }
    format!(
        "a step of position is {:.1e} N of spring in f32, {:.1e} N in I32F32; the rest modes integrate it",
        f32.force_step_n, i32f32.force_step_n
    )
}

pub(crate) fn columns(rows: &[Precision]) -> Columns {
    let mut columns = Columns::of(rows)
        .value("scene", |row| row.scene.as_str())
        .value("duration_s", |row| row.duration_s)
        .data_only()
        .value("largest_position_m", |row| row.largest_position_m)
        .data_only();
    for (name, of) in [("f32", (|row| &row.f32) as fn(&Precision) -> &Differences), ("i32f32", |row| &row.i32f32)] {
        columns = columns
            .number(format!("{name}.position_m"), 3, |row| of(row).position_m)
            .shown_in("µm", 1e6)
            .number(format!("{name}.force_n"), 3, |row| of(row).force_n)
            .shown_in("mN", 1e3)
            .value(format!("{name}.position_step_m"), |row| of(row).position_step_m)
            .data_only()
            .value(format!("{name}.force_step_n"), |row| of(row).force_step_n)
            .data_only();
    }
    let columns = columns.value("faulted_after_s", |row| row.faulted_after_s).data_only();
    columns.value("explanation", |row| row.explanation.as_str()).head("why").done()
}
