//! Tests of `src/shared/world/host.rs` from inside.

use super::*;
use crate::shared::world::PACKET_US;

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
