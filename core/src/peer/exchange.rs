//! What a peer says to the other one and hears of it: packets once each packet period, and the silence between them.
//!
//! Packets are written where the caller wants them, and read where he has them: on a board that is the memory that tick and network
//! share, and copies cost more than what is decided here.

use super::Peer;
use crate::device::kinematics::Kinematics;
use crate::law::degradation::Remnant;
use crate::law::{Law, Packet};
use crate::num::Scalar;
use crate::safety::{Fault, Mode};

/// What has come from the other peer since the last tick.
#[derive(Clone, Copy, Debug)]
pub struct Arrived<'a, S: Scalar, const SHARED: usize> {
    /// The other peer has gone, or has started again: nothing counts that came before.
    pub parted: bool,
    /// The newest packets, one for each shared axis.
    pub packets: Option<&'a [Packet<S>; SHARED]>,
    /// Packets come too late to be used, as [`Peer::delayed`] has it.
    pub late: bool,
}

impl<S: Scalar, L: Law<S>, const SHARED: usize, const N: usize, K: Kinematics<S, N>> Peer<S, L, SHARED, N, K> {
    /// Whether [`Peer::exchange`] is due before the next [`Peer::tick`].
    pub fn packet_due(&self) -> bool {
        self.until_packet == 0
    }

    /// One packet period: gives what to send, if anything, and counts the silence if nothing has been heard in it.
    ///
    /// Due before every M-th tick, when [`Peer::packet_due`].
    pub fn exchange(&mut self) -> Option<[Packet<S>; SHARED]> {
        let mut packets = [Packet::default(); SHARED];
        self.exchange_into(&mut packets).then_some(packets)
    }

    /// [`Peer::exchange`] that writes into `packets` instead of copying; true if they are to be sent.
    pub fn exchange_into(&mut self, packets: &mut [Packet<S>; SHARED]) -> bool {
        let speaks = self.speak_into(packets);
        self.listen();
        speaks
    }

    /// The first half of [`Peer::exchange`]: the packets to send; none where the law has nothing worth sending on any
    /// axis ([`crate::law::event`]). Only a network without delay needs it apart, before [`Peer::hear`].
    pub fn speak(&mut self) -> Option<[Packet<S>; SHARED]> {
        let mut packets = [Packet::default(); SHARED];
        self.speak_into(&mut packets).then_some(packets)
    }

    /// [`Peer::speak`], written where it is to lie.
    fn speak_into(&mut self, packets: &mut [Packet<S>; SHARED]) -> bool {
        let engaged = self.is_engaged();
        for (packet, axis) in packets.iter_mut().zip(&self.shared_axes) {
            *packet = axis.outgoing(&self.law, engaged);
        }
        self.degradation.longest <= 1 || !self.keeps_silent(packets)
    }

    /// What [`Peer::exchange`] would send now, if it is worth sending.
    pub fn outgoing(&self) -> [Packet<S>; SHARED] {
        let engaged = self.is_engaged();
        self.shared_axes.each_ref().map(|axis| axis.outgoing(&self.law, engaged))
    }

    /// Whether none of these packets is worth sending, and silence not over.
    #[inline(never)]
    fn keeps_silent(&mut self, packets: &[Packet<S>; SHARED]) -> bool {
        self.quiet = self.quiet.saturating_add(1);
        let may = self.is_engaged() && self.quiet < self.degradation.longest;
        if may
            && !self.shared_axes.iter().zip(packets).any(|(axis, packet)| self.law.speaks(&axis.coordination, packet))
        {
            return true;
        }
        self.quiet = 0;
        for (axis, packet) in self.shared_axes.iter_mut().zip(packets) {
            self.law.spoke(&mut axis.coordination, packet);
        }
        false
    }

