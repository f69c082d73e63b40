//! Every single-bit flip, truncation and extension of every message, and every datagram that was sent to someone else, in
//! another session or before: refused, and nothing has changed.

use cohold_protocol::ends::Ends;
use cohold_protocol::key::Key;
use cohold_protocol::link::{Config, Error, Link};
use cohold_protocol::wire::{AxisFlow, Event, Flow, MAX_DATAGRAM, PeerId, Telemetry};

use crate::protocol::world::{PERIOD, Rng, World, config, state};

fn poll(world: &mut World, from: usize) -> Option<Vec<u8>> {
    let mut out = [0; MAX_DATAGRAM];
    let now = world.clock(from);
    world.links[from].poll(now, &mut out).map(|len| out[..len].to_vec())
}

fn receive(world: &mut World, to: usize, datagram: &[u8]) -> Result<(), Error> {
    let now = world.clock(to);
    world.links[to].receive(now, &mut datagram.to_vec()).map(|_| ())
}

/// Two engaged peers with nothing left to say for now.
fn silent(seed: u64) -> World {
    let mut world = World::engaged(seed);
    for peer in [0, 1] {
        while poll(&mut world, peer).is_some() {}
    }
    world
}

/// One sealed datagram of every kind of message, from peer 0 to peer 1, on its way.
fn sealed() -> Vec<(&'static str, usize, World, Vec<u8>)> {
    let mut all = vec![];
    let mut out = [0; MAX_DATAGRAM];

    let mut world = silent(1);
    let now = world.clock(0);
    let flow =
        Flow { engaged: true, tick: 9, axes: [AxisFlow { position: 0.25, ..AxisFlow::default() }], ..Flow::default() };
    let len = world.links[0].send(now, flow, &mut out).unwrap();
    all.push(("flow", 88, world, out[..len].to_vec()));

    let mut world = silent(2);
    let now = world.clock(0);
    let len = world.links[0].send(now, Telemetry::default(), &mut out).unwrap();
    all.push(("telemetry", 136, world, out[..len].to_vec()));

    let mut world = silent(3);
    world.links[0].push_event(Event::new(5, b"hello").unwrap()).unwrap();
    let event = poll(&mut world, 0).unwrap();
    all.push(("event", 61, world, event));

    let mut world = silent(4);
    world.links[1].push_event(Event::new(5, b"hello").unwrap()).unwrap();
    let event = poll(&mut world, 1).unwrap();
    receive(&mut world, 0, &event).unwrap();
    let ack = poll(&mut world, 0).unwrap();
    all.push(("acknowledgement", 60, world, ack));

    let mut world = silent(5);
    world.now += 2 * PERIOD + 1;
    let probe = poll(&mut world, 0).unwrap();
    all.push(("probe", 60, world, probe));

    let mut world = silent(6);
    world.now += 2 * PERIOD + 1;
    let probe = poll(&mut world, 1).unwrap();
    receive(&mut world, 0, &probe).unwrap();
    let reply = poll(&mut world, 0).unwrap();
    all.push(("reply", 76, world, reply));
    all
}

/// Hello and welcome from peer 0 to peer 1, on their way to a peer that they would give a session.
fn greetings() -> Vec<(&'static str, usize, World, Vec<u8>)> {
    // Peer 1 has answered a hello; the hello that echoes its challenge is on its way.
    let mut world = World::new(7, crate::protocol::world::CLEAN);
    let hello = poll(&mut world, 0).unwrap();
    receive(&mut world, 1, &hello).unwrap();
    let welcome = poll(&mut world, 1).unwrap();
    receive(&mut world, 0, &welcome).unwrap();
    let hello = poll(&mut world, 0).unwrap();

    let mut other = World::new(8, crate::protocol::world::CLEAN);
    let called = poll(&mut other, 1).unwrap();
    receive(&mut other, 0, &called).unwrap();
    let welcome = poll(&mut other, 0).unwrap();
    vec![("hello", 200, world, hello), ("welcome", 200, other, welcome)]
}

/// Peer 1 refuses `datagram` and is the same as before.
fn refuses(world: &mut World, what: &str, datagram: &[u8]) {
    let before = state(&world.links[1]);
    let refused = world.links[1].counts().refused;
    assert!(receive(world, 1, datagram).is_err(), "{what} was taken");
    assert_eq!(state(&world.links[1]), before, "{what} has changed something");
    assert_eq!(world.links[1].counts().refused, refused + 1);
}

#[test]
fn altered_datagrams_are_refused() {
    let mut rng = Rng(9);
    for (name, len, mut world, datagram) in sealed().into_iter().chain(greetings()) {
        assert_eq!(datagram.len(), len, "{name}");
        let now = world.clock(1);
        let _ = world.links[1].receive(now, &mut []); // Lets the time pass before states are compared.
        for bit in 0..8 * len {
            let mut flipped = datagram.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            refuses(&mut world, &format!("{name} with bit {bit} flipped"), &flipped);
        }
        for short in 0..len {
            refuses(&mut world, &format!("{name} cut to {short} bytes"), &datagram[..short]);
            refuses(&mut world, &format!("{name} from byte {short}"), &datagram[len - short..]);
        }
        for more in 1..=64 {
            let mut long = datagram.clone();
            long.extend((0..more).map(|_| rng.next() as u8));
            refuses(&mut world, &format!("{name} with {more} bytes more"), &long);
            long[len..].fill(0);
            refuses(&mut world, &format!("{name} with {more} zeros more"), &long);
            let mut ahead = long[len..].to_vec();
            ahead.extend(&datagram);
            refuses(&mut world, &format!("{name} after {more} zeros"), &ahead);
        }
        // And what was sent is taken, after all that.
        assert_eq!(receive(&mut world, 1, &datagram), Ok(()), "{name}");
    }
}

