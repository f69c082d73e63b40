//! Every message comes back as it was, has one encoding only, and no decoder is surprised by anything.

use cohold_environments::roles::Carried as _;
use cohold_environments::roles::collaborative::ring;
use cohold_environments::roles::collaborative::ring::{Ballot, Kept, Roster, State};
use cohold_environments::roles::squash;
use cohold_environments::roles::squash::{Ball, Ending, Game, Phase, Turn, Verdict};
use cohold_environments::{roles::collaborative::lock, roles::collaborative::lock::Copy};
use cohold_environments::{roles::cooperative, roles::cooperative::Body};
use cohold_protocol::wire::{Error, Event, PeerId};
use proptest::prelude::*;

pub(crate) fn locks() -> impl Strategy<Value = lock::Message> {
    any::<([u32; 4], [u8; 24], bool)>().prop_flat_map(|([one, two, three, four], value, flag)| {
        prop_oneof![
            Just(lock::Message::Follow { known: one }),
            Just(lock::Message::Ask { incarnation: one, number: two, known: three }),
            Just(lock::Message::Release { fence: one, value: flag.then_some(value) }),
            Just(lock::Message::Grant {
                incarnation: one,
                number: two,
                fence: three,
                copy: Copy { version: four, value }
            }),
            Just(lock::Message::State { copy: Copy { version: one, value } }),
            Just(lock::Message::Answer { fence: one, taken: flag }),
        ]
    })
}

pub(crate) fn rings() -> impl Strategy<Value = ring::Message> {
    any::<([u32; 4], [u16; 2], [u8; 24], [bool; 2])>().prop_flat_map(
        |([epoch, turn, version, number], rosters, value, [wants, leaves])| {
            let ballot = Ballot { epoch, turn };
            let [roster, before] = rosters.map(|seats| Roster::of((0..16).filter(move |seat| seats >> seat & 1 == 1)));
            let kept = Kept { ballot, state: State { version, roster, before, value } };
            prop_oneof![
                Just(ring::Message::Hold { kept, number }),
                Just(ring::Message::Held { ballot, version, number, wants, leaves }),
                Just(ring::Message::Pass { kept }),
                Just(ring::Message::Elect { epoch }),
                Just(ring::Message::Vote { epoch: number, kept }),
                Just(ring::Message::Newer { epoch }),
                Just(ring::Message::Join),
                Just(ring::Message::Leave),
            ]
        },
    )
}

pub(crate) fn squashes() -> impl Strategy<Value = squash::Message> {
    let finite = || any::<f32>().prop_filter("finite", |number| number.is_finite());
    (any::<([u16; 4], [u32; 2], [u64; 3], [u8; 17])>(), prop::array::uniform4(finite()), 0..3_usize, 0..5_usize)
        .prop_flat_map(
            |(
                ([rally, stroke, revision, life], [number, round_trip_us], [sent_us, received_us, answered_us], bytes),
                [x, y, vx, vy],
                phase,
                ending,
            )| {
                let turn = Turn { rally, stroke };
                let ball = Ball { position: [x, y], velocity: [vx, vy] };
                let phase = [Phase::Waiting, Phase::Rally, Phase::Over][phase];
                let ending = [Ending::None, Ending::Missed, Ending::Fault, Ending::Unseen, Ending::Broken][ending];
                let game = Game {
                    phase,
                    rally,
                    revision,
                    players: std::array::from_fn(|at| PeerId(bytes[at])),
                    round_trip_us,
                    last: Verdict { rally: life, strokes: stroke, ending, loser: PeerId(bytes[16]) },
                    score: std::array::from_fn(|at| bytes[8 + at]),
                };
                prop_oneof![
                    Just(squash::Message::Join),
                    Just(squash::Message::Leave),
                    Just(squash::Message::Game { game }),
                    Just(squash::Message::Place { turn, revision, life, number, round_trip_us, racket: ball }),
                    Just(squash::Message::Hit { turn, at_us: sent_us, ball }),
                    Just(squash::Message::Miss { turn, ending }),
                    Just(squash::Message::Ping { number, sent_us }),
                    Just(squash::Message::Pong { number, sent_us, received_us, answered_us }),
                ]
            },
        )
}

