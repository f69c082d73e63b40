//! Where wave lines meet on a network that loses, jitters and falls silent: core's lossless node, and a port for each line.
//!
//! Once a packet period, and where lines have a time of their own once a control period, [`Junction::exchange`] takes what came
//! out of every line, scatters it ([`super::node`]), and every port has what goes back.
//!
//! **Paid for.** With `coordination.ledger` a port lets no more wave energy into the node than its peer is known to have put
//! into the line ([`cohold_core::law::credit`], a packet period for a tick), and counts what it sends, so that the peer
//! can do the same: then the junction is passive on any network. Without, waves are held as they are, and only a constant
//! delay without loss is passive. A counter is only what a peer says: of it the junction books what it would ever give out,
//! no more than [`cohold_core::law::credit::CAP_J`] in hand at a time along each axis, so that whatever one peer claims, the figures of
//! an axis are off by that at the most.
//!
//! **Silence.** A port fades with silence as a peer does ([`cohold_core::law::degradation`]). At share s it is matched to its
//! line of impedance b and is a line of impedance s·b to the node: of the wave u that comes √s·u goes in, of what the node
//! answers √s comes back, together s·(√(2b)·v − u); the rest ends in the port. So s = 1 is the line itself and s = 0 none,
//! all is continuous between them, and no s makes energy: a line goes quiet, and comes back, without a jump for the others. Along each
//! axis s falls so slowly that the line's force on the node falls by no more than [`STEP_N`] a tick, however large it was.
//! A peer that is known to be gone, or another life of it ([`Junction::part`]), counts as silent until its line is quiet:
//! the last wave fades as in any silence, as far as the ledger pays for it, and the counters of two lives never meet.
//!
//! **Lines with a time of their own** (self-timed) meet in a copy of the object instead (`copy.rs`). They lose nothing: a silence is
//! stood through, not faded; then the force falls, as in silence at a peer, and another life begins where the copy is.
//!
//! **Several shared axes.** Each axis has a node of its own, or a copy, with accounts of its own, so that each is passive by itself. A
//! line is one all the same: its peer is there, fades, leaves and begins anew along all axes at once (`port.rs`).
//!
//! **Units**: √W, J, N, N·s/m, s. **Limit**: waves carry no positions: what a long silence takes apart stays apart.

use cohold_core::law::Packet;
use cohold_core::law::credit::Credit;
use cohold_core::law::degradation::{Degradation, STEP_N};
use cohold_core::num::Motion;
use cohold_core::settings::{Allowed, Refused, Value};
use cohold_sim::Scene;
use copy::SharedCopy;

use super::MOST_USERS;
use super::node::Node;
use crate::Error;

mod copy;
mod port;

pub use port::{AxisPort, Energy, Port};

/// Where up to `MOST_USERS` lines meet, along each of `AXES` shared axes.
#[derive(Clone, Debug)]
pub struct Junction<const AXES: usize = 1> {
    /// In the order of the lines.
    pub ports: Vec<Port<AXES>>,
    degradation: Degradation<f64>,
    credit: Option<Credit<f64>>,
    impedance: f64,
    packet_s: f64,
    period_s: f64,
    /// By how much the force of a line that fades may fall in a packet period, N.
    fall_n: f64,
    /// Where self-timed lines meet along each axis.
    copies: Option<[SharedCopy; AXES]>,
    /// The most, at the end of any exchange, that had gone back into all lines beyond what their peers had put in, along each axis, J.
    pub made_j: [f64; AXES],
    /// Where the lines meet along each axis; as far as their common velocity has carried it, from 0.
    pub motion: [Motion<f64>; AXES],
}

impl<const AXES: usize> Junction<AXES> {
    /// The lines of `users` peers of this scene, engaged as the peers are that are armed together.
    ///
    /// # Errors
    /// A scene or a number of users that the junction cannot serve: another number of shared axes, too.
    pub fn new(scene: &Scene, users: usize) -> Result<Self, Error> {
        let settings = &scene.peer;
        let (coordination, shared) = (&settings.coordination, settings.axis.shared);
        if shared as usize != AXES {
            let allowed = Allowed::Whole { min: AXES as u32, max: AXES as u32 };
            return Err(Refused { key: "axis.shared", value: Value::Number(shared.into()), allowed, unit: "" }.into());
        }
        let users = users.min(MOST_USERS);
        let copies = match scene.law() {
            law if law.scatters => None,
            law if law.own_time => {
                let copy = SharedCopy::build(settings, users).map_err(|_| Error::NoWaves(coordination.comm))?;
                Some(std::array::from_fn(|_| copy.clone()))
            }
            _ => return Err(Error::NoWaves(coordination.comm)),
        };
        let packet_s = settings.timing.packet_period_s();
        // The node's tick is a packet period.
        let mut own = *settings;
        (own.timing.control_period_s, own.timing.ticks_per_packet) = (packet_s, 1);
        let degradation = Degradation::build(settings).expect("settings that peers accept");
        Ok(Self {
            ports: vec![Port::new(degradation.engaged()); users],
            degradation,
            credit: Credit::build(&own),
            impedance: coordination.wave_impedance_n_s_per_m,
            packet_s,
            period_s: settings.timing.control_period_s,
            fall_n: STEP_N * f64::from(settings.timing.ticks_per_packet),
            copies,
            made_j: [0.0; AXES],
            motion: [Motion::REST; AXES],
        })
    }

