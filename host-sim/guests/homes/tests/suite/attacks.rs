//! Attacks on two homes: each is made, and what it gains is counted.

use std::net::SocketAddr;

use cohold_homes::Way;
use cohold_homes::agreement::{Accepter, Heard, Inviter};
use cohold_homes::carrier::{Carrier, Config};
use cohold_homes::frame::{Frame, Join, Welcome};
use cohold_homes::invite::Invite;
use cohold_homes::place::Place;
use cohold_homes::seat::Seat;
use cohold_protocol::key::Key;
use cohold_protocol::wire::VERSION;

use super::world::{MEET, Router, World};

/// A stranger with an address of his own.
const THIEF: &str = "198.51.100.66:6666";
/// Most datagrams to an address before it has proved itself; one more every 12 s.
const BUDGET: usize = 5;

#[test]
fn candidates_that_point_at_a_third_party_bring_it_five_datagrams() {
    // Home 1 says that it can be reached at six addresses that are others'.
    let mut world = World::new([Router::Kept, Router::Kept]);
    let victims: Vec<SocketAddr> = (1..=6).map(|host| SocketAddr::from(([198, 51, 100, host], 53))).collect();
    let config = Config {
        key: Key::new([9; 32]),
        side: 1,
        meet: MEET.parse().unwrap(),
        bases: victims.clone(),
        mapped: None,
        relay_only: false,
    };
    world.homes[1].carrier = Carrier::new(config, &Key::new([2; 32]), world.start);
    // Two minutes, with restarts of ICE.
    world.run(11_000);
    for victim in &victims {
        let got = world.nowhere.get(victim).map_or(0, Vec::len);
        assert!((1..=BUDGET).contains(&got), "{victim} got {got}");
    }
    world.run(130_000);
    for victim in &victims {
        let got = world.nowhere.get(victim).map_or(0, Vec::len);
        assert!(got <= BUDGET + 130 / 12, "{victim} got {got}");
        assert!(world.nowhere[victim].iter().all(|bytes| Frame::of(bytes) == Frame::Stun), "no flow goes there");
    }
}

/// Who has read every join of a live session sends all of them again, with the cookie of an address of his own.
#[test]
fn an_onlooker_moves_no_seat_of_a_live_session() {
    let mut world = World::new([Router::Symmetric, Router::Symmetric]);
    world.keeps = true;
    world.run(5000);
    let (thief, meet) = (THIEF.parse().unwrap(), MEET.parse().unwrap());
    let mut tried = 0;
    for round in 1..=600 {
        let joins: Vec<Join> = world.seen.iter().rev().filter_map(|(_, _, _, bytes)| Join::parse(bytes)).collect();
        let cookie = world.nowhere.get(&thief).and_then(|came| Welcome::parse(came.last()?)).map(|came| came.cookie);
        for side in 0..2 {
            let seen = joins.iter().find(|join| join.side == side && Some(join.cookie) != cookie).expect("a join");
            world.post(thief, meet, &Join { cookie: cookie.unwrap_or_default(), ..*seen }.emit());
            tried += u32::from(cookie.is_some());
        }
        world.run(5000 + 5 * round);
    }
    assert!(tried > 1000);
    assert_eq!((world.ways(), world.lost(0), world.lost(1)), ([Way::Relayed; 2], 0, 0));
    let got = &world.nowhere[&thief];
    assert!(got.iter().all(|bytes| Welcome::parse(bytes).is_some_and(|welcome| !welcome.seated)), "no seat, no flow");
}

