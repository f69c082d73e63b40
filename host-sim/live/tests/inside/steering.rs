//! A live peer that is steered: two on loopback, in real time.

use std::net::{SocketAddr, UdpSocket};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use cohold_protocol::key::Key;
use cohold_sim::Laws;
use cohold_sim::scene::Scene;

use super::*;
use crate::Error;
use crate::endpoint::{Span, Stop};
use crate::peer::{self, Report};
use crate::tell::Manner;
use crate::watch::LiveOptions;

type Peer = (Arc<Steering>, Stop, JoinHandle<Result<Report, Error>>);

fn ends() -> [SocketAddr; 2] {
    let sockets = [(); 2].map(|()| UdpSocket::bind("127.0.0.1:0").expect("a socket on loopback"));
    sockets.map(|socket| socket.local_addr().expect("its address"))
}

/// Peer `number`, wanted armed or not, without an end of its own.
fn peer(number: u8, ends: [SocketAddr; 2], armed: bool, patience_s: f64) -> Peer {
    let (steering, stop) = (Arc::new(Steering::new(armed)), Stop::default());
    let wanted = LiveOptions { manner: Manner::Quiet, steering: Some(steering.clone()), ..LiveOptions::default() };
    let own = stop.clone();
    let thread = std::thread::spawn(move || {
        let scene = Scene::load(Laws::built_in(), None, &[]).expect("the default scene");
        let span = Span { duration_s: f64::INFINITY, patience_s };
        peer::run(&scene, Key::new([7; Key::LEN]), number, ends, span, &wanted, &own)
    });
    (steering, stop, thread)
}

fn until(what: &str, is_so: impl Fn() -> bool) {
    let by = Instant::now() + Duration::from_secs(20);
    while !is_so() {
        assert!(Instant::now() < by, "{what}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

fn report((_, stop, thread): Peer) -> Report {
    stop.ask();
    thread.join().expect("a thread that has not failed").expect("a report")
}

#[test]
fn it_arms_when_that_is_wanted_and_lets_go_when_it_is_not() {
    let [left, right] = ends();
    // Not wanted armed it outlasts its patience; once it is, that counts from then.
    let (one, other) = (peer(1, [left, right], false, 1.0), peer(2, [right, left], true, 20.0));
    std::thread::sleep(Duration::from_millis(1_200));
    let seen = one.0.snapshot();
    assert!(seen.has_begun && seen.state == "held" && seen.tick == 0, "{seen:?}");
    one.0.want(|wanted| wanted.armed = true);
    until("armed", || one.0.snapshot().state == "armed" && other.0.snapshot().state == "armed");
    one.0.want(|wanted| wanted.pull_n[0] = 1.0);
    until("pushed back", || one.0.snapshot().force_n[0] < -0.3);
    one.0.want(|wanted| wanted.clutch = true);
    until("free", || one.0.snapshot().force_n[0] == 0.0);
    assert_eq!(one.0.snapshot().state, "armed");
    one.0.want(|wanted| *wanted = Wanted::default());
    until("off", || one.0.snapshot().state == "held");
    assert_eq!(one.0.snapshot().force_n, [0.0; AXES]);
    let report = report(one);
    assert!(report.ticks > 0 && report.decoded_discrepancy_mm.is_finite() && report.fault.is_none(), "{report:?}");
    self::report(other);
}

#[test]
fn patience_counts_from_when_it_was_wanted() {
    let [left, right] = ends();
    let (steering, stop, thread) = peer(1, [left, right], false, 0.3);
    std::thread::sleep(Duration::from_millis(600));
    assert!(!thread.is_finished(), "not wanted armed, it misses nobody");
    steering.want(|wanted| wanted.armed = true);
    let why = thread.join().expect("a thread that has not failed").expect_err("nobody is there").to_string();
    assert!(why.starts_with("nobody answered") && !stop.is_asked(), "{why}");
}