    /// Lets go of the peer on a line, which is not there yet, is gone, or began anew.
    pub fn part(&mut self, line: usize) {
        let Some(port) = self.ports.get_mut(line) else { return };
        if port.is_engaged() {
            self.copies.iter_mut().flatten().zip(&self.motion).for_each(|(copy, at)| copy.let_go(line, *at));
        }
        // Before anything was said there is nothing to fade, and a line with a time of its own fades nothing.
        port.part(!port.engagement.has_heard() || self.copies.is_some());
    }

    /// Whether all of what comes on a line reaches the node.
    pub fn is_whole(&self, line: usize) -> bool {
        let whole = |port: &Port<AXES>| match self.copies {
            // A line with a time of its own fades nothing.
            Some(_) => port.is_engaged(),
            None => self.degradation.is_whole(&port.engagement),
        };
        self.ports.get(line).is_some_and(|port| port.engagement.has_heard() && whole(port))
    }

    /// Whether [`Junction::exchange`] is due before a tick at which packets are due, or are not.
    pub fn is_due(&self, packets: bool) -> bool {
        packets || self.copies.is_some()
    }

    /// Before a tick at which `packets` are due or are not: what came of every line, in order, a packet for each axis; what goes back
    /// is then in the ports.
    pub fn exchange(&mut self, came: impl IntoIterator<Item = Option<[Packet<f64>; AXES]>>, packets: bool) {
        if self.copies.is_some() {
            self.pull(came, packets)
        } else {
            self.scatter(came)
        }
        let energies = self.energies();
        for (most_j, energy) in self.made_j.iter_mut().zip(energies) {
            *most_j = most_j.max(energy.sent_j - energy.put_in_j);
        }
    }

    /// A tick of the copies in which lines with a time of their own meet.
    fn pull(&mut self, came: impl IntoIterator<Item = Option<[Packet<f64>; AXES]>>, packets: bool) {
        let Self { ports, degradation, copies: Some(copies), motion, period_s, .. } = self else { return };
        for (line, (port, came)) in ports.iter_mut().zip(came).enumerate() {
            let Some(came) = came else { continue };
            let anew = degradation.hear(&mut port.engagement);
            for ((copy, packet), at) in copies.iter_mut().zip(came).zip(&*motion) {
                if anew {
                    copy.restart(line, *at);
                }
                copy.hear(line, packet);
            }
        }
        if packets {
            for (line, port) in ports.iter_mut().enumerate() {
                if degradation.pass(&mut port.engagement, []) {
                    copies.iter_mut().zip(&*motion).for_each(|(copy, at)| copy.let_go(line, *at));
                }
            }
        }
        for (axis, (copy, motion)) in copies.iter_mut().zip(motion).enumerate() {
            if packets {
                for (line, port) in ports.iter_mut().enumerate() {
                    port.axes[axis].back = copy.back(line, *motion);
                }
            }
            *motion = copy.tick(|line| ports[line].is_engaged(), *motion);
            for (line, port) in ports.iter_mut().enumerate() {
                port.axes[axis].pull(copy.coupled(line), *period_s);
            }
        }
    }

    /// One packet period of waves.
    fn scatter(&mut self, came: impl IntoIterator<Item = Option<[Packet<f64>; AXES]>>) {
        for (port, came) in self.ports.iter_mut().zip(came) {
            port.take(&self.degradation, self.credit.as_ref(), self.packet_s, came);
        }
        let (impedance, root) = (self.impedance, (0.5 * self.impedance).sqrt());
        for (axis, motion) in self.motion.iter_mut().enumerate() {
            let (mut impedances, mut waves) = ([0.0; MOST_USERS], [0.0; MOST_USERS]);
            for ((port, own), wave) in self.ports.iter_mut().zip(&mut impedances).zip(&mut waves) {
                let (engaged, axis) = (self.degradation.share(&port.engagement), &mut port.axes[axis]);
                *own = impedance * axis.open(engaged, self.fall_n, impedance, motion.velocity);
                *wave = axis.give(self.packet_s);
            }
            let scattered = Node::new(impedances).scatter(waves);
            for (port, answer) in self.ports.iter_mut().zip(scattered.back) {
                port.axes[axis].send(answer, self.packet_s, root);
            }
            *motion =
                Motion { position: motion.position + self.packet_s * scattered.velocity, velocity: scattered.velocity };
        }
    }

    /// Wave energy of all lines along each axis, J.
    pub fn energies(&self) -> [Energy; AXES] {
        std::array::from_fn(|axis| self.ports.iter().map(|port| port.axes[axis].energy).sum())
    }

    /// Wave energy of all lines along all axes, J.
    pub fn energy(&self) -> Energy {
        self.energies().into_iter().sum()
    }
}
