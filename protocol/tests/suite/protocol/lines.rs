//! Lines: one server and more clients than there are peer numbers, each with its own key.

use cohold_protocol::key::Key;
use cohold_protocol::link::{Config, Error, Link};
use cohold_protocol::wire::{Greeting, Header, MAX_DATAGRAM, Message, Presence, Sighting};

use crate::protocol::world::config;

fn link(local: u8, line: u32, entropy: u8) -> Link {
    let master = Key::new([7; 32]);
    Link::new(Config { key: master.line(line), ..config(local, 1 - local, [entropy; 32]) }).unwrap().on_line(line)
}

/// Passes everything that the two have to say until neither has any more.
fn talk(now: u64, pair: &mut [Link; 2]) {
    let mut out = [0; MAX_DATAGRAM];
    for _ in 0..4 {
        for from in [0, 1] {
            while let Some(len) = pair[from].poll(now, &mut out) {
                pair[1 - from].receive(now, &mut out[..len]).unwrap();
            }
        }
    }
}

#[test]
fn a_thousand_clients_of_one_server_are_told_apart_by_line_and_session() {
    let mut sessions = std::collections::BTreeSet::new();
    for line in 1..=1_000 {
        let mut pair = [link(0, line, 1), link(1, line, 2)];
        let mut out = [0; MAX_DATAGRAM];
        let len = pair[1].poll(0, &mut out).unwrap();
        // What a server reads before it knows who that is.
        assert_eq!(Greeting::parse(&out[..len]).unwrap().0.line, line);
        pair[0].receive(0, &mut out[..len]).unwrap();
        talk(1, &mut pair);
        talk(9_000, &mut pair);
        let session = pair[0].session_number().unwrap();
        assert_eq!(pair[1].session_number(), Some(session));
        assert!(sessions.insert(session), "session numbers of different keys differ");
        let sighting = Sighting { who: line, ..Sighting::default() };
        let len = pair[1].send(10_000, Presence::new(5, [sighting]), &mut out).unwrap();
        assert_eq!(Header::parse(&mut out[..len]).unwrap().0.session, session);
        match pair[0].receive(10_000, &mut out[..len]) {
            Ok(Some(Message::Presence(presence))) => assert_eq!(presence.seen(), [sighting]),
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn a_client_has_no_other_line() {
    let (mut server, mut stranger) = (link(0, 3, 1), link(1, 4, 2));
    let mut out = [0; MAX_DATAGRAM];
    let len = stranger.poll(0, &mut out).unwrap();
    assert_eq!(server.receive(0, &mut out[..len]), Err(Error::OtherLine));
    // The right number does not help without the key of that line.
    let mut liar = link(1, 4, 2).on_line(3);
    let len = liar.poll(0, &mut out).unwrap();
    assert_eq!(server.receive(0, &mut out[..len]), Err(Error::ForgedGreeting));
    // Line 0 is the plain key.
    assert_eq!(Key::new([9; 32]).line(0), Key::new([9; 32]));
    assert_ne!(Key::new([9; 32]).line(1), Key::new([9; 32]).line(2));
}
