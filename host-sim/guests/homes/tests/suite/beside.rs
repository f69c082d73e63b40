//! A board behind the PC beside it, in virtual time: with a plain peer at the other end, and with another board behind a PC of its own.

use cohold_homes::Way;
use cohold_homes::bridge::Counts;

use super::homes_world::{World, beside};
use super::two_homes::change_paths;

#[test]
fn a_board_behind_a_pc_keeps_its_line_while_the_path_is_found_dies_and_comes_back() {
    for boards in [[true, false], [false, true], [true, true]] {
        // A millisecond more between each board and its PC, each way.
        let world = change_paths(boards, 0.1);
        for (side, bridge) in world.bridges.iter().enumerate() {
            let Some(Counts { from_board, to_board, arrivals, .. }) = bridge.as_ref().map(|bridge| bridge.counts)
            else {
                continue;
            };
            // All that was for either, and nothing else.
            let counts = Counts { from_board, to_board, arrivals: 1, ..Counts::default() };
            assert_eq!(bridge.as_ref().map(|bridge| bridge.counts), Some(counts), "{arrivals} arrivals");
            let taken = world.nodes[side].line.link.counts();
            assert!(from_board > 31_000 && to_board >= u64::from(taken.taken), "{counts:?}, {taken:?}");
            assert!(taken.missing <= 60, "{taken:?}");
        }
    }
}

/// A second board, or whoever else is on that network, sends what the board sends, before it and after it.
#[test]
fn a_stranger_beside_the_board_moves_nothing() {
    let mut world = World::new([true, false]);
    let [_, pc] = beside(0);
    world.run(8000);
    let before = world.nodes[1].line.link.counts();
    for _ in 0..1000 {
        for host in ["192.168.70.66:7701", "192.168.70.1:9999"] {
            world.post(host.parse().expect("an address"), pc, &[3; 88]);
        }
        world.run(1);
    }
    let after = world.nodes[1].line.link.counts();
    assert!(after.taken >= before.taken + 1000, "a packet each tick, as before");
    assert_eq!((after.missing, after.refused), (before.missing, before.refused));
    let counts = world.bridges[0].as_ref().map(|bridge| bridge.counts).expect("a bridge");
    assert_eq!((counts.strangers, counts.arrivals, counts.unasked), (2000, 1, 0));
    assert!(world.are_together() && !world.have_parted());
}

#[test]
fn a_board_that_starts_anew_is_met_again_as_a_peer_is() {
    let [jumps_n, jumped_n] = [false, true].map(|board| {
        let mut world = World::new([board, false]);
        world.run(8000);
        world.restart(0);
        let [jump_n, ..] = world.run(8000);
        assert!(world.are_together() && world.have_parted(), "let go of, and met again");
        assert_eq!(world.ways(), [Way::Direct; 2], "no path has changed");
        jump_n
    });
    eprintln!(
        "largest change of F_T in a tick when peer 1 starts anew: {jumps_n:.4} N, behind a bridge {jumped_n:.4} N"
    );
    assert!(jumped_n <= jumps_n + 0.05, "{jumped_n} N instead of {jumps_n}");
}

/// What either end does then is what it does at any silence: it is compared with a peer whose own carrier is gone for as long. Of three phases
/// of the led hand the worst counts: a contact that opens or closes just within or just after the silence is no difference.
#[test]
fn a_pc_that_is_killed_is_a_silence_and_its_next_run_goes_on() {
    for gone_ms in [40, 500, 2500, 12_000] {
        let [silence, bridged] = [false, true].map(|board| {
            let worst = [8000, 8250, 9000].map(|from_ms| {
                let mut world = World::new([board, false]);
                world.run(from_ms);
                world.kill(0);
                let [gone_n, ..] = world.run(gone_ms);
                world.begin(0, board, 77);
                let [back_n, ..] = world.run(12_000);
                assert_eq!(world.ways(), [Way::Direct; 2], "the path is found again");
                // Short of safety.disengage_s nothing is let go of; beyond safety.peer_lost_s motors stay off.
                let met = (world.are_together(), world.have_parted());
                assert_eq!(met, (gone_ms < 10_000, gone_ms > 6000), "{gone_ms} ms, behind a bridge {board}");
                [gone_n, back_n]
            });
            let [gone_n, back_n] = worst.into_iter().reduce(|[a, b], [c, d]| [a.max(c), b.max(d)]).expect("three");
            eprintln!("gone for {gone_ms} ms, behind a bridge {board}: {gone_n:.3} N a tick, and back {back_n:.3} N");
            [gone_n, back_n]
        });
        for (silent_n, bridged_n) in silence.into_iter().zip(bridged) {
            assert!(bridged_n <= 1.2 * silent_n + 0.05, "{gone_ms} ms: {bridged_n} N instead of {silent_n}");
        }
    }
}
