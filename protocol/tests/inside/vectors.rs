//! Known answers, made by a second implementation (`vectors.py`, from FORMAT.md and the RFCs alone): another language can talk
//! to this crate.

use x25519_dalek::{X25519_BASEPOINT_BYTES, x25519};

use crate::ends::Ends;
use crate::error::Refusal;
use crate::handshake::Handshake;
use crate::key::Key;
use crate::lease::{Want, Word};
use crate::parameters::{Parameters, Table};
use crate::session::{Counter, EPOCH_BITS, Offer, Says, Session};
use crate::wire::{
    Ask, AxisFlow, Bits, Flow, Greeting, GreetingKind, Header, MAX_DATAGRAM, Message, PeerId, Presence, Probe, Scope,
    Sighting, Topic,
};

const HELLO: &str = concat!(
    "0401010200000000000102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f080706050403020179a6",
    "31eede1bf9c98f12032cdeadd0e7a079398fc786b88cc846ec89af85a51a02000000000000001194c85d0a61fc00e0989f62",
    "0000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000",
    "00000000000000000000000000000000000000000000000000000000000000000000ce595a26307cbf84864b211ae63e491c",
);
const FLOW: &str = concat!(
    "040301020e48cc130000000000000000081fc9af296c03421f1fba375a9cfad3b80101232b8908cf4316d2fae4f0bd409c48",
    "3f6721046a01ef3718f15a9ec047dd3780e8c724e19a1aa33fc1866cd6a67d00b1432f0caa8d",
);
const LATER_FLOW: &str = concat!(
    "040301020e48cc130300500000000000c25ac207fe69addb2dd4be050599749226ac3c3995cfbfe6edcf412ae9e1b03eace9",
    "1a79fb81950b648ec250fc4251b2c58044c1e3a9af83f95ea3bb6bd09e06ce976fa5ba2ff610",
);
const PROBE_BACK: &str = concat!(
    "040302010e48cc1309000000000000007f262c1e08c4e2cb888cae0f10b81c851124f6c25c826357bbec1f2a49bf3f0c46db",
    "d0e92788004f7e93d2a8",
);
const PADDED_PROBE: &str = concat!(
    "040302010e48cc1309000000000000007f262c1e08c4e2e7888cae0f10b81c931124f6c25c826357bbec1f2a936026627355",
    "1f3ad48acfd364c77857eea08860244d6f392e5536a77168d3231fb89338d66fe77c4e46cfdd65eb0323a8305d97a7de6c21",
    "6d09c676",
);
const LINE_HELLO_TAG: &str = "6bedd782b76fe1849215468f054a23d9";
/// The parts of a world as messages before they are sealed, a line each, in hexadecimal.
const WORLD_PARTS: &str = include_str!("../data/world-parts.txt");
const ASK: &str = concat!(
    "040302010e48cc130a000000000000001ee96d7d82c4cb85c487fb3291faf0554071569c56dbec0f47d6ce9c552001098b2f",
    "6282270a2dec066df35ab715d773bfadf1a352a1413044b53d7e66b34e65029579d9146fb3e801bd44767c15cd7a5aedec28",
);
const PART_MANIFEST: &str = concat!(
    "040301020e48cc130b000000000000002e6ab5b2b8565d0a32f8c4b30571fc23d630ecc40db4dc5d6b96ec8b9fed8ce196b2",
    "500b9471b24391d161a9aa358f05ad450dc52b7053b07bdc9be5",
);
const PART_REGION: &str = concat!(
    "040301020e48cc130c0000000000000089969710044947f5616a071c4eb0dfae9e97c9fcf0f192cbdd86c74a097d62f08703",
    "5694be99afa629813ff5972dbce2b5c56cd0a31b76514ea905ab85c98c9a78540b96c2a194b5f64ec28dd4fc18a6",
);
const PART_PAGE: &str = concat!(
    "040301020e48cc130d00000000000000844c308511af210aaf1c3cf061a6b3087f8ff2b9ed59f0f499f62a1c0638f810ba2f",
    "8be9e4350b426a6818c081ed3d919cea4ae97a364e4db2247c35374f7cab240ddb868895546a22cf227ecbdf2146d605509f",
    "b5fe045f9b724417e7c8aa402337d1e56cd4b891b22dd37fb8d523fce7530cfc",
);
const PART_OBJECT: &str = concat!(
    "040301020e48cc130e00000000000000581419d7802eb2f9460e63cc5083538122aeac01d1ef7bcdc18c542a95ecb9aaa8de",
    "af68d573089420b2ebbcf7e2f8c5a3d77712eb7761319cddddb01427ba0a610bd7c337ac523c09488a72e14c9c1b70092a86",
    "5b619afd6d171605327af8cec9c46ecfa900492dc72330a3c3eed7ce",
);
const PRESENCE: &str = concat!(
    "040302010e48cc130f000000000000001c294ac40b1332f1132aad36572d600f59bb0fce112194132c200ca0bb06981ad316",
    "bb515aac6bfc4508db8aafbd2c2d53fade97ba9c8b34c8ed0585",
);

