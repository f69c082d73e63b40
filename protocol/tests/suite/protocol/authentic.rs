//! Datagrams whose tag is right and whose message is none: numbers that are none, lengths, kinds and bits that version 4 does
//! not know. A `Link` never says such things, so they are sealed here by a second implementation ([`crate::protocol::format`]).

use cohold_protocol::link::{Error, Link, Stage};
use cohold_protocol::wire::{self, AxisFlow, Flow, MAX_DATAGRAM, Message};

use crate::protocol::format::{GREETING, Session, hello, hello_with};
use crate::protocol::world::{CLEAN, PERIOD, Rng, World, config};

/// The key of the tests' peers.
const KEY: [u8; 32] = [7; 32];

/// The second implementation's ephemeral secret.
const SECRET: [u8; 32] = [9; 32];

/// Peer 1 of an engaged pair, heard under the session's keys from a peer 2 that says anything.
struct Ear {
    link: Link,
    session: Session,
    now: u64,
    sequence: u64,
    /// The newest time of the link's clock that peer 2 has opened.
    echo_us: u64,
    /// Every sealed datagram of the link's.
    said: Vec<Vec<u8>>,
}

impl Ear {
    /// A link in its first life, called by the second implementation.
    fn joining(entropy: u8) -> Self {
        let mut link = Link::new(config(1, 2, [entropy; 32])).expect("a good configuration");
        let mut out = [0; MAX_DATAGRAM];
        let called = link.poll(0, &mut out).expect("it calls");
        let answer = hello(&KEY, &out[..called], SECRET);
        let session = Session::of(&KEY, &out[..called], &answer, SECRET);
        assert_eq!(link.receive(0, &mut answer.clone()), Ok(None));
        assert_eq!((link.stage(), link.session_number()), (Stage::Joining, Some(u32::from_le_bytes(session.number))));
        Self { link, session, now: 0, sequence: 1 << 20, echo_us: 0, said: Vec::new() }
    }

    /// Engaged, by flow of 20 packet periods.
    fn new(entropy: u8) -> Self {
        let mut ear = Self::joining(entropy);
        for tick in 0..20 {
            ear.now += PERIOD;
            ear.listen();
            let _ = ear.hear(&flow(tick).1);
        }
        assert_eq!(ear.link.stage(), Stage::Running);
        ear
    }

    /// Takes in what the link says.
    fn listen(&mut self) {
        let mut out = [0; MAX_DATAGRAM];
        while let Some(len) = self.link.poll(self.now, &mut out) {
            if let Some(([at_us, _], _)) = self.session.open(&out[..len]) {
                self.echo_us = at_us;
                self.said.push(out[..len].to_vec());
            }
        }
    }

    fn sealed(&self, message: &[u8]) -> Vec<u8> {
        self.session.seal(2, 1, self.sequence, [1 + self.now, self.echo_us], message)
    }

    fn hear(&mut self, message: &[u8]) -> Result<Option<Message>, Error> {
        self.listen();
        self.sequence += 1;
        let mut sealed = self.sealed(message);
        self.link.receive(self.now, &mut sealed)
    }
}

#[test]
fn the_second_implementation_opens_all_that_was_said() {
    let mut ear = Ear::new(1);
    // Probes of its own are answered.
    for _ in 0..20 {
        ear.now += PERIOD;
        ear.hear(&[&[5, 0, 0, 0][..], &ear.now.to_le_bytes()].concat()).expect("a probe");
        let mut out = [0; MAX_DATAGRAM];
        let len = ear.link.send(ear.now, flow(1).0, &mut out).expect("a session");
        ear.said.push(out[..len].to_vec());
    }
    ear.listen();
    let mut kinds = std::collections::BTreeSet::new();
    for datagram in &ear.said {
        let (stamps, message) = ear.session.open(datagram).expect("of this session");
        assert!(Message::parse(&message).is_ok());
        kinds.insert(message[0]);
        let [_, _, from, to, ..] = datagram[..] else { panic!("a header") };
        let sequence = u64::from_le_bytes(datagram[8..16].try_into().expect("8 bytes"));
        assert_eq!(&ear.session.seal(from, to, sequence, stamps, &message), datagram);
    }
    // Flow, probes and replies.
    assert!(kinds.is_superset(&[1, 5, 6].into()), "{kinds:?}");
}

/// Whoever gets the shared key later reads nothing of what was recorded: the ephemerals' secrets are gone.
#[test]
fn the_shared_key_alone_opens_no_recording() {
    let mut world = World::new(1, CLEAN);
    world.log = Some([vec![], vec![]]);
    world.run(300_000);
    assert!(world.is_engaged());
    let log = world.log.take().expect("it was asked for");
    let greetings = |peer: usize| log[peer].iter().filter(|datagram| datagram.len() == GREETING);
    for (one, two) in greetings(0).flat_map(|one| greetings(1).map(move |two| (one, two))) {
        for secret in [[0; 32], [7; 32], SECRET] {
            let session = Session::of(&KEY, one, two, secret);
            assert!(log.iter().flatten().all(|datagram| session.open(datagram).is_none()));
        }
    }
}