    /// The second half of [`Peer::exchange`]: counts the silence if nothing has been heard in this packet period.
    pub fn listen(&mut self) {
        if self.hand.mode == Mode::Armed {
            let forces = self.shared_axes.iter().map(|axis| axis.observed.coordination_force);
            if self.degradation.pass(&mut self.engagement, forces) {
                self.let_go();
                self.engagement.part();
            } else if self.engagement.is_fading() {
                self.fade();
            }
            if self.engagement.silent() >= self.hand.guard.silent_packets && !self.falls() {
                self.trip(if self.delayed { Fault::PeerDelayed } else { Fault::PeerLost });
            }
        }
    }

    /// Takes what has come since the last tick, in the order that a board and a PC share: first that the other peer has gone, then its packets.
    #[inline(always)]
    pub fn arrive(&mut self, Arrived { parted, packets, late }: Arrived<'_, S, SHARED>) {
        if parted {
            self.part();
        }
        match packets {
            Some(packets) => self.hear(packets),
            None if late => self.delayed(),
            None => {}
        }
    }

    /// Takes in the packets of the other peer, one for each shared axis: they act at the next tick, and stand until others come.
    ///
    /// Call it before a tick, whether or not [`Peer::exchange`] is due; if it is, before that. Of several packets that
    /// have come the caller passes the newest. A packet that is not finite is [`Fault::NonFiniteInput`].
    pub fn hear(&mut self, packets: &[Packet<S>; SHARED]) {
        if !packets.iter().all(|packet| packet.is_finite()) {
            return self.trip(Fault::NonFiniteInput);
        }
        if self.hand.mode != Mode::Armed {
            return;
        }
        self.age_ticks = 0;
        self.delayed = false;
        if !self.engagement.is_engaged() && self.falls() {
            return self.engagement.note();
        }
        let anew = self.degradation.hear(&mut self.engagement);
        let whole = self.degradation.is_whole(&self.engagement);
        for (axis, packet) in self.shared_axes.iter_mut().zip(packets) {
            if anew {
                self.law.restart(&mut axis.coordination, axis.object);
            }
            axis.standing = *packet;
            if whole {
                self.law.receive(&mut axis.coordination, *packet);
            }
        }
        if !whole {
            self.fade();
        }
    }

    /// Whether packets are only held ([`Law::only_holds`]).
    pub fn only_holds(&self) -> bool {
        self.law.only_holds()
    }

    /// These packets as the law would receive them if only this share of them counted ([`Packet::faded`]).
    pub fn faded(&self, share: S, packets: &[Packet<S>; SHARED]) -> [Packet<S>; SHARED] {
        core::array::from_fn(|at| packets[at].faded(share, self.shared_axes[at].object))
    }

    /// Gives the law the packets that stand, as far as they still count.
    #[inline(never)]
    fn fade(&mut self) {
        let share = self.degradation.share(&self.engagement);
        for axis in &mut self.shared_axes {
            axis.fade(&self.law, share);
        }
    }

    /// Whether something is left of a force that falls.
    pub(super) fn falls(&self) -> bool {
        self.shared_axes.iter().any(|axis| !axis.remnant.is_none())
    }

    /// The coordination lets go: what is left of its force falls to 0 ([`crate::law::degradation::STEP_N`]).
    #[cold]
    #[inline(never)]
    fn let_go(&mut self) {
        for axis in &mut self.shared_axes {
            axis.remnant = Remnant::of(axis.observed.coordination_force, axis.object, &self.spring);
            axis.grip.loosen();
        }
        self.hand.fast_path = false;
    }

    /// Reports that packets come but are too old to be used (`safety.max_delay_s`), as the link measures it. They count
    /// as silence; until one is used, the fault that silence leads to is [`Fault::PeerDelayed`], not
    /// [`Fault::PeerLost`].
    pub fn delayed(&mut self) {
        self.delayed = true;
    }

    /// Disengages at once from the other peer, which is known to be gone or to have restarted: this peer renders alone, but for what is left of
    /// the force ([`crate::law::degradation::STEP_N`]), until a packet comes, which starts the coordination anew from no force, step by step. A peer that is armed and
    /// never parted uses its first packet in full, for both copies begin at rest.
    pub fn part(&mut self) {
        if self.is_engaged() {
            self.let_go();
        }
        self.engagement.part();
    }
}
