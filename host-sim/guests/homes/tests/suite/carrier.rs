//! The flow changes its path within one session, and loses nothing by it.

use std::net::SocketAddr;

use cohold_homes::Way;
use cohold_homes::place::Place;
use cohold_protocol::key::Key;

use super::world::{Router, World};

/// When flow first went one of these ways, ms.
fn first(world: &World, side: usize, ways: &[Way]) -> Option<u64> {
    world.homes[side].ways.iter().find(|(_, way)| ways.contains(way)).map(|(ms, _)| *ms)
}

fn none_twice(world: &World) {
    for home in &world.homes {
        assert!(home.came.values().all(|times| *times == 1), "what came twice is a copy, and goes no further");
    }
}

#[test]
fn the_relay_carries_at_once_and_the_direct_path_takes_over() {
    let mut world = World::new([Router::Kept, Router::Kept]);
    world.run(10_000);
    for side in 0..2 {
        let relayed = first(&world, side, &[Way::Relayed]).expect("a relay");
        let direct = first(&world, side, &[Way::Both, Way::Direct]).expect("a direct path");
        assert!(relayed < 100 && direct < 500, "relayed after {relayed} ms, direct after {direct} ms");
        assert_eq!(world.lost(side), 0);
        let report = world.homes[side].carrier.report();
        assert!(report.way == Way::Direct && !report.lan && report.copies > 500, "{report:?}");
        // 16 ms there and back; 32 by the relay, whose two ways are as long each; a step more at each end.
        assert!((16.0..=18.5).contains(&report.direct.round_trip_ms), "{report:?}");
        assert!((32.0..=36.5).contains(&report.relayed.round_trip_ms), "{report:?}");
        assert!(report.direct.lost == 0.0 && report.relayed.lost == 0.0, "{report:?}");
        // Until an end has an answer to its own check it takes nothing directly, though the other end may send already: all of it comes by the relay, too.
        assert!(report.strangers < 200, "{report:?}");
    }
    none_twice(&world);
    let relayed = world.place.as_ref().expect("it is there").counts.passed;
    world.run(12_000);
    let after = world.place.as_ref().expect("it is there").counts.passed - relayed;
    assert!(after <= 22, "the relay rests, but for 10 signals a second: {after}");
}

#[test]
fn where_no_hole_can_be_made_the_relay_goes_on() {
    for routers in [[Router::Symmetric; 2], [Router::Kept, Router::Symmetric], [Router::Symmetric, Router::Kept]] {
        let mut world = World::new(routers);
        world.run(20_000);
        for side in 0..2 {
            assert_eq!(world.lost(side), 0, "{routers:?}");
            assert_eq!(world.homes[side].ways.len(), 1, "{:?}", world.homes[side].ways);
        }
        assert_eq!(world.ways(), [Way::Relayed; 2], "{routers:?}");
        none_twice(&world);
    }
}

/// Relayed within 5 s and direct within 3 s, where it is, and 10 s of a datagram each ms without a loss.
fn meets(world: &mut World, direct: bool, name: &str) {
    world.run(10_000);
    for side in 0..2 {
        let relayed = first(world, side, &[Way::Relayed, Way::Both]).expect("a relay");
        let found = first(world, side, &[Way::Both, Way::Direct]);
        assert!(relayed < 5000 && found.is_none_or(|ms| ms < 3000), "{name}: {:?}", world.homes[side].ways);
        assert_eq!((found.is_some(), world.lost(side)), (direct, 0), "{name}: {:?}", world.homes[side].ways);
    }
    assert_eq!(world.ways(), [if direct { Way::Direct } else { Way::Relayed }; 2], "{name}");
    none_twice(world);
}

#[test]
fn a_port_that_is_passed_on_lets_flow_in_past_routers_that_give_each_partner_another() {
    let mut world = World::new([Router::Symmetric; 2]);
    world.run(1000);
    world.homes[0].passes = Some(40_000);
    let mapped = SocketAddr::new(world.homes[0].outer, 40_000);
    world.homes[0].carrier.add_mapped(mapped);
    meets(&mut world, true, "mapped");
    assert_eq!(world.homes[0].carrier.report().mapped, Some(mapped));
}

#[test]
fn behind_one_router_flow_turns_there_if_it_lets_it_and_is_relayed_if_not() {
    for hairpin in [true, false] {
        let mut world = World::with([Router::Kept; 2], false, [false; 2], Some(hairpin));
        meets(&mut world, hairpin, "hairpin");
    }
}

#[test]
fn a_router_that_takes_a_strangers_datagram_for_a_flow_of_its_own_leaves_it_to_the_relay_or_not_and_says_which() {
    for routers in [[Router::Open; 2], [Router::Open, Router::Kept], [Router::Kept, Router::Open]] {
        let mut world = World::new(routers);
        world.run(20_000);
        for (side, home) in world.homes.iter().enumerate() {
            let report = home.carrier.report();
            let said = first(&world, side, &[Way::Both, Way::Direct]).is_some();
            assert_eq!(report.direct.datagrams > 0, said, "{routers:?}: what is said is what was: {report:?}");
            assert_eq!(world.lost(side), 0, "{routers:?}");
        }
        let [one, two] = world.ways();
        assert!(one == two && matches!(one, Way::Direct | Way::Relayed), "{routers:?}: {one:?} {two:?}");
        none_twice(&world);
    }
}

