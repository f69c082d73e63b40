//! The meeting place: seats, whose they are, and their bounds.

use std::net::SocketAddr;
use std::time::{Duration, Instant};

use cohold_homes::frame::{Join, Welcome};
use cohold_homes::place::{BURST, LEAST, MOST_ROOMS, MOST_SEATS, Place, RATE, SILENCE};
use cohold_homes::seat::Seat;
use cohold_protocol::key::Key;

/// A meeting place, and what one says and hears there.
struct Visit {
    place: Place,
    now: Instant,
}

impl Visit {
    fn new() -> Self {
        let now = Instant::now();
        Self { place: Place::new(&Key::new([1; 32]), now), now }
    }

    fn say(&mut self, from: SocketAddr, datagram: &[u8]) -> Vec<(SocketAddr, Vec<u8>)> {
        let mut sent = Vec::new();
        self.place.hear(self.now, from, datagram, &mut |to, bytes| sent.push((to, bytes.to_vec())));
        sent
    }

    fn ask(&mut self, from: SocketAddr, join: &[u8]) -> Welcome {
        let sent = self.say(from, join);
        assert!(sent.len() == 1 && sent[0].0 == from, "{sent:?}");
        Welcome::parse(&sent[0].1).expect("a welcome")
    }

    /// Asks until the cookie has come back; the last join and its answer.
    fn sit(&mut self, from: SocketAddr, mut seat: Seat) -> (Join, Welcome) {
        self.now += Duration::from_millis(1);
        loop {
            let join = seat.poll(self.now, true).expect("it is due");
            let welcome = self.ask(from, &join);
            assert!(welcome.seen == from);
            if seat.hear(self.now, &welcome.emit()) == Some(false) {
                return (Join::parse(&join).expect("a join"), welcome);
            }
            assert!(!welcome.seated && !welcome.refused, "nothing is kept of an address before its cookie came back");
        }
    }

    /// Takes a seat of a room, as one of the two ends that share its key.
    fn join(&mut self, from: SocketAddr, room: u32, side: u8) -> Welcome {
        self.sit(from, seat(room, side)).1
    }

    /// Sends a join that was seen, or made of one, from another address: with the cookie of that address, since it comes to it.
    fn repeats(&mut self, from: SocketAddr, join: Join) -> Welcome {
        let cookie = self.ask(from, &join.emit()).cookie;
        self.ask(from, &Join { cookie, ..join }.emit())
    }
}

fn seat(room: u32, side: u8) -> Seat {
    let mut key = [7; 32];
    key[..4].copy_from_slice(&room.to_le_bytes());
    Seat::new(&Key::new(key), side, &Key::new([side; 32]))
}

fn at(host: u32, port: u16) -> SocketAddr {
    SocketAddr::from((std::net::Ipv4Addr::from(0x0A00_0000 + host), port))
}

/// A sealed datagram, as far as its first byte goes.
fn sealed(bytes: usize) -> Vec<u8> {
    vec![cohold_protocol::wire::VERSION; bytes]
}

#[test]
fn two_meet_and_a_third_does_not() {
    let mut visit = Visit::new();
    let [one, two, three] = [at(1, 1), at(2, 2), at(3, 3)];
    assert!(!visit.join(one, 7, 0).other);
    let welcome = visit.join(two, 7, 1);
    assert!(welcome.seated && welcome.other && !welcome.refused);
    assert_eq!(visit.say(one, &sealed(88)), [(two, sealed(88))]);
    assert_eq!(visit.say(two, &sealed(200)), [(one, sealed(200))]);
    // Who has another address by now and shows that the seat is its own goes on.
    assert!(visit.join(at(2, 77), 7, 1).other);
    assert_eq!(visit.say(one, &sealed(88)), [(at(2, 77), sealed(88))]);
    assert_eq!(visit.say(two, &sealed(88)), [], "the old address has no seat any more");
    assert_eq!(visit.say(three, &sealed(88)), []);
    assert_eq!((visit.place.counts.passed, visit.place.counts.strangers, visit.place.counts.refused), (3, 2, 0));
}

/// An onlooker sees whole joins, with cookie and proof, and can send from an address of his own.
#[test]
fn an_onlooker_of_joins_takes_no_seat_and_moves_none() {
    let mut visit = Visit::new();
    let [one, two, thief] = [at(1, 1), at(2, 2), at(3, 3)];
    let (first, _) = visit.sit(one, seat(7, 0));
    // The other seat is free, and the onlooker has seen its name alone: under his own key it is of another room.
    let (own, _) = visit.sit(thief, seat(8, 1));
    let name: [u8; 16] = Key::new(first.seat).derive("seat").first();
    let welcome = visit.repeats(thief, Join { other: name, ..own });
    assert!(welcome.seated && !welcome.other, "in a room where nobody else is");
    assert!(visit.repeats(thief, Join { side: 1, ..first }).refused);
    let (second, welcome) = visit.sit(two, seat(7, 1));
    assert!(welcome.other && !welcome.refused);
    // Both joins are seen by now.
    for seen in [first, second] {
        let welcome = visit.repeats(thief, seen);
        assert!(welcome.refused && !welcome.seated);
    }
    assert_eq!(visit.say(thief, &sealed(88)), []);
    assert_eq!(visit.say(one, &sealed(88)), [(two, sealed(88))]);
    assert_eq!(visit.say(two, &sealed(88)), [(one, sealed(88))]);
}

