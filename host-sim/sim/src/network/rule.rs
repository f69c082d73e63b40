//! [`Rule`]: what becomes of each packet, how late it arrives, how often, broken or not at all.
//!
//! Drawn from a seed by the scene's `network` table, read from a trace, or said by any closure. A trace is the same list
//! written down, so that one recording impairs a run in memory, two processes and two boards alike:
//!
//! ```csv
//! direction,packet,delay_s,fate
//! 1,0,0.0031,arrives
//! 1,1,,lost
//! 2,0,0.0005,corrupt
//! ```
//!
//! `direction` is the sender (1 or 2), `delay_s` what is added to the constant delay; a packet with two rows arrives twice.
//! After its end a trace begins anew.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::rng::Rng;
use crate::scene::{Network, Scene};

/// Nanoseconds as seconds.
pub fn seconds(ns: u64) -> f64 {
    ns as f64 / 1e9
}

/// Seconds to the nearest nanosecond.
pub fn nanoseconds(s: f64) -> u64 {
    (1e9 * s).round() as u64
}

/// Which way a packet goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// From peer 1 to peer 2.
    OneToTwo,
    /// From peer 2 to peer 1.
    TwoToOne,
}

/// One copy of a packet that arrives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Arrival {
    /// Time on top of the constant delay, ns.
    pub delay_ns: u64,
    /// Its bits are no longer what was sent.
    pub corrupt: bool,
}

/// What becomes of a packet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Fate {
    /// It arrives after the constant delay.
    Pass,
    /// It never arrives.
    Drop,
    /// These copies of it arrive; none, and it is lost.
    Copies(Vec<Arrival>),
}

impl Fate {
    /// Whole, once, and this much later than the constant delay.
    pub fn late(delay_ns: u64) -> Self {
        Self::Copies(vec![Arrival { delay_ns, corrupt: false }])
    }

    /// The copies that arrive.
    pub fn copies(self) -> Vec<Arrival> {
        match self {
            Self::Pass => vec![Arrival { delay_ns: 0, corrupt: false }],
            Self::Drop => Vec::new(),
            Self::Copies(copies) => copies,
        }
    }
}

/// Says of every packet on one way of a network what becomes of it.
///
/// The network table of a scene is a rule, a recorded trace is one, and so is any closure: `|number, _| if number % 3 == 0
/// { Fate::Drop } else { Fate::Pass }` loses every third packet in the [`crate::engine`], in a relay and in a test alike.
pub trait Rule: Send {
    /// What becomes of packet `number`, counted from 0 in the order of sending, which is sent at `sent_ns`.
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
    let packet_s = scene.peer.timing.packet_period_s();
    (network != plain).then(|| -> Box<dyn Rule> { Box::new(SeededRule::new(own, direction, packet_s)) })
}

/// How the delay varies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Jitter {
    /// Not at all.
    None,
    /// Uniformly from 0 to jitter_s.
    Uniform,
    /// Gamma-distributed with shape 2 and mean jitter_s.
    Gamma,
}

impl haptic_core::names::Choice for Jitter {
    const NAMES: &'static [&'static str] = &["none", "uniform", "gamma"];
    const ALL: &'static [Self] = &[Self::None, Self::Uniform, Self::Gamma];
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
    fn decide(&mut self, number: u64, _: u64) -> Fate {
        Fate::Copies(self.trace.of(self.direction, number).to_vec())
    }
}

/// What a network table says, drawn from its seed.
#[derive(Clone, Debug)]
pub struct SeededRule {
    network: Network,
    direction: Direction,
    packet_s: f64,
    rng: Rng,
    /// In a run of losses (Gilbert–Elliott).
    losing: bool,
    /// When the line is free again, s.
    free_s: f64,
}

impl SeededRule {
    /// As `network` describes it for packets every `packet_s` seconds; each direction has its own stream.
    pub fn new(network: Network, direction: Direction, packet_s: f64) -> Self {
        let stream = match direction {
            Direction::OneToTwo => 0,
            Direction::TwoToOne => 1 << 32,
        };
        let rng = Rng::new(u64::from(network.seed) | stream);
        Self { network, direction, packet_s, rng, losing: false, free_s: 0.0 }
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
        };
        delay
    }
}

