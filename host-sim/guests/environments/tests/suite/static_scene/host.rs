//! A server and strangers: what is not from its clients gets nothing, changes nothing and takes no memory to speak of.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use cohold_core::num::Motion;
use cohold_environments::world::host::{Host, MOST_LINES};
use cohold_environments::world::load;
use cohold_environments::world::visitor::{Setup, Visitor};
use cohold_protocol::key::Key;
use cohold_protocol::wire::{Header, VERSION};

use super::world_file::TWO_ROOMS;

const CLIENT: u32 = 1;
const STRANGER: u32 = 666;

/// A server and its client on line 3, talking without a network; everything that the client ever sent.
struct Pair {
    host: Host<u32>,
    visitor: Visitor,
    now: u64,
    sent: Vec<Vec<u8>>,
}

impl Pair {
    fn new() -> Self {
        let mut drawn = 0_u8;
        let entropy = move || {
            drawn = drawn.wrapping_add(1).max(1);
            [drawn; Key::LEN]
        };
        let (world, key) = (*load(TWO_ROOMS.as_ref()).expect("a good world"), Key::new([7; 32]));
        let setup = Setup { key: key.line(3), line: 3, home: 1, reachable: vec![1], radius_m: None };
        let visitor = Visitor::new(setup, || [99; Key::LEN]);
        let host = Host::new(key, 1, 8, world, None, entropy).expect("a good world");
        Self { host, visitor, now: 0, sent: vec![] }
    }

    /// One packet period; whom the server's clock made it send to.
    fn period(&mut self) -> Vec<u32> {
        self.now += 8_000;
        self.visitor.step([Motion::at(0.0); 2]);
        let mut said = vec![];
        self.visitor.exchange(self.now, |_, bytes| said.push(bytes.to_vec()));
        while let Some(bytes) = said.pop() {
            self.sent.push(bytes.clone());
            let mut answers = vec![];
            self.host.receive(self.now, CLIENT, &mut bytes.clone(), |to, bytes| answers.push((to, bytes.to_vec())));
            for (to, mut answer) in answers {
                assert_eq!(to, CLIENT);
                let server = cohold_environments::world::visitor::Correspondent::Server(1);
                self.visitor.receive(self.now, server, &mut answer, |_, bytes| said.push(bytes.to_vec()));
            }
        }
        let mut sent_to = vec![];
        self.host.tick(self.now, |to, _| sent_to.push(to));
        sent_to
    }
}

#[test]
fn what_was_recorded_is_worth_nothing_to_a_stranger() {
    let mut pair = Pair::new();
    for _ in 0..200 {
        pair.period();
    }
    assert!(pair.visitor.is_complete() && pair.sent.len() > 200);
    let (now, refused) = (pair.now, pair.host.counts.refused);
    let mut greetings = 0;
    for datagram in &pair.sent {
        pair.host.receive(now, STRANGER, &mut datagram.clone(), |to, answer| {
            // An old hello is answered, byte for byte as long, with a challenge that the stranger cannot meet.
            assert_eq!((to, answer[1], answer.len()), (STRANGER, 2, 200));
            assert_eq!(datagram.len(), 200);
            greetings += 1;
        });
    }
    // Every sealed one was refused, and none of them moved the client's address or session.
    let sealed = pair.sent.iter().filter(|datagram| datagram[1] == Header::KIND).count() as u64;
    assert_eq!(pair.host.counts.refused - refused, sealed);
    assert!(sealed > 100 && greetings <= pair.sent.len() as u64 - sealed);
    let sent_to: Vec<u32> = (0..200).flat_map(|_| pair.period()).collect();
    assert!(sent_to.iter().all(|to| *to == CLIENT));
    assert_eq!(pair.host.clients(), 1);
    assert!(pair.visitor.is_complete());
}

