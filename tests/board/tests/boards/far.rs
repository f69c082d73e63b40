//! One board and cohold's live peer far away: the PC beside the board carries its datagrams, unopened, to a meeting. The image is the one that knows of none.

use std::sync::Arc;

use board_bench::bench::{Bench, for_boards};
use board_bench::far::Far;
use board_bench::image::Firmware;
use board_bench::partner::Partner;
use board_bench::pc::{board_ip, board_mac, udp};
use board_bench::twin::{self, Equal};
use board_bench::wire::{Line, PC};
use cohold_core::safety::Mode;
use cohold_homes::Way;
use cohold_homes::bridge::Counts;
use firmware_parts::record::ENGAGED;

use crate::bad_wire::PUSHES;
use crate::breaks;

fn far(bench: &mut Bench) -> &mut Far {
    bench.partner.as_mut().and_then(|partner| partner.far.as_mut()).expect("it is far away")
}

#[test]
fn a_board_holds_one_object_with_a_peer_far_away_by_the_pc_beside_it() {
    let scene = for_boards(&breaks::built_in("any-network", &PUSHES));
    let line = Line { delay_ns: 0, silent: false };
    let mut bench = breaks::just_armed(&Arc::new(Firmware::release()), 1, line, &scene);
    assert!(bench.ask(1, "status").contains("link calling"));

    // It is relayed, then direct; that path is cut, and found again.
    bench.partner = Some(Partner::new(&scene, 2).expect("cohold takes it too").far());
    bench.run_for_ms(5000);
    assert_eq!(far(&mut bench).ways(), [Way::Direct; 2]);
    far(&mut bench).cut = true;
    // Somebody beside the board, who writes from its port, and from its address.
    for _ in 0..50 {
        for (ip, port) in [([192, 168, 77, 66], 7701), (board_ip(1), 9999)] {
            let frame = udp(([2, 0, 0, 0, 0, 0x66], ip, port), (board_mac(2), board_ip(2), 7701), &[3; 88]);
            bench.wire.send(PC, bench.now_ns(), &frame);
        }
        bench.run_for_ms(20);
    }
    bench.run_for_ms(1000);
    assert_eq!(far(&mut bench).ways(), [Way::Relayed; 2]);
    far(&mut bench).cut = false;
    bench.run_for_ms(6000);
    assert!(far(&mut bench).ways().iter().all(|way| matches!(way, Way::Both | Way::Direct)));

    let status = bench.ask(1, "status");
    assert!(status.contains("ok board 1 armed") && status.contains("link running"), "{status}");
    let partner = bench.partner.take().expect("it is there");
    assert_eq!((partner.node.peer.mode(), partner.node.peer.is_engaged()), (Mode::Armed, true));
    let records = bench.armed_ticks(1);
    let engaged = records.iter().position(|record| record.flags() & ENGAGED != 0).expect("the board engages");
    let together = &records[engaged..];
    assert!(together.iter().all(|record| record.flags() & ENGAGED != 0), "it lets go of nothing");
    // The board's hand was alone and came at 1 m/s: that it is held is no change of path.
    let forces = together.iter().skip(1000).map(|record| record.observed().coordination_force);
    let steps = forces.clone().zip(forces.skip(1)).map(|(before, after)| (after - before).abs());
    let largest_n = steps.fold(0.0, f32::max);
    let Counts { from_board, to_board, unasked, .. } =
        partner.far.as_ref().map(|far| far.bridge.counts).expect("it is far away");
    println!(
        "engaged after {engaged} ticks, {} together; largest change of coordination in a tick {largest_n:.3} N; {from_board} datagrams from the board and {to_board} to it; {:?}",
        together.len(),
        partner.node.line.link.counts()
    );
    assert!(together.len() > 12_000 && largest_n < 0.1, "{} ticks, {largest_n} N", together.len());
    assert!(from_board > 12_000 && to_board > 12_000, "{from_board} {to_board}");
    // What the partner says before the board has called is not for it.
    assert!(unasked < 1000, "{unasked}");
    let counts = Counts { from_board, to_board, strangers: 100, unasked, ..Counts::default() };
    assert_eq!(partner.far.map(|far| far.bridge.counts), Some(counts));

    // And every tick of the board is what the code here makes of the same arrivals.
    let settings = &scene.peers()[0];
    assert_eq!(twin::replay_alone(settings, records), Equal { ticks: records.len() as u64, first_difference: None });
}
