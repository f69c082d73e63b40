//! Any bytes as datagrams at a meeting place, at a carrier, at who asks a router, at both sides of an agreement, and as a link: no panic, nothing is sent to an address
//! that nobody has proved, a meeting place answers with no more than it was sent, and no key is agreed on. Then two ends that have the key and the
//! link, with the input as what happens to their datagrams on the way: nobody else is sent more than a check, and they agree on one key or none.

use std::collections::VecDeque;
use std::net::SocketAddr;
use std::time::{Duration, Instant};

use cohold_homes::agreement::{Accepter, Heard, Inviter};
use cohold_homes::carrier::{Carrier, Config};
use cohold_homes::invite::Invite;
use cohold_homes::mapping::Mapping;
use cohold_homes::place::Place;
use cohold_protocol::key::Key;

fn at(address: &str) -> SocketAddr {
    address.parse().expect("an address")
}

/// Runs one fuzz input.
pub(super) fn run(bytes: &[u8]) {
    without_the_key(bytes);
    with_the_key(bytes);
}

/// Two ends with the key meet at a place and agree by their link. A byte for each datagram: it is lost, said twice, cut, another at one bit, or whole.
fn with_the_key(bytes: &[u8]) {
    let (start, key) = (Instant::now(), Key::new([9; 32]));
    let [meet, first, second] = ["203.0.113.1:7710", "198.51.100.1:1", "198.51.100.2:2"].map(at);
    let owns = [first, second];
    let mut ends = [0, 1].map(|side| {
        let bases = vec![owns[usize::from(side)]];
        let config = Config { key: key.clone(), side, meet, bases, mapped: None, relay_only: false };
        Carrier::new(config, &Key::new([side; 32]), start)
    });
    let mut place = Place::new(&key, start);
    let mut inviter = Inviter::new("203.0.113.1:7710", &Key::new([3; 32]), start);
    let accepter = Accepter::new(&inviter.invite, &Key::new([4; 32]));
    let mut bytes = bytes.iter().copied();
    let mut changed = |datagram: &[u8]| {
        let (change, mut now) = (bytes.next()?, datagram.to_vec());
        let at = usize::from(change / 8) * now.len() / 32;
        match change % 8 {
            0 => now.clear(),
            1 => now.truncate(at),
            2 => now.extend(datagram),
            3 if !now.is_empty() => now[at] ^= 1 << (change / 32),
            _ => {}
        }
        Some(now)
    };
    let (mut under_way, mut now) = (VecDeque::new(), start);
    // A welcome that was changed on the way names another address of an end: that is asked by a check of STUN, and is sent nothing else.
    let put = |under_way: &mut VecDeque<_>, from: SocketAddr, to: SocketAddr, datagram: &[u8]| {
        if to == meet || owns.contains(&to) {
            under_way.push_back((from, to, datagram.to_vec()));
        } else {
            assert!(matches!(datagram, [0 | 1, ..]), "{to} is nobody, and is sent {datagram:?}");
        }
    };
    loop {
        now += Duration::from_millis(20);
        for (end, own) in ends.iter_mut().zip(owns) {
            let mut sends = |to, datagram: &[u8]| put(&mut under_way, own, to, datagram);
            end.poll(now, &mut sends);
            end.send(now, b"\x04 sealed by the ends", &mut sends);
        }
        let Some(offer) = changed(&accepter.offer()) else { return };
        let (answer, heard) = inviter.hear(now, &offer);
        if let Some(answer) = answer {
            let Some(answer) = changed(&answer) else { return };
            if let Ok(Some(agreed)) = accepter.hear(&answer) {
                assert!(!matches!(heard, Heard::Agreed(key) if key != agreed), "two keys");
            }
        }
        for _ in 0..under_way.len() {
            let (from, to, datagram) = under_way.pop_front().expect("so many are under way");
            let Some(datagram) = changed(&datagram) else { return };
            let mut sends = |then, answer: &[u8]| put(&mut under_way, to, then, answer);
            match owns.iter().position(|own| *own == to) {
                Some(end) => {
                    ends[end].hear(now, from, &datagram, &mut sends);
                    while ends[end].release(now).is_some() {}
                }
                None => place.hear(now, from, &datagram, &mut sends),
            }
        }
        assert!(under_way.len() < 100 && place.rooms() < 20, "{} under way, {} rooms", under_way.len(), place.rooms());
    }
}

/// A byte of length before each datagram.
fn without_the_key(bytes: &[u8]) {
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
