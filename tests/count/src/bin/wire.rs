//! Instructions of the wire on the processor of the board: sealing, opening and refusing a datagram, and joining.
//!
//! Two links in one program, so that each opens what the other has sealed. Every figure is the mean of [`CALLS`] calls of
//! the public functions that the board's network task calls, buffers already in place; the refusals leave the session up, which
//! is checked. Instructions, not cycles (`lib.rs`).
#![no_std]
#![no_main]

use core::hint::black_box;

use cortex_m_rt::entry;
use cortex_m_semihosting::hprintln;
use cohold_protocol::ends::Ends;
use cohold_protocol::key::Key;
use cohold_protocol::link::{Config, Link, Stage};
use cohold_protocol::parameters::{Parameters, Table};
use cohold_protocol::wire::{AxisFlow, Datagram, Flow, MAX_DATAGRAM, Message, PeerId};

/// Packet periods in which everything is done once.
const CALLS: u32 = 100;
const PERIOD_US: u64 = 8_000;

/// Link of peer `local` in its n-th life.
fn link(local: u8, life: u8) -> Link {
    let mut parameters = Parameters::new();
    let _ = parameters.add(Table::new("timing").number("control_period_s", 0.001));
    let ends = Ends { local: PeerId(local), remote: PeerId(3 - local) };
    let mut entropy = [local; Key::LEN];
    entropy[0] = life;
    let config = Config { key: Key::new([7; Key::LEN]), ends, packet_period_us: PERIOD_US as u32, parameters, entropy };
    match Link::new(config) {
        Ok(link) => link,
        Err(error) => panic!("{error}"),
    }
}

/// Instructions of something done many times.
#[derive(Default)]
struct Row {
    sum: u64,
    calls: u32,
}

impl Row {
    #[inline(always)]
    fn count<O>(&mut self, body: impl FnOnce() -> O) -> O {
        let (out, instructions) = counting::counted(body);
        self.sum += u64::from(instructions);
        self.calls += 1;
        out
    }

    fn mean(&self) -> u64 {
        (self.sum + u64::from(self.calls / 2)) / u64::from(self.calls.max(1))
    }
}

#[inline(never)]
fn send(link: &mut Link, now: u64, flow: &Flow, out: &mut Datagram) -> usize {
    link.send(now, *flow, out).unwrap_or(0)
}

#[inline(never)]
fn poll(link: &mut Link, now: u64, out: &mut Datagram) -> usize {
    link.poll(now, out).unwrap_or(0)
}

/// Whether it was taken, and as flow.
#[inline(never)]
fn receive(link: &mut Link, now: u64, datagram: &mut [u8]) -> (bool, bool) {
    let taken = link.receive(now, datagram);
    (taken.is_ok(), matches!(taken, Ok(Some(Message::Flow(_)))))
}

/// Hello, welcome and the first sealed datagram: what each side does until it has keys.
fn join(rows: &mut [Row; 4], life: u8) -> [Link; 2] {
    let [hello, answer, accept, last] = rows;
    let (mut one, mut two) = (link(1, life), link(2, life));
    let mut out = [0; MAX_DATAGRAM];
    let len = hello.count(|| poll(&mut one, 0, &mut out));
    answer.count(|| {
        receive(&mut two, 0, &mut out[..len]);
        poll(&mut two, 0, &mut out)
    });
    let (taken, _) = accept.count(|| receive(&mut one, 0, &mut out));
    let len = poll(&mut one, 0, &mut out);
    let (also, _) = last.count(|| receive(&mut two, 0, &mut out[..len]));
    assert!(taken && also && one.stage() == Stage::Joining && two.stage() == Stage::Joining);
    for now in [1_000, 2_000, 3_000] {
        for turn in 0..2 {
            let (from, to) = if turn == 0 { (&mut one, &mut two) } else { (&mut two, &mut one) };
            while let Some(len) = from.poll(now, &mut out) {
                let _ = to.receive(now, &mut out[..len]);
            }
        }
    }
    [one, two]
}

#[entry]
fn main() -> ! {
    counting::start();
    let mut joining: [Row; 4] = Default::default();
    let mut links = join(&mut joining, 0);
    for life in 1..20 {
        links = join(&mut joining, life);
    }
    let [one, two] = &mut links;
    let (mut seal, mut open, mut altered, mut replayed, mut reflected, mut random, mut idle) = (
        Row::default(),
        Row::default(),
        Row::default(),
        Row::default(),
        Row::default(),
        Row::default(),
        Row::default(),
    );
    let mut out = [0; MAX_DATAGRAM];
    for call in 0..CALLS {
        let now = PERIOD_US * u64::from(call + 1);
        let along = AxisFlow { position: 0.01, wave: -0.5, energy_sent: 1.0, ..AxisFlow::default() };
        let flow = Flow { engaged: true, tick: 8 * call, axes: [along], ..Flow::default() };
        let len = seal.count(|| send(one, now, black_box(&flow), &mut out));
        assert!(len > Flow::LEN);
        let sealed = out;

        let mut came = sealed;
        came[len - 1 - call as usize % 40] ^= 1;
        let (taken, _) = altered.count(|| receive(two, now, &mut came[..len]));
        assert!(!taken);
        came = sealed;
        let (_, flowed) = open.count(|| receive(two, now, &mut came[..len]));
        assert!(flowed);
        came = sealed;
        let (taken, _) = replayed.count(|| receive(two, now, &mut came[..len]));
        assert!(!taken);
        came = sealed;
        let (taken, _) = reflected.count(|| receive(one, now, &mut came[..len]));
        assert!(!taken);
        came = [0xa5; MAX_DATAGRAM];
        let (taken, _) = random.count(|| receive(two, now, &mut came[..len]));
        assert!(!taken);

        // The rest of the period: probes, replies, and in the end nothing to say.
        for turn in 0..2 {
            let (from, to) = if turn == 0 { (&mut *one, &mut *two) } else { (&mut *two, &mut *one) };
            while let Some(len) = from.poll(now, &mut out) {
                let _ = to.receive(now, &mut out[..len]);
            }
        }
        assert!(idle.count(|| poll(two, now, &mut out)) == 0);
    }
    assert!(two.stage() == Stage::Running);
    let [hello, answer, accept, last] = joining;

    hprintln!(
        "# Instructions per call, Cortex-M7 (thumbv7em, QEMU), release build. Flow is 40 bytes, sealed with ChaCha20-Poly1305."
    );
    hprintln!("# Counted by `cargo xtask count`. Instructions, not cycles.");
    for (what, row) in [
        ("seal and send a flow", seal),
        ("open and take a flow", open),
        ("refuse an altered datagram", altered),
        ("refuse a replayed datagram", replayed),
        ("refuse a reflected datagram", reflected),
        ("refuse random bytes", random),
        ("poll with nothing to say", idle),
        ("say hello", hello),
        ("take a hello, answer with a welcome", answer),
        ("take a welcome, make the keys", accept),
        ("take the second hello, make the keys", last),
    ] {
        hprintln!("{:<38} {:>7}", what, row.mean());
    }
    counting::end(true)
}