/// A thief with the link takes both seats in turn, before the right person does: to the inviter he is the partner, to the partner he is nobody.
#[test]
fn who_takes_both_seats_with_a_stolen_link_gets_the_key_of_one_end_alone() {
    let now = std::time::Instant::now();
    let mut place = Place::new(&Key::new([1; 32]), now);
    let mut inviter = Inviter::new(MEET, &Key::new([2; 32]), now);
    let link = inviter.invite.link();
    let stolen = Invite::parse(&link).expect("a link");
    let (home, partner, thief): (SocketAddr, SocketAddr, SocketAddr) =
        ("203.0.113.11:1".parse().unwrap(), "203.0.113.12:1".parse().unwrap(), THIEF.parse().unwrap());
    fn say(place: &mut Place, now: std::time::Instant, from: SocketAddr, bytes: &[u8]) -> (SocketAddr, Vec<u8>) {
        let mut sent = Vec::new();
        place.hear(now, from, bytes, &mut |to, bytes| sent.push((to, bytes.to_vec())));
        sent.pop().expect("an answer, or passed on")
    }
    let sit = |place: &mut Place, from, mut seat: Seat| {
        while let Some(join) = seat.poll(now, true) {
            seat.hear(now, &say(place, now, from, &join).1);
        }
        assert!(seat.is_seated(now));
    };
    sit(&mut place, home, inviter.invite.seat(0, &Key::new([3; 32])));
    sit(&mut place, thief, stolen.seat(1, &Key::new([4; 32])));
    let takes = Accepter::new(&stolen, &Key::new([5; 32]));
    let (to, offer) = say(&mut place, now, thief, &takes.offer());
    assert_eq!(to, home);
    let (answer, heard) = inviter.hear(now, &offer);
    let (to, answer) = say(&mut place, now, home, &answer.expect("an answer"));
    let theirs = takes.hear(&answer).expect("it is not used").expect("a key");
    assert_eq!((to, heard), (thief, Heard::Agreed(theirs)), "he was quicker");
    // Now he is to be the inviter.
    sit(&mut place, thief, stolen.seat(0, &Key::new([6; 32])));
    sit(&mut place, partner, Invite::parse(&link).expect("a link").seat(1, &Key::new([7; 32])));
    let accepter = Accepter::new(&Invite::parse(&link).expect("a link"), &Key::new([8; 32]));
    let (to, offer) = say(&mut place, now, partner, &accepter.offer());
    assert_eq!(to, thief);
    let mut invites = Inviter::new(MEET, &Key::new([9; 32]), now);
    invites.invite = stolen;
    let (forged, _) = invites.hear(now, &offer);
    for answer in [forged.expect("he has the link's secret").to_vec(), answer] {
        let (to, answer) = say(&mut place, now, thief, &answer);
        assert_eq!((to, accepter.hear(&answer)), (partner, Ok(None)), "only who made the link can answer");
    }
}

#[test]
fn replayed_stun_moves_no_flow() {
    let mut world = World::new([Router::Kept, Router::Kept]);
    world.keeps = true;
    world.run(3000);
    let checks: Vec<_> = world.seen.drain(..).filter(|(_, _, _, bytes)| Frame::of(bytes) == Frame::Stun).collect();
    assert!(checks.len() > 4, "{} checks were seen", checks.len());
    // Every check and response of either end again, from an address that the routers were made to let in.
    let thief: SocketAddr = THIEF.parse().unwrap();
    for (_, _, to, bytes) in &checks {
        if let Some(side) = world.homes.iter().position(|home| home.outer == to.ip()) {
            let (now, home) = (world.now(), &mut world.homes[side]);
            let mut sent = Vec::new();
            assert!(!home.carrier.hear(now, thief, bytes, &mut |to, bytes| sent.push((to, bytes.to_vec()))));
            sent.into_iter().for_each(|(to, bytes)| world.post(thief, to, &bytes));
        }
    }
    let before = world.seen.len();
    world.run(20_000);
    assert_eq!((world.ways(), world.lost(0), world.lost(1)), ([Way::Direct; 2], 0, 0));
    let got = world.nowhere.get(&thief).map_or(0, Vec::len);
    assert!(got <= 2 * (BUDGET + 2), "both homes together send it {got}");
    assert!(world.nowhere.values().flatten().all(|bytes| Frame::of(bytes) != Frame::Sealed), "no flow goes there");
    assert!(world.seen.len() > before);
}

