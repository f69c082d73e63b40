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
    "0201010200000000000102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f08070605040302010200",
    "0000000000001194c85d0a6134f6fc00e0989f62d7e800000000000000000000000000000000000000000000000000000000",
    "0000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000",
    "00000000000000000000000000000000000000000000000000000000000000000000122122571c695be918467bddb71cfde7",
);
const FLOW: &str = concat!(
    "02030102ae4fd71e00000000000000001abe6508e20d5c4d97e56bf4610e48dbf8f2cbf50a08407ee9d3c5ac0e1a1a956b12",
    "4f848138d9fcc3dffb12250c4e290f89baab7a496635",
);
const LATER_FLOW: &str = concat!(
    "02030102ae4fd71e03005000000000003d1eba2e4f0f93ee32d2dec70a1fa3e282d747de501031c6dc8b3d4ba717f9fef598",
    "24f04bb1187a9c6dbe0db1f1105bf3c000a409b4c817",
);
const PROBE_BACK: &str = "02030201ae4fd71e09000000000000004a46a69b5f8bbd5cc8808960fbf3437a3ef1676eba0ae59218e4538a";
const LINE_HELLO_TAG: &str = "eec4a4abfdee27cce4669d05b906ccff";
const WORLD: &str = "98bb64ccfb8d3313";
const ASK: &str = concat!(
    "02030201ae4fd71e0a000000000000003c86df7f54dcb8df14674cd95595776a0ca4531512d4f670171e977498f8c76632ec",
    "a244a6e15e61a7291dbf856dc893434cd20cf33a9973f55ac15727226be9137e3c9d",
);
const PART_MANIFEST: &str = concat!(
    "02030102ae4fd71e0b000000000000006dc742d151e5d0a84291788a89372d085684b260512a935c04f5f9926015325bd7f8",
    "1b205ba0e103794d7dbc",
);
const PART_REGION: &str = concat!(
    "02030102ae4fd71e0c00000000000000df60311eef1d215851a0c323d42a8079e2f8c885d59d849e55ce62a03b4eac9cb726",
    "4b470b54a6c7c236743c5a63fac216c881e2ccea8043f39821afdec8e476",
);
const PART_PAGE: &str = concat!(
    "02030102ae4fd71e0d00000000000000f705fca6b649996327b6179be4b2fd6344b3d9fe73afc6db59113584d8fde46373b1",
    "621793eaa793fd1855428af536a930f60d7a815732de929394c290b4a1caf078e02b3c2636c67c43735e887fad033833d6ed",
    "41620ce7ddf556ecc11cc38fca29126c",
);
const PART_OBJECT: &str = concat!(
    "02030102ae4fd71e0e000000000000000cf7c29f28b9903c2e1e51f9dbf45f7de5cc45d152e78d3df2ed5992ce1cacc4e9e4",
    "e8f8d35969ec080a0c9f940ccd1a91219d5cf839b6e0499eda2a403f2d27aebad58479bbb33fdd8d29246463b04af44522e3",
    "24886bfc23528ed796c6eead",
);
const PRESENCE: &str = concat!(
    "02030201ae4fd71e0f0000000000000005a71e429fb14f7a9bfbf2f17e6a913c225660320ed401b7e223c4704ef1be12ecb8",
    "fe393ee64a5382a75de0",
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
        live_ticks: 4712,
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
    for len in 0..72 {
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
