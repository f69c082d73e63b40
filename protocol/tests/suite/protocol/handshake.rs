//! Who meets whom: parameters, crossing hellos, greetings of the past, and that no key ever meets a nonce twice.

use std::collections::HashSet;

use cohold_protocol::key::Key;
use cohold_protocol::link::{Config, ConfigError, Error, Link, Notice, Stage};
use cohold_protocol::wire::MAX_DATAGRAM;

use crate::protocol::world::{CLEAN, Impairment, Rng, World, config, parameters, state};

#[test]
fn what_a_link_cannot_be_made_from() {
    let error = |config: Config| Link::new(config).err();
    let good = config(1, 2, [1; 32]);
    assert_eq!(error(good.clone()), None);
    assert_eq!(error(config(1, 1, [1; 32])), Some(ConfigError::SameNumber(1)));
    assert_eq!(error(config(1, 2, [0; 32])), Some(ConfigError::ZeroEntropy));
    assert_eq!(error(Config { key: Key::new([0; 32]), ..good.clone() }), Some(ConfigError::ZeroKey));
    for us in [0, 99, 10_000_001] {
        let config = Config { packet_period_us: us, ..good.clone() };
        assert_eq!(error(config), Some(ConfigError::PacketPeriod { us }));
    }
    let sentence = "packet period = 99 µs is not allowed: it must be from 100 to 10000000 µs";
    assert_eq!(ConfigError::PacketPeriod { us: 99 }.to_string(), sentence);
}

#[test]
fn hellos_that_cross() {
    let mut world = World::new(1, CLEAN);
    let mut out = [[0; MAX_DATAGRAM]; 2];
    // Both say hello before either has heard anything, again and again, each step in perfect symmetry.
    for _ in 0..6 {
        let lens = [0, 1].map(|peer| world.links[peer].poll(1_000, &mut out[peer]));
        for (peer, len) in [(1, lens[0]), (0, lens[1])] {
            if let Some(len) = len {
                let mut datagram = out[1 - peer][..len].to_vec();
                world.links[peer].receive(1_000, &mut datagram).unwrap();
            }
        }
    }
    assert_eq!(world.stages(), [Stage::Idle; 2]);
}

#[test]
fn parameters_that_differ_are_refused_by_name_at_both_ends() {
    let mut world = World::new(2, CLEAN);
    world.links[1] = Link::new(Config { parameters: parameters(9e3), ..config(2, 1, [5; 32]) }).unwrap();
    world.run(500_000);
    for peer in [0, 1] {
        assert_eq!(world.links[peer].stage(), Stage::Refused);
        assert_eq!(world.links[peer].refused(), Some("coordination"));
        assert_eq!(world.notices[peer], [Notice::Refused("coordination")]);
        assert!(world.flows[peer].is_empty());
    }
    let error = Error::Parameters("coordination");
    assert_eq!(error.to_string(), "the other peer has other parameters: coordination");
    // Configured better, it is taken.
    world.restart(1);
    assert!(world.run_until(200_000, World::is_engaged).is_some());
    assert_eq!(world.links[0].refused(), None);
}

#[test]
fn a_peer_that_comes_back_with_other_parameters_is_refused() {
    let mut world = World::engaged(3);
    world.notices = [vec![], vec![]];
    world.links[1] = Link::new(Config { parameters: parameters(9e3), ..config(2, 1, [5; 32]) }).unwrap();
    world.run(300_000);
    assert_eq!(world.stages(), [Stage::Refused; 2]);
    // Peer 0 has nothing to say to a stranger while its session lasts; peer 1 tells it of the refusal.
    let notices = [Notice::Disengaged, Notice::Lost, Notice::Refused("coordination")];
    assert_eq!(world.notices[0], notices);
}

#[test]
fn another_key_never_meets() {
    let mut world = World::new(4, CLEAN);
    world.links[1] = Link::new(Config { key: Key::new([8; 32]), ..config(2, 1, [5; 32]) }).unwrap();
    world.run(2_000_000);
    assert_eq!(world.stages(), [Stage::Calling; 2]);
    assert!(world.links.iter().all(|link| link.counts().refused > 100));
}

/// Everything that two peers said in several lives, and the world in which they are together again.
fn recorded(seed: u64) -> (World, [Vec<Vec<u8>>; 2]) {
    let mut world = World::new(seed, Impairment { loss: 0.1, duplicate: 0.1, delay: 500, jitter: 15_000 });
    world.log = Some([vec![], vec![]]);
    for life in 0..20 {
        world.run(150_000);
        world.restart(life % 2);
    }
    world.run(20_000);
    let past = world.log.take().unwrap();
    world.impairment = CLEAN;
    world.restart(0);
    world.run(400_000);
    assert!(world.is_engaged());
    world.notices = [vec![], vec![]];
    (world, past)
}

#[test]
fn the_whole_past_replayed_changes_nothing_in_a_running_session() {
    let (mut world, past) = recorded(5);
    let flows = world.flows.clone();
    for datagrams in &past {
        for (n, datagram) in datagrams.iter().enumerate() {
            for to in [0, 1] {
                let now = world.clock(to);
                assert!(!matches!(world.links[to].receive(now, &mut datagram.clone()), Ok(Some(_))));
                // What a replayed hello gets is a welcome that goes stale at the other end.
                world.poll(to);
            }
            if n % 20 == 0 {
                world.step();
                assert!(world.is_engaged());
            }
        }
    }
    assert_eq!(world.notices, [vec![], vec![]]);
    assert!(world.flows[0].len() > flows[0].len());
}

