//! The hub's end of a line: one peer, who is there or fades along all shared axes at once, and along each axis a wave and an account.
//!
//! What belongs to the peer is kept once: how far it is engaged, and that it leaves. What belongs to an axis is kept for each, as a peer
//! keeps it (`cohold_core::peer`): the packet that stands, the credit that pays for it, the counters. So an axis whose credit is used up
//! falls quiet by itself and takes nothing from the others, and no axis is let go of without them.

use std::iter::Sum;

use cohold_core::law::credit::{Account, CAP_J, Credit};
use cohold_core::law::degradation::{Degradation, Engagement};
use cohold_core::law::{Coupled, Packet};
use serde::Serialize;

/// Wave energy at one port, J.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Energy {
    /// Put into the line by its peer: by the counters in its packets, as far as there was room for it (what was in hand along an axis
    /// stays within [`CAP_J`] where waves are paid for); of a line with a time of its own, what of it has come out.
    pub put_in_j: f64,
    /// Taken out of the line into the node.
    pub taken_j: f64,
    /// Sent back into the line.
    pub sent_j: f64,
}

impl Sum for Energy {
    fn sum<I: Iterator<Item = Self>>(energies: I) -> Self {
        energies.fold(Self::default(), |sum, energy| Self {
            put_in_j: sum.put_in_j + energy.put_in_j,
            taken_j: sum.taken_j + energy.taken_j,
            sent_j: sum.sent_j + energy.sent_j,
        })
    }
}

/// The end of one line along one shared axis.
#[derive(Clone, Copy, Debug, Default)]
pub struct AxisPort {
    /// The packet that stands.
    standing: Packet<f64>,
    account: Account<f64>,
    /// The peer's energy counter in the newest packet, J.
    counted_j: Option<f64>,
    /// What of that is booked and not taken out, J.
    in_hand_j: f64,
    /// What came out of the line in this packet period, √W.
    out: f64,
    /// How far a wave line is open, from 0 to 1: as far as its peer is engaged, but it never falls faster than a force may.
    share: f64,
    /// Force at the end of the line, N. While a wave line fades, a part of it ends in the port.
    pub force_n: f64,
    /// What goes back, with this end's own counters.
    pub back: Packet<f64>,
    /// Energy that went through the port, J.
    pub energy: Energy,
}

impl AxisPort {
    /// Another life of the peer, whose counters begin anew.
    fn begin_anew(&mut self) {
        (self.account, self.counted_j) = (Account::default(), None);
        self.energy.put_in_j -= std::mem::take(&mut self.in_hand_j);
    }

    /// One packet period of a line that is open so far: the wave that comes out of it, √W.
    fn take(
        &mut self,
        engagement: &Engagement<f64>,
        credit: Option<&Credit<f64>>,
        packet_s: f64,
        came: Option<Packet<f64>>,
    ) -> f64 {
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
        if self.share == 0.0 && !engagement.is_engaged() {
            return 0.0;
        }
        let Some(credit) = credit else { return self.standing.wave };
        if came.is_some() || engagement.silent() > 0 {
            credit.receive(&mut self.account, &self.standing);
        }
        let wave = credit.spend(&mut self.account, self.standing.wave);
        self.in_hand_j = (self.in_hand_j - 0.5 * packet_s * wave * wave).max(0.0);
        wave
    }

    /// Opens or closes the port of a line of this impedance (N·s/m) to where its peer's engagement is. At a node that moves with `velocity`
    /// (m/s) its force is share·(√(2b)·u − b·v), which falls by no more than `fall_n`.
    pub(super) fn open(&mut self, engaged: f64, fall_n: f64, impedance: f64, velocity: f64) -> f64 {
        let whole_n = (2.0 * impedance).sqrt() * self.out - impedance * velocity;
        self.share = engaged.max(self.share - fall_n / whole_n.abs());
        self.share
    }

    /// What came out of the line as far as the port is open, √W: the node takes it.
    pub(super) fn give(&mut self, packet_s: f64) -> f64 {
        let wave = self.share.sqrt() * self.out;
        self.energy.taken_j += 0.5 * packet_s * wave * wave;
        wave
    }

    /// Sends what the node answers back as far as the port is open, √W; `root` is √(b/2) of the line.
    pub(super) fn send(&mut self, answer: f64, packet_s: f64, root: f64) {
        let wave = self.share.sqrt() * answer;
        self.energy.sent_j += 0.5 * packet_s * wave * wave;
        self.back = Packet {
            wave,
            energy_j: self.energy.sent_j,
            wave_integral: self.back.wave_integral + packet_s * wave,
            ..Packet::default()
        };
        self.force_n = root * (self.out - self.back.wave);
    }

    /// What a line with a time of its own did in a tick.
    pub(super) fn pull(&mut self, coupled: Coupled<f64>, period_s: f64) {
        self.force_n = coupled.force;
        self.energy.taken_j += period_s * coupled.power_in;
        // What has come out here was put in there: by the hub's own reckoning, whatever a peer claims.
        self.energy.put_in_j = self.energy.taken_j;
        self.energy.sent_j += period_s * coupled.power_out;
    }
}

/// The end of one line.
#[derive(Clone, Copy, Debug)]
pub struct Port<const AXES: usize = 1> {
    pub(super) engagement: Engagement<f64>,
    /// The peer is gone: nothing is heard until the line is quiet.
    leaving: bool,
    /// Along each shared axis.
    pub axes: [AxisPort; AXES],
}

impl<const AXES: usize> Port<AXES> {
    /// Engaged, with nothing on the line.
    pub(super) fn new(engagement: Engagement<f64>) -> Self {
        Self { engagement, leaving: false, axes: [AxisPort::default(); AXES] }
    }

    /// Whether anything of the line reaches the node.
    pub fn is_engaged(&self) -> bool {
        self.engagement.is_engaged() || self.falls()
    }

    /// Whether something is left of the line's force.
    fn falls(&self) -> bool {
        self.axes.iter().any(|axis| axis.share > 0.0)
    }

    /// What goes back, along each axis.
    pub fn back(&self) -> [Packet<f64>; AXES] {
        self.axes.map(|axis| axis.back)
    }

    /// Energy that went through the port along all axes, J.
    pub fn energy(&self) -> Energy {
        self.axes.iter().map(|axis| axis.energy).sum()
    }

    /// Lets go of the peer, at once or by fading.
    pub(super) fn part(&mut self, at_once: bool) {
        if at_once {
            self.engagement.part();
            self.axes.iter_mut().for_each(|axis| axis.share = 0.0);
        }
        self.leaving = self.is_engaged();
    }

    /// One packet period of waves: what comes out of the line is then in the ports of the axes.
    pub(super) fn take(
        &mut self,
        degradation: &Degradation<f64>,
        credit: Option<&Credit<f64>>,
        packet_s: f64,
        came: Option<[Packet<f64>; AXES]>,
    ) {
        self.leaving &= self.is_engaged();
        let mut came = came.filter(|_| !self.leaving);
        if came.is_some() && !self.engagement.is_engaged() && self.falls() {
            // As a peer that lets go hears nothing until it has let go.
            self.engagement.note();
            came = None;
        }
        if came.is_some() && degradation.hear(&mut self.engagement) {
            self.axes.iter_mut().for_each(AxisPort::begin_anew);
        }
        degradation.pass(&mut self.engagement, []);
        for (at, axis) in self.axes.iter_mut().enumerate() {
            axis.out = axis.take(&self.engagement, credit, packet_s, came.map(|came| came[at]));
        }
    }
}
