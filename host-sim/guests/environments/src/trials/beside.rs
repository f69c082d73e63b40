//! What the machine does without a server's work, to hold a crowd's figures against: a bare echo in the same batches, and sealing
//! by ring and openssl.
//!
//! **Echo**: a thread as the server's sends each datagram back as it came, on the same kind of sockets, under a load as the crowd's
//! ([`super::load`]) that sends as many datagrams a second as the server took, each as long as an answer is on the average; nothing
//! is opened, looked up or sealed. What a datagram costs falls with how many come in one batch, and who does less takes smaller ones:
//! so the mean batch is given as well. **Sealing**: 40
//! bytes under 16 of header, the least of 25 rounds; openssl by its own command, without a header, where that is installed.

use std::hint::black_box;
use std::net::SocketAddr;
use std::process::Command;
use std::time::{Duration, Instant};

use cohold_live::endpoint::{Endpoint, Live, Stop, Ticker};
use cohold_live::quantiles::Quantiles;
use cohold_protocol::cipher::Cipher;
use cohold_protocol::key::Key;
use cohold_sim::engine::{Actor, Out};
use ring::aead::{Aad, CHACHA20_POLY1305, LessSafeKey, Nonce, UnboundKey};
use serde::Serialize;

use super::load::{self, Clients, Span};
use crate::Error;
use crate::live::serve::Computed;
use crate::world::PACKET_US;

/// Length of a flow message, bytes.
const FLOW: usize = 40;
const HEAD: [u8; 16] = [0; 16];
/// Sealed in a round.
const CALLS: u64 = 20_000;

/// What a bare echo took.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Echo {
    /// Length of a datagram, bytes.
    pub bytes: usize,
    /// Echoed while it was measured.
    pub pairs: u64,
    /// Datagrams that came with one system call, mean.
    pub per_batch: f64,
    /// Share of one processor that the echo's thread took.
    pub cpu_share: Option<f64>,
    /// Processor time of the echo's thread for a datagram there and one back, user and system, µs.
    pub us_per_pair: Option<f64>,
    /// How late the load was with its packets.
    pub load_late: Quantiles,
}

/// Sealing 40 bytes, ns.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Sealing {
    /// As this program seals, ns.
    pub here_ns: f64,
    /// With the library `ring` called directly, ns.
    pub ring_ns: f64,
    /// `None` where there is no such command.
    pub openssl_ns: Option<f64>,
}

struct Echoing {
    warm_up_s: f64,
    /// When it is measured from, and what had been echoed by then.
    since: Option<(Computed, [u64; 2])>,
    /// Datagrams and batches.
    echoed: [u64; 2],
    /// The one in hand is the first of its batch.
    first: bool,
}

impl Actor<SocketAddr> for Echoing {
    type Packet = [u8];

    fn hear(&mut self, _: u64, from: SocketAddr, datagram: &mut [u8], out: &mut Out<'_, SocketAddr, [u8]>) {
        self.echoed[0] += 1;
        self.echoed[1] += u64::from(std::mem::take(&mut self.first));
        out(from, datagram);
    }

    fn act(&mut self, now_ns: u64, _: &mut Out<'_, SocketAddr, [u8]>) {
        if self.since.is_none() && 1e-9 * now_ns as f64 >= self.warm_up_s {
            self.since = Some((Computed::now(), self.echoed));
        }
    }
}

impl Live for Echoing {
    fn sent(&mut self, _: u64) {
        self.first = true;
    }
}

struct Callers<'a>(&'a [u8]);

impl Clients for Callers<'_> {
    fn exchange(&mut self, _: usize, _: u64, _: bool, say: &mut dyn FnMut(&[u8])) {
        say(self.0);
    }

    fn receive(&mut self, _: u64, _: bool, _: &mut [u8], _: &mut dyn FnMut(&[u8])) {}
}

/// Datagrams of so many bytes echoed, one in each packet period for each of `callers`, for so long.
pub fn echo(callers: u64, bytes: usize, span: Span, stop: &Stop) -> Result<Echo, Error> {
    let (loopback, start) = (SocketAddr::from(([127, 0, 0, 1], 0)), Instant::now());
    let (server, caller) = (Endpoint::answering(loopback)?.since(start), Endpoint::polled(loopback)?.since(start));
    let mut echoing = Echoing { warm_up_s: span.warm_up_s, since: None, echoed: [0; 2], first: true };
    let done = Stop::default();
    std::thread::scope(|scope| {
        let echo = scope.spawn(|| {
            let ticker = Ticker::realtime(Duration::from_micros(PACKET_US));
            server.run(ticker, f64::MAX, &done, &mut echoing)?;
            let (computed, before) = echoing.since.unwrap_or((Computed::now(), echoing.echoed));
            Ok::<_, Error>((computed.share(), computed.seconds(), [0, 1].map(|of| echoing.echoed[of] - before[of])))
        });
        let datagram = vec![0; bytes];
        let kept = load::run(&caller, server.address, callers, span, stop, &mut Callers(&datagram));
        done.ask();
        let (cpu_share, cpu_s, [pairs, batches]) = echo.join().map_err(|_| "the echo's thread ended".to_owned())??;
        let us_per_pair = cpu_s.map(|s| 1e6 * s / pairs.max(1) as f64);
        let per_batch = pairs as f64 / batches.max(1) as f64;
        Ok(Echo { bytes, pairs, per_batch, cpu_share, us_per_pair, load_late: kept?.late })
    })
}

/// ns of a call, the least of 25 rounds.
fn time(mut call: impl FnMut([u8; 12])) -> f64 {
    let nonce = |number: u64| {
        let mut nonce = [0; 12];
        nonce[4..].copy_from_slice(&number.to_le_bytes());
        nonce
    };
    let round = |_| {
        let start = Instant::now();
        (0..CALLS).for_each(|number| call(nonce(number)));
        start.elapsed().as_nanos() as f64 / CALLS as f64
    };
    (0..25).map(round).fold(f64::INFINITY, f64::min)
}

/// By openssl's own command, ns.
fn openssl() -> Option<f64> {
    let bytes = FLOW.to_string();
    let arguments = ["speed", "-seconds", "1", "-mr", "-evp", "chacha20-poly1305", "-bytes", &bytes];
    let said = Command::new("openssl").args(arguments).output().ok()?;
    // The last line ends with bytes a second.
    let rate = String::from_utf8_lossy(&said.stdout).lines().last()?.rsplit(':').next()?.parse::<f64>().ok()?;
    Some(1e9 * FLOW as f64 / rate)
}

/// Measures how long sealing a flow message takes.
pub fn sealing() -> Result<Sealing, Error> {
    let key = [7; Key::LEN];
    let (ours, mut message) = (Cipher::new(&Key::new(key)), [0; FLOW]);
    let theirs = UnboundKey::new(&CHACHA20_POLY1305, &key).map_err(|_| "ring takes no key".to_owned())?;
    let theirs = LessSafeKey::new(theirs);
    let here_ns = time(|nonce| _ = black_box(ours.seal(nonce, &HEAD, &mut message)));
    let ring_ns = time(|nonce| {
        let nonce = Nonce::assume_unique_for_key(nonce);
        _ = black_box(theirs.seal_in_place_separate_tag(nonce, Aad::from(&HEAD), &mut message));
    });
    Ok(Sealing { here_ns, ring_ns, openssl_ns: openssl() })
}