#[test]
fn anything_at_all_from_anybody() {
    let mut pair = Pair::new();
    for _ in 0..20 {
        pair.period();
    }
    let before = pair.host.counts.refused;
    let (mut random, mut answers) = (1_u64, 0);
    let mut next = move || {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (random >> 33) as u8
    };
    for round in 0..20_000 {
        let mut bytes: Vec<u8> = (0..usize::from(next())).map(|_| next()).collect();
        // Every other one begins as a hello on some line, or as a datagram that the client has sent, with one bit wrong.
        if round % 3 == 1 {
            bytes.resize(200, 0);
            bytes[..8].copy_from_slice(&[VERSION, 1, 0, 1, next() % 16, 0, 0, 0]);
        } else if round % 3 == 2 {
            bytes.clone_from(&pair.sent[round % pair.sent.len()]);
            let bit = usize::from(next()) * 8 % (8 * bytes.len());
            bytes[bit / 8] ^= 1 << (next() % 8);
        }
        let came = bytes.len();
        pair.host.receive(pair.now, STRANGER, &mut bytes, |to, said| {
            assert!((to, said[1]) == (STRANGER, 1) && said.len() <= came);
            answers += 1;
        });
    }
    // One hello a second at the most tells a stranger what is wrong.
    assert!(answers <= 1);
    assert_eq!(pair.host.counts.refused - before, 20_000);
    assert_eq!((pair.host.clients(), pair.period()), (1, vec![]));
}

#[test]
fn a_server_has_as_many_lines_as_it_was_told() {
    let world = *load(TWO_ROOMS.as_ref()).expect("a good world");
    for lines in [0, MOST_LINES + 1] {
        let error = Host::<u32>::new(Key::new([7; 32]), 1, lines, world.clone(), None, || [1; 32]).err();
        let error = error.map(|error| error.to_string());
        assert_eq!(error, Some(format!("lines = {lines} is not allowed: it must be from 1 to 4096")));
    }
}

impl Pair {
    /// One packet period in which `copies` of each datagram of the client come first, from somebody else; to whom the server
    /// said how many bytes, and how many came from that somebody.
    fn raced(&mut self, copies: usize) -> (Vec<(u32, usize)>, usize) {
        self.now += 8_000;
        self.visitor.step([Motion::at(0.0); 2]);
        let (mut said, mut sent_to, mut copied) = (vec![], vec![], 0);
        self.visitor.exchange(self.now, |_, bytes| said.push(bytes.to_vec()));
        while let Some(bytes) = said.pop() {
            let mut answers = vec![];
            for from in [STRANGER].repeat(copies).into_iter().chain([CLIENT]) {
                copied += if from == STRANGER { bytes.len() } else { 0 };
                self.host.receive(self.now, from, &mut bytes.clone(), |to, bytes| answers.push((to, bytes.to_vec())));
            }
            sent_to.extend(answers.iter().map(|(to, answer)| (*to, answer.len())));
            for (_, mut answer) in answers.into_iter().filter(|(to, _)| *to == CLIENT) {
                let server = cohold_environments::world::visitor::Correspondent::Server(1);
                self.visitor.receive(self.now, server, &mut answer, |_, bytes| said.push(bytes.to_vec()));
            }
        }
        self.host.tick(self.now, |to, bytes| sent_to.push((to, bytes.len())));
        (sent_to, copied)
    }
}

/// What a client sends, injected from elsewhere before it comes from the client: its line stays where it has proved to be.
#[test]
fn a_copy_that_comes_first_moves_no_line() {
    let mut pair = Pair::new();
    for _ in 0..100 {
        pair.period();
    }
    let mut to_client = 0;
    for _ in 0..500 {
        let (sent_to, copied) = pair.raced(1);
        assert!(copied > 0 && sent_to.iter().all(|(to, _)| *to == CLIENT), "{sent_to:?}");
        to_client += sent_to.len();
    }
    assert!(to_client > 500 && pair.host.clients() == 1 && pair.visitor.is_complete());
}