#[test]
fn flow_from_an_address_that_has_not_proved_itself_is_not_handed_on() {
    let mut world = World::new([Router::Kept, Router::Kept]);
    world.run(3000);
    let (now, home) = (world.now(), &mut world.homes[0]);
    let strangers = home.carrier.report().strangers;
    for port in 1..=100 {
        let from = SocketAddr::from(([198, 51, 100, 66], port));
        assert!(!home.carrier.hear(now, from, &[VERSION; 88], &mut |_, _| panic!("nothing is answered")));
    }
    assert_eq!(home.carrier.report().strangers, strangers + 100);
}

#[test]
fn signals_of_an_earlier_run_count_for_nothing() {
    // Two whole runs under one key file: what was sent in the first is sent again to the second.
    let mut first = World::new([Router::Kept, Router::Kept]);
    first.keeps = true;
    first.run(4000);
    let mut second = World::new([Router::Symmetric, Router::Symmetric]);
    for side in 0..2_u8 {
        let config = Config {
            key: Key::new([9; 32]),
            side,
            meet: MEET.parse().unwrap(),
            bases: vec![second.homes[0].inner],
            mapped: None,
            relay_only: false,
        };
        second.homes[usize::from(side)].carrier = Carrier::new(config, &Key::new([40 + side; 32]), second.start);
    }
    second.run(2000);
    let old: Vec<_> = first.seen.iter().filter(|(_, _, _, bytes)| Frame::of(bytes) == Frame::Signal).cloned().collect();
    assert!(old.len() > 500);
    let meet = MEET.parse().unwrap();
    for (at, (_, _, to, bytes)) in old.iter().enumerate() {
        if at % 20 == 0 {
            second.step();
        }
        for home in second.homes.iter_mut().filter(|home| home.outer == to.ip()) {
            let now = second.start + std::time::Duration::from_millis(second.ms);
            home.carrier.hear(now, meet, bytes, &mut |_, _| {});
        }
    }
    second.run(10_000);
    assert_eq!((second.ways(), second.lost(0), second.lost(1)), ([Way::Relayed; 2], 0, 0));
    assert_eq!(second.homes[0].ways.len(), 1, "{:?}", second.homes[0].ways);
}

#[test]
fn noise_of_any_kind_moves_nothing_and_ends_nothing() {
    let mut world = World::new([Router::Kept, Router::Kept]);
    world.run(3000);
    let peers = [0, 1].map(|side: usize| SocketAddr::new(world.homes[side].outer, 50_001));
    let froms = [MEET.parse().unwrap(), peers[0], peers[1], THIEF.parse().unwrap()];
    let mut rng = 3_u64;
    let mut next = || {
        rng = rng.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        rng >> 33
    };
    for round in 0..20_000_u64 {
        if round % 10 == 0 {
            world.step();
        }
        let mut bytes: Vec<u8> = (0..next() % 240).map(|_| next() as u8).collect();
        // Half of it looks like STUN, with attributes of noise.
        if next() % 2 == 0 && bytes.len() >= 24 {
            bytes.truncate(bytes.len() / 4 * 4);
            let size = (bytes.len() - 20) as u16;
            bytes[..2].copy_from_slice(&[[0, 1], [1, 1], [1, 0x11], [0, 0x11]][next() as usize % 4]);
            bytes[2..4].copy_from_slice(&size.to_be_bytes());
            bytes[4..8].copy_from_slice(&[0x21, 0x12, 0xA4, 0x42]);
            let at = [6, 8, 0x20, 0x24, 0x8028, 0x802A][next() as usize % 6] as u16;
            bytes[20..22].copy_from_slice(&at.to_be_bytes());
        }
        let (side, from) = (next() as usize % 2, froms[next() as usize % 4]);
        let now = world.now();
        let taken = world.homes[side].carrier.hear(now, from, &bytes, &mut |_, _| {});
        assert!(!taken || bytes[0] == VERSION, "only what looks sealed is the link's to judge");
    }
    world.run(world.ms + 3000);
    assert_eq!((world.ways(), world.lost(0), world.lost(1)), ([Way::Direct; 2], 0, 0));
}
