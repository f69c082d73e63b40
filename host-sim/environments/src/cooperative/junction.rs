//! Where wave lines meet on a network that loses, jitters and falls silent: core's lossless node, and a port for each line.
//!
//! Once a packet period, and where lines have a time of their own once a control period, [`Junction::exchange`] takes what came
//! out of every line, scatters it ([`haptic_core::law::node`]), and every port has what goes back.
//!
//! **Paid for.** With `coordination.ledger` a port lets no more wave energy into the node than its peer is known to have put
//! into the line ([`haptic_core::law::credit`], a packet period for a tick), and counts what it sends, so that the peer
//! can do the same: then the junction is passive on any network. Without, waves are held as they are, and only a constant
//! delay without loss is passive. A counter is only what a peer says: of it the junction books what it would ever give out,
//! no more than [`CAP_J`] in hand at a time, so that whatever one peer claims, the figures of all are off by that at the most.
//!
//! **Silence.** A port fades with silence as a peer does ([`haptic_core::law::degradation`]). At share s it is matched to its
//! line of impedance b and is a line of impedance s·b to the node: of the wave u that comes √s·u goes in, of what the node
//! answers √s comes back, together s·(√(2b)·v − u); the rest ends in the port. So s = 1 is the line itself and s = 0 none,
//! all is continuous between them, and no s makes energy: a line goes quiet, and comes back, without a jump for the others.
//! A peer that is known to be gone, or another life of it ([`Junction::part`]), counts as silent until its line is quiet:
//! the last wave fades as in any silence, as far as the ledger pays for it, and the counters of two lives never meet.
//!
//! **Lines with a time of their own** (self-timed) meet in a copy of the object instead (`copy.rs`). They lose nothing and let go
//! at once: a silence is stood through, not faded, and another life begins where the copy is.
//!
//! **Units**: √W, J, N, N·s/m, s. **Limit**: waves carry no positions: what a long silence takes apart stays apart.

use copy::SharedCopy;
use haptic_core::law::credit::{Account, CAP_J, Credit};
use haptic_core::law::degradation::{Degradation, Engagement};
use haptic_core::law::{Packet, Sends};
use haptic_core::{law::node::Node, num::Motion};
use haptic_sim::Scene;
use serde::Serialize;

use super::MOST_USERS;
use crate::Error;

mod copy;

/// Wave energy at one port, J.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Energy {
    /// Put into the line by its peer: by the counters in its packets, as far as there was room for it (what was in hand stays
    /// within [`CAP_J`] where waves are paid for); of a line with a time of its own, what of it has come out.
    pub put_in_j: f64,
    /// Taken out of the line into the node.
    pub taken_j: f64,
    /// Sent back into the line.
    pub sent_j: f64,
}

/// The end of one line.
#[derive(Clone, Copy, Debug)]
pub struct Port {
    engagement: Engagement,
    /// The peer is gone: nothing is heard until the line is quiet.
    leaving: bool,
    /// The packet that stands.
    standing: Packet<f64>,
    account: Account<f64>,
    /// The peer's energy counter in the newest packet, J.
    counted_j: Option<f64>,
    /// What of that is booked and not taken out, J.
    in_hand_j: f64,
    /// Force at the end of the line, N. While a wave line fades, a part of it ends in the port.
    pub force_n: f64,
    /// What goes back, with this end's own counters.
    pub back: Packet<f64>,
    /// Energy that went through the port, J.
    pub energy: Energy,
}

impl Port {
    /// Whether anything of the line reaches the node.
    pub fn is_engaged(&self) -> bool {
        self.engagement.is_engaged()
    }