/// Whoever wins every race from the first datagram on keeps a client out; the moment he stops, it is served.
#[test]
fn a_client_is_served_when_a_race_is_over() {
    let mut pair = Pair::new();
    for _ in 0..500 {
        pair.raced(1);
    }
    assert!(!pair.visitor.is_complete());
    for _ in 0..300 {
        pair.raced(0);
    }
    assert!(pair.visitor.is_complete());
}

/// A client that has moved begins anew from there, and is served there.
#[test]
fn a_client_that_moves_is_answered_where_it_is_now() {
    const MOVED: u32 = 7;
    let mut pair = Pair::new();
    for _ in 0..100 {
        pair.period();
    }
    let mut to_moved = 0;
    for _ in 0..200 {
        pair.now += 8_000;
        pair.visitor.step([Motion::at(0.0); 2]);
        let mut said = vec![];
        pair.visitor.exchange(pair.now, |_, bytes| said.push(bytes.to_vec()));
        while let Some(mut bytes) = said.pop() {
            let mut answers = vec![];
            pair.host.receive(pair.now, MOVED, &mut bytes, |to, bytes| answers.push((to, bytes.to_vec())));
            // What goes to where it was is lost.
            for (_, mut answer) in answers.into_iter().filter(|(to, _)| *to == MOVED) {
                to_moved += 1;
                let server = cohold_environments::world::visitor::Correspondent::Server(1);
                pair.visitor.receive(pair.now, server, &mut answer, |_, bytes| said.push(bytes.to_vec()));
            }
        }
        pair.host.tick(pair.now, |_, _| {});
    }
    assert!(to_moved > 100 && pair.host.clients() == 1, "{to_moved} datagrams");
}

/// Greetings on every line, by someone who holds no key of theirs: nothing is kept, and at most one a second is answered.
#[test]
fn greetings_without_a_key_take_no_memory() {
    let mut pair = Pair::new();
    let mut answers = vec![];
    for count in 0..4_000_u32 {
        let mut hello = [0x5a; 200];
        hello[..8].copy_from_slice(&[VERSION, 1, 0, 1, (count % 8 + 1) as u8, 0, 0, 0]);
        hello[48..56].fill(0);
        hello[48] = 1;
        hello[64..184].fill(0);
        let now = u64::from(count) * 1_000;
        pair.host.receive(now, STRANGER, &mut hello, |to, bytes| answers.push((to, bytes.len())));
    }
    assert_eq!((pair.host.lines_called(), pair.host.clients(), pair.host.counts.refused), (0, 0, 4_000));
    assert_eq!(answers, [(STRANGER, 200); 4]);
    let news: Vec<String> = (0..4_000_000).step_by(8_000).filter_map(|now| pair.host.news(now)).collect();
    assert!(news.len() == 1 && news[0].starts_with("666 holds another key"), "{news:?}");
}

/// A link is made from fresh randomness, and its first multiplication with it: ten thousand hellos of a second without a line's key bring
/// about no more than the one from which the answer of that second comes.
#[test]
fn greetings_without_a_key_make_no_link() {
    let drawn = Arc::new(AtomicU32::new(0));
    let draws = drawn.clone();
    let entropy = move || {
        draws.fetch_add(1, Ordering::Relaxed);
        [9; Key::LEN]
    };
    let world = *load(TWO_ROOMS.as_ref()).expect("a good world");
    let mut host = Host::new(Key::new([7; 32]), 1, 8, world, None, entropy).expect("a good world");
    for count in 0..10_000_u32 {
        let mut hello = [0x5a; 200];
        hello[..8].copy_from_slice(&[VERSION, 1, 0, 1, (count % 8 + 1) as u8, 0, 0, 0]);
        hello[48..56].fill(0);
        hello[48] = 1;
        hello[64..184].fill(0);
        host.receive(100 * u64::from(count), STRANGER, &mut hello, |_, _| {});
    }
    assert_eq!((host.counts.refused, drawn.load(Ordering::Relaxed)), (10_000, 1));
}