/// Refused by the session at hand: by its keys, or by what it has taken under this number.
fn by_session(taken: Result<(), Error>) -> bool {
    matches!(taken, Err(Error::Forged | Error::Replayed | Error::TooOld))
}

#[test]
fn reflected_replayed_and_redirected_datagrams_are_refused() {
    for (name, _, mut world, datagram) in sealed() {
        assert_eq!(receive(&mut world, 0, &datagram), Err(Error::OwnNumber), "{name} reflected");
        let mut turned = datagram.clone();
        turned.swap(2, 3);
        let turned = receive(&mut world, 0, &turned);
        assert!(by_session(turned), "{name} reflected with its numbers swapped: {turned:?}");

        assert_eq!(receive(&mut world, 1, &datagram), Ok(()), "{name}");
        let replayed = Err(Error::Replayed);
        assert_eq!(receive(&mut world, 1, &datagram), replayed, "{name} replayed");
    }
    for (name, _, mut world, datagram) in greetings() {
        assert_eq!(receive(&mut world, 0, &datagram), Err(Error::OwnNumber), "{name} reflected");
        let mut turned = datagram.clone();
        turned.swap(2, 3);
        let forged = Err(Error::ForgedGreeting);
        assert_eq!(receive(&mut world, 0, &turned), forged, "{name} reflected with its numbers swapped");
    }
}

#[test]
fn datagrams_of_other_sessions_are_refused() {
    for (name, _, world, datagram) in sealed() {
        // To the same peer after it has restarted and joined again, and to one that has just started.
        let mut world = world;
        world.restart(1);
        assert_eq!(receive(&mut world, 1, &datagram), Err(Error::NoSession), "{name}");
        world.run(400_000);
        assert!(world.is_engaged());
        let other = Err(Error::OtherSession);
        assert_eq!(receive(&mut world, 1, &datagram), other, "{name}");
        // The same with the number of the session at hand: only the tag tells.
        world.log = Some([vec![], vec![]]);
        world.run(20_000);
        let current = world.log.take().unwrap()[0].last().unwrap().clone();
        let mut renamed = datagram.clone();
        renamed[4..8].copy_from_slice(&current[4..8]);
        assert!(by_session(receive(&mut world, 1, &renamed)), "{name}");
        // To a pair that has the same key and never heard of this one.
        assert_eq!(receive(&mut World::engaged(99), 1, &datagram), other, "{name}");
    }
}

#[test]
fn strangers_with_another_key_or_number_are_refused() {
    let mut world = World::new(10, crate::protocol::world::CLEAN);
    let mut out = [0; MAX_DATAGRAM];
    let strangers = [
        Config { key: Key::new([8; 32]), ..config(1, 2, [1; 32]) },
        config(3, 2, [1; 32]),
        config(1, 3, [1; 32]),
        Config { ends: Ends { local: PeerId(2), remote: PeerId(1) }, ..config(1, 2, [1; 32]) },
    ];
    for stranger in strangers {
        let mut link = Link::new(stranger).unwrap();
        let len = link.poll(0, &mut out).unwrap();
        let _ = receive(&mut world, 1, &[]);
        refuses(&mut world, "a stranger's hello", &out[..len]);
    }
}

#[test]
fn a_flood_of_forgeries_leaves_the_session_up() {
    let mut world = World::engaged(11);
    world.log = Some([vec![], vec![]]);
    world.run(100_000);
    let recorded = world.log.take().unwrap();
    let flows = world.flows[1].len();
    let mut rng = Rng(12);
    for round in 0..1_000 {
        // 100 forgeries each ms: noise with a right header, altered recordings of both directions, random bytes.
        for _ in 0..100 {
            let (to, list) = (rng.below(2) as usize, &recorded[rng.below(2) as usize]);
            let mut forged = list[rng.below(list.len() as u64) as usize].clone();
            match rng.below(4) {
                0 => forged[16..].iter_mut().for_each(|byte| *byte = rng.next() as u8),
                1 => forged[8..16].copy_from_slice(&rng.next().to_le_bytes()),
                2 => forged.iter_mut().for_each(|byte| *byte = rng.next() as u8),
                _ => forged[rng.below(8) as usize + 8] ^= 1 << rng.below(8),
            }
            assert!(receive(&mut world, to, &forged).is_err());
        }
        world.step();
        assert!(world.is_engaged(), "after {round} ms");
    }
    assert_eq!(world.flows[1].len() - flows, 125);
    assert_eq!(world.links[1].counts().late, 0);
}