#[test]
fn the_whole_past_replayed_does_not_keep_a_restarted_peer_out() {
    let (mut world, past) = recorded(6);
    let mut rng = Rng(7);
    for round in 0..50 {
        world.restart(round % 2);
        let start = world.now;
        let fresh = world.flows[round % 2].len();
        while !world.is_engaged() {
            // 40 recorded datagrams each ms, to either peer.
            for _ in 0..40 {
                let (to, list) = (rng.below(2) as usize, &past[rng.below(2) as usize]);
                let now = world.clock(to);
                let mut datagram = list[rng.below(list.len() as u64) as usize].clone();
                assert!(!matches!(world.links[to].receive(now, &mut datagram), Ok(Some(_))));
                world.poll(to);
            }
            world.step();
            assert!(world.now - start < 500_000, "round {round}: {:?}", world.stages());
        }
        assert!(world.flows[round % 2].len() > fresh);
    }
}

#[test]
fn a_hello_of_the_past_is_given_no_memory() {
    let (mut world, past) = recorded(8);
    let now = world.clock(1);
    let mut hellos = past[0].iter().filter(|datagram| datagram[1] == 1);
    // The challenge that all of them are answered with is drawn for the first.
    let _ = world.links[1].receive(now, &mut hellos.next().unwrap().clone());
    world.poll(1);
    let before = state(&world.links[1]);
    for hello in hellos {
        let _ = world.links[1].receive(now, &mut hello.clone());
        // Once it is answered nothing is left of it.
        let len = world.links[1].poll(now, &mut [0; MAX_DATAGRAM]);
        assert_eq!(len, Some(200));
        assert_eq!(state(&world.links[1]), before);
    }
}

/// Every (session, direction, sequence) that was ever sealed.
fn all_different(logs: &[Vec<Vec<u8>>; 2]) -> usize {
    let mut seen = HashSet::new();
    for datagram in logs.iter().flatten().filter(|datagram| datagram[1] == 3) {
        assert!(seen.insert(datagram[2..16].to_vec()), "a nonce was used twice under one key: {datagram:?}");
    }
    seen.len()
}

#[test]
fn no_key_meets_a_nonce_twice_whatever_is_restarted_lost_or_replayed() {
    let mut world = World::new(9, Impairment { loss: 0.3, duplicate: 0.2, delay: 500, jitter: 30_000 });
    world.log = Some([vec![], vec![]]);
    for _ in 0..300 {
        let wait = world.rng.below(200_000);
        world.run(wait);
        match world.rng.below(3) {
            0 => world.restart(0),
            1 => world.restart(1),
            _ => world.cut = [world.rng.chance(0.3), world.rng.chance(0.3)],
        }
    }
    let sealed = all_different(&world.log.unwrap());
    assert!(sealed > 3_000, "{sealed} sealed datagrams");
}

#[test]
fn a_peer_whose_randomness_repeats_itself_still_gets_fresh_keys() {
    let mut world = World::new(10, CLEAN);
    world.log = Some([vec![], vec![]]);
    for _ in 0..50 {
        // The same challenges and sequence numbers at every start: the other peer's challenge saves it.
        world.links[0] = Link::new(config(1, 2, [3; 32])).unwrap();
        assert!(world.run_until(500_000, World::is_engaged).is_some());
    }
    all_different(&world.log.unwrap());
}

#[test]
fn a_session_ends_with_silence_and_the_next_one_has_other_keys() {
    let mut world = World::engaged(11);
    let mut numbers = HashSet::new();
    for _ in 0..20 {
        world.log = Some([vec![], vec![]]);
        world.cut = [true, true];
        world.run(150_000);
        assert_eq!(world.stages(), [Stage::Calling; 2]);
        world.cut = [false, false];
        assert!(world.run_until(200_000, World::is_engaged).is_some());
        let log = world.log.take().unwrap();
        assert!(numbers.insert(log[0].last().unwrap()[4..8].to_vec()));
    }
}

#[test]
fn errors_are_sentences() {
    let mut world = World::engaged(12);
    let now = world.clock(0);
    for (datagram, sentence) in [
        (vec![], "sealed: 0 bytes where 32 belong"),
        (vec![2; 40], "greeting: 40 bytes where 200 belong"),
        (vec![9, 3, 2, 1], "sealed: 4 bytes where 32 belong"),
        ([&[9, 3, 2, 1], [0; 64].as_slice()].concat(), "version 9 is spoken here, this end speaks 4"),
        ([&[4, 7, 2, 1], [0; 64].as_slice()].concat(), "kind 7 is no message of version 4"),
        ([&[4, 3, 5, 1], [0; 64].as_slice()].concat(), "a datagram from a peer that this link does not lead to"),
        ([&[4, 3, 2, 5], [0; 64].as_slice()].concat(), "a datagram for another peer"),
        ([&[4, 3, 2, 1], [0; 64].as_slice()].concat(), "this datagram belongs to another session"),
    ] {
        let error: Error = world.links[0].receive(now, &mut datagram.clone()).unwrap_err();
        assert_eq!(error.to_string(), sentence);
    }
}
