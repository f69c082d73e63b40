//! Known answers, made by a second implementation (`vectors.py`, from FORMAT.md and the RFCs alone): another language can talk
//! to this crate.

use crate::ends::Ends;
use crate::error::Refusal;
use crate::handshake::Handshake;
use crate::key::Key;
use crate::parameters::{Parameters, Table};
use crate::roles::static_scene::Server;
use crate::session::{Counter, EPOCH_BITS, Offer, Session};
use crate::wire::{
    Ask, Bits, Flow, Greeting, GreetingKind, Header, MAX_DATAGRAM, Message, PeerId, Presence, Probe, Sighting, Topic,
};
use crate::world::{Bounds, Database, Object, Region, Scope, Shape, Wall};

const HELLO: &str = concat!(
    "0101010200000000000102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f08070605040302010200",
    "0000000000001194c85d0a6134f6fc00e0989f62d7e800000000000000000000000000000000000000000000000000000000",
    "0000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000",
    "00000000000000000000000000000000000000000000000000000000000000000000071f54d5eed17754a3f25e7cf046f37a",
);
const FLOW: &str = concat!(
    "01030102a787d83500000000000000000cdbce6f390e4693bba6e8068571fe936458141c0d1a82e66adc9b5374e77599d5de",
    "2bd7d62e04fbb9fcf7c828c5ba58375bf5c1",
);
const LATER_FLOW: &str = concat!(
    "01030102a787d8350300500000000000881bf6842abeb176e322c1f706a2aedc8ded862dbc2e9948735f3dcc907a7d6e1f77",
    "522a965ef62f221088d35a95d1034a2be0af",
);
const PROBE_BACK: &str = "01030201a787d8350900000000000000a36a50082dda0344993625d0739e21eceb6068b9d688b9d0964dd276";
const LINE_HELLO_TAG: &str = "8a17e6e279afb1e95233e692b5964735";
const WORLD: &str = "98bb64ccfb8d3313";
const ASK: &str = concat!(
    "01030201a787d8350a0000000000000087b066b6dcc68e8ac49d4f9448a58ea318e5cd9414b64c10216c4f4dde0d91181942",
    "30af93acab0b13f4081ac6058df9316363ea3aa6970d999d2c8caa5e07c0860249d7",
);
const PART_MANIFEST: &str = concat!(
    "01030102a787d8350b00000000000000361165adeac2d201b9fef9bf04afc212b02e5b582c9f6862dfd798aec0a0b79eb7b9",
    "817084dc941892b00ee6",
);
const PART_REGION: &str = concat!(
    "01030102a787d8350c00000000000000e451bfc52d3ee87a1ad0835eeff9b990d43f11d38a4fa557db75402fa14fb0345189",
    "d9d28bad36362f1e93680e8cfa51ac0484423884303c2c7c5a1e952075e7",
);
const PART_PAGE: &str = concat!(
    "01030102a787d8350d0000000000000071fd78caddff0d625d9d5b2c46a4a6bdee769798147b2bd661cb27774f6670c065f1",
    "83bd1c3cc9c547243168cbbcf7783f3787b5a8aae3b785e598c07f872328882949775b9c3a555933835a45161a8ccac54cea",
    "37cefe76802e816389cf26acd59a9b7e",
);
const PART_OBJECT: &str = concat!(
    "01030102a787d8350e00000000000000bf545acad774479eaa9e3c7cacf6fbe15174aa15f34efabae4dbf4fc44d5c8301587",
    "a2bdc88a135381ef39163778fe0e7fe91fff49135ac943cf2652d9069397ecaa55150d1dcb8d25816d3a1ab41e421e9631c5",
    "e3e36c7d8b21fd4abd53c122",
);
const PRESENCE: &str = concat!(
    "01030201a787d8350f0000000000000017c9305d9d1c65ef90165492df31486e9776bf7dbae513ff670634354ccdc65a8343",
    "a1406abfbfac4feec383",
);

fn bytes(hex: &str) -> Vec<u8> {
    (0..hex.len()).step_by(2).map(|at| u8::from_str_radix(&hex[at..at + 2], 16).unwrap()).collect()
}

fn ends(local: u8) -> Ends {
    Ends { local: PeerId(local), remote: PeerId(3 - local) }
}

fn offer(peer: u8) -> Offer {
    let challenge = std::array::from_fn(|at| at as u8 + 16 * (peer - 1));
    Offer { challenge, incarnation: 0x0102_0304_0506_0708 + u64::from(peer - 1) * 0x1010_1010_1010_1010 }
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
    Session::new(&Key::new([7; 32]), ends(local), offer(local), offer(3 - local), &agreed)
}

fn flow() -> Message {
    Message::Flow(Flow {
        engaged: true,
        fading: false,
        tick: 4711,
        position: 0.25,
        velocity: -0.5,
        wave: 1.5,
        wave_integral: 2.0,
        energy_sent: 3.0,
    })
}

/// Seals `message` at `local` as number `sequence`, and opens it at the other end.
fn sealed(local: u8, sequence: u64, message: Message) -> Vec<u8> {
    let mut out = [0; MAX_DATAGRAM];
    let len = session(local).seal(&mut Counter::starting_at(sequence), &message, &mut out).unwrap();
    let mut datagram = out[..len].to_vec();
    let (header, head, sealed) = Header::parse(&mut datagram).unwrap();
    assert_eq!(Message::parse(session(3 - local).open(&header, head, sealed).unwrap()), Ok(message));
    out[..len].to_vec()
}

