//! Peers restart at any instant, 10,000 times, and always find each other again: from zero, within half a second.

use cohold_protocol::link::{Link, Notice, Stage};
use cohold_protocol::wire::MAX_DATAGRAM;

use crate::protocol::world::{CLEAN, Impairment, World, config, state};

/// Restarts one peer or the other at random instants; the longest time to re-engage, ms.
fn restarts(count: u32, seed: u64, impairment: Impairment) -> u64 {
    let mut world = World::new(seed, impairment);
    let mut slowest = 0;
    world.run_until(500_000, World::is_engaged).expect("the first join");
    for restart in 0..count {
        let wait = world.rng.below(60_000);
        world.run(wait);
        world.notices.iter_mut().for_each(Vec::clear);
        world.notices.iter_mut().for_each(Vec::clear);
        let peer = world.rng.below(2) as usize;
        let before = world.flows[peer].len();
        world.restart(peer);
        assert_eq!(world.links[peer].stage(), Stage::Calling);
        // The other one parts as well: it gets to know of the restart before anything couples again.
        let apart = |world: &World| !matches!(world.links[1 - peer].stage(), Stage::Running | Stage::Fading);
        let parted = world.run_until(500_000, apart).unwrap();
        let met = world.run_until(500_000 - parted, World::is_engaged);
        let met = met.unwrap_or_else(|| panic!("restart {restart} of peer {peer}: {:?}", world.stages()));
        assert!(world.flows[peer].len() > before);
        let told = &world.notices[1 - peer];
        let new_peer = Notice::NewPeer(0);
        for notice in [Notice::Disengaged, Notice::Lost, new_peer, Notice::Joined, Notice::Engaged] {
            assert!(told.contains(&notice), "{notice:?} is not in {told:?}");
        }
        slowest = slowest.max((parted + met) / 1_000);
        world.flows.iter_mut().for_each(Vec::clear);
    }
    slowest
}

#[test]
fn ten_thousand_restarts_without_loss() {
    let worst = restarts(10_000, 1, Impairment { loss: 0.0, duplicate: 0.0, delay: 500, jitter: 2_000 });
    println!("slowest: {worst} ms");
}

#[test]
fn ten_thousand_restarts_with_a_fifth_lost() {
    let worst = restarts(10_000, 2, Impairment { loss: 0.2, duplicate: 0.1, delay: 500, jitter: 12_000 });
    println!("slowest: {worst} ms");
}

#[test]
fn restarts_in_the_middle_of_joining() {
    let impairment = Impairment { loss: 0.2, duplicate: 0.2, delay: 1_000, jitter: 20_000 };
    let mut world = World::new(3, impairment);
    for round in 0..2_000 {
        // Several restarts of both, faster than they can join; then peace.
        for _ in 0..world.rng.below(6) {
            let peer = world.rng.below(2) as usize;
            world.restart(peer);
            let wait = world.rng.below(40_000);
            world.run(wait);
        }
        let joined = world.run_until(500_000, World::is_engaged);
        assert!(joined.is_some(), "round {round}: {:?}", world.stages());
        world.flows.iter_mut().for_each(Vec::clear);
        world.notices.iter_mut().for_each(Vec::clear);
    }
}

#[test]
fn any_order_of_starting() {
    for late in [0, 1] {
        let mut world = World::new(4, CLEAN);
        world.off[late] = true;
        world.run(5_000_000);
        assert_eq!(world.links[1 - late].stage(), Stage::Calling);
        world.restart(late);
        world.off[late] = false;
        assert!(world.run_until(200_000, World::is_engaged).is_some());
    }
}

#[test]
fn far_apart() {
    // 200 ms each way is within what a campaign asks for; joining takes two round trips.
    for delay in [50_000, 200_000] {
        let mut world = World::new(5, Impairment { loss: 0.2, duplicate: 0.1, delay, jitter: 12_000 });
        assert!(world.run_until(3_000_000, World::is_engaged).is_some(), "{delay} µs: {:?}", world.stages());
    }
}

/// A peer that says goodbye is gone at once, and not after 12 packet periods of silence; a lost goodbye is that silence.
#[test]
fn a_goodbye_ends_the_session_at_once() {
    for (heard, limit) in [(true, 2_000), (false, 120_000)] {
        let mut world = World::engaged(7);
        let mut out = [0; MAX_DATAGRAM];
        let len = world.links[0].goodbye(world.clock(0), &mut out).expect("a session to end");
        world.off[0] = true;
        if heard {
            world.send(0, &out[..len]);
        }
        world.notices[1].clear();
        let after = world.run_until(limit, |world| world.stages()[1] == Stage::Calling);
        assert!(after.is_some_and(|after| heard || after > 80_000), "{after:?}");
        assert!(world.notices[1].ends_with(&[Notice::Disengaged, Notice::Lost]), "{:?}", world.notices[1]);
        // Said once more it ends nothing: the session that it is for is over.
        let before = state(&world.links[1]);
        assert!(world.links[1].receive(world.clock(1), &mut out[..len]).is_err() && state(&world.links[1]) == before);
        // The same peer again: it calls, and both go on.
        world.off[0] = false;
        assert!(world.run_until(1_000_000, World::is_engaged).is_some());
    }
    assert_eq!(Link::new(config(1, 2, [1; 32])).expect("a link").goodbye(0, &mut [0; MAX_DATAGRAM]), None);
}