impl Rule for SeededRule {
    fn decide(&mut self, _: u64, sent_ns: u64) -> Fate {
        let (network, sent_s) = (self.network, seconds(sent_ns));
        if self.lost() {
            return Fate::Drop;
        }
        let mut queued = 0.0;
        if network.bandwidth_bit_per_s > 0.0 {
            self.free_s = self.free_s.max(sent_s) + PACKET_BITS / network.bandwidth_bit_per_s;
            queued = self.free_s - sent_s;
        }
        let copies = 1 + usize::from(self.rng.chance(network.duplicate));
        let copy = |_| {
            let mut delay_s = queued + self.delay(sent_s);
            if self.rng.chance(network.reorder) {
                delay_s += f64::from(network.reorder_depth_packets) * self.packet_s * self.rng.unit();
            }
            // No packet arrives before the constant delay is over, whatever steps are asked for.
            Arrival { delay_ns: nanoseconds(delay_s.max(0.0)), corrupt: self.rng.chance(network.corrupt) }
        };
        Fate::Copies((0..copies).map(copy).collect())
    }
}

/// A recording of what a network did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NetworkTrace {
    file: PathBuf,
    packets: [Vec<Vec<Arrival>>; 2],
}

impl NetworkTrace {
    /// What becomes of the first `packets` packets of a scene, sent each packet period.
    pub fn record(scene: &Scene, packets: u64) -> Self {
        let packet_ns = scene.peer.timing.packet_period_ns();
        let half = |direction| {
            let mut rule = of_scene(scene, direction, 0);
            let fate = |number: u64| rule.as_mut().map_or(Fate::Pass, |rule| rule.decide(number, number * packet_ns));
            (0..packets).map(fate).map(Fate::copies).collect()
        };
        Self { file: PathBuf::default(), packets: [half(Direction::OneToTwo), half(Direction::TwoToOne)] }
    }

    fn of(&self, direction: Direction, packet: u64) -> &[Arrival] {
        let half = match direction {
            Direction::OneToTwo => &self.packets[0],
            Direction::TwoToOne => &self.packets[1],
        };
        half.get((packet % half.len().max(1) as u64) as usize).map_or(&[], Vec::as_slice)
    }

    /// Reads a trace.
    ///
    /// # Errors
    /// The first row that is wrong, or why the file cannot be read, in one line.
    pub fn read(path: &Path) -> Result<Self, String> {
        let place = path.display();
        let mut reader = csv::Reader::from_path(path).map_err(|cause| format!("cannot read {place}: {cause}"))?;
        let mut packets = [Vec::new(), Vec::new()];
        for (at, row) in reader.deserialize::<(usize, usize, Option<f64>, String)>().enumerate() {
            let wrong = |what: &str| format!("{place}: row {}: {what}", at + 1);
            let (direction, packet, delay_s, fate) = row.map_err(|cause| wrong(&cause.to_string()))?;
            let half: &mut Vec<Vec<Arrival>> = match direction {
                1 => &mut packets[0],
                2 => &mut packets[1],
                _ => return Err(wrong("direction must be 1 or 2")),
            };
            // A second copy follows its first; anything else is the next packet.
            if packet == half.len() {
                half.push(Vec::new());
            } else if packet + 1 != half.len() {
                return Err(wrong(&format!("packet {packet} must be {} or, for a copy, the one before", half.len())));
            }
            let corrupt = match fate.as_str() {
                "arrives" => false,
                "corrupt" => true,
                "lost" => continue,
                _ => return Err(wrong("fate must be arrives, corrupt or lost")),
            };
            match delay_s {
                Some(delay_s) if (0.0..=1e4).contains(&delay_s) => {
                    half[packet].push(Arrival { delay_ns: nanoseconds(delay_s), corrupt });
                }
                _ => return Err(wrong("delay_s must be a number from 0 to 10000")),
            }
        }
        if packets.iter().any(Vec::is_empty) {
            return Err(format!("{place}: both directions need at least one packet"));
        }
        Ok(Self { file: std::path::absolute(path).unwrap_or_else(|_| path.to_owned()), packets })
    }

    /// The file it was read from; empty for none.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// Writes the trace.
    ///
    /// # Errors
    /// Why the file cannot be written, in one line.
    pub fn write(&self, path: &Path) -> Result<(), String> {
        let failed = |cause: csv::Error| format!("cannot write {}: {cause}", path.display());
        let mut writer = csv::Writer::from_path(path).map_err(failed)?;
        writer.write_record(["direction", "packet", "delay_s", "fate"]).map_err(failed)?;
        for (direction, half) in (1..).zip(&self.packets) {
            for (packet, copies) in half.iter().enumerate() {
                let mut row = |delay: String, fate: &str| {
                    writer.write_record([&direction.to_string(), &packet.to_string(), &delay, fate]).map_err(failed)
                };
                if copies.is_empty() {
                    row(String::new(), "lost")?;
                }
                for copy in copies {
                    row(seconds(copy.delay_ns).to_string(), if copy.corrupt { "corrupt" } else { "arrives" })?;
                }
            }
        }
        writer.flush().map_err(|cause| failed(cause.into()))
    }
}
