//! A scene on two boards, from power-on to the figures of merit: what `cargo xtask board` runs and what tests compare.
//!
//! Figures are formed as host-sim forms its own (means over the last half, decoded at peer 2), from what the boards told
//! over telemetry, tick by tick; host-sim's f32 run of the same scene stands beside them.

use std::sync::Arc;
use std::time::Instant;

use firmware_parts::record::{RECEIVED, Record, SENT};
use haptic_core::peer::Observed;
use haptic_core::safety::Mode;
use haptic_sim::measure::{LastHalf, Statistics};
use haptic_sim::network::rule::{Direction, of_scene};
use haptic_sim::report::Columns;
use haptic_sim::run::{Options, Outcome, PortEnergy};
use haptic_sim::scene::Scene;

use crate::bench::{Bench, PERIOD_NS, for_boards};
use crate::cost;
use crate::image::Firmware;
use crate::node::Report;
use crate::twin::{self, Equal};
use crate::wire::Line;

/// What a scene on two boards gave.
#[derive(Debug)]
pub struct Trial {
    /// The scene as the boards ran it.
    pub scene: Scene,
    /// Figures of merit and curves of the boards.
    pub boards: Outcome,
    /// The same of host-sim, in f32.
    pub host_sim: Outcome,
    /// Ticks that were due and did not come, came late, or are missing from telemetry; both boards.
    pub ticks_missed: u64,
    /// Packets that the ticks made since arming; both boards.
    pub packets_sent: u64,
    /// Packets that the ticks got since arming; both boards.
    pub packets_received: u64,
    /// Packets that the boards' network tasks dropped or refused since arming.
    pub packets_dropped: u64,
    /// Frames that the wire lost.
    pub wire_lost: u64,
    /// Ticks of both boards whose bits equal host-sim's; on a bad line, of a host-sim that is given the same arrivals.
    pub equal: Equal,
    /// The same of each board's recorded inputs, run again here.
    pub replayed: [Equal; 2],
    /// Instructions of an armed tick, over both boards.
    pub instructions: cost::MedianAndMost,
    /// Every armed tick of both boards.
    pub records: [Vec<Record>; 2],
    /// What the emulator could not do.
    pub reports: Vec<Report>,
    /// Wall-clock time, s.
    pub wall_s: f64,
}

/// The wire between the boards that gives the scene's network; or why there is none.
///
/// # Errors
/// One sentence: what to change.
pub fn line(scene: &Scene) -> Result<Line, String> {
    let network = &scene.world.network;
    if network.one_way_delay_packets == 0 {
        return Err(
            "network.one_way_delay_packets must be at least 1: a wire cannot deliver within the tick".to_owned()
        );
    }
    if network.clock_drift_ppm != 0.0 || network.playout_packets != 0 {
        return Err("the boards' clocks do not drift and have no play-out buffer: leave network.clock_drift_ppm and \
                    network.playout_packets alone; `host-sim cooperate` runs them"
            .to_owned());
    }
    let packet_ns = u64::from(scene.peer.timing.ticks_per_packet) * PERIOD_NS;
    // It arrives in the middle of the packet period before the one that takes it.
    Ok(Line { delay_ns: u64::from(network.one_way_delay_packets) * packet_ns - packet_ns / 2, ..Line::default() })
}

/// Dropped and refused packets, by a board's own account.
fn dropped(bench: &mut Bench, number: usize) -> u64 {
    let answer = bench.ask(number, "status");
    let words: Vec<&str> = answer.split([' ', ';']).collect();
    let after = |name: &str| {
        let at = words.iter().position(|word| *word == name).expect("a status has its counters");
        words[at + 1].parse::<u64>().expect("a counter is a number")
    };
    after("dropped") + after("refused") + after("overruns")
}

