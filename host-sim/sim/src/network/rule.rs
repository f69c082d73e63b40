//! What becomes of each packet: how late it arrives, how often, broken or not at all.
//!
//! Drawn from a seed by the scene's `network` table, or read from a trace. A trace is the same list written down, so that
//! one recording impairs a run in memory, two processes and two boards alike:
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

use std::path::Path;
use std::sync::Arc;

use crate::rng::Dice;
use crate::scene::{Network, Scene};

/// Which way a packet goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// From peer 1 to peer 2.
    OneToTwo,
    /// From peer 2 to peer 1.
    TwoToOne,
}

/// One copy of a packet that arrives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arrival {
    /// Time on top of the constant delay, s.
    pub delay_s: f64,
    /// Its bits are no longer what was sent.
    pub corrupt: bool,
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

impl haptic_core::settings::Choice for Jitter {
    const NAMES: &'static [&'static str] = &["none", "uniform", "gamma"];
    const ALL: &'static [Self] = &[Self::None, Self::Uniform, Self::Gamma];
}

/// Bits of one packet on the wire: a sealed flow message with its Ethernet, IP and UDP headers.
const PACKET_BITS: f64 = 8.0 * 110.0;

/// Where fates come from.
#[derive(Clone, Debug)]
pub enum Fates {
    /// Drawn.
    Seeded(Box<Generator>),
    /// Read.
    Recorded {
        /// The recording.
        trace: Arc<NetworkTrace>,
        /// Which half of it.
        direction: Direction,
    },
}

impl Fates {
    /// The scene's network in one direction; `None` if all it does is delay.
    pub fn new(scene: &Scene, direction: Direction) -> Option<Self> {
        if let Some(trace) = &scene.network_trace {
            return Some(Self::Recorded { trace: Arc::clone(trace), direction });
        }
        let network = scene.world.network;
        let plain = Network {
            one_way_delay_packets: network.one_way_delay_packets,
            playout_packets: network.playout_packets,
            clock_drift_ppm: network.clock_drift_ppm,
            seed: network.seed,
            ..Network::default()
        };
        let packet_s = scene.peer.timing.control_period_s * f64::from(scene.peer.timing.ticks_per_packet);
        (network != plain).then(|| Self::Seeded(Box::new(Generator::new(network, direction, packet_s))))
    }

    /// The copies of packet number `packet`, sent at `sent_s`, that arrive.
    pub fn next(&mut self, packet: u64, sent_s: f64) -> Vec<Arrival> {
        match self {
            Self::Seeded(generator) => generator.next(sent_s),
            Self::Recorded { trace, direction } => trace.of(*direction, packet).to_vec(),
        }
    }
}

/// Draws fates from a seed.
#[derive(Clone, Debug)]
pub struct Generator {
    network: Network,
    direction: Direction,
    packet_s: f64,
    dice: Dice,
    /// In a run of losses (Gilbert–Elliott).
    losing: bool,
    /// When the line is free again, s.
    free_s: f64,
}

impl Generator {
    /// Fates as `network` describes them for packets every `packet_s` seconds; each direction has its own stream.
    pub fn new(network: Network, direction: Direction, packet_s: f64) -> Self {
        let stream = match direction {
            Direction::OneToTwo => 0,
            Direction::TwoToOne => 1 << 32,
        };
        let dice = Dice::new(u64::from(network.seed) | stream);
        Self { network, direction, packet_s, dice, losing: false, free_s: 0.0 }
    }

    fn lost(&mut self) -> bool {
        let (loss, burst) = (self.network.loss, self.network.loss_burst_packets);
        if burst <= 1.0 {
            return self.dice.chance(loss);
        }
        // Mean run of `burst` losses; entered so often that `loss` of all packets fall into one.
        let change = if self.losing { 1.0 / burst } else { loss / (burst * (1.0 - loss)) };
        if self.dice.chance(change) {
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
            Jitter::Uniform => network.jitter_s * self.dice.unit(),
            // Two exponentials of half the mean.
            Jitter::Gamma => {
                -0.5 * network.jitter_s * (libm::log(1.0 - self.dice.unit()) + libm::log(1.0 - self.dice.unit()))
            }
        };
        delay
    }

    /// The copies of the next packet, sent at `sent_s`, that arrive.
    pub fn next(&mut self, sent_s: f64) -> Vec<Arrival> {
        let network = self.network;
        if self.lost() {
            return Vec::new();
        }
        let mut queued = 0.0;
        if network.bandwidth_bit_per_s > 0.0 {
            self.free_s = self.free_s.max(sent_s) + PACKET_BITS / network.bandwidth_bit_per_s;
            queued = self.free_s - sent_s;
        }
        let copies = 1 + usize::from(self.dice.chance(network.duplicate));
        (0..copies)
            .map(|_| {
                let mut delay_s = queued + self.delay(sent_s);
                if self.dice.chance(network.reorder) {
                    delay_s += f64::from(network.reorder_depth_packets) * self.packet_s * self.dice.unit();
                }
                // No packet arrives before the constant delay is over, whatever steps are asked for.
                Arrival { delay_s: delay_s.max(0.0), corrupt: self.dice.chance(network.corrupt) }
            })
            .collect()
    }
}

/// A recording of what a network did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NetworkTrace {
    packets: [Vec<Vec<Arrival>>; 2],
}

impl NetworkTrace {
    /// The fates of the first `packets` packets of a scene, sent every `packet_s` seconds.
    pub fn record(scene: &Scene, packets: u64) -> Self {
        let timing = &scene.peer.timing;
        let packet_s = timing.control_period_s * f64::from(timing.ticks_per_packet);
        let half = |direction| match Fates::new(scene, direction) {
            Some(mut fates) => (0..packets).map(|packet| fates.next(packet, packet as f64 * packet_s)).collect(),
            None => vec![vec![Arrival { delay_s: 0.0, corrupt: false }]; packets as usize],
        };
        Self { packets: [half(Direction::OneToTwo), half(Direction::TwoToOne)] }
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
                Some(delay_s) if (0.0..=1e4).contains(&delay_s) => half[packet].push(Arrival { delay_s, corrupt }),
                _ => return Err(wrong("delay_s must be a number from 0 to 10000")),
            }
        }
        if packets.iter().any(Vec::is_empty) {
            return Err(format!("{place}: both directions need at least one packet"));
        }
        Ok(Self { packets })
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
                    row(copy.delay_s.to_string(), if copy.corrupt { "corrupt" } else { "arrives" })?;
                }
            }
        }
        writer.flush().map_err(|cause| failed(cause.into()))
    }
}