#[test]
fn a_hello_with_its_tables_and_tag() {
    let greeting = greeting();
    assert_eq!((greeting.kind, greeting.from, greeting.to), (GreetingKind::Hello, PeerId(1), PeerId(2)));
    assert_eq!((greeting.challenge, greeting.echo), (offer(1).challenge, offer(2).challenge));
    assert_eq!(greeting.incarnation, offer(1).incarnation);
    // The tables were hashed there and here: nothing differs, so there is a session to be had.
    assert!(handshake(2).accept(&greeting).is_ok());
    assert_eq!(greeting.count, 2);
    assert_eq!(handshake(1).open(&bytes(HELLO)).map(|_| ()), Err(Refusal::OwnNumber));
}

#[test]
fn sealed_messages_of_both_directions_and_later_epochs() {
    assert_eq!(sealed(1, 0, flow()), bytes(FLOW));
    assert_eq!(sealed(1, (5 << 20) + 3, flow()), bytes(LATER_FLOW));
    assert_eq!(sealed(2, 9, Message::Probe(Probe { sent_us: 123_456_789 })), bytes(PROBE_BACK));
}

#[test]
fn keys_move_on_and_a_reordered_datagram_of_the_last_epoch_is_still_opened() {
    let (mut here, mut there) = (session(1), session(2));
    let mut counter = Counter::starting_at((1 << EPOCH_BITS) - 20);
    let mut datagrams = (0..40)
        .map(|_| {
            let mut out = [0; MAX_DATAGRAM];
            let len = here.seal(&mut counter, &flow(), &mut out).unwrap();
            out[..len].to_vec()
        })
        .collect::<Vec<_>>();
    // The middle of the key's life and the next one's, alternating.
    let (first, second) = datagrams.split_at_mut(20);
    for (old, new) in first.iter_mut().zip(second) {
        for datagram in [new, old] {
            let (header, head, sealed) = Header::parse(datagram).unwrap();
            assert_eq!(Message::parse(there.open(&header, head, sealed).unwrap()), Ok(flow()));
        }
    }
    assert_eq!((there.taken(), there.missing()), (40, 0));
    // A forgery from an epoch far away moves nothing.
    let mut forged = bytes(LATER_FLOW);
    *forged.last_mut().unwrap() ^= 1;
    let (header, head, sealed) = Header::parse(&mut forged).unwrap();
    assert_eq!(there.open(&header, head, sealed), Err(Refusal::Forged));
    let mut out = [0; MAX_DATAGRAM];
    let len = here.seal(&mut counter, &flow(), &mut out).unwrap();
    let (header, head, sealed) = Header::parse(&mut out[..len]).unwrap();
    assert!(there.open(&header, head, sealed).is_ok());
}

#[test]
fn the_last_sequence_number_is_the_last() {
    let mut counter = Counter::starting_at(crate::replay::SEQUENCE_LIMIT - 1);
    assert!(counter.draw().is_ok());
    for _ in 0..3 {
        assert_eq!(counter.draw(), Err(Refusal::Exhausted));
    }
    let mut out = [0; MAX_DATAGRAM];
    assert_eq!(session(1).seal(&mut counter, &flow(), &mut out), Err(Refusal::Exhausted));
}

#[test]
fn a_buffer_that_is_too_short_is_an_error() {
    for len in 0..68 {
        let mut out = vec![0; len];
        assert!(session(1).seal(&mut Counter::default(), &flow(), &mut out).is_err(), "{len}");
    }
    for len in 0..200 {
        assert!(handshake(1).greet(GreetingKind::Hello, [0; 16], &mut vec![0; len]).is_err(), "{len}");
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
fn a_world_and_the_messages_that_carry_it() {
    let mut database = Database::<4>::default();
    (database.version, database.margin_m) = (9, 0.125);
    let (min, max) = ([-1.0, -1.0], [1.0, 1.0]);
    database.put_region(Region { id: 3, server: 1, bounds: Bounds { min, max } }).unwrap();
    let wall = Wall { from_x_m: 0.0, from_y_m: 0.5, to_x_m: 2.0, to_y_m: 0.5, thickness_m: 0.25, ..Wall::default() };
    database.put(Object { id: 5, version: 6, shape: Shape::Wall(wall) }).unwrap();
    let server = Server::new(database, None).unwrap();
    assert_eq!(server.world().to_le_bytes()[..], bytes(WORLD));

    let mut wanted = Bits::default();
    wanted.set(0);
    let ask =
        Ask { topic: Topic::Object, scope: Scope::Around { x: 1.0, y: -2.0, radius: 3.0 }, tag: 8, wanted, first: 0 };
    assert_eq!(sealed(2, 10, Message::Ask(ask)), bytes(ASK));
    // The wall's rectangle reaches down to y = 0.25, within 3 m of the point.
    let topics = [Topic::Manifest, Topic::Region, Topic::Page, Topic::Object];
    let expected = [PART_MANIFEST, PART_REGION, PART_PAGE, PART_OBJECT];
    for ((sequence, topic), expected) in (11..).zip(topics).zip(expected) {
        let ask = Ask { topic, ..ask };
        let answer: Vec<_> = server.answer(&ask).collect();
        assert_eq!(answer.len(), 1);
        assert_eq!(sealed(1, sequence, Message::Part(answer[0])), bytes(expected), "{topic:?}");
    }
    let sighting = Sighting { who: 300, position: [0.5, -0.5], velocity: [1.5, -1.5] };
    assert_eq!(sealed(2, 15, Message::Presence(Presence::new(77, [sighting]))), bytes(PRESENCE));
}
