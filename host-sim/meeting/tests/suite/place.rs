//! The meeting place: seats, and their bounds.

use std::net::SocketAddr;
use std::time::{Duration, Instant};

use haptic_meeting::frame::{Join, Welcome};
use haptic_meeting::place::{BURST, LEAST, MOST_ROOMS, MOST_SEATS, Place, RATE, SILENCE};
use haptic_protocol::key::Key;

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

    fn ask(&mut self, from: SocketAddr, join: Join) -> Welcome {
        let sent = self.say(from, &join.emit());
        assert!(sent.len() == 1 && sent[0].0 == from, "{sent:?}");
        Welcome::parse(&sent[0].1).expect("a welcome")
    }

    /// Asks with the cookie that came back.
    fn join(&mut self, from: SocketAddr, room: u32, side: u8, token: u8) -> Welcome {
        let mut number = [0; 16];
        number[..4].copy_from_slice(&room.to_le_bytes());
        let join = Join { side, room: number, cookie: [0; 16], token: [token; 16], nonce: [side; 8] };
        let first = self.ask(from, join);
        assert!(!first.seated && first.seen == from && first.nonce == join.nonce);
        self.ask(from, Join { cookie: first.cookie, ..join })
    }
}

fn at(host: u32, port: u16) -> SocketAddr {
    SocketAddr::from((std::net::Ipv4Addr::from(0x0A00_0000 + host), port))
}

/// A sealed datagram, as far as its first byte goes.
fn sealed(bytes: usize) -> Vec<u8> {
    vec![haptic_protocol::wire::VERSION; bytes]
}

#[test]
fn two_meet_and_a_third_does_not() {
    let mut visit = Visit::new();
    let [one, two, three] = [at(1, 1), at(2, 2), at(3, 3)];
    assert!(!visit.join(one, 7, 0, 1).other);
    let welcome = visit.join(two, 7, 1, 2);
    assert!(welcome.seated && welcome.other && !welcome.refused);
    assert_eq!(visit.say(one, &sealed(88)), [(two, sealed(88))]);
    assert_eq!(visit.say(two, &sealed(200)), [(one, sealed(200))]);
    // Without the token there is no seat, and without a seat nothing is passed on.
    let welcome = visit.join(three, 7, 1, 9);
    assert!(!welcome.seated && welcome.refused);
    assert_eq!(visit.say(three, &sealed(88)), []);
    assert_eq!(visit.say(one, &sealed(88)), [(two, sealed(88))]);
    // With it, who was given another address goes on.
    assert!(visit.join(at(2, 77), 7, 1, 2).other);
    assert_eq!(visit.say(one, &sealed(88)), [(at(2, 77), sealed(88))]);
    assert_eq!(visit.say(two, &sealed(88)), [], "the old address has no seat any more");
    assert_eq!((visit.place.counts.passed, visit.place.counts.strangers, visit.place.counts.refused), (4, 2, 1));
}

#[test]
fn an_address_that_sends_no_cookie_back_gets_no_seat() {
    let mut visit = Visit::new();
    let (victim, thief) = (at(1, 1), at(2, 2));
    let join = Join { side: 0, room: [1; 16], cookie: [0; 16], token: [1; 16], nonce: [0; 8] };
    let cookie = visit.ask(thief, join).cookie;
    // A cookie is of one address, and of 20 s.
    assert!(!visit.ask(victim, Join { cookie, ..join }).seated);
    visit.now += Duration::from_secs(21);
    assert!(!visit.ask(thief, Join { cookie, ..join }).seated);
    assert_eq!(visit.place.rooms(), 0);
}

#[test]
fn what_is_no_flow_and_what_is_too_long_goes_nowhere() {
    let mut visit = Visit::new();
    visit.join(at(1, 1), 7, 0, 1);
    visit.join(at(2, 2), 7, 1, 2);
    assert_eq!(visit.say(at(1, 1), &sealed(209)), []);
    for first in (0..=255).filter(|first| ![haptic_protocol::wire::VERSION, 0xF3, 0xF4].contains(first)) {
        let mut bytes = sealed(88);
        bytes[0] = first;
        assert_eq!(visit.say(at(1, 1), &bytes), [], "first byte {first}");
    }
}

#[test]
fn a_seat_passes_on_so_much_and_no_more() {
    let mut visit = Visit::new();
    visit.join(at(1, 1), 7, 0, 1);
    visit.join(at(2, 2), 7, 1, 2);
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
        assert_eq!(visit.join(at(1, port), port.into(), 0, 1).seated, port <= MOST_SEATS, "port {port}");
    }
    // An address that asks for another room has left the first.
    assert!(visit.join(at(1, 1), 1000, 0, 1).seated);
    assert_eq!(visit.place.rooms(), usize::from(MOST_SEATS));
    // A home has a network of IPv6.
    for host in 1..40_u16 {
        let from: SocketAddr = format!("[2001:db8::{host:x}]:9").parse().unwrap();
        assert_eq!(visit.join(from, 2000 + u32::from(host), 0, 1).seated, host <= MOST_SEATS, "{from}");
    }
    let before = visit.place.rooms() as u32;
    for host in 2..6000 {
        let seated = visit.join(at(host, 1), 10_000 + host, 0, 1).seated;
        assert_eq!(seated, host - 2 < MOST_ROOMS as u32 - before, "host {host}");
    }
    assert_eq!(visit.place.rooms(), MOST_ROOMS);
    assert!(visit.join(at(9000, 1), 10_002, 1, 1).other, "in a room that is there is still a seat");
}

#[test]
fn who_falls_silent_is_forgotten_and_nothing_of_him_stays() {
    let mut visit = Visit::new();
    for host in 1..100 {
        visit.join(at(host, 1), host, 0, 1);
    }
    visit.now += SILENCE / 2;
    visit.join(at(1, 1), 1, 0, 1);
    visit.now += SILENCE / 2 + Duration::from_secs(2);
    visit.join(at(500, 1), 500, 0, 1);
    assert_eq!(visit.place.rooms(), 2);
    let welcome = visit.join(at(600, 1), 2, 0, 9);
    assert!(welcome.seated, "a seat that is free again is for any token");
}
