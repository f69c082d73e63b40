//! Tests of `src/world/host.rs` from inside.

use cohold_protocol::wire::Header;

use super::*;
use crate::world::PACKET_US;

/// A host that another line has `taken` a session number of, and the numbers of the sessions that a client on line 1 had in 2 s.
fn visit(taken: Option<u32>) -> (Host<()>, Vec<u32>) {
    let key = Key::new([7; Key::LEN]);
    let mut host = Host::new(key.clone(), 1, 2, World::default(), None, || [1; Key::LEN]).expect("a good host");
    host.sessions.extend(taken.map(|session| (session, 2)));
    let mut link = open_link(key.line(1), [CLIENT, 1], [2; Key::LEN]).expect("a good link").on_line(1);
    let (mut out, mut had) = ([0; MAX_DATAGRAM], Vec::new());
    for now in (0..2_000_000).step_by(PACKET_US as usize) {
        let mut answers = Vec::new();
        while let Some(len) = link.poll(now, &mut out) {
            host.receive(now, (), &mut out[..len], |(), answer| answers.push(answer.to_vec()));
        }
        host.tick(now, |(), said| answers.push(said.to_vec()));
        for mut answer in answers {
            let _ = link.receive(now, &mut answer);
        }
        had.extend(link.session_number());
        had.dedup();
    }
    (host, had)
}

#[test]
fn a_session_number_stays_with_the_line_that_had_it_first() {
    let (host, had) = visit(None);
    let [number] = had[..] else { panic!("one session for as long as nothing happens: {had:x?}") };
    assert_eq!(host.sessions.get(&number), Some(&1));
    // The same client, but another has that number.
    let (host, had) = visit(Some(number));
    assert_eq!((had.first(), host.sessions.get(&number)), (Some(&number), Some(&2)));
    let last = had.last().expect("a session");
    assert_eq!((had.len(), host.sessions.get(last)), (2, Some(&1)), "{had:x?}");
}

/// A client that asks for all there is, in somebody else's name: he is sent no more than was sent in it, whatever is asked for.
#[test]
fn an_address_that_answers_no_probe_is_sent_no_more_than_it_sent() {
    const OWN: u32 = 1;
    const VICTIM: u32 = 2;
    let (key, mut seen) = (Key::new([7; Key::LEN]), 0_u8);
    let entropy = move || {
        seen = seen.wrapping_add(1).max(1);
        [seen; Key::LEN]
    };
    let world = *crate::world::parse("[[wall]]\nid = 1\n[[wall]]\nid = 2\n", "a test").expect("a good world");
    let mut host = Host::new(key.clone(), 1, 2, world, None, entropy).expect("a good host");
    let mut link = open_link(key.line(1), [CLIENT, 1], [2; Key::LEN]).expect("a good link").on_line(1);
    let (mut to_victim, mut from_victim, mut parts) = (0, 0, 0);
    let mut wanted = crate::roles::static_scene::Download::<OBJECTS>::default();
    for now in (0..2_000_000).step_by(PACKET_US as usize) {
        let mut said = Vec::new();
        link.say_due(now, |bytes| said.push(bytes.to_vec()));
        if let Some(ask) = wanted.poll(now, 1) {
            link.say(now, ask, |bytes| said.push(bytes.to_vec()));
        }
        for mut bytes in said {
            let from = if bytes[1] == Header::KIND { VICTIM } else { OWN };
            from_victim += if from == VICTIM { bytes.len() } else { 0 };
            let mut answers = Vec::new();
            host.receive(now, from, &mut bytes, |to, answer| answers.push((to, answer.to_vec())));
            for (to, mut answer) in answers {
                to_victim += if to == VICTIM { answer.len() } else { 0 };
                // What is sealed goes to the victim; the client has the greetings alone.
                if to == OWN && answer[1] != Header::KIND {
                    let _ = link.receive(now, &mut answer);
                }
            }
        }
        parts = host.counts.parts;
        host.tick(now, |to, bytes| to_victim += if to == VICTIM { bytes.len() } else { 0 });
        assert!(to_victim <= from_victim, "{to_victim} bytes for {from_victim}");
    }
    assert!(from_victim > 10_000, "{from_victim} bytes, {parts} parts");
}
