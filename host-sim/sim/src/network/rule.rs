//! [`Rule`]: what becomes of each packet, how late it arrives, how often, broken or not at all.
//!
//! A rule is drawn from a seed by the scene's `network` table, read from a trace, or any closure.

use std::sync::Arc;

use super::fitted::{FittedRule, Like};
use crate::rng::Rng;
use crate::scene::{Network, Scene};

pub use super::measured::Arrival;
pub use super::measured::Found;
pub use super::trace::{Direction, NetworkTrace, nanoseconds, seconds};
pub use crate::scene::Jitter;

/// The copy of a packet that is neither late nor broken.
const IN_TIME: Arrival = Arrival { delay_ns: 0, corrupt: false };

/// What becomes of a packet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Fate {
    /// It arrives after the constant delay.
    Pass,
    /// The packet is lost.
    Drop,
    /// These copies of it arrive; none, and it is lost.
    Copies(Vec<Arrival>),
}

impl Fate {
    /// One intact copy that arrives this much later than the constant delay, ns.
    pub fn late(delay_ns: u64) -> Self {
        Self::Copies(vec![Arrival { delay_ns, corrupt: false }])
    }

    /// The copies that arrive.
    pub fn copies(self) -> Vec<Arrival> {
        match self {
            Self::Pass => vec![IN_TIME],
            Self::Drop => Vec::new(),
            Self::Copies(copies) => copies,
        }
    }
}

/// Decides what becomes of every packet in one direction of a network.
///
/// The network table of a scene is a rule, a recorded trace is one, and so is any closure: `|number, _| if number % 3 == 0
/// { Fate::Drop } else { Fate::Pass }` loses every third packet in the [`crate::engine`], in a relay and in a test alike.
pub trait Rule: Send {
    /// What becomes of packet `number`, counted from 0 in the order of sending, which is sent at `sent_ns`. Numbers are missing where the
    /// sender says which packet period it is and kept silent in some.
    fn decide(&mut self, number: u64, sent_ns: u64) -> Fate;
}

impl<F: FnMut(u64, u64) -> Fate + Send> Rule for F {
    fn decide(&mut self, number: u64, sent_ns: u64) -> Fate {
        self(number, sent_ns)
    }
}

/// The rule of a scene's network in one direction, on line `line` of several with streams of their own; `None` if all that
/// the network does is delay by whole packets.
pub fn of_scene(scene: &Scene, direction: Direction, line: u32) -> Option<Box<dyn Rule>> {
    if let Some(trace) = &scene.network_trace {
        return Some(Box::new(RecordedRule { trace: Arc::clone(trace), direction }));
    }
    let network = scene.world.network;
    let plain = Network {
        one_way_delay_packets: network.one_way_delay_packets,
        playout_packets: network.playout_packets,
        clock_drift_ppm: network.clock_drift_ppm,
        seed: network.seed,
        ..Network::default()
    };
    let own = Network { seed: network.seed.wrapping_add(line), ..network };
    if network.like != Like::None {
        return Some(Box::new(FittedRule::new(own, direction)));
    }
    let packet_s = scene.peer.timing.packet_period_s();
    (network != plain).then(|| -> Box<dyn Rule> { Box::new(SeededRule::new(own, direction, packet_s)) })
}

/// Bits of one packet on the wire: a sealed flow message with its Ethernet, IP and UDP headers.
const PACKET_BITS: f64 = 8.0 * 110.0;

/// One direction of a recording.
#[derive(Clone, Debug)]
struct RecordedRule {
    trace: Arc<NetworkTrace>,
    direction: Direction,
}

impl Rule for RecordedRule {
    fn decide(&mut self, number: u64, sent_ns: u64) -> Fate {
        Fate::Copies(self.trace.of(self.direction, number, sent_ns).to_vec())
    }
}

/// A rule that draws the impairments of a `network` table from its seed.
#[derive(Clone, Debug)]
pub struct SeededRule {
    network: Network,
    direction: Direction,
    packet_s: f64,
    rng: Rng,
    /// In a run of losses (Gilbert–Elliott).
    losing: bool,
    /// The number of the next packet, if one is sent each packet period.
    next: u64,
    /// When the line is free again, s.
    free_s: f64,
}