#[test]
fn wrong_proofs_of_one_host_keep_no_other_out() {
    let mut visit = Visit::new();
    let (join, _) = visit.sit(at(1, 1), seat(7, 0));
    for port in 2..10_002 {
        assert!(visit.repeats(at(2, port), join).refused);
    }
    assert!(visit.join(at(2, 1), 9, 0).refused, "nor himself, for a moment");
    visit.now += Duration::from_secs(1);
    assert!(visit.join(at(2, 1), 9, 0).seated);
    assert!((3..23).all(|host| visit.join(at(host, 1), host, 0).seated));
}

#[test]
fn an_address_that_sends_no_cookie_back_gets_no_seat() {
    let mut visit = Visit::new();
    let (victim, thief) = (at(1, 1), at(2, 2));
    let mut own = seat(1, 0);
    let first = own.poll(visit.now, true).expect("it is due");
    own.hear(visit.now, &visit.say(thief, &first)[0].1);
    // A cookie, and the proof that goes with it, is of one address, and of 20 s.
    let proved = own.poll(visit.now, true).expect("it is due at once");
    assert!(!visit.ask(victim, &proved).seated);
    visit.now += Duration::from_secs(21);
    assert!(!visit.ask(thief, &proved).seated);
    assert_eq!(visit.place.rooms(), 0);
    visit.now -= Duration::from_secs(21);
    assert!(visit.ask(thief, &proved).seated);
}

#[test]
fn what_is_no_flow_and_what_is_too_long_goes_nowhere() {
    let mut visit = Visit::new();
    visit.join(at(1, 1), 7, 0);
    visit.join(at(2, 2), 7, 1);
    assert_eq!(visit.say(at(1, 1), &sealed(209)), []);
    for first in (0..=255).filter(|first| ![cohold_protocol::wire::VERSION, 0xF3, 0xF4].contains(first)) {
        let mut bytes = sealed(88);
        bytes[0] = first;
        assert_eq!(visit.say(at(1, 1), &bytes), [], "first byte {first}");
    }
}

#[test]
fn a_seat_passes_on_so_much_and_no_more() {
    let mut visit = Visit::new();
    visit.join(at(1, 1), 7, 0);
    visit.join(at(2, 2), 7, 1);
    let mut passed = 0;
    // 20,000 each second for 3 s, empty ones among them.
    for round in 0..60_000 {
        visit.now += Duration::from_micros(50);
        passed += visit.say(at(1, 1), &sealed(if round % 2 == 0 { 88 } else { 1 })).len();
    }
    let most = (BURST + 3.0 * RATE) / LEAST as f64;
    assert!((passed as f64 - most).abs() < 2.0, "{passed} passed, {most} may");
    assert_eq!(visit.say(at(2, 2), &sealed(88)).len(), 1, "the other seat is as it was");
}

#[test]
fn a_host_has_few_seats_and_all_hosts_have_so_many_rooms() {
    let mut visit = Visit::new();
    for port in 1..40 {
        assert_eq!(visit.join(at(1, port), port.into(), 0).seated, port <= MOST_SEATS, "port {port}");
    }
    // An address that asks for another room has left the first.
    assert!(visit.join(at(1, 1), 1000, 0).seated);
    assert_eq!(visit.place.rooms(), usize::from(MOST_SEATS));
    // A home has a network of IPv6.
    for host in 1..40_u16 {
        let from: SocketAddr = format!("[2001:db8::{host:x}]:9").parse().unwrap();
        assert_eq!(visit.join(from, 2000 + u32::from(host), 0).seated, host <= MOST_SEATS, "{from}");
    }
    let before = visit.place.rooms() as u32;
    for host in 2..6000 {
        let seated = visit.join(at(host, 1), 10_000 + host, 0).seated;
        assert_eq!(seated, host - 2 < MOST_ROOMS as u32 - before, "host {host}");
    }
    assert_eq!(visit.place.rooms(), MOST_ROOMS);
    assert!(visit.join(at(9000, 1), 10_002, 1).other, "in a room that is there is still a seat");
}

#[test]
fn who_falls_silent_is_forgotten_and_nothing_of_him_stays() {
    let mut visit = Visit::new();
    for host in 1..100 {
        visit.join(at(host, 1), host, 0);
    }
    visit.now += SILENCE / 2;
    visit.join(at(1, 1), 1, 0);
    visit.now += SILENCE / 2 + Duration::from_secs(2);
    visit.join(at(500, 1), 500, 0);
    assert_eq!(visit.place.rooms(), 2);
    assert!(visit.join(at(600, 1), 2, 0).seated, "a seat that is free again is for whom it was");
}
