//! A flood of forged datagrams against two nodes on loopback, while they hold their object.
//!
//! Two nodes run in two threads, each on a socket of its own; a third thread has no key, knows both addresses and has seen
//! everything that either peer took, and sends them, as fast as it is asked to:
//!
//! | kind | what |
//! |---|---|
//! | random | up to 160 random bytes |
//! | altered | what was taken, with one bit flipped |
//! | replayed | what was taken, once more |
//! | reflected | what was taken, back to its sender |
//! | cut | what was taken, shorter or longer |
//!
//! Everything that comes from the third address is forged, so a peer that takes any of it is wrong, and so is one whose
//! state is another afterwards: link, newest flow and the whole peer, compared as text for one forged datagram in
//! 64 and as far as the other peer could tell for all. The one thing a stranger can do is to make a peer say
//! welcome once more, by an old hello (a limit that `cohold_protocol::handshake` states); those are counted apart.
//!
//! The system drops what does not fit into a socket's buffer, valid or forged; how much of the valid flow came through is
//! measured. The two nodes take every tick together, and their links' time is counted in ticks: on a machine that is slow,
//! time is slow, and what is found is found there too. The flood does not wait for them.

use std::net::SocketAddr;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Barrier, Mutex, PoisonError};
use std::time::{Duration, Instant};

use cohold_live::Error;
use cohold_live::endpoint::{Endpoint, Live, Stop, Ticker};
use cohold_live::key_file::entropy;
use cohold_live::node::Node;
use cohold_protocol::{key::Key, link::Notice, link::Stage, wire::Greeting};
use cohold_sim::engine::{Actor, Out};
use cohold_sim::{rng::Rng, scene::Scene};

/// Of so many forged datagrams that are refused, one has the whole state compared.
const COMPARE_EVERY: u64 = 64;
/// Ticks for the two peers to engage before the flood.
const CALM_TICKS: u64 = 400;
/// Ticks after the flood in which the flow must become whole.
const AFTER_TICKS: u64 = 400;
/// What a stranger remembers of each peer.
const REMEMBERED: usize = 256;
/// Longest datagram that a stranger makes up.
const LONGEST: usize = 160;
/// How often a flood is refilled.
const BURST: Duration = Duration::from_micros(500);

/// Kinds of forged datagrams: random, altered, replayed, reflected, cut.
const KINDS: usize = 5;

/// What one peer went through.
#[derive(Clone, Debug, Default)]
pub(super) struct Attacked {
    /// Forged datagrams that arrived during the flood.
    pub forged_arrived: u64,
    /// Forged datagrams that were refused.
    pub forged_refused: u64,
    /// Old hellos that were answered with a welcome.
    pub hellos_answered: u64,
    /// As anything else: must be 0.
    pub forged_taken: u64,
    /// Comparisons of the whole state before and after a forged datagram.
    pub states_compared: u64,
    /// By a forged datagram: must be 0.
    pub states_changed: u64,
    /// Whether the session lasted from before the flood to the end.
    pub session_stayed: bool,
    /// Whether the coordination acted at the end.
    pub engaged: bool,
    /// Share of the other peer's flow that came through during the flood.
    pub flow_through: f64,
    /// From the end of the flood until nothing was missing any more, ms.
    pub whole_after_ms: u64,
}

/// What the threads share.
struct Field {
    /// What each peer took, for a stranger to see.
    seen: [Mutex<Vec<Vec<u8>>>; 2],
    tick: Barrier,
    /// The tick that is on.
    now: AtomicU64,
    /// First and last tick of the flood; 0 before it is known.
    flood: [AtomicU64; 2],
}

