//! Two links and a wire that the script commands: calls in any order at any time, datagrams delivered, dropped, repeated,
//! altered, peers restarted. No panic; events once and in order; levels within bounds; and in the end they always meet.

use cohold_protocol::link::Stage;
use cohold_protocol::wire::{Event, Flow, MAX_DATAGRAM, Telemetry};

use super::pair;

/// Runs one fuzz input through two links and the wire between them.
pub(super) fn run(bytes: &[u8]) {
    let mut links = [pair::link(1, 0), pair::link(2, 0)];
    let (mut wire, mut out, mut now) = (Vec::<(usize, Vec<u8>)>::new(), [0; MAX_DATAGRAM], 0u64);
    let (mut life, mut pushed, mut next) = (0u8, [0u32; 2], [None::<u32>; 2]);
    for step in bytes.chunks_exact(2).take(2_000) {
        let (call, value) = (step[0] >> 1, step[1]);
        let peer = usize::from(step[0] & 1);
        let link = &mut links[peer];
        let said = match call % 10 {
            0 => {
                now += u64::from(value) * 500;
                None
            }
            1 | 2 => link.poll(now, &mut out),
            3 => link.send(now, Flow::default(), &mut out),
            4 => link.send(now, Telemetry::default(), &mut out),
            5 => {
                let event = Event::new(life.into(), &pushed[peer].to_le_bytes()).expect("a short payload");
                pushed[peer] += u32::from(link.push_event(event).is_ok());
                None
            }
            6 if value > 250 && life < 250 => {
                life += 1;
                *link = pair::link(peer as u8 + 1, life);
                next[1 - peer] = None;
                None
            }
            _ if wire.is_empty() => None,
            choice => {
                let at = usize::from(value) % wire.len();
                let (to, mut bytes) = if choice == 7 { wire[at].clone() } else { wire.remove(at) };
                if choice == 8 {
                    let bit = usize::from(value) * 7 % (8 * bytes.len());
                    bytes[bit / 8] ^= 1 << (bit % 8);
                }
                let _ = links[to].receive(now, &mut bytes);
                None
            }
        };
        if let Some(len) = said {
            wire.push((1 - peer, out[..len].to_vec()));
        }
        for (peer, link) in links.iter_mut().enumerate() {
            while let Some(event) = link.take_event() {
                let number = u32::from_le_bytes(event.payload().try_into().expect("as it was pushed"));
                // Some may be missing where a peer has restarted; none comes twice or early.
                assert!(next[peer].is_none_or(|next| number >= next), "event {number} after {:?}", next[peer]);
                next[peer] = Some(number + 1);
            }
        }
    }
    // Peace: whatever has happened, they meet.
    for _ in 0..25 {
        now += 8_000;
        for from in [0, 1] {
            let flow = links[from].send(now, Flow::default(), &mut out);
            if let Some(len) = flow {
                let _ = links[1 - from].receive(now, &mut out[..len]);
            }
            while let Some(len) = links[from].poll(now, &mut out) {
                let _ = links[1 - from].receive(now, &mut out[..len]);
            }
        }
    }
    assert!(links.iter().all(|link| link.stage() == Stage::Running));
}
