//! One board and cohold's live peer on one wire: the same bytes both ways, sealed, on a good wire and on a bad one.

use std::sync::Arc;

use board_bench::bench::Bench;
use board_bench::image::Firmware;
use board_bench::partner::Partner;
use board_bench::twin::{self, Equal};
use board_bench::wire::Line;
use cohold_core::safety::Mode;
use firmware_parts::record::ENGAGED;

use crate::breaks;

/// The last part of the run, ms: over it forces are averaged.
const LAST_MS: u32 = 500;

fn hold_one_object(set: &[&str]) {
    let firmware = Arc::new(Firmware::release());
    let scene = breaks::scene(set);
    let mut bench = Bench::start(&firmware, 1, Line::default());
    bench.set_up(&scene).expect("the board takes the scene");
    bench.wire.impair(&scene);
    bench.arm();
    assert!(bench.ask(1, "status").contains("link calling"));

    // It comes, calls, hears that the board is there, arms and engages.
    bench.partner = Some(Partner::new(&scene, 2).expect("cohold takes it too"));
    bench.run_for_ms(5000 - u64::from(LAST_MS));
    let mut host_n = 0.0;
    for _ in 0..LAST_MS {
        bench.run_for_ms(1);
        let node = &bench.partner.as_ref().expect("it is there").node;
        host_n += f64::from(node.observed().coordination_force) / f64::from(LAST_MS);
    }
    let status = bench.ask(1, "status");
    assert!(status.contains("ok board 1 armed") && status.contains("link running"), "{status}");
    let partner = bench.partner.take().expect("it is there");
    let (node, records) = (&partner.node, bench.armed_ticks(1));
    assert_eq!((node.peer.mode(), node.peer.is_engaged()), (Mode::Armed, true));

    let engaged = records.iter().position(|record| record.flags() & ENGAGED != 0).expect("the board engages");
    assert_eq!(records[..engaged].iter().map(|record| record.observed().coordination_force).fold(0.0, f32::max), 0.0);
    let counts = node.line.link.counts();
    let last = &records[records.len() - LAST_MS as usize..];
    let mean = last.iter().map(|record| f64::from(record.observed().coordination_force)).sum::<f64>();
    let board_n = mean / f64::from(LAST_MS);
    println!(
        "engaged after {engaged} ticks; mean coordination {board_n:.3} N on the board, {host_n:.3} N in cohold; {counts:?}"
    );
    // What one pulls the other is pulled by: the forces of a line that is at rest are equal and opposite; on a bad wire on average.
    assert!(board_n.abs() > 0.5 && (board_n + host_n).abs() < 0.05 * board_n.abs(), "{board_n} N and {host_n} N");

    // And every tick of the board is what the code here makes of the same arrivals.
    let from = &records[engaged..];
    assert!(from.iter().filter(|record| record.incoming().is_some()).count() > 200);
    let settings = &scene.peers()[0];
    assert_eq!(twin::replay_alone(settings, records), Equal { ticks: records.len() as u64, first_difference: None });
}

#[test]
fn on_a_good_wire() {
    hold_one_object(&[]);
}

#[test]
fn on_a_bad_wire() {
    hold_one_object(&["network.loss=0.2", "network.jitter=uniform", "network.jitter_s=0.008", "network.duplicate=0.1"]);
}
