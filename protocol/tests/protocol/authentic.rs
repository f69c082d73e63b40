//! Datagrams whose tag is right and whose message is none: numbers that are none, lengths, kinds and bits that version 2 does
//! not know. A `Link` never says such things, so they are sealed here by a second implementation ([`crate::format`]).

use haptic_protocol::link::{Error, Link, Stage};
use haptic_protocol::wire::{self, Flow, MAX_DATAGRAM, Message};

use crate::format::{GREETING, Session, hello};
use crate::world::{CLEAN, PERIOD, Rng, World, config};

/// The key of the tests' peers.
const KEY: [u8; 32] = [7; 32];

/// Two engaged peers, everything that was said, and the session as the second implementation makes it of that.
fn overheard(seed: u64) -> (World, [Vec<Vec<u8>>; 2], Session) {
    let mut world = World::new(seed, CLEAN);
    world.log = Some([vec![], vec![]]);
    world.run(300_000);
    assert!(world.is_engaged());
    let log = world.log.take().expect("it was asked for");
    let number = &log[0].last().expect("something was said")[4..8];
    let greetings = |peer: usize| log[peer].iter().filter(|datagram| datagram.len() == GREETING);
    let mut pairs = greetings(0).flat_map(|one| greetings(1).map(move |two| Session::of(&KEY, one, two)));
    let session = pairs.find(|session| session.number == number).expect("two greetings made the session");
    (world, log, session)
}

#[test]
fn the_second_implementation_opens_all_that_was_said() {
    let (_, log, session) = overheard(1);
    let mut kinds = std::collections::BTreeSet::new();
    for datagram in log.iter().flatten().filter(|datagram| datagram[1] == 3) {
        let message = session.open(datagram).expect("of this session");
        assert!(Message::parse(&message).is_ok());
        kinds.insert(message[0]);
        let [_, _, from, to, ..] = datagram[..] else { panic!("a header") };
        let sequence = u64::from_le_bytes(datagram[8..16].try_into().expect("8 bytes"));
        assert_eq!(&session.seal(from, to, sequence, &message), datagram);
    }
    // Flow, probes and replies.
    assert!(kinds.is_superset(&[1, 5, 6].into()), "{kinds:?}");
}

/// Peer 1 of an engaged pair, heard under the session's keys from a peer 2 that says anything.
struct Ear {
    link: Link,
    session: Session,
    now: u64,
    sequence: u64,
}

impl Ear {
    fn new(seed: u64) -> Self {
        let (world, _, session) = overheard(seed);
        let now = world.clock(0);
        let [link, _] = world.links;
        Self { link, session, now, sequence: 1 << 20 }
    }

    fn hear(&mut self, message: &[u8]) -> Result<Option<Message>, Error> {
        self.sequence += 1;
        self.link.receive(self.now, &mut self.session.seal(2, 1, self.sequence, message))
    }
}

fn flow(tick: u32) -> (Flow, [u8; Flow::LEN]) {
    let flow = Flow { engaged: true, tick, position: 0.25, ..Flow::default() };
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
            assert_eq!((ear.link.stage(), ear.link.engagement()), (Stage::Running, 1.0));
            // It was heard, under a number that is spent now.
            let after = ear.link.counts();
            assert_eq!((after.taken, after.refused), (before.taken + 1, before.refused + 1));
            let again = ear.link.receive(ear.now, &mut ear.session.seal(2, 1, ear.sequence, &bytes));
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
    let mut last = 1.0;
    for _ in 0..20 {
        ear.now += PERIOD;
        assert!(ear.hear(&bytes).is_err());
        assert!(ear.link.engagement() <= last);
        last = ear.link.engagement();
    }
    assert_eq!((ear.link.stage(), last), (Stage::Idle, 0.0));
    // From the first word, too: it proves that the keys are there, and engages nobody.
    let mut link = Link::new(config(1, 2, [5; 32])).expect("a good configuration");
    let mut out = [0; MAX_DATAGRAM];
    let called = link.poll(0, &mut out).expect("it calls");
    let answer = hello(&KEY, &out[..called], [9; 16]);
    let session = Session::of(&KEY, &out[..called], &answer);
    assert_eq!(link.receive(0, &mut answer.clone()), Ok(None));
    assert_eq!((link.stage(), link.session_number()), (Stage::Joining, Some(u32::from_le_bytes(session.number))));
    assert!(link.receive(0, &mut session.seal(2, 1, 0, &bytes)).is_err());
    assert_eq!((link.stage(), link.engagement()), (Stage::Idle, 0.0));
}

#[test]
fn any_bytes_under_a_right_tag_are_a_message_of_version_2_or_nothing() {
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
        assert!((0.0..=1.0).contains(&ear.link.engagement()));
        while ear.link.take_event().is_some() {}
        while ear.link.poll(ear.now, &mut [0; MAX_DATAGRAM]).is_some() {}
        ear.now += rng.below(2 * PERIOD);
    }
    assert!((2_000..18_000).contains(&taken), "{taken}");
    // After all that it is as good a link as any.
    let (good, bytes) = flow(9);
    assert_eq!(ear.hear(&bytes), Ok(Some(Message::Flow(good))));
    assert_eq!(ear.link.stage(), Stage::Running);
}
