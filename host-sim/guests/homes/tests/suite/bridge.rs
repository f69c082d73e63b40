//! What a bridge lets through between a board and a carrier: every kind and length, every sender, floods and silence.

use std::net::SocketAddr;
use std::time::{Duration, Instant};

use cohold_homes::bridge::Bridge;
use cohold_homes::place::{BURST, RATE};
use cohold_protocol::wire::{MAX_DATAGRAM, VERSION};

fn board() -> SocketAddr {
    "192.168.77.1:7701".parse().expect("an address")
}

fn sealed(length: usize) -> Vec<u8> {
    let mut datagram = vec![0x55; length];
    datagram[0] = VERSION;
    datagram
}

#[test]
fn only_the_board_itself_is_listened_to_and_written_to_once_it_has_spoken() {
    let now = Instant::now();
    let mut bridge = Bridge::new(board(), now);
    assert!(!bridge.hear_far(now, &sealed(88)), "nobody has asked");
    // A neighbour, the board's operator's port, and the same port of IPv6.
    for stranger in ["192.168.77.2:7701", "192.168.77.1:7702", "[::ffff:192.168.77.1]:7701", "[::1]:7701"] {
        assert!(!bridge.hear_board(now, stranger.parse().expect("an address"), &sealed(88)), "{stranger}");
        assert!(!bridge.hear_far(now, &sealed(88)) && bridge.look(now).is_none(), "{stranger} woke it");
    }
    assert_eq!((bridge.counts.strangers, bridge.counts.unasked, bridge.counts.from_board), (4, 5, 0));
    assert!(bridge.hear_board(now, board(), &sealed(88)) && bridge.hear_far(now, &sealed(88)));
    assert_eq!((bridge.counts.from_board, bridge.counts.to_board), (1, 1));
}

#[test]
fn only_the_sealed_wire_passes_and_nothing_longer_than_its_longest() {
    let start = Instant::now();
    let (mut bridge, mut far, mut refused) = (Bridge::new(board(), start), 0, [0; 2]);
    assert!(bridge.hear_board(start, board(), &sealed(88)));
    for (at, length) in [0, 1, 2, 28, 64, 88, 200, 201, 208, 1472, 2048].into_iter().enumerate() {
        for first in 0..=255_u8 {
            // Slowly enough that no rate counts.
            let now = start + Duration::from_millis(256 * at as u64 + u64::from(first));
            let mut datagram = vec![0x11; length];
            datagram.iter_mut().take(1).for_each(|byte| *byte = first);
            let is = length > 0 && first == VERSION;
            let passes = is && length <= MAX_DATAGRAM;
            assert_eq!(bridge.hear_board(now, board(), &datagram), passes, "{first} with {length} bytes");
            assert_eq!(bridge.hear_far(now, &datagram), passes, "{first} with {length} bytes");
            far += u64::from(passes);
            refused[usize::from(is)] += if passes { 0 } else { 2 };
        }
    }
    let counts = bridge.counts;
    assert_eq!((counts.from_board, counts.to_board), (far + 1, far));
    assert_eq!([counts.other_kinds, counts.too_long], refused);
    assert_eq!((MAX_DATAGRAM, far, counts.over_rate), (200, 6, 0));
}

#[test]
fn a_flood_either_way_is_bounded_and_a_packet_each_tick_is_none() {
    let start = Instant::now();
    let mut bridge = Bridge::new(board(), start);
    for ms in 0..10_000 {
        let now = start + Duration::from_millis(ms);
        assert!(bridge.hear_board(now, board(), &sealed(MAX_DATAGRAM)) && bridge.hear_far(now, &sealed(MAX_DATAGRAM)));
    }
    assert_eq!(bridge.counts.over_rate, 0);
    let mut bridge = Bridge::new(board(), start);
    let mut passed = [0; 2];
    for us in 0..100_000 {
        let now = start + Duration::from_micros(10 * us);
        passed[0] += u64::from(bridge.hear_board(now, board(), &sealed(88)));
        passed[1] += u64::from(bridge.hear_far(now, &sealed(88)));
    }
    let most = ((RATE + BURST) / 88.0) as u64 + 1;
    assert!(passed.iter().all(|passed| (most - 2..=most).contains(passed)), "{passed:?} of 100,000, {most}");
    assert_eq!(bridge.counts.over_rate, 200_000 - passed[0] - passed[1]);
}

#[test]
fn a_board_that_falls_silent_is_written_to_no_longer_and_found_again() {
    let start = Instant::now();
    let mut bridge = Bridge::new(board(), start);
    assert_eq!(bridge.look(start), None);
    assert!(bridge.hear_board(start, board(), &sealed(88)));
    assert_eq!((bridge.look(start), bridge.look(start)), (Some(true), None));
    let mut to_board = 0;
    for ms in 0..20_000 {
        let now = start + Duration::from_millis(ms);
        // What a stranger says keeps nobody.
        bridge.hear_board(now, "192.168.77.66:7701".parse().expect("an address"), &sealed(88));
        to_board += u64::from(bridge.hear_far(now, &sealed(88)));
    }
    let late = start + Duration::from_secs(20);
    assert_eq!((to_board, bridge.look(late)), (5000, Some(false)), "for five seconds");
    assert_eq!(bridge.counts.unasked, 15_000);
    assert!(bridge.hear_board(late, board(), &sealed(88)) && bridge.hear_far(late, &sealed(88)));
    assert_eq!((bridge.look(late), bridge.counts.arrivals), (Some(true), 2));
}