/// Holds the scene's object through a flood of so many datagrams per second on both peers together; gives how many of each kind were
/// sent, and what either peer went through.
pub(super) fn run(scene: &Scene, rate_per_s: f64, seconds: f64) -> Result<([u64; KINDS], [Attacked; 2]), Error> {
    let endpoint = || Endpoint::polled(SocketAddr::from(([127, 0, 0, 1], 0)));
    let (endpoints, stranger) = ([endpoint()?, endpoint()?], endpoint()?);
    let addresses = endpoints.each_ref().map(|endpoint| endpoint.address);
    let key = Key::new(entropy()?);
    let nodes = [<Node>::build(scene, 1, key.clone(), entropy()?)?, <Node>::build(scene, 2, key, entropy()?)?];
    let period = Duration::from_secs_f64(scene.peer.timing.control_period_s);
    let field =
        Field { seen: Default::default(), tick: Barrier::new(2), now: AtomicU64::new(0), flood: Default::default() };

    let (flooded, held) = std::thread::scope(|scope| {
        let flood = scope.spawn(|| flood(&field, &stranger, addresses, [rate_per_s, seconds]));
        let peers: Vec<_> = (nodes.into_iter().zip(&endpoints).enumerate())
            .map(|(index, (node, endpoint))| {
                let (field, period_us, other) = (&field, period.as_micros() as u64, addresses[1 - index]);
                let (attacked, flows) = (Attacked::default(), Vec::new());
                let mut held = Held { field, index, node, other, now: 0, period_us, over: false, attacked, flows };
                let ticker = Ticker::realtime(period);
                scope.spawn(move || endpoint.run(ticker, f64::MAX, &Stop::default(), &mut held).map(|_| held))
            })
            .collect();
        let held: Vec<_> = peers.into_iter().map(std::thread::ScopedJoinHandle::join).collect();
        (flood.join(), held)
    });
    let ended = "one of its threads ended";
    let sent = flooded.map_err(|_| ended)?;
    let held = held.into_iter().map(|held| held.map_err(|_| ended)?).collect::<Result<Vec<_>, Error>>()?;
    let packet = u64::from(scene.peer.timing.ticks_per_packet);
    let ticks = field.now.load(Ordering::Relaxed);
    let [from, to] = [0, 1].map(|end: usize| field.flood[end].load(Ordering::Relaxed));
    let ms = |ticks: u64| (ticks as f64 * 1e3 * period.as_secs_f64()).round() as u64;
    let mut attacked = held.into_iter().map(|held| evaluate(held, from..to, ticks, packet, &ms));
    Ok((sent, [(); 2].map(|()| attacked.next().unwrap_or_default())))
}

/// One peer, from its first tick to the end.
struct Held<'a> {
    field: &'a Field,
    index: usize,
    node: Node,
    other: SocketAddr,
    /// The tick that is on.
    now: u64,
    period_us: u64,
    over: bool,
    attacked: Attacked,
    /// When each flow that came was sent, and when it came, ticks.
    flows: Vec<[u64; 2]>,
}

impl Actor<SocketAddr> for Held<'_> {
    type Packet = [u8];

    fn hear(&mut self, _: u64, from: SocketAddr, datagram: &mut [u8], _: &mut Out<'_, SocketAddr, [u8]>) {
        let now_us = self.now * self.period_us;
        if from != self.other {
            return forged(&mut self.node, &mut self.attacked, now_us, datagram);
        }
        let copy = datagram.to_vec();
        if let Ok(flow) = self.node.receive(now_us, datagram) {
            let mut seen = self.field.seen[self.index].lock().unwrap_or_else(PoisonError::into_inner);
            if seen.len() >= REMEMBERED {
                seen.remove(0);
            }
            seen.push(copy);
            if let Some(flow) = flow {
                // The first tick is 0.
                self.flows.push([u64::from(flow.tick), self.now]);
            }
        }
    }

    fn act(&mut self, _: u64, out: &mut Out<'_, SocketAddr, [u8]>) {
        let Self { field, node, now, period_us, .. } = self;
        node.tick(*now * *period_us, |bytes| out(self.other, bytes));
        *now += 1;
        // Both peers end a tick before either begins the next, and have read the same of the flood.
        if field.tick.wait().is_leader() {
            field.now.store(*now, Ordering::Relaxed);
        }
        let over = field.flood[1].load(Ordering::Relaxed);
        field.tick.wait();
        self.over = over > 0 && *now > over + AFTER_TICKS;
        // Nothing at all, which is refused: brings the link's time to now, so that only what a datagram does is compared.
        let _ = node.receive(*now * *period_us, &mut []);
    }
}

impl Live for Held<'_> {
    fn end(&mut self) -> Option<Result<(), Error>> {
        self.over.then_some(Ok(()))
    }
}

/// What a datagram of a third party must never change: stage of the link, packets taken, events under way, tick of the newest flow, and
/// whether the peer is engaged.
fn standing(node: &Node) -> (Stage, u32, usize, Option<u32>, bool) {
    let link = &node.line.link;
    let tick = node.line.inbox.newest().map(|flow| flow.tick);
    (link.stage(), link.counts().taken, link.events_under_way(), tick, node.peer.is_engaged())
}

/// All that a datagram could change, as text: link, newest flow and the peer, but for the count of refused datagrams.
fn fingerprint(node: &Node) -> String {
    let link = format!("{:?}", node.line.link);
    // The last field of all.
    let link = link.rfind("refused: ").map_or(link.as_str(), |end| &link[..end]);
    format!("{link} {:?} {:?} {:?}", node.line.inbox, node.line.heard, node.peer)
}

