//! A scene on two boards, from power-on to the figures of merit: what `cargo xtask board` runs and what tests compare.
//!
//! Figures are formed as cohold forms its own (means over the last half, decoded at peer 2), from what the boards reported
//! over telemetry, tick by tick; cohold's f32 run of the same scene stands beside them.

use std::sync::Arc;
use std::time::Instant;

use cohold_cli::Failure;
use cohold_sim::network::rule::{Direction, of_scene};
use cohold_sim::run::{Accounts, Options, Outcome, Ticked};
use cohold_sim::scene::Scene;
use firmware_parts::record::{ENGAGED, RECEIVED, Record, SENT};

use crate::bench::{Bench, for_boards};
use crate::cost;
use crate::image::Firmware;
use crate::node::Report;
use crate::twin::{self, Armed, Equal};
use crate::wire::Line;

/// What a scene on two boards gave.
#[derive(Debug)]
pub struct Trial {
    /// The scene as the boards ran it.
    pub scene: Scene,
    /// Figures of merit and curves of the boards.
    pub boards: Outcome,
    /// Figures of merit and curves of cohold, in f32.
    pub cohold: Outcome,
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
    /// Ticks of both boards whose bits equal cohold's; on a bad line, or where a line counts from arming on, of a cohold
    /// that is given the same arrivals, from arming on.
    pub equal: Equal,
    /// Comparison of each board's ticks with its recorded inputs from arming on, run again here.
    pub replayed: [Equal; 2],
    /// Instructions of an armed tick, over both boards.
    pub instructions: cost::MedianAndMost,
    /// Instructions of a run of the current loop, where there is one.
    pub loop_instructions: cost::MedianAndMost,
    /// Every armed tick of both boards.
    pub records: [Vec<Record>; 2],
    /// What the emulator could not do.
    pub reports: Vec<Report>,
    /// Wall-clock time of the trial, s.
    pub wall_s: f64,
}

/// The wire between the boards that gives the scene's network; or why there is none.
///
/// # Errors
/// One sentence: what to change.
pub fn line(scene: &Scene) -> Result<Line, Failure> {
    let network = &scene.world.network;
    if network.one_way_delay_packets == 0 {
        return Err("network.one_way_delay_packets must be at least 1: a wire cannot deliver within the tick".into());
    }
    if network.clock_drift_ppm != 0.0 || network.playout_packets != 0 {
        return Err("the boards' clocks do not drift and have no play-out buffer: leave network.clock_drift_ppm and \
                    network.playout_packets alone; `cohold cooperate` runs them"
            .into());
    }
    let timing = &scene.peer.timing;
    // It is heard a control period after it has arrived.
    Ok(Line {
        delay_ns: u64::from(network.one_way_delay_packets) * timing.packet_period_ns() - timing.control_period_ns(),
        ..Line::default()
    })
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
pub fn run(firmware: &Arc<Firmware>, scene: &Scene, seconds: f64) -> Result<Trial, Failure> {
    let scene = for_boards(scene);
    let line = line(&scene)?;
    let given = of_scene(&scene, Direction::OneToTwo, 0).is_some() || scene.law().own_time;
    let ticks = (seconds / scene.peer.timing.control_period_s).round() as u64;
    let options = Options::recorded(seconds, scene.peer.timing.control_period_s);
    let cohold = cohold_sim::run::run::<f32>(&scene, options, &|_| {})?;
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
    let due = (bench.now_ns() - counted_from) / scene.peer.timing.control_period_ns();
    let instructions = cost::MedianAndMost::of(bench.meters.iter().flat_map(|meter| meter.ticks.iter().copied()));
    let loop_instructions = cost::MedianAndMost::of(bench.loops.iter().flat_map(|meter| meter.ticks.iter().copied()));
    let late = bench.meters.iter().map(|meter| due.abs_diff(meter.ticks.len() as u64)).sum::<u64>();
    // What is still in the boards comes out.
    bench.run_for_ms(24);
    let after: u64 = (1..=2).map(|number| dropped(&mut bench, number)).sum();
    let whole = [1, 2].map(|number| {
        let Armed { records, standing } = bench.since_armed(number);
        (records.iter().copied().take(standing + ticks as usize).collect::<Vec<_>>(), standing)
    });
    let armed = [0, 1].map(|at| Armed { records: &whole[at].0, standing: whole[at].1 });
    let records = armed.map(|board| board.records[board.standing..].to_vec());
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
        boards: outcome(both, &scene, &cohold, options),
        ticks_missed: late + records.iter().map(|records| gaps(records)).sum::<u64>(),
        packets_sent: flagged(SENT),
        packets_received: flagged(RECEIVED),
        packets_dropped: after - before,
        wire_lost,
        equal: if given { twin::closed_loop_given(&scene, armed) } else { twin::closed_loop(&scene, both) },
        replayed: [0, 1].map(|index| twin::replay_alone(&settings[index], armed[index].records)),
        instructions,
        loop_instructions,
        records,
        reports,
        wall_s,
        cohold,
        scene,
    })
}

/// What cohold forms of a run of its own (host-sim/sim/src/run), of what the boards recorded.
fn outcome(both: [&[Record]; 2], scene: &Scene, like: &Outcome, options: Options) -> Outcome {
    let ticks = both.map(<[Record]>::len).into_iter().min().unwrap_or(0);
    let mut account = Accounts::<1>::new(scene, ticks as u64, options);
    for tick in 0..ticks {
        for (at, records) in both.iter().enumerate() {
            let record = &records[tick];
            let engaged = record.flags() & ENGAGED != 0;
            account.ticked(at, [Ticked::new(&record.observed(), record.energy_j(), record.mode(), engaged)]);
        }
        account.period();
    }
    // Impacts are not recorded; the boards' states are compared tick by tick: see twin.
    Outcome { impacts: like.impacts, hash: like.hash, ..account.outcome() }
}
