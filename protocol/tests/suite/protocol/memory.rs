//! Bounded memory: a link is one value of fixed size, and what it keeps beyond keys is a few bounded lists.

use cohold_protocol::link::{Link, Notice};
use cohold_protocol::wire::{Event, MAX_DATAGRAM};

use crate::protocol::world::{CLEAN, World};

#[test]
fn a_link_fits_on_a_microcontroller() {
    println!("Link {} B; datagram {MAX_DATAGRAM} B", size_of::<Link>());
    assert!(size_of::<Link>() <= 4096);
    // `Link: 'static` without a lifetime or a pointer to anything: it is all there is.
    fn owns_everything<T: Send + 'static>() {}
    owns_everything::<Link>();
}

#[test]
fn nothing_piles_up_in_a_link_that_nobody_asks() {
    // A caller that never takes events or notices: the newest notices stay, the other peer's events wait at the sender.
    let mut world = World::new(1, CLEAN);
    let mut out = [0; MAX_DATAGRAM];
    for round in 0..2_000u32 {
        let now = u64::from(round) * 4_000;
        let _ = world.links[0].push_event(Event::new(1, &round.to_le_bytes()).unwrap());
        for from in [0, 1] {
            // Long silences now and then: sessions end and begin.
            if round % 200 < 150 {
                while let Some(len) = world.links[from].poll(now, &mut out) {
                    let _ = world.links[1 - from].receive(now, &mut out[..len].to_vec());
                }
            } else {
                while world.links[from].poll(now, &mut out).is_some() {}
            }
        }
    }
    assert_eq!(world.links[0].events_under_way(), 8);
    let mut events = 0;
    while world.links[1].take_event().is_some() {
        events += 1;
    }
    assert_eq!(events, 8);
    let notices = std::iter::from_fn(|| world.links[1].take_notice()).collect::<Vec<_>>();
    assert_eq!(notices.len(), 16);
    assert_eq!(notices.last(), Some(&Notice::Lost));
}