/// Runs a scene for `seconds` of virtual time.
///
/// # Errors
/// The wire cannot do what the scene asks for, or the boards cannot run it.
pub fn run(firmware: &Arc<Firmware>, scene: &Scene, seconds: f64) -> Result<Trial, String> {
    let scene = for_boards(scene);
    let line = line(&scene)?;
    let impaired = of_scene(&scene, Direction::OneToTwo, 0).is_some();
    let ticks = (seconds / scene.peer.timing.control_period_s).round() as u64;
    let host_sim = haptic_sim::run::run::<f32>(&scene, Options::recorded(seconds, 1e-3), &|_| {})
        .map_err(|refused| refused.to_string())?;
    let wall = Instant::now();
    let mut bench = Bench::start(firmware, 2, line);
    bench.set_up(&scene)?;
    bench.wire.impair(&scene);
    bench.arm();
    // After arming: the checks before it begin new sessions, and what was under way in the old ones is refused.
    let before: u64 = (1..=2).map(|number| dropped(&mut bench, number)).sum();
    bench.run_for_ms(1);
    bench.count_instructions();
    let counted_from = bench.now_ns();
    while bench.ticks < ticks + 1 {
        bench.step();
    }
    let due = (bench.now_ns() - counted_from) / PERIOD_NS;
    let instructions = cost::MedianAndMost::of(bench.meters.iter().flat_map(|meter| meter.ticks.iter().copied()));
    let late = bench.meters.iter().map(|meter| due.abs_diff(meter.ticks.len() as u64)).sum::<u64>();
    // What is still in the boards comes out.
    bench.run_for_ms(24);
    let after: u64 = (1..=2).map(|number| dropped(&mut bench, number)).sum();
    let records =
        [1, 2].map(|number| bench.armed_ticks(number).iter().copied().take(ticks as usize).collect::<Vec<_>>());
    let wire_lost = bench.wire.lost;
    let reports = bench.finish();
    let wall_s = wall.elapsed().as_secs_f64();
    let gaps = |records: &[Record]| {
        let jumps = records.windows(2).map(|pair| u64::from(pair[1].tick().wrapping_sub(pair[0].tick())) - 1);
        jumps.sum::<u64>() + (ticks - records.len() as u64)
    };
    let flagged = |flag: u8| records.iter().flatten().filter(|record| record.flags() & flag != 0).count() as u64;
    let both = [&*records[0], &*records[1]];
    let settings = scene.peers();
    Ok(Trial {
        boards: outcome(both, &host_sim),
        ticks_missed: late + records.iter().map(|records| gaps(records)).sum::<u64>(),
        packets_sent: flagged(SENT),
        packets_received: flagged(RECEIVED),
        packets_dropped: after - before,
        wire_lost,
        equal: if impaired { twin::closed_loop_given(&scene, both) } else { twin::closed_loop(&scene, both) },
        replayed: [0, 1].map(|index| twin::replay(&settings[index], both[index])),
        instructions,
        records,
        reports,
        wall_s,
        host_sim,
        scene,
    })
}

/// The columns that host-sim records for a peer, in its order.
fn columns(record: &Record) -> [f64; 8] {
    let [received, sent] = record.energy_j();
    let Observed { device, object, desired, contact_force, coordination_force } = record.observed();
    let [x, o, d] = [device, object, desired].map(|motion| motion.position);
    [x, o, d, object.velocity, contact_force, coordination_force, received, sent].map(f64::from)
}

/// Figures of merit as host-sim forms them (host-sim/sim/src/run.rs), from what the boards recorded. Names of the
/// columns are those of `like`.
fn outcome([first, second]: [&[Record]; 2], like: &Outcome) -> Outcome {
    let ticks = first.len().min(second.len());
    let pairs = || first.iter().zip(second);
    let discrepancies = |one: &Record, two: &Record| {
        let [seen_1, seen_2] = [one.observed(), two.observed()];
        let [x1, x2] = [seen_1, seen_2].map(|seen| f64::from(seen.object.position));
        [(x1 - x2).abs(), (x2 - f64::from(seen_2.desired.position)).abs()]
    };
    let forces = |record: &Record| {
        let Observed { contact_force, coordination_force, .. } = record.observed();
        [contact_force, coordination_force].map(f64::from)
    };
    let mut halves = LastHalf::new(ticks as u64);
    for (tick, (one, two)) in (0..).zip(pairs()) {
        let ([true_m, decoded_m], [[contact_1, _], [contact_2, force]]) =
            (discrepancies(one, two), [one, two].map(forces));
        halves.see(tick, [true_m, decoded_m, force, force * force, 0.5 * (contact_1.abs() + contact_2.abs())]);
    }
    let [true_m, decoded_m, force, force_squared, contact_force_n] = halves.means();
    let fault = pairs().enumerate().find_map(|(tick, (one, two))| {
        (1..).zip([one, two]).find_map(|(peer, record)| match record.mode() {
            Mode::Faulted(fault) => Some((tick, peer, fault)),
            _ => None,
        })
    });
    let every = (ticks / like.table.len().max(1)).max(1);
    let mut table = Columns::named(like.table.data().map(|column| column.name()));
    for (tick, (one, two)) in pairs().enumerate().step_by(every) {
        let peers = [one, two].into_iter().flat_map(columns);
        let row: Vec<f64> = std::iter::once(tick as f64 * 1e-3).chain(peers).chain(discrepancies(one, two)).collect();
        table.push_row(&row);
    }
    Outcome {
        bounded: fault.is_none(),
        fault: fault.map(|(_, peer, fault)| (peer, fault)),
        fault_time_s: fault.map(|(tick, ..)| tick as f64 * 1e-3),
        true_discrepancy_mm: 1e3 * true_m,
        decoded_discrepancy_mm: 1e3 * decoded_m,
        coordination_force_n: Statistics::of_moments(force, force_squared),
        contact_force_n,
        peak_coordination_force_n: pairs()
            .flat_map(|(one, two)| [forces(one)[1], forces(two)[1]])
            .fold(0.0, |peak, force| force.abs().max(peak)),
        energy: [first, second].map(|records| {
            let [received, sent] = records.last().map_or([0.0; 2], Record::energy_j);
            PortEnergy { received_j: received.into(), sent_j: sent.into() }
        }),
        ticks: ticks as u64,
        table,
        // What is not formed here is not shown either; the boards' states are compared tick by tick: see twin.
        ..like.clone()
    }
}