fn bytes(hex: &str) -> Vec<u8> {
    (0..hex.len()).step_by(2).map(|at| u8::from_str_radix(&hex[at..at + 2], 16).unwrap()).collect()
}

fn ends(local: u8) -> Ends {
    Ends { local: PeerId(local), remote: PeerId(3 - local) }
}

/// Of a peer's ephemeral.
fn secret(peer: u8) -> [u8; 32] {
    std::array::from_fn(|at| at as u8 + 0x40 * peer)
}

fn offer(peer: u8) -> Offer {
    let ephemeral = x25519(secret(peer), X25519_BASEPOINT_BYTES);
    Offer { ephemeral, incarnation: 0x0102_0304_0506_0708 + u64::from(peer - 1) * 0x1010_1010_1010_1010 }
}

fn parameters() -> Parameters {
    let mut parameters = Parameters::new();
    parameters.add(Table::new("timing").number("control_period_s", 0.001).number("ticks_per_packet", 8.0)).unwrap();
    parameters.add(Table::new("coordination").text("comm", "wave").flag("one_sided", true)).unwrap();
    parameters
}

fn handshake(local: u8) -> Handshake {
    Handshake::new(Key::new([7; 32]), ends(local), parameters(), &Key::new([1; 32]))
}

fn greeting() -> Greeting {
    handshake(2).open(&bytes(HELLO)).unwrap()
}

fn session(local: u8) -> Session {
    let greeting = greeting();
    let agreed = (greeting.count, greeting.tables);
    let secret = Key::new(x25519(secret(local), offer(3 - local).ephemeral));
    Session::new(&Key::new([7; 32]), ends(local), [offer(local), offer(3 - local)], &secret, &agreed, 1)
}

fn flow() -> Message {
    Message::Flow(Flow {
        engaged: true,
        fading: false,
        tick: 4711,
        axes: [AxisFlow {
            position: 0.25,
            velocity: -0.5,
            wave: 1.5,
            wave_integral: 2.0,
            energy_sent: 3.0,
            live_ticks: 4712,
        }],
    })
}

/// When everything is sealed, µs.
const SEALED_US: u64 = 1_000_000;

fn seal(session: &mut Session, sequence: u64, message: Message) -> Vec<u8> {
    let mut out = [0; MAX_DATAGRAM];
    let len =
        session.seal(&mut Counter::starting_at(sequence), SEALED_US, Says::default(), &message, &mut out).unwrap();
    out[..len].to_vec()
}

/// What is in it and how old that is 7 µs later.
fn open(session: &mut Session, datagram: &[u8]) -> Result<(Message, Option<u64>), Refusal> {
    let mut datagram = datagram.to_vec();
    let (header, head, sealed) = Header::parse(&mut datagram).unwrap();
    let opened = session.open(SEALED_US + 7, &header, head, sealed)?;
    Ok((Message::parse(opened.message).unwrap(), opened.age_us))
}

/// Seals `message` at `local` as number `sequence`, and opens it at the other end.
fn sealed(local: u8, sequence: u64, message: Message) -> Vec<u8> {
    let (mut here, mut there) = (session(local), session(3 - local));
    let datagram = seal(&mut here, sequence, message);
    assert_eq!(open(&mut there, &datagram), Ok((message, None)));
    datagram
}

#[test]
fn a_hello_with_its_tables_and_tag() {
    let greeting = greeting();
    assert_eq!((greeting.kind, greeting.from, greeting.to), (GreetingKind::Hello, PeerId(1), PeerId(2)));
    let challenge = |peer: u8| std::array::from_fn(|at| at as u8 + 16 * (peer - 1));
    assert_eq!((greeting.challenge, greeting.echo), (challenge(1), challenge(2)));
    assert_eq!(greeting.ephemeral, offer(1).ephemeral);
    assert_eq!(greeting.incarnation, offer(1).incarnation);
    // The tables were hashed there and here: nothing differs, so there is a session to be had.
    assert!(handshake(2).accept(0, &greeting).is_ok());
    assert_eq!(greeting.count, 2);
    assert_eq!(handshake(1).open(&bytes(HELLO)).map(|_| ()), Err(Refusal::OwnNumber));
}

#[test]
fn sealed_messages_of_both_directions_and_later_epochs() {
    assert_eq!(sealed(1, 0, flow()), bytes(FLOW));
    assert_eq!(sealed(1, (5 << 20) + 3, flow()), bytes(LATER_FLOW));
    // What was opened before is echoed, and tells the other end how old the answer is.
    let (mut here, mut there) = (session(2), session(1));
    assert_eq!(open(&mut here, &bytes(FLOW)), Ok((flow(), None)));
    let probe = Message::Probe(Probe { sent_us: 123_456_789 });
    let back = seal(&mut here, 9, probe);
    assert_eq!(back, bytes(PROBE_BACK));
    assert_eq!(open(&mut there, &back), Ok((probe, Some(7))));
    assert_eq!(there.heard(), Some((0, Some(SEALED_US))));
}

