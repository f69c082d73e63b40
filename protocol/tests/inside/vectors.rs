//! Known answers, made by a second implementation (`vectors.py`, from FORMAT.md and the RFCs alone): another language can talk
//! to this crate.

use x25519_dalek::{X25519_BASEPOINT_BYTES, x25519};

use crate::ends::Ends;
use crate::error::Refusal;
use crate::handshake::Handshake;
use crate::key::Key;
use crate::parameters::{Parameters, Table};
use crate::session::{Counter, EPOCH_BITS, Offer, Says, Session};
use crate::wire::{
    Ask, AxisFlow, Bits, Flow, Greeting, GreetingKind, Header, MAX_DATAGRAM, Message, PeerId, Presence, Probe, Scope,
    Sighting, Topic,
};

const HELLO: &str = concat!(
    "0301010200000000000102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f080706050403020179a6",
    "31eede1bf9c98f12032cdeadd0e7a079398fc786b88cc846ec89af85a51a02000000000000001194c85d0a61fc00e0989f62",
    "0000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000",
    "00000000000000000000000000000000000000000000000000000000000000000000b4c1d0945452472457bae4e4fc1d911a",
);
const FLOW: &str = concat!(
    "03030102e17d26710000000000000000b4fa5fe9e88ed7cebed3acf1557641d09b2628564e481d631b5b93f67571eb36e2ce",
    "4bc5e110a0827ed06c4e6b45309007d5e5e566f3c177e62cac118d7c706ef97fe57f8d8bf49a",
);
const LATER_FLOW: &str = concat!(
    "03030102e17d267103005000000000008d512202b790228885d467c48e0f8cab247da3c4d5bb60944b7b65b81fe5a4c93429",
    "74b58a120806d0f280fd80fa3529dc450897d7805a4fee41423c6e1d9f3296931bcf4eb3b97f",
);
const PROBE_BACK: &str = concat!(
    "03030201e17d26710900000000000000a61ab71298cb90e0bc444a2e70963f7df078d3c49cddb0e291d568804faf233dafd2",
    "b9b50a2a4715e428c352",
);
const PADDED_PROBE: &str = concat!(
    "03030201e17d26710900000000000000a61ab71298cb904cbc444a2e70963f7df078d3c49cddb0e291d56880584b78d18fa7",
    "df9d63643debf25aad183e6f2dbd29022e67840eb59edbc852bc919dba43284d98257ec8bbe9ddcad72d5c57ef1547918e80",
    "4a533443",
);
const LINE_HELLO_TAG: &str = "e9ee4900a4bb55a9eb8d031434d00889";
/// The parts of a world as messages before they are sealed, a line each, in hexadecimal.
const WORLD_PARTS: &str = include_str!("../data/world-parts.txt");
const ASK: &str = concat!(
    "03030201e17d26710a000000000000006cb2e53602056cfc846da2a62558917f9c23947b9f820a48e653f786298604e16277",
    "0dbd721b462554314b14017d1cec370ecee92521ac6247731c224fdb6711d16728187145aa9b78a448d28cc2625183706e15",
);
const PART_MANIFEST: &str = concat!(
    "03030102e17d26710b0000000000000068a7bfafaa98ee026954c83b168ae64f0561495c0b7e3cfd6253bcf7cad53eca3ddb",
    "45d724ba460faaf9e4f07375a4963b61d7fca451d956e6dfa99d",
);
const PART_REGION: &str = concat!(
    "03030102e17d26710c000000000000003b8842ffb45a8d7592426229ae05755ce55a47dfc62230afcf0f78a79e570e99be8a",
    "d646c04cf231dcfa015c22aa0e5ebcb3e9c5887a3fe916c6974bf0c2844f7d1a366e30ceabbcde1220832b0b5f3f",
);
const PART_PAGE: &str = concat!(
    "03030102e17d26710d00000000000000a4980e197d7aa944ca6b391fd170f03fdabb949d61b6ce0afdffc3dcc1a3438e14cf",
    "3d0303e4835a05b9c9db1c41f20f1874a6d2c31754b3d28cdbdcf21938aafdecd8e206d8efe6df7055539a5a5875417669ef",
    "753e6327df319a46a700ddce641f255c394244f7f241e14398a8729029f80795",
);
const PART_OBJECT: &str = concat!(
    "03030102e17d26710e00000000000000780c7688a0acde7d9c5afa833ec2360229987c38182ab3d6c83c0652dd763415b8b8",
    "9a9e7e76e69327c5496f7fff1d9ac59479590475ebae176550dbedb3690e220460afd1b55adf6e4b1c97ac088a2877851462",
    "58a50aad91c220ce1ba6c5b2c0a9a95290c6c9c47211f99cfa7996bf",
);
const PRESENCE: &str = concat!(
    "03030201e17d26710f00000000000000ef3723c4bbea13c0ec96aa486b982c141c1590d4539635f4947a4c52aed30b3264e8",
    "15f2499468fc6fa46d139df3e9f0a64867b83da567db64f69645",
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
    assert_eq!((there.echoed_us(), there.consented_us()), (Some(SEALED_US), None));
}

/// Consent counts from what was known when it was given, and is taken back by whatever is newer and does not give it.
#[test]
fn consent_and_padding() {
    let (mut here, mut there) = (session(2), session(1));
    open(&mut here, &bytes(FLOW)).unwrap();
    let probe = Message::Probe(Probe { sent_us: 123_456_789 });
    let says = Says { consents: true, least: 56 };
    let mut out = [0; MAX_DATAGRAM];
    let len = here.seal(&mut Counter::starting_at(9), SEALED_US, says, &probe, &mut out).unwrap();
    assert_eq!(&out[..len], bytes(PADDED_PROBE));
    let no = [8, 10].map(|sequence| seal(&mut here, sequence, probe));
    assert_eq!(open(&mut there, &out[..len]), Ok((probe, Some(7))));
    assert_eq!(there.consented_us(), Some(SEALED_US));
    open(&mut there, &no[0]).unwrap();
    assert_eq!(there.consented_us(), Some(SEALED_US), "said before");
    open(&mut there, &no[1]).unwrap();
    assert_eq!(there.consented_us(), None);
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
