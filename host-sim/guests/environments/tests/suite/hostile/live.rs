//! Two hundred programs in real time, as far as the machine keeps up: a hub and two honest peers over UDP on loopback, each in a thread
//! of its own.

use std::net::{SocketAddr, UdpSocket};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use cohold_environments::cooperative::hub::number_on;
use cohold_environments::live::hub;
use cohold_live::endpoint::{Span, Stop};
use cohold_live::node::Line;
use cohold_live::tell::Manner;
use cohold_live::watch::LiveOptions;
use cohold_protocol::end::End as _;
use cohold_protocol::key::Key;
use cohold_protocol::wire::MAX_DATAGRAM;
use cohold_sim::rng::Rng;
use cohold_sim::scene::Scene;

#[path = "../../../../../tests/suite/program/free.rs"]
mod free;

use free::free;

use super::program::Program;
use super::{asked, scene};

const PROGRAMS: u64 = 200;
/// Ticks of each.
const TICKS: u64 = 30;

/// Says one program after the other on line 3 of a hub until it is over; gives how many flows that were.
fn hostile(scene: &Scene, key: Key, hub: SocketAddr, over: &AtomicBool) -> u64 {
    let mut rng = Rng::new(asked("HOSTILE_SEED", 1));
    let mut line = Line::<1>::open(scene, number_on(3), key, [3; Key::LEN]).expect("a line");
    let socket = UdpSocket::bind("127.0.0.1:0").expect("a socket on loopback");
    socket.set_nonblocking(true).expect("a socket that does not wait");
    let start = Instant::now();
    let (mut bytes, mut said) = ([0; MAX_DATAGRAM], 0);
    let mut program = Program::new(&mut rng, 58.0);
    let mut at = 0;
    let send = |bytes: &[u8]| _ = socket.send_to(bytes, hub);
    for tick in 0_u32.. {
        let now = start.elapsed().as_micros() as u64;
        while let Ok((length, _)) = socket.recv_from(&mut bytes) {
            let _ = line.receive(now, tick, &mut bytes[..length]);
        }
        line.link.say_due(now, send);
        if line.link.is_up() {
            let flow = program.flow(&mut rng, tick, at, 1, 1e-3);
            said += u64::from(line.link.say(now, flow, send));
            at += 1;
            if at >= TICKS {
                (program, at) = (Program::new(&mut rng, 58.0), 0);
            }
        }
        if over.load(Ordering::Relaxed) {
            break;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    said
}

#[test]
fn two_hundred_programs_at_a_live_hub() {
    let (scene, key) = (scene("any-network", &["user.1.push_n=0.3"]), Key::new([0x5a; Key::LEN]));
    let address = free();
    let (quiet, stop) = (LiveOptions { manner: Manner::Quiet, ..LiveOptions::default() }, Stop::default());
    let over = AtomicBool::new(false);
    let span = |duration_s: f64| Span { duration_s, patience_s: 20.0 };
    let duration_s = 1e-3 * (PROGRAMS * TICKS) as f64;
    let (hub, peers, said) = std::thread::scope(|scope| {
        let hub = scope.spawn(|| hub::run(&scene, &key, 3, address, span(duration_s + 1.0), &quiet, &stop));
        let peer = |line: u32| {
            let (scene, quiet, stop, key) = (&scene, &quiet, &stop, key.line(line));
            let listen = SocketAddr::from(([127, 0, 0, 1], 0));
            scope.spawn(move || {
                cohold_live::peer::run(scene, key, number_on(line), [listen, address], span(duration_s), quiet, stop)
            })
        };
        let peers = [1, 2].map(peer);
        let said = scope.spawn(|| hostile(&scene, key.line(3), address, &over));
        let (peers, hub) = (peers.map(|peer| peer.join().expect("it ends")), hub.join().expect("it ends"));
        over.store(true, Ordering::Relaxed);
        (hub.expect("a report"), peers.map(|peer| peer.expect("a report")), said.join().expect("it ends"))
    });
    // On a busy machine fewer.
    assert!(said > PROGRAMS * TICKS / 10, "{said} flows");
    let (packets, object_mm, made_mj) = (hub.packets, hub.object_mm, hub.energy_made_mj);
    assert!(
        packets as f64 >= 1e3 * duration_s && object_mm.is_finite() && made_mj <= 15.0,
        "{packets} packet periods, {object_mm} mm, {made_mj} mJ made"
    );
    let why = hub.lines[2].refused.as_deref().unwrap_or_default();
    assert!(why.contains("says what cannot be"), "{why}");
    for line in &hub.lines[..2] {
        assert!(line.refused.is_none() && line.energy.sent_j.is_finite() && line.lives == 1, "{:?}", line.refused);
    }
    for peer in peers {
        let force_n = peer.forces.contact_force_n;
        assert!(peer.forces.coordination_force_n.is_finite() && peer.decoded_discrepancy_mm.is_finite(), "{force_n:?}");
        let fault = peer.fault.unwrap_or_default();
        assert!(!fault.contains("fault 1:") && !fault.contains("fault 7:"), "{fault}");
    }
}