proptest! {
    #[test]
    fn there_and_back(object: u16, lock in locks(), ring in rings(), squash in squashes()) {
        prop_assert_eq!(squash::Message::parse(&squash.event(object).unwrap()), Ok((0, squash)));
        prop_assert_eq!(lock::Message::parse(&lock.event(object).unwrap()), Ok((object, lock)));
        prop_assert_eq!(ring::Message::parse(&ring.event(object).unwrap()), Ok((object, ring)));
    }

    #[test]
    fn one_encoding_only(own in any::<bool>(), kind in 0..10_u8, flag in 0..5_u8, rest in prop::collection::vec(any::<u8>(), 0..47)) {
        let mut bytes = vec![kind, flag];
        bytes.extend(rest);
        let code = |code| if own { code } else { code ^ 1 };
        let event = Event::new(code(lock::Message::CODE), &bytes[..bytes.len().min(48)]).unwrap();
        if let Ok((object, message)) = lock::Message::parse(&event) {
            prop_assert!(own);
            prop_assert_eq!(message.event(object).unwrap(), event);
        }
        let event = Event::new(code(squash::Message::CODE), &bytes[..bytes.len().min(48)]).unwrap();
        if let Ok((object, message)) = squash::Message::parse(&event) {
            prop_assert_eq!(message.event(object).unwrap(), event);
        }
        let event = Event::new(code(ring::Message::CODE), &bytes[..bytes.len().min(48)]).unwrap();
        if let Ok((object, message)) = ring::Message::parse(&event) {
            prop_assert_eq!(message.event(object).unwrap(), event);
        }
    }
}

#[test]
fn literal_bytes() {
    let release = lock::Message::Release { fence: 0x0102_0304, value: None };
    assert_eq!(release.event(0x0506).unwrap().payload(), [3, 0, 6, 5, 4, 3, 2, 1]);
    let held = ring::Message::Held {
        ballot: Ballot { epoch: 0x11, turn: 2 },
        version: 3,
        number: 4,
        wants: true,
        leaves: false,
    };
    assert_eq!(held.event(1).unwrap().payload(), [2, 1, 1, 0, 0x11, 0, 0, 0, 2, 0, 0, 0, 3, 0, 0, 0, 4, 0, 0, 0]);
}

#[test]
fn an_engine_that_is_handed_over() {
    use cooperative::Message;
    let renew = Message::Renew { version: 7, stamp_us: 0x0a0b }.event(0x0102).unwrap();
    assert_eq!(renew.code, 0x0201);
    assert_eq!(renew.payload(), [3, 0, 2, 1, 7, 0, 0, 0, 0x0b, 0x0a, 0, 0, 0, 0, 0, 0]);
    let at = Body { axes: [[1.0, -0.5], [0.25, 0.0]] };
    for message in [
        Message::Ask { stamp_us: u64::MAX },
        Message::Lend { version: 1, stamp_us: 2, body: at },
        Message::Renew { version: u32::MAX, stamp_us: 0 },
        Message::Renewed { version: 3, stamp_us: 4 },
        Message::Recall { version: 5 },
        Message::Return { version: 6, body: at },
        Message::Taken { version: 7 },
    ] {
        assert_eq!(Message::parse(&message.event(9).unwrap()), Ok((9, message)));
    }
    let said = Message::Return { version: 6, body: at }.event(0).unwrap();
    let bytes = said.payload();
    let heard = |bytes: &[u8]| Message::parse(&Event::new(Message::CODE, bytes).unwrap());
    for len in 0..bytes.len() {
        assert!(heard(&bytes[..len]).is_err());
    }
    assert!(heard(&[bytes, &[0]].concat()).is_err());
    for (at, with) in [(0, 0), (0, 8), (1, 1)] {
        let mut broken = bytes.to_vec();
        broken[at] = with;
        assert!(heard(&broken).is_err());
    }
    let mut broken = bytes.to_vec();
    broken[8..16].copy_from_slice(&f64::NAN.to_le_bytes());
    assert_eq!(heard(&broken), Err(Error::NotFinite("cooperative")));
    assert!(Message::parse(&Event::new(lock::Message::CODE, bytes).unwrap()).is_err());
}
