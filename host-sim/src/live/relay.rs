//! A bad network between two peers: takes their datagrams, and does with each what the scene's network table or a trace
//! says. It has no key, so all it can do is what a network can.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::net::{SocketAddr, UdpSocket};
use std::time::{Duration, Instant};

use serde::Serialize;

use crate::network::fate::{Direction, Fates};
use crate::scene::SceneFile;

/// What the relay did in one direction.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Relayed {
    /// Datagrams taken in.
    pub taken: u64,
    /// Datagrams sent on, copies included.
    pub sent: u64,
    /// Datagrams lost.
    pub lost: u64,
    /// Datagrams broken on purpose.
    pub corrupt: u64,
}

/// Relays between a peer that talks to `listen[0]` and one that talks to `listen[1]` for `duration_s`.
///
/// # Errors
/// A socket that cannot be opened, in one line.
pub fn run(scene: &SceneFile, listen: [SocketAddr; 2], duration_s: f64) -> Result<[Relayed; 2], String> {
    let open = |address| {
        let socket = UdpSocket::bind(address).map_err(|cause| format!("cannot listen on {address}: {cause}"))?;
        socket.set_nonblocking(true).map_err(|cause| format!("cannot poll the socket: {cause}"))?;
        Ok::<_, String>(socket)
    };
    let sockets = [open(listen[0])?, open(listen[1])?];
    let timing = &scene.peer.timing;
    let constant_s = timing.control_period_s
        * f64::from(timing.ticks_per_packet)
        * f64::from(scene.world.network.one_way_delay_packets);
    let mut fates = [Direction::OneToTwo, Direction::TwoToOne].map(|direction| Fates::new(scene, direction));
    let mut peers: [Option<SocketAddr>; 2] = [None, None];
    let mut relayed = [Relayed::default(); 2];
    let mut in_flight = BinaryHeap::new();
    let (start, mut bytes, mut order) = (Instant::now(), [0; 2048], 0_u64);
    while start.elapsed().as_secs_f64() < duration_s {
        let now_s = start.elapsed().as_secs_f64();
        for side in 0..2 {
            while let Ok((len, from)) = sockets[side].recv_from(&mut bytes) {
                peers[side] = Some(from);
                let count = &mut relayed[side];
                let copies = match &mut fates[side] {
                    None => vec![crate::network::fate::Arrival { delay_s: 0.0, corrupt: false }],
                    Some(fates) => fates.next(count.taken, now_s),
                };
                count.taken += 1;
                count.lost += u64::from(copies.is_empty());
                for copy in copies {
                    let mut datagram = bytes[..len].to_vec();
                    if copy.corrupt {
                        let middle = len / 2;
                        datagram[middle] ^= 0x10;
                        count.corrupt += 1;
                    }
                    order += 1;
                    let due_us = (1e6 * (now_s + constant_s + copy.delay_s)) as u64;
                    in_flight.push(Reverse((due_us, order, side, datagram)));
                }
            }
        }
        let now_us = (1e6 * start.elapsed().as_secs_f64()) as u64;
        while in_flight.peek().is_some_and(|Reverse((due_us, ..))| *due_us <= now_us) {
            let Some(Reverse((_, _, side, datagram))) = in_flight.pop() else { break };
            if let Some(to) = peers[1 - side] {
                // Sent from the socket that the other peer talks to.
                relayed[side].sent += u64::from(sockets[1 - side].send_to(&datagram, to).is_ok());
            }
        }
        std::thread::sleep(Duration::from_micros(200));
    }
    Ok(relayed)
}