#[test]
fn ipv6_leads_past_any_router_at_both_ends_and_helps_and_harms_nobody_at_one() {
    let mut world = World::with([Router::Symmetric; 2], false, [true; 2], None);
    meets(&mut world, true, "IPv6 at both ends");
    for v6 in [[true, false], [false, true]] {
        meets(&mut World::with([Router::Kept; 2], false, v6, None), true, "IPv6 at one end");
        meets(&mut World::with([Router::Symmetric; 2], false, v6, None), false, "IPv6 at one end, random ports");
    }
}

#[test]
fn a_direct_path_that_is_cut_is_missed_after_15_ms_and_found_again() {
    let mut world = World::new([Router::Kept, Router::Kept]);
    world.run(5000);
    assert_eq!(world.ways(), [Way::Direct; 2]);
    world.cut = true;
    world.run(11_000);
    assert_eq!(world.ways(), [Way::Relayed; 2]);
    world.cut = false;
    world.run(30_000);
    assert_eq!(world.ways(), [Way::Direct; 2]);
    for side in 0..2 {
        // 15 ms of silence are heard, and said by the relay: 16 ms until the other end knows. What was under way then, 8 ms, is gone as well.
        let lost = world.lost(side);
        assert!((15..=60).contains(&lost), "{lost} of one cut");
        let back = world.homes[side].ways.iter().find(|(ms, way)| *ms > 11_000 && *way == Way::Both);
        assert!(back.is_some_and(|(ms, _)| *ms < 16_000), "{:?}", world.homes[side].ways);
    }
    none_twice(&world);
}

#[test]
fn a_router_that_forgets_its_mapping_costs_a_moment() {
    let mut world = World::new([Router::Kept, Router::Kept]);
    world.run(5000);
    world.homes[0].forgets();
    world.run(30_000);
    assert_eq!(world.ways(), [Way::Direct; 2], "{:?}", world.homes[0].ways);
    for side in 0..2 {
        // Home 0 still writes to the other's address, which lets nobody in from its new port; both are deaf within 15 ms, and the seat follows.
        let lost = world.lost(side);
        assert!(lost < 400, "{lost} lost");
    }
}

#[test]
fn a_meeting_place_that_dies_takes_nothing_along_once_the_path_is_direct() {
    let mut world = World::new([Router::Kept, Router::Kept]);
    world.run(5000);
    world.place = None;
    world.run(40_000);
    assert_eq!((world.ways(), world.lost(0), world.lost(1)), ([Way::Direct; 2], 0, 0));
    // It starts anew, and the direct path dies: the seats are there again.
    world.place = Some(Place::new(&Key::new([77; 32]), world.now()));
    world.run(42_000);
    world.cut = true;
    world.run(43_000);
    assert_eq!(world.ways(), [Way::Relayed; 2]);
    assert!(world.lost(0) <= 60 && world.lost(1) <= 60, "{} {}", world.lost(0), world.lost(1));
}

#[test]
fn a_meeting_place_that_restarts_is_found_again_by_a_relayed_flow() {
    let mut world = World::new([Router::Symmetric, Router::Symmetric]);
    world.run(5000);
    world.place = None;
    world.run(6000);
    world.place = Some(Place::new(&Key::new([77; 32]), world.now()));
    world.run(10_000);
    assert_eq!(world.ways(), [Way::Relayed; 2]);
    for side in 0..2 {
        let lost = world.lost(side);
        assert!((1000..1300).contains(&lost), "{lost} lost: a second of absence, and the seats");
    }
}

#[test]
fn who_hides_his_address_stays_on_the_relay_and_tells_none() {
    let mut world = World::of([Router::Kept, Router::Kept], true);
    world.keeps = true;
    world.run(8000);
    assert_eq!((world.ways(), world.lost(0), world.lost(1)), ([Way::Relayed; 2], 0, 0));
    let meet = super::world::MEET.parse().unwrap();
    assert!(world.seen.iter().all(|(_, from, to, _)| *from == meet || *to == meet), "nothing goes past the relay");
}

#[test]
fn a_path_of_80_ms_changes_to_one_of_16_without_a_gap() {
    let mut world = World::new([Router::Kept, Router::Kept]);
    world.relay_ms = 64;
    world.run(10_000);
    assert_eq!((world.ways(), world.lost(0), world.lost(1)), ([Way::Direct; 2], 0, 0));
    none_twice(&world);
    for home in &world.homes {
        // 80 ms one way by the relay, 8 directly: never more than two datagrams in a ms, and those in order.
        assert!(home.took.iter().all(|(.., took)| (8..=81).contains(took)), "no longer than by the relay");
        let falls = |pair: &[(u64, u64, u64)]| pair[1].2 + 1 < pair[0].2 || pair[1].1 != pair[0].1 + 1;
        assert_eq!(home.took.windows(2).filter(|pair| falls(pair)).count(), 0, "a delay falls by 1 ms at a time");
        let last = home.took.iter().rposition(|(.., took)| *took > 8).expect("it was longer");
        let first = home.took.iter().position(|(.., took)| *took < 80).expect("it becomes shorter");
        let slid_ms = home.took[last].0 - home.took[first].0;
        assert!((1400..=1480).contains(&slid_ms), "72 ms, a ms in 20: {slid_ms} ms");
    }
}