/// What a peer does with a datagram of the stranger's.
fn forged(node: &mut Node, seen: &mut Attacked, now_us: u64, datagram: &mut [u8]) {
    seen.forged_arrived += 1;
    let whole = seen.forged_arrived.is_multiple_of(COMPARE_EVERY);
    let (before, text) = (standing(node), whole.then(|| fingerprint(node)));
    let verdict = node.receive(now_us, datagram);
    seen.states_changed += u64::from(before != standing(node));
    match verdict {
        Err(_) => {
            seen.forged_refused += 1;
            if let Some(text) = text {
                seen.states_compared += 1;
                seen.states_changed += u64::from(text != fingerprint(node));
            }
        }
        Ok(None) if datagram.get(1).is_some_and(|kind| Greeting::is_kind(*kind)) => {
            seen.hellos_answered += 1;
        }
        Ok(_) => seen.forged_taken += 1,
    }
}

/// The stranger: waits for calm, floods, says when it was; gives how many of each kind it sent.
fn flood(
    field: &Field,
    endpoint: &Endpoint,
    addresses: [SocketAddr; 2],
    [rate_per_s, seconds]: [f64; 2],
) -> [u64; KINDS] {
    while field.now.load(Ordering::Relaxed) < CALM_TICKS {
        std::thread::sleep(BURST);
    }
    let mut random = Rng::new(1);
    let (mut sent, mut total, mut seen) = ([0; KINDS], 0_u64, [Vec::new(), Vec::new()]);
    let start = Instant::now();
    field.flood[0].store(field.now.load(Ordering::Relaxed), Ordering::Relaxed);
    loop {
        let spent_s = start.elapsed().as_secs_f64();
        for (seen, all) in seen.iter_mut().zip(&field.seen) {
            seen.clone_from(&*all.lock().unwrap_or_else(PoisonError::into_inner));
        }
        // What could not be sent in time is not made up for: a burst is no rate.
        let due = (rate_per_s * spent_s.min(seconds)) as u64;
        let most = (2.0 * rate_per_s * BURST.as_secs_f64()).ceil() as u64;
        for _ in 0..due.saturating_sub(total).min(most) {
            let [kind, to] = [KINDS, 2].map(|most| random.below(most as u64) as usize);
            let (to, datagram) = forge(kind, to, &seen, &mut random);
            sent[kind] += u64::from(endpoint.send(addresses[to], &datagram));
        }
        total = due;
        if spent_s >= seconds {
            break;
        }
        std::thread::sleep(BURST);
    }
    field.flood[1].store(field.now.load(Ordering::Relaxed), Ordering::Relaxed);
    sent
}

/// A forged datagram of one of [`KINDS`], and the peer it goes to.
fn forge(kind: usize, to: usize, seen: &[Vec<Vec<u8>>; 2], random: &mut Rng) -> (usize, Vec<u8>) {
    let mut below = |most: usize| random.below(most as u64) as usize;
    let known = &seen[to];
    let mut bytes = match known.get(below(known.len())) {
        Some(bytes) if kind != 0 => bytes.clone(),
        _ => vec![0; below(LONGEST + 1)],
    };
    match kind {
        0 => bytes.fill_with(|| below(256) as u8),
        1 => {
            let bit = below(8 * bytes.len());
            if let Some(byte) = bytes.get_mut(bit / 8) {
                *byte ^= 1 << (bit % 8);
            }
        }
        3 => return (1 - to, bytes),
        4 => {
            let whole = bytes.len();
            let len = below(LONGEST);
            bytes.resize(if len == whole { len + 1 } else { len }, 0);
        }
        _ => {}
    }
    (to, bytes)
}

/// What a peer's notes say about a flood in the ticks `flood`.
fn evaluate(
    held: Held<'_>,
    flood: std::ops::Range<u64>,
    ticks: u64,
    packet: u64,
    ms: &impl Fn(u64) -> u64,
) -> Attacked {
    let Held { attacked, flows, node, period_us, .. } = held;
    let lost = |&(at_us, notice): &(u64, Notice)| notice == Notice::Lost && at_us >= flood.start * period_us;
    // Flow is sent every packet period.
    let phase = flows.last().map_or(0, |[sent, _]| sent % packet);
    let sent = |ticks: std::ops::Range<u64>| ticks.filter(move |tick| tick % packet == phase);
    let came = |tick: &u64| flows.binary_search_by_key(tick, |[sent, _]| *sent).is_ok();
    // Up to the last that may still be on its way.
    let missing = sent(flood.end..ticks.saturating_sub(2 * packet)).filter(|tick| !came(tick)).max();
    Attacked {
        session_stayed: flows.first().is_some_and(|[_, first]| *first < flood.start)
            && !node.line.notices.iter().any(lost),
        engaged: node.peer.is_engaged(),
        flow_through: sent(flood.clone()).filter(came).count() as f64 / sent(flood.clone()).count().max(1) as f64,
        whole_after_ms: missing.map_or(0, |sent| ms(sent + packet - flood.end)),
        ..attacked
    }
}