    /// One packet period: the wave that comes out of the line, √W.
    fn take(
        &mut self,
        degradation: &Degradation<f64>,
        credit: Option<&Credit<f64>>,
        packet_s: f64,
        came: Option<Packet<f64>>,
    ) -> f64 {
        self.leaving &= self.is_engaged();
        let came = came.filter(|_| !self.leaving);
        if came.is_some() && degradation.hear(&mut self.engagement) {
            (self.account, self.counted_j) = (Account::default(), None);
            self.energy.put_in_j -= std::mem::take(&mut self.in_hand_j);
        }
        degradation.pass(&mut self.engagement);
        if let Some(packet) = came {
            // The first packet of a life pays for itself and brings no past.
            let own_j = 0.5 * packet_s * packet.wave * packet.wave;
            let before_j = self.counted_j.unwrap_or((packet.energy_j - own_j).max(0.0));
            let mut new_j = (packet.energy_j - before_j).max(0.0);
            if credit.is_some() {
                new_j = new_j.min(CAP_J - self.in_hand_j).max(0.0);
                self.in_hand_j += new_j;
            }
            self.energy.put_in_j += new_j;
            self.counted_j = Some(packet.energy_j.max(before_j));
            self.standing = packet;
        }
        if !self.is_engaged() {
            return 0.0;
        }
        let Some(credit) = credit else { return self.standing.wave };
        if came.is_some() || self.engagement.is_fading() {
            credit.receive(&mut self.account, &self.standing);
        }
        let wave = credit.spend(&mut self.account, self.standing.wave);
        self.in_hand_j = (self.in_hand_j - 0.5 * packet_s * wave * wave).max(0.0);
        wave
    }

    /// Sends a wave back, √W.
    fn send(&mut self, wave: f64, packet_s: f64) {
        self.energy.sent_j += 0.5 * packet_s * wave * wave;
        self.back = Packet {
            wave,
            energy_j: self.energy.sent_j,
            wave_integral: self.back.wave_integral + packet_s * wave,
            ..Packet::default()
        };
    }
}

/// Where up to `MOST_USERS` lines meet.
#[derive(Clone, Debug)]
pub struct Junction {
    /// In the order of the lines.
    pub ports: Vec<Port>,
    degradation: Degradation<f64>,
    credit: Option<Credit<f64>>,
    impedance: f64,
    packet_s: f64,
    period_s: f64,
    /// Where self-timed lines meet.
    copy: Option<SharedCopy>,
    /// Where the lines meet; as far as their common velocity has carried it, from 0.
    pub motion: Motion<f64>,
}

impl Junction {
    /// The lines of `users` peers of this scene, engaged as the peers are that are armed together.
    ///
    /// # Errors
    /// A scene or a number of users that the junction cannot serve.
    pub fn new(scene: &Scene, users: usize) -> Result<Self, Error> {
        let settings = &scene.peer;
        let coordination = &settings.coordination;
        let users = users.min(MOST_USERS);
        let copy = match scene.law().sends {
            Sends::Waves => None,
            Sends::Counters => Some(SharedCopy::build(settings, users).map_err(|_| Error::NoWaves(coordination.comm))?),
            _ => return Err(Error::NoWaves(coordination.comm)),
        };
        let packet_s = settings.timing.packet_period_s();
        // The node's tick is a packet period.
        let mut own = *settings;
        (own.timing.control_period_s, own.timing.ticks_per_packet) = (packet_s, 1);
        let degradation = Degradation::build(settings).expect("settings that peers accept");
        let port = Port {
            engagement: degradation.engaged(),
            leaving: false,
            standing: Packet::default(),
            account: Account::default(),
            counted_j: None,
            in_hand_j: 0.0,
            force_n: 0.0,
            back: Packet::default(),
            energy: Energy::default(),
        };
        Ok(Self {
            ports: vec![port; users],
            degradation,
            credit: Credit::build(&own),
            impedance: coordination.wave_impedance_n_s_per_m,
            packet_s,
            period_s: settings.timing.control_period_s,
            copy,
            motion: Motion::REST,
        })
    }

    /// Lets go of the peer on a line, which is not there yet, is gone, or began anew.
    pub fn part(&mut self, line: usize) {
        if let Some(port) = self.ports.get_mut(line) {
            // Before anything was said there is nothing to fade, and a line with a time of its own fades nothing.
            if port.counted_j.is_none() || self.copy.is_some() {
                port.engagement.part();
            }
            port.leaving = port.is_engaged();
        }
    }

