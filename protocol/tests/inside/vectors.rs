//! Known answers, made by a second implementation (`vectors.py`, from FORMAT.md and the RFCs alone): another language can talk
//! to this crate.

use x25519_dalek::{X25519_BASEPOINT_BYTES, x25519};

use crate::ends::Ends;
use crate::error::Refusal;
use crate::handshake::Handshake;
use crate::key::Key;
use crate::parameters::{Parameters, Table};
use crate::session::{Counter, EPOCH_BITS, Offer, Session};
use crate::wire::{
    Ask, AxisFlow, Bits, Flow, Greeting, GreetingKind, Header, MAX_DATAGRAM, Message, PeerId, Presence, Probe, Scope,
    Sighting, Topic,
};

const HELLO: &str = concat!(
    "0201010200000000000102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f080706050403020179a6",
    "31eede1bf9c98f12032cdeadd0e7a079398fc786b88cc846ec89af85a51a02000000000000001194c85d0a61fc00e0989f62",
    "0000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000",
    "000000000000000000000000000000000000000000000000000000000000000000003a84991c097de4b5214f39744639c466",
);
const FLOW: &str = concat!(
    "0203010258e90d6500000000000000004e3e4c7c8d2be8263330ad03bfe20e46a4e76d28ca93650e671a28e591b9adc01c22",
    "ee40c05bb66f901db298666b10f160cb662dbb0831de1e9544252298f4a8f0edb128acdfdd7b",
);
const LATER_FLOW: &str = concat!(
    "0203010258e90d6503005000000000002e92a2feba8b57a9569529516be1fc23eb2ae372a77445267d504763382c2a02dbf8",
    "605b8c90a948fec3df4ece72ceca1708d838c2656b29e47f907ab578f307106e44129f9c81d4",
);
const PROBE_BACK: &str = concat!(
    "0203020158e90d6509000000000000003a9b6a256d04743f0bfd1d1778b3453b7a14b9bff0d7b3527de7295734a6096a5b75",
    "02343982fe23444c19bd",
);
const LINE_HELLO_TAG: &str = "db924f5af6e942c8d0eed61132dff7bf";
/// The parts of a world as messages before they are sealed, a line each, in hexadecimal.
const WORLD_PARTS: &str = include_str!("../data/world-parts.txt");
const ASK: &str = concat!(
    "0203020158e90d650a00000000000000df7fcfdfff78ea0e0d5b9c5cd9f0e4c1c5954505302be9d32d9bdb5b351f8c06a9ee",
    "c721dc336844a28bd85fafd1a63c8d4ab1beab83e05c872c3b10a2bf50735695d8106ed8a4aace143060987ebfeb53a45edc",
);
const PART_MANIFEST: &str = concat!(
    "0203010258e90d650b00000000000000bb4c7009909836daaafede8eb9911d88a1fad30edabe430ff3a13138542961135759",
    "b68838264e0f0634054525649157215982ce8f774dd61180b62c",
);
const PART_REGION: &str = concat!(
    "0203010258e90d650c00000000000000031e33586224d2696ca549bd7192b204702229e855d1c18f93e162955afce6067ccb",
    "878d9a0e95f3b6668b46bcbf8f1b2ec663138501878f74587ee2acbdd849a57d123cc1a020c33554137fbaee7983",
);
const PART_PAGE: &str = concat!(
    "0203010258e90d650d00000000000000fe21e3bbaa7b7b4b6021376ced85d379fe382908e70a12081fac287cace2b7b7c62c",
    "46da7f109b6d7a7e59cb093943ac4f50c22f157b61e7c23c5c2198d72ae53367b850b4c2ca74febdaec0fa8fff85441ac1b6",
    "630e10e941e5d9f6aa0edc301d13787b3b9258230901b763b0e89e7f1e473fff",
);
const PART_OBJECT: &str = concat!(
    "0203010258e90d650e000000000000004e70de358ec372d6e0bb3df9b02a1ef18f81d2d723ddb128563fd2653bde909bd320",
    "5103c516d414b240f3b912ffa489c92d19adb6771c8a7dca8a87bff917d5eb34d0931369ed9ffb0c54101b7008db6f4f14f4",
    "9ca3a532897ab11211f505cf08969aaa01003138be544f041f662b76",
);
const PRESENCE: &str = concat!(
    "0203020158e90d650f0000000000000062c62f8eae0dec4a1714019a0a9634211f288ed67d00b5aaeabad3571aa68bf7db5f",
    "146b9b9e5ff875575851a78d3de30cb50b265e5d8eaab12829c9",
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
    let len = session.seal(&mut Counter::starting_at(sequence), SEALED_US, &message, &mut out).unwrap();
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
}

#[test]
fn keys_move_on_and_a_reordered_datagram_of_the_last_epoch_is_still_opened() {
    let (mut here, mut there) = (session(1), session(2));
    let mut counter = Counter::starting_at((1 << EPOCH_BITS) - 20);
    let mut datagrams = (0..40)
        .map(|_| {
            let mut out = [0; MAX_DATAGRAM];
            let len = here.seal(&mut counter, SEALED_US, &flow(), &mut out).unwrap();
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
    let len = here.seal(&mut counter, SEALED_US, &flow(), &mut out).unwrap();
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
    assert_eq!(session(1).seal(&mut counter, SEALED_US, &flow(), &mut out), Err(Refusal::Exhausted));
}

#[test]
fn a_buffer_that_is_too_short_is_an_error() {
    for len in 0..88 {
        let mut out = vec![0; len];
        assert!(session(1).seal(&mut Counter::default(), SEALED_US, &flow(), &mut out).is_err(), "{len}");
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
