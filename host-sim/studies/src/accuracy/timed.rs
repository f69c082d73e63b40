//! Error and time: every scheme of `whole_peer` with what a millisecond of control of one peer takes on this machine.
//!
//! Time is the least of `REPLAYS` replays of the recording whose instructions are counted (`cohold_cases`): what interrupts a machine makes a
//! replay longer and never shorter. In f32, an eighth of an exchange in each tick; of a program as it was built, so ask a release build.
//! Unit: m, N, ns, instructions.

use std::time::Instant;

use cohold_cases::scenes::SCENES;
use cohold_cases::ticks::{Recording, TICKS, measured_tick};
use cohold_core::law::AnyLaw;
use cohold_core::settings::{Refused, Settings};
use cohold_report::Columns;

use super::counts::Processor;
use super::whole_peer::{self, Measured};

/// Lines of a page between which the table stands.
pub const LINES: [&str; 2] = ["<!-- times begin -->", "<!-- times end -->"];
/// Replays of 800 ticks each: some 20 ms.
const REPLAYS: u32 = 300;

/// A scheme at a control rate, its errors and its price.
#[derive(Clone, Debug)]
pub struct Timed {
    /// What is chosen.
    pub choice: String,
    /// Control rate, ticks each millisecond.
    pub ticks_per_ms: u32,
    /// RMS error of the copies' positions, m.
    pub position_m: f64,
    /// RMS error of the coordination force, N.
    pub force_n: f64,
    /// Of one peer for a millisecond of control, ns.
    pub ns: f64,
    /// The same in instructions of a Cortex-M7; none where nobody has counted them.
    pub instructions: Option<u64>,
}

/// Time of a tick of a peer in f32, ns.
fn tick_ns(settings: &Settings) -> f64 {
    let recording = Recording::<f32, AnyLaw<f32>>::new(settings);
    let replay = |_| {
        let start = Instant::now();
        recording.replay(measured_tick);
        start.elapsed().as_secs_f64()
    };
    1e9 * (0..REPLAYS).map(replay).fold(f64::INFINITY, f64::min) / TICKS as f64
}

/// Every scheme at every rate.
///
/// # Errors
/// The first key that is out of range or impossible beside the others.
pub fn study() -> Result<Vec<Timed>, Refused<'static>> {
    // One after the other, and nothing beside them.
    let (mut known, mut rows) = (None, Vec::new());
    for Measured { scheme, ticks_per_ms, deviation } in whole_peer::deviations()? {
        let case = scheme.case();
        let Some(scene) = SCENES.iter().find(|scene| scene.name == case) else { continue };
        let (_, tick_ns) =
            known.take().filter(|(of, _)| *of == scheme).unwrap_or_else(|| (scheme, tick_ns(&scene.settings())));
        known = Some((scheme, tick_ns));
        let count = Processor::CortexM7.count(&format!("tick/{case}"), "f32");
        rows.push(Timed {
            choice: scheme.name(),
            ticks_per_ms,
            position_m: deviation.position_rms_m,
            force_n: deviation.force_rms_n,
            ns: f64::from(ticks_per_ms) * tick_ns,
            instructions: count.map(|count| count * u64::from(ticks_per_ms)),
        });
    }
    Ok(rows)
}

/// The table.
pub fn columns(rows: &[Timed]) -> Columns {
    Columns::of(rows)
        .value("choice", |row| row.choice.as_str())
        .means("integrator and decode of the passive wave, or the self-timed line with its integrator")
        .value("rate_khz", |row| row.ticks_per_ms)
        .means("control rate")
        .head("rate")
        .significant("force_n", 2, |row| row.force_n)
        .means("RMS error of F_T")
        .head("error of F_T")
        .shown_in("mN", 1e3)
        .significant("position_m", 2, |row| row.position_m)
        .means("RMS error of x_o")
        .head("of x_o")
        .shown_in("µm", 1e6)
        .number("time_s", 0, |row| 1e-9 * row.ns)
        .means("time of a millisecond of control of one peer on this machine, in f32")
        .head("time a ms")
        .shown_in("ns", 1e9)
        .value("instructions", |row| row.instructions)
        .means("instructions of a millisecond of control of one peer on a Cortex-M7, in f32; nothing where nobody has counted")
        .head("M7 instructions a ms")
        .done()
}