#[test]
fn an_ephemeral_that_leads_to_no_secret_is_refused() {
    for weak in [[0; 32], core::array::from_fn(|at| u8::from(at == 0))] {
        let mut link = Link::new(config(1, 2, [5; 32])).expect("a good configuration");
        let mut out = [0; MAX_DATAGRAM];
        let called = link.poll(0, &mut out).expect("it calls");
        let answer = hello_with(&KEY, &out[..called], weak);
        assert_eq!(link.receive(0, &mut answer.clone()), Err(Error::WeakEphemeral));
        assert_eq!(link.stage(), Stage::Calling);
    }
}

/// Every greeting is authentic and echoes what was offered now, and each has another ephemeral.
#[test]
fn greetings_bring_about_a_multiplication_every_50_ms_and_no_more() {
    let mut link = Link::new(config(1, 2, [5; 32])).expect("a good configuration");
    let mut out = [0; MAX_DATAGRAM];
    let (mut taken, mut hurried) = (0, 0);
    for now in (0..1_000_000).step_by(1_000) {
        let Some(called) = link.poll(now, &mut out).filter(|len| *len == GREETING) else { continue };
        for nth in 0..10 {
            let secret = core::array::from_fn(|at| if at == 3 { nth } else { ((now / 1_000) >> (8 * (at % 2))) as u8 });
            match link.receive(now, &mut hello(&KEY, &out[..called], secret)) {
                Ok(None) => taken += 1,
                Err(Error::Hurried) => hurried += 1,
                other => panic!("{other:?}"),
            }
        }
    }
    assert!((10..=20).contains(&taken) && hurried > 100, "{taken} taken, {hurried} too soon");
}

fn flow(tick: u32) -> (Flow, [u8; Flow::LEN]) {
    let flow =
        Flow { engaged: true, tick, axes: [AxisFlow { position: 0.25, ..AxisFlow::default() }], ..Flow::default() };
    let mut bytes = [0; Flow::LEN];
    flow.emit(&mut bytes).expect("finite numbers");
    (flow, bytes)
}

#[test]
fn a_number_that_is_none_is_refused_and_the_coordination_goes_on() {
    let mut ear = Ear::new(2);
    let (good, bytes) = flow(9);
    for (at, len) in [(8, 4), (12, 4), (16, 4), (20, 8), (28, 8)] {
        for number in [f64::NAN, -f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let before = ear.link.counts();
            let mut broken = bytes;
            match len {
                4 => broken[at..at + 4].copy_from_slice(&(number as f32).to_le_bytes()),
                _ => broken[at..at + 8].copy_from_slice(&number.to_le_bytes()),
            }
            assert_eq!(ear.hear(&broken), Err(Error::Wire(wire::Error::NotFinite("flow"))), "byte {at}");
            assert_eq!(ear.link.stage(), Stage::Running);
            // It was heard, under a number that is spent now.
            let after = ear.link.counts();
            assert_eq!((after.taken, after.refused), (before.taken + 1, before.refused + 1));
            let mut again = ear.sealed(&bytes);
            let again = ear.link.receive(ear.now, &mut again);
            assert_eq!(again, Err(Error::Replayed));
            // And the next flow is as good as ever.
            assert_eq!(ear.hear(&bytes), Ok(Some(Message::Flow(good))));
        }
    }
}

#[test]
fn a_peer_that_says_nothing_else_is_there_and_coordinates_nothing() {
    let mut ear = Ear::new(3);
    let (_, mut bytes) = flow(9);
    bytes[16..20].copy_from_slice(&f32::NAN.to_le_bytes());
    for _ in 0..20 {
        ear.now += PERIOD;
        assert!(ear.hear(&bytes).is_err());
    }
    assert_eq!(ear.link.stage(), Stage::Idle);
    // From the first word, too: it proves that the keys are there, once it answers, and engages nobody.
    let mut ear = Ear::joining(5);
    let mut sealed = ear.sealed(&bytes);
    assert_eq!(ear.link.receive(0, &mut sealed), Err(Error::Wire(wire::Error::NotFinite("flow"))));
    assert_eq!(ear.link.stage(), Stage::Joining, "it has answered nothing");
    ear.now = 1;
    assert!(ear.hear(&bytes).is_err());
    assert_eq!(ear.link.stage(), Stage::Idle);
}

#[test]
fn any_bytes_under_a_right_tag_are_a_message_of_this_version_or_nothing() {
    let mut ear = Ear::new(4);
    let mut rng = Rng(5);
    let mut taken = 0;
    for round in 0..20_000 {
        let mut message: Vec<u8> = (0..rng.below(169)).map(|_| rng.next() as u8).collect();
        // Half of them begin like a message, a quarter are one but for a bit.
        if let Some(first) = message.first_mut().filter(|_| round % 2 == 0) {
            *first = [1, 2, 3, 4, 5, 6, 9, 16, 17, 18, 19, 20][rng.below(12) as usize];
        }
        if round % 4 == 0 {
            message = flow(round).1.to_vec();
            message[rng.below(40) as usize] ^= 1 << rng.below(8);
        }
        let read = Message::parse(&message);
        taken += u32::from(read.is_ok());
        assert_eq!(ear.hear(&message).map(|_| ()), read.map(|_| ()).map_err(Error::Wire), "{message:?}");
        while ear.link.take_event().is_some() {}
        ear.listen();
        ear.now += rng.below(2 * PERIOD);
    }
    assert!((2_000..18_000).contains(&taken), "{taken}");
    // After all that it is as good a link as any.
    let (good, bytes) = flow(9);
    assert_eq!(ear.hear(&bytes), Ok(Some(Message::Flow(good))));
    assert_eq!(ear.link.stage(), Stage::Running);
}