impl SeededRule {
    /// As `network` describes it for packets every `packet_s` seconds; each direction has its own stream.
    pub fn new(network: Network, direction: Direction, packet_s: f64) -> Self {
        let rng = Rng::new(u64::from(network.seed) | (direction as u64) << 32);
        Self { network, direction, packet_s, rng, losing: false, next: 0, free_s: 0.0 }
    }

    fn lost(&mut self) -> bool {
        let (loss, burst) = (self.network.loss, self.network.loss_burst_packets);
        if burst <= 1.0 {
            return self.rng.chance(loss);
        }
        // Mean run of `burst` losses; entered so often that `loss` of all packets fall into one.
        let change = if self.losing { 1.0 / burst } else { loss / (burst * (1.0 - loss)) };
        if self.rng.chance(change) {
            self.losing = !self.losing;
        }
        self.losing
    }

    fn delay(&mut self, sent_s: f64) -> f64 {
        let network = self.network;
        let mut delay = network.extra_delay_s;
        if self.direction == Direction::TwoToOne {
            delay += network.asymmetry_s;
        }
        if sent_s >= network.delay_step_at_s {
            delay += network.delay_step_s;
        }
        delay += match network.jitter {
            Jitter::None => 0.0,
            Jitter::Uniform => network.jitter_s * self.rng.unit(),
            // Two exponentials of half the mean.
            Jitter::Gamma => {
                -0.5 * network.jitter_s * (libm::log(1.0 - self.rng.unit()) + libm::log(1.0 - self.rng.unit()))
            }
            // P(X > x) = (1 + x/λ)^-2, cut at 99·λ: its mean is 0.99·λ, and the cut 100 times that.
            Jitter::Pareto => {
                let scale_s = network.jitter_s / 0.99;
                (scale_s * (1.0 / libm::sqrt(1.0 - self.rng.unit()) - 1.0)).min(99.0 * scale_s)
            }
        };
        delay
    }

    /// How much later a packet is, so that its block arrives in reverse order, a packet a packet period, when its last is sent.
    fn held_back(&self, number: u64) -> f64 {
        let block = u64::from(self.network.reverse_block_packets.max(1));
        2.0 * (block - 1 - number % block) as f64 * self.packet_s
    }
}

impl Rule for SeededRule {
    fn decide(&mut self, number: u64, sent_ns: u64) -> Fate {
        let (network, sent_s) = (self.network, seconds(sent_ns));
        if network.loss_burst_packets > 1.0 {
            // A burst goes on through packet periods in which nothing is sent.
            (self.next..number).for_each(|_| _ = self.lost());
        }
        self.next = number + 1;
        if self.lost() {
            return Fate::Drop;
        }
        let mut queued = 0.0;
        if network.bandwidth_bit_per_s > 0.0 {
            self.free_s = self.free_s.max(sent_s) + PACKET_BITS / network.bandwidth_bit_per_s;
            queued = self.free_s - sent_s;
        }
        let copies = 1 + usize::from(self.rng.chance(network.duplicate));
        let mut copy = |_| {
            let mut delay_s = queued + self.held_back(number) + self.delay(sent_s);
            if self.rng.chance(network.reorder) {
                delay_s += f64::from(network.reorder_depth_packets) * self.packet_s * self.rng.unit();
            }
            // No packet arrives before the constant delay is over, whatever steps are asked for.
            Arrival { delay_ns: nanoseconds(delay_s.max(0.0)), corrupt: self.rng.chance(network.corrupt) }
        };
        if copies == 1 {
            let one = copy(0);
            // Most packets are not late: nothing is allocated for them.
            return if one == IN_TIME { Fate::Pass } else { Fate::Copies(vec![one]) };
        }
        Fate::Copies((0..copies).map(copy).collect())
    }
}

impl NetworkTrace {
    /// Records the fates of the first `packets` packets of a scene, one sent in each packet period.
    pub fn record(scene: &Scene, packets: u64) -> Self {
        let packet_ns = scene.peer.timing.packet_period_ns();
        let half = |direction| {
            let mut rule = of_scene(scene, direction, 0);
            let fate = |number: u64| rule.as_mut().map_or(Fate::Pass, |rule| rule.decide(number, number * packet_ns));
            (0..packets).map(fate).map(Fate::copies).collect()
        };
        Self::of_packets([half(Direction::OneToTwo), half(Direction::TwoToOne)])
    }
}
