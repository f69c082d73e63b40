//! A server and strangers: what is not from its clients gets nothing, changes nothing and takes no memory to speak of.

use haptic_core::num::Motion;
use haptic_protocol::key::Key;
use haptic_protocol::wire::{Header, VERSION};
use host_sim::shared::world::host::{Host, MOST_LINES};
use host_sim::shared::world::load;
use host_sim::shared::world::visitor::{Setup, Visitor};

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
        let mut drawn = 0;
        let entropy = move || {
            drawn += 1;
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
                let server = host_sim::shared::world::visitor::Party::Server(1);
                self.visitor.receive(self.now, server, &mut answer, |_, bytes| said.push(bytes.to_vec()));
            }
        }
        let mut told = vec![];
        self.host.tick(self.now, |to, _| told.push(to));
        told
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
    let told: Vec<u32> = (0..200).flat_map(|_| pair.period()).collect();
    assert!(told.iter().all(|to| *to == CLIENT));
    assert_eq!(pair.host.clients(), 1);
    assert!(pair.visitor.is_complete());
}

#[test]
fn anything_at_all_from_anybody() {
    let mut pair = Pair::new();
    for _ in 0..20 {
        pair.period();
    }
    let mut random = 1_u64;
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
        pair.host.receive(pair.now, STRANGER, &mut bytes, |_, _| panic!("an answer to a stranger"));
    }
    assert_eq!(pair.host.counts.refused, 20_000);
    assert_eq!((pair.host.clients(), pair.period()), (1, vec![]));
}

#[test]
fn a_server_has_as_many_lines_as_it_was_told() {
    let world = *load(TWO_ROOMS.as_ref()).expect("a good world");
    for lines in [0, MOST_LINES + 1] {
        let error = Host::<u32>::new(Key::new([7; 32]), 1, lines, world.clone(), None, || [1; 32]).err();
        assert_eq!(error, Some(format!("lines = {lines} is not allowed: it must be from 1 to 4096")));
    }
}
