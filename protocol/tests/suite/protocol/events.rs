//! Reliable events: once, in order, whatever the wire does; and the flow does not wait for them.

use cohold_protocol::link::{EVENTS, Full, Notice, Stage};
use cohold_protocol::wire::Event;

use crate::protocol::world::{Impairment, World};

fn event(code: u32) -> Event {
    Event::new(code as u16, &code.to_le_bytes()).unwrap()
}

fn codes(events: &[Event]) -> Vec<u32> {
    events.iter().map(|event| u32::from_le_bytes(event.payload().try_into().unwrap())).collect()
}

/// Both peers send `count` events as fast as the window lets them; how long that takes, µs.
fn exchange(world: &mut World, count: u32, limit: u64) -> u64 {
    let start = world.now;
    let mut sent = [0, 0];
    while world.events.iter().any(|events| events.len() < count as usize) {
        for (peer, sent) in sent.iter_mut().enumerate() {
            while *sent < count && world.links[peer].push_event(event(*sent)).is_ok() {
                *sent += 1;
            }
        }
        world.step();
        assert!(world.now - start < limit, "{:?}", world.events.each_ref().map(Vec::len));
    }
    for events in &world.events {
        assert_eq!(codes(events), (0..count).collect::<Vec<_>>());
    }
    world.now - start
}

#[test]
fn once_and_in_order_over_any_wire() {
    for (seed, loss, duplicate, jitter) in
        [(1, 0.0, 0.0, 0), (2, 0.2, 0.2, 12_000), (3, 0.5, 0.2, 40_000), (4, 0.0, 1.0, 100_000)]
    {
        let mut world = World::new(seed, Impairment { loss, duplicate, delay: 1_000, jitter });
        exchange(&mut world, 300, 300_000_000);
    }
}

#[test]
fn once_and_in_order_across_sessions_that_end() {
    let mut world = World::engaged(5);
    let mut sent = 0;
    for _ in 0..60 {
        world.cut = [world.rng.chance(0.5), world.rng.chance(0.5)];
        for _ in 0..world.rng.below(300) {
            if world.links[0].push_event(event(sent)).is_ok() {
                sent += 1;
            }
            world.step();
        }
    }
    world.cut = [false; 2];
    world.run(3_000_000);
    assert!(world.notices[0].iter().filter(|notice| **notice == Notice::Lost).count() > 5);
    assert!(sent > 100);
    assert_eq!(codes(&world.events[1]), (0..sent).collect::<Vec<_>>());
    assert_eq!(world.links[0].events_under_way(), 0);
}

#[test]
fn what_was_meant_for_a_peer_that_is_gone_is_dropped_and_told() {
    let mut world = World::engaged(6);
    world.off[1] = true;
    for code in 0..5 {
        world.links[0].push_event(event(code)).unwrap();
    }
    world.run(200_000);
    assert_eq!(world.links[0].stage(), Stage::Calling);
    world.restart(1);
    world.off[1] = false;
    assert!(world.run_until(500_000, World::is_engaged).is_some());
    assert!(world.notices[0].contains(&Notice::NewPeer(5)), "{:?}", world.notices[0]);
    assert!(world.events[1].is_empty());
    // Numbers begin again, at both ends.
    exchange(&mut world, 50, 5_000_000);
}

#[test]
fn events_wait_for_the_first_peer() {
    let mut world = World::new(7, crate::protocol::world::CLEAN);
    world.off[1] = true;
    world.links[0].push_event(event(0)).unwrap();
    world.run(1_000_000);
    world.off[1] = false;
    world.run(100_000);
    assert_eq!(codes(&world.events[1]), [0]);
}

#[test]
fn the_window_is_full_and_says_so() {
    let mut world = World::engaged(8);
    world.cut[1] = true;
    for code in 0..EVENTS as u32 {
        assert_eq!(world.links[0].push_event(event(code)), Ok(code));
    }
    assert_eq!(world.links[0].push_event(event(8)), Err(Full));
    assert_eq!(world.links[0].events_under_way(), EVENTS);
    world.cut[1] = false;
    world.run(1_000_000);
    assert_eq!(world.links[0].push_event(event(8)), Ok(8));
}

#[test]
fn the_flow_does_not_wait_for_events() {
    let mut busy = World::engaged(9);
    let mut idle = World::engaged(9);
    for world in [&mut busy, &mut idle] {
        world.flows = [vec![], vec![]];
    }
    for code in 0.. {
        if busy.now >= 3_000_000 {
            break;
        }
        let _ = busy.links[0].push_event(event(code));
        busy.step();
    }
    idle.run(busy.now - idle.now);
    assert_eq!(busy.flows[1], idle.flows[1]);
}