/// The newest datagram says what holds, and counts from the time that it echoes.
#[test]
fn a_word_of_the_lease_and_padding() {
    let (mut here, mut there) = (session(2), session(1));
    open(&mut here, &bytes(FLOW)).unwrap();
    let probe = Message::Probe(Probe { sent_us: 123_456_789 });
    let word = Word::of_byte(5 << 2 | 2);
    let says = Says { lease: word.byte(), least: 56, is_eager: true };
    let mut out = [0; MAX_DATAGRAM];
    let len = here.seal(&mut Counter::starting_at(9), SEALED_US, says, &probe, &mut out).unwrap();
    assert_eq!(&out[..len], bytes(PADDED_PROBE));
    let others = [8, 10].map(|sequence| seal(&mut here, sequence, probe));
    assert_eq!(open(&mut there, &out[..len]), Ok((probe, Some(7))));
    assert_eq!((word.want, there.heard()), (Want::Run, Some((word.byte(), Some(SEALED_US)))));
    open(&mut there, &others[0]).unwrap();
    assert_eq!(there.heard(), Some((word.byte(), Some(SEALED_US))), "said before");
    open(&mut there, &others[1]).unwrap();
    assert_eq!(there.heard(), Some((0, Some(SEALED_US))));
}

#[test]
fn keys_move_on_and_a_reordered_datagram_of_the_last_epoch_is_still_opened() {
    let (mut here, mut there) = (session(1), session(2));
    let mut counter = Counter::starting_at((1 << EPOCH_BITS) - 20);
    let mut datagrams = (0..40)
        .map(|_| {
            let mut out = [0; MAX_DATAGRAM];
            let len = here.seal(&mut counter, SEALED_US, Says::default(), &flow(), &mut out).unwrap();
            out[..len].to_vec()
        })
        .collect::<Vec<_>>();
    // The middle of the key's life and the next one's, alternating.
    let (first, second) = datagrams.split_at_mut(20);
    for (old, new) in first.iter_mut().zip(second) {
        for datagram in [new, old] {
            assert_eq!(open(&mut there, datagram), Ok((flow(), None)));
        }
    }
    assert_eq!((there.taken(), there.missing()), (40, 0));
    // A forgery from an epoch far away moves nothing.
    let mut forged = bytes(LATER_FLOW);
    *forged.last_mut().unwrap() ^= 1;
    assert_eq!(open(&mut there, &forged), Err(Refusal::Forged));
    let mut out = [0; MAX_DATAGRAM];
    let len = here.seal(&mut counter, SEALED_US, Says::default(), &flow(), &mut out).unwrap();
    assert!(open(&mut there, &out[..len]).is_ok());
}

#[test]
fn the_last_sequence_number_is_the_last() {
    let mut counter = Counter::starting_at(crate::replay::SEQUENCE_LIMIT - 1);
    assert!(counter.draw().is_ok());
    for _ in 0..3 {
        assert_eq!(counter.draw(), Err(Refusal::Exhausted));
    }
    let mut out = [0; MAX_DATAGRAM];
    assert_eq!(session(1).seal(&mut counter, SEALED_US, Says::default(), &flow(), &mut out), Err(Refusal::Exhausted));
}

#[test]
fn a_buffer_that_is_too_short_is_an_error() {
    for len in 0..88 {
        let mut out = vec![0; len];
        assert!(
            session(1).seal(&mut Counter::default(), SEALED_US, Says::default(), &flow(), &mut out).is_err(),
            "{len}"
        );
    }
    for len in 0..200 {
        assert!(handshake(1).greet(0, GreetingKind::Hello, [0; 16], &mut vec![0; len]).is_err(), "{len}");
    }
}

#[test]
fn a_hello_on_a_line_of_a_server() {
    let mut handshake = Handshake::new(Key::new([7; 32]).line(300), ends(2), parameters(), &Key::new([1; 32]));
    handshake.set_line(300);
    let mut hello = bytes(HELLO);
    hello[4..8].copy_from_slice(&300_u32.to_le_bytes());
    assert_eq!(handshake.open(&hello).map(|_| ()), Err(Refusal::ForgedGreeting));
    hello[184..].copy_from_slice(&bytes(LINE_HELLO_TAG));
    assert_eq!(handshake.open(&hello).unwrap().line, 300);
}

#[test]
fn the_messages_that_carry_a_world() {
    let mut wanted = Bits::default();
    wanted.set(0);
    let ask =
        Ask { topic: Topic::Object, scope: Scope::Around { x: 1.0, y: -2.0, radius: 3.0 }, tag: 8, wanted, first: 0 };
    assert_eq!(sealed(2, 10, Message::Ask(ask)), bytes(ASK));
    let expected = [PART_MANIFEST, PART_REGION, PART_PAGE, PART_OBJECT];
    for ((sequence, part), expected) in (11..).zip(WORLD_PARTS.lines()).zip(expected) {
        let part = Message::parse(&bytes(part)).unwrap();
        assert_eq!(sealed(1, sequence, part), bytes(expected), "{part:?}");
    }
    let sighting = Sighting { who: 300, position: [0.5, -0.5], velocity: [1.5, -1.5] };
    assert_eq!(sealed(2, 15, Message::Presence(Presence::new(77, [sighting]))), bytes(PRESENCE));
}