    /// Whether all of what comes on a line reaches the node.
    pub fn is_whole(&self, line: usize) -> bool {
        let whole = |port: &Port| match self.copy {
            // A line with a time of its own fades nothing.
            Some(_) => port.is_engaged(),
            None => self.degradation.is_whole(&port.engagement),
        };
        self.ports.get(line).is_some_and(|port| port.engagement.has_heard() && whole(port))
    }

    /// Whether [`Junction::exchange`] is due before a tick at which packets are due, or are not.
    pub fn is_due(&self, packets: bool) -> bool {
        packets || self.copy.is_some()
    }

    /// Before a tick at which `packets` are due or are not: what came of every line, in order; what goes back is then in the ports.
    pub fn exchange(&mut self, came: impl IntoIterator<Item = Option<Packet<f64>>>, packets: bool) {
        if self.copy.is_some() { self.pull(came, packets) } else { self.scatter(came) }
    }

    /// A tick of the copy in which lines with a time of their own meet.
    fn pull(&mut self, came: impl IntoIterator<Item = Option<Packet<f64>>>, packets: bool) {
        let Some(copy) = &mut self.copy else { return };
        for (line, (port, came)) in self.ports.iter_mut().zip(came).enumerate() {
            if let Some(packet) = came {
                if self.degradation.hear(&mut port.engagement) {
                    copy.restart(line, self.motion);
                }
                copy.hear(line, packet);
            }
        }
        if packets {
            for (line, port) in self.ports.iter_mut().enumerate() {
                self.degradation.pass(&mut port.engagement);
                port.back = Packet { energy_j: port.energy.sent_j, ..copy.back(line, self.motion) };
            }
        }
        self.motion = copy.tick(|line| self.ports[line].is_engaged(), self.motion);
        for (line, port) in self.ports.iter_mut().enumerate() {
            let coupled = copy.coupled(line);
            port.force_n = coupled.force;
            port.energy.taken_j += self.period_s * coupled.power_in;
            // What has come out here was put in there: by the hub's own reckoning, whatever a peer claims.
            port.energy.put_in_j = port.energy.taken_j;
            port.energy.sent_j += self.period_s * coupled.power_out;
        }
    }

    /// One packet period of waves.
    fn scatter(&mut self, came: impl IntoIterator<Item = Option<Packet<f64>>>) {
        let (mut shares, mut waves) = ([0.0; MOST_USERS], [0.0; MOST_USERS]);
        let places = shares.iter_mut().zip(&mut waves);
        let mut taken = [0.0; MOST_USERS];
        for (((port, came), (share, wave)), taken) in self.ports.iter_mut().zip(came).zip(places).zip(&mut taken) {
            *taken = port.take(&self.degradation, self.credit.as_ref(), self.packet_s, came);
            *share = self.degradation.share(&port.engagement);
            *wave = share.sqrt() * *taken;
            port.energy.taken_j += 0.5 * self.packet_s * *wave * *wave;
        }
        let scattered = Node::new(shares.map(|share| share * self.impedance)).scatter(waves);
        let root = (0.5 * self.impedance).sqrt();
        for ((port, taken), (wave, share)) in
            self.ports.iter_mut().zip(taken).zip(scattered.back.into_iter().zip(shares))
        {
            port.send(share.sqrt() * wave, self.packet_s);
            port.force_n = root * (taken - port.back.wave);
        }
        self.motion = Motion {
            position: self.motion.position + self.packet_s * scattered.velocity,
            velocity: scattered.velocity,
        };
    }

    /// Wave energy of all lines, J.
    pub fn energy(&self) -> Energy {
        self.ports.iter().fold(Energy::default(), |sum, port| Energy {
            put_in_j: sum.put_in_j + port.energy.put_in_j,
            taken_j: sum.taken_j + port.energy.taken_j,
            sent_j: sum.sent_j + port.energy.sent_j,
        })
    }
}
