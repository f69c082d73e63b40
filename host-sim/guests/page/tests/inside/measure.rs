//! How well the control loop keeps time without a window and with ten, and how soon a window is answered.
//!
//! The windows are of this process, over loopback, each on a thread of its own: they ask 60 times a second and read
//! what they get, as a page does; two of them hold a hand. Beside ten of them stand three connections that misbehave:
//! one that asks for all that is kept and never reads, one that says nothing after its handshake, one that never ends
//! its request.

use std::io::{Read as _, Write as _};
use std::net::{Ipv4Addr, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use cohold_live::endpoint::Stop;
use cohold_live::quantiles::{Quantiles, Times};
use cohold_report::Columns;
use cohold_sim::scene::Scene;
use tungstenite::protocol::Role as Side;
use tungstenite::{Message, WebSocket};

use crate::control_loop::Kept;
use crate::kinds::{EnvironmentKind, Kinds};
use crate::page::{At, Page, Shown};
use crate::partner::Model;
use crate::roles::Role;
use cohold_cli::Failure;

/// From one question of a window to the next.
const FRAME: Duration = Duration::from_micros(16_667);

/// A run with so many windows.
struct Run {
    windows: usize,
    misbehaving: usize,
    kept: Kept,
    answered: Quantiles,
}

/// Runs the control loop for `SECONDS` each (30 without it), without and with windows.
#[test]
#[ignore = "takes minutes, and tells of the machine"]
fn how_well_the_loop_keeps_time() {
    let seconds = std::env::var("SECONDS").map_or(30.0, |text| text.parse().expect("seconds"));
    let scene = cohold_sim::scenes::load(cohold_sim::Laws::built_in(), "any-network").expect("a scene");
    let of = |(windows, misbehaving)| run(&scene, seconds, &Stop::default(), windows, misbehaving).expect("it runs");
    let runs = [(0, 0), (2, 0), (10, 3)].map(of);
    let table = Columns::of(&runs)
        .value("windows", |run| run.windows)
        .value("misbehaving", |run| run.misbehaving)
        .value("ticks", |run| run.kept.ticks)
        .value("late", |run| run.kept.late)
        .means("ticks that began more than a millisecond late")
        .number("worst_ms", 3, |run| run.kept.worst_us as f64 * 1e-3)
        .value("slept", |run| run.kept.slept)
        .means("times that the beat was more than half a second behind and began anew")
        .value("realtime_priority", |run| run.kept.realtime_priority)
        .value("answers", |run| run.answered.samples)
        .number("answer_p50_ms", 3, |run| run.answered.p50_us * 1e-3)
        .means("from a window's question to its samples")
        .number("answer_p99_ms", 3, |run| run.answered.p99_us * 1e-3)
        .done();
    println!("{table}");
}

fn run(scene: &Scene, seconds: f64, stop: &Stop, windows: usize, misbehaving: usize) -> Result<Run, Failure> {
    let page = Page::serve(
        Kinds::default(),
        scene.clone(),
        Shown::Here(EnvironmentKind::Pair),
        Model::CarriesOn,
        At::default(),
    )?;
    let over = Arc::new(AtomicBool::new(false));
    let asking: Vec<_> = (0..windows)
        .map(|window| {
            // Two hold a hand, the others watch.
            let role = [Role::Hand1, Role::Hand2].get(window).copied().unwrap_or(Role::Watch);
            let (address, over) = (page.address(&[role]), Arc::clone(&over));
            std::thread::spawn(move || ask(&address, &over))
        })
        .collect();
    let bad: Vec<_> =
        (0..misbehaving).map(|which| misbehave(&page.address(&[Role::Watch]), which)).collect::<Result<_, _>>()?;
    let kept = page.run(seconds, None, stop)?;
    over.store(true, Ordering::Relaxed);
    let mut times = Times::default();
    for thread in asking {
        let answered = thread.join().map_err(|_| "a window's thread failed".to_owned())??;
        answered.into_iter().for_each(|ns| times.add(ns));
    }
    drop(bad);
    Ok(Run { windows, misbehaving, kept, answered: times.quantiles() })
}

/// Connects as a browser does.
pub(super) fn connect(address: &str) -> Result<TcpStream, Failure> {
    let failed = |cause: &dyn std::fmt::Display| format!("a window cannot open {address}: {cause}");
    let parts = address.strip_prefix("http://").and_then(|rest| rest.split_once("/#"));
    let (host, ring) = parts.ok_or_else(|| failed(&"it is not an address of the page"))?;
    let port = host.rsplit(':').next().and_then(|port| port.parse().ok()).unwrap_or(0);
    let mut stream = TcpStream::connect((Ipv4Addr::LOCALHOST, port)).map_err(|cause| failed(&cause))?;
    stream.set_nodelay(true).map_err(|cause| failed(&cause))?;
    stream.set_read_timeout(Some(Duration::from_secs(5))).map_err(|cause| failed(&cause))?;
    write!(
        stream,
        "GET /ws/{ring} HTTP/1.1\r\nHost: {host}\r\nOrigin: http://{host}\r\nUpgrade: websocket\r\n\
         Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
    )
    .map_err(|cause| failed(&cause))?;
    // The head of the answer, byte by byte: what follows belongs to the WebSocket.
    let mut head = Vec::new();
    let mut byte = [0];
    while !head.ends_with(b"\r\n\r\n") {
        stream.read_exact(&mut byte).map_err(|cause| failed(&cause))?;
        head.push(byte[0]);
    }
    if !head.starts_with(b"HTTP/1.1 101") {
        return Err(failed(&"it was refused").into());
    }
    Ok(stream)
}

/// A question: everything from this tick on, and no hand.
fn question(next: u32) -> Message {
    let mut bytes = next.to_le_bytes().to_vec();
    bytes.extend([f32::NAN; 3].into_iter().flat_map(f32::to_le_bytes));
    bytes.extend(0_u32.to_le_bytes());
    Message::Binary(bytes.into())
}

/// Asks once a frame until it is over; how long each answer took, ns.
fn ask(address: &str, over: &AtomicBool) -> Result<Vec<u64>, Failure> {
    let mut socket = WebSocket::from_raw_socket(connect(address)?, Side::Client, None);
    let (mut next, mut took) = (u32::MAX, Vec::new());
    let mut frame = Instant::now();
    while !over.load(Ordering::Relaxed) {
        let asked = Instant::now();
        if socket.send(question(next)).is_err() {
            break;
        }
        // The program ends before its windows do.
        let bytes = loop {
            match socket.read() {
                Ok(Message::Binary(bytes)) => break bytes,
                Ok(_) => {}
                Err(_) => return Ok(took),
            }
        };
        took.push(asked.elapsed().as_nanos() as u64);
        next = crate::web::next(&bytes, EnvironmentKind::Pair).ok_or("an answer is too short")?;
        frame += FRAME;
        std::thread::sleep(frame.saturating_duration_since(Instant::now()));
    }
    Ok(took)
}

/// A connection that misbehaves in one of three ways, for as long as it is kept.
fn misbehave(address: &str, which: usize) -> Result<TcpStream, Failure> {
    if which == 2 {
        let port = address.split(':').nth(2).and_then(|rest| rest.split('/').next()?.parse().ok()).unwrap_or(0);
        let mut stream = TcpStream::connect((Ipv4Addr::LOCALHOST, port))?;
        stream.write_all(b"GET / HTTP/1.1\r\nHost: ")?;
        return Ok(stream);
    }
    let stream = connect(address)?;
    if which == 0 {
        let mut asking = WebSocket::from_raw_socket(stream.try_clone()?, Side::Client, None);
        stream.set_write_timeout(Some(Duration::from_millis(100)))?;
        std::thread::spawn(move || while asking.send(question(u32::MAX)).is_ok() {});
    }
    Ok(stream)
}
