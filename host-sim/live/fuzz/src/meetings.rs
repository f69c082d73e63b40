//! Any bytes as datagrams at a meeting place, at a carrier, at who asks a router, at both sides of an agreement, and as a link: no panic, nothing is sent to an address
//! that nobody has proved, a meeting place answers with no more than it was sent, and no key is agreed on.

use std::net::SocketAddr;
use std::time::{Duration, Instant};

use haptic_meeting::agreement::{Accepter, Heard, Inviter};
use haptic_meeting::carrier::{Carrier, Config};
use haptic_meeting::invite::Invite;
use haptic_meeting::mapping::Mapping;
use haptic_meeting::place::Place;
use haptic_protocol::key::Key;

fn at(address: &str) -> SocketAddr {
    address.parse().expect("an address")
}

/// Runs one fuzz input: a byte of length before each datagram.
pub(super) fn run(bytes: &[u8]) {
    let (start, key, meet) = (Instant::now(), Key::new([9; 32]), at("203.0.113.1:7710"));
    let froms = [meet, at("198.51.100.1:1"), at("[2001:db8::1]:2")];
    let config = Config {
        key: key.clone(),
        side: 0,
        meet,
        bases: vec![at("192.168.1.10:40000")],
        mapped: None,
        relay_only: false,
    };
    let mut carrier = Carrier::new(config, &key, start);
    let mut place = Place::new(&key, start);
    let own = "192.168.1.10:40000".parse().expect("an address");
    let mut mapping = Mapping::new(froms[1], own, &key, start);
    let mut inviter = Inviter::new("example.org:7710", &key, start);
    let accepter = Accepter::new(&inviter.invite, &Key::new([8; 32]));
    let (mut rest, mut now) = (bytes, start);
    while let Some((length, more)) = rest.split_first() {
        let (datagram, after) = more.split_at(more.len().min((*length).into()));
        rest = after;
        now += Duration::from_millis(7);
        let from = froms[usize::from(*length) % froms.len()];
        let mut sent = 0;
        place.hear(now, from, datagram, &mut |to, answer| {
            assert_eq!(to, from, "nobody has a seat");
            sent += answer.len();
        });
        assert!(sent <= datagram.len(), "{sent} bytes for {}", datagram.len());
        // Without the key nobody makes a signal or a check: all that a carrier ever sends goes to the meeting place.
        let mut to_meet = |to, _: &[u8]| assert_eq!(to, meet, "a stranger is sent something");
        carrier.hear(now, from, datagram, &mut to_meet);
        carrier.poll(now, &mut to_meet);
        let _ = carrier.release(now);
        mapping.poll(now);
        mapping.hear(now, from, datagram);
        let _ = mapping.outer(now);
        assert!(!matches!(inviter.hear(now, datagram).1, Heard::Agreed(_)), "a key without the link");
        assert!(!matches!(accepter.hear(datagram), Ok(Some(_))), "a key without the link");
    }
    if let Ok(text) = std::str::from_utf8(bytes)
        && let Ok(invite) = Invite::parse(text)
    {
        assert_eq!(
            invite.link().to_ascii_lowercase(),
            text.trim().to_ascii_lowercase(),
            "a link is read as it is written"
        );
    }
}
