//! A bad network between two peers: takes their datagrams, and does with each what the scene's network table or a trace
//! says. It has no key, so all it can do is what a network can.

use std::net::SocketAddr;
use std::time::{Duration, Instant};

use super::socket::{drain, open};
use haptic_sim::network::link::{Counts, Link, Route};
use haptic_sim::network::rule::Direction;
use haptic_sim::scene::Scene;

/// How long the relay sleeps when it has nothing to do: what it adds to the delay at the most.
const NAP: Duration = Duration::from_micros(200);

/// Relays between a peer that talks to `listen[0]` and one that talks to `listen[1]` for `duration_s`.
///
/// # Errors
/// A socket that cannot be opened, in one line.
pub fn run(scene: &Scene, listen: [SocketAddr; 2], duration_s: f64) -> Result<[Counts; 2], String> {
    let sockets = [open(listen[0])?, open(listen[1])?];
    let mut lines = [Direction::OneToTwo, Direction::TwoToOne]
        .map(|direction| Link::<[u8]>::new(Route::of_scene(scene, direction, 0)));
    let mut peers: [Option<SocketAddr>; 2] = [None, None];
    let start = Instant::now();
    let now_ns = || start.elapsed().as_nanos() as u64;
    while start.elapsed().as_secs_f64() < duration_s {
        for ((socket, line), peer) in sockets.iter().zip(&mut lines).zip(&mut peers) {
            drain(socket, Instant::now() + NAP, |from, datagram| {
                *peer = Some(from);
                line.send(now_ns(), datagram);
            });
        }
        for (side, line) in lines.iter_mut().enumerate() {
            // Kept until the peer it is for has spoken; sent from the socket that this one talks to.
            let Some(to) = peers[1 - side] else { continue };
            while let Some((_, datagram)) = line.take(now_ns()) {
                let _ = sockets[1 - side].send_to(&datagram, to);
            }
        }
        std::thread::sleep(NAP);
    }
    Ok(lines.map(|line| line.counts()))
}
