//! What somebody in the same process reads of a live peer and tells it, at any rate, beside its tick.
//!
//! The tick leaves what it saw and takes what is wanted. Both locks are held for a copy, and the tick only tries them, so that nobody who looks
//! or steers holds it up: what it could not leave or take, it does a tick later.
//!
//! A peer that is steered arms when that is wanted, the other end is there and the verdict lets it; its patience counts from when that was
//! wanted. What is wanted is no way around a guard: a fault stays until somebody clears it, and a device that has gone stays gone.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use cohold_core::num::Motion;
use cohold_core::peer::Observed;
use cohold_core::safety::{Command, Mode};
use cohold_sim::device::Device;

use crate::devices::AXES;
use crate::hand::Hand;
use crate::node::Node;
use crate::tell::Second;
use crate::verdict::{Judging, Verdict, state};

/// What is wanted of a peer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wanted {
    /// Its motors on, as soon as it may.
    pub armed: bool,
    /// Its clutch held open.
    pub clutch: bool,
    /// Forces on a simulated device beside its user's: along each axis, N toward positive x, y, z.
    pub pull_n: [f64; AXES],
    /// Where a hand at a simulated device is to be, along each axis, m of the device's own; none, and it has let go.
    pub hand_m: Option<[f64; AXES]>,
    /// How often that was said so far.
    pub moves: u64,
    /// How often faults were to be forgotten so far.
    pub clears: u64,
}

/// Who steers a peer, seen from its tick: what was wanted last, and the hand that is moved.
pub(crate) struct Steered<const SHARED: usize> {
    pub(crate) steering: Arc<Steering>,
    wanted: Wanted,
    pub(crate) hand: Hand<SHARED>,
    /// Force of the hand in this tick, N.
    pub(crate) pulled_n: [f64; SHARED],
    ticks: u64,
}

impl<const SHARED: usize> Steered<SHARED> {
    pub(crate) fn new(steering: Arc<Steering>) -> Self {
        let wanted = steering.wanted();
        Self { steering, wanted, hand: Hand::default(), pulled_n: [0.0; SHARED], ticks: 0 }
    }

    /// Does what is wanted in this tick, but for arming, and says what that is. The hand takes the device where that is when its motors go on,
    /// and goes from there to where it is to be.
    pub(crate) fn heed<const N: usize, D: Device<f32, N> + ?Sized>(
        &mut self,
        node: &mut Node<SHARED, N, D>,
        period_s: f64,
    ) -> Wanted {
        let before = self.wanted;
        self.wanted = self.steering.order().unwrap_or(before);
        self.ticks += 1;
        let motions: [Motion<f64>; SHARED] = first(node.motions(), Motion::REST);
        let is_armed = node.peer.mode() == Mode::Armed;
        if !is_armed || self.wanted.hand_m.is_none() {
            self.hand = Hand::default();
        } else if self.wanted.moves != before.moves || self.hand.holds().is_none() {
            let to = self.wanted.hand_m.map(|to| first(to, 0.0));
            self.hand.point(self.ticks, to, motions.map(|axis| axis.position));
        }
        self.pulled_n = self.hand.pull(self.ticks, motions, period_s);
        let (pushed, pulled): ([f64; N], [f64; N]) = (first(self.wanted.pull_n, 0.0), first(self.pulled_n, 0.0));
        node.pull(std::array::from_fn(|axis| pushed[axis] + pulled[axis]));
        node.hold_clutch(self.wanted.clutch);
        if self.wanted.clears != before.clears {
            node.peer.command(Command::Clear);
        }
        self.wanted
    }
}

/// As many of these as there are axes; `otherwise` beyond them.
fn first<T: Copy, const N: usize>(of: impl AsRef<[T]>, otherwise: T) -> [T; N] {
    std::array::from_fn(|axis| of.as_ref().get(axis).copied().unwrap_or(otherwise))
}

/// What a peer was at its newest tick.
#[derive(Clone, Debug, Default)]
pub struct Snapshot {
    /// Whether its loop has begun: socket and device are open.
    pub has_begun: bool,
    /// Time since it began, s.
    pub time_s: f64,
    /// Control periods in which its hand moved.
    pub tick: u64,
    /// `calling`, `waiting`, `refused`, `alone`, `armed`, `faulted`; `held` while it is not wanted armed. The motors are on in `alone` and `armed`.
    pub state: &'static str,
    /// What stopped it.
    pub fault: Option<String>,
    /// Along each shared axis, m, m/s and N of the shared world; what the device is at is known before it is armed, too.
    pub axes: [Observed<f64>; AXES],
    /// Force that the peer commands along each shared axis, N: 0 while its motors are off.
    pub force_n: [f64; AXES],
    /// Its newest second, as its command says it.
    pub second: Option<Second>,
    /// What its scene is at the delays that are measured.
    pub verdict: Option<Verdict>,
}

/// Both, shared with whoever reads and steers.
#[derive(Debug)]
pub struct Steering {
    wanted: Mutex<Wanted>,
    seen: Mutex<Snapshot>,
}

impl Steering {
    /// Of a peer that is to arm as soon as it may, or to wait until it is told.
    pub fn new(armed: bool) -> Self {
        Self { wanted: Mutex::new(Wanted { armed, ..Wanted::default() }), seen: Mutex::default() }
    }

    /// The newest tick.
    pub fn snapshot(&self) -> Snapshot {
        held(&self.seen).clone()
    }

    /// What is wanted now.
    pub fn wanted(&self) -> Wanted {
        *held(&self.wanted)
    }

    /// Changes what is wanted from the next tick on.
    pub fn want(&self, change: impl FnOnce(&mut Wanted)) {
        change(&mut held(&self.wanted));
    }

    /// What is wanted, for the tick; none while somebody is changing it.
    pub(crate) fn order(&self) -> Option<Wanted> {
        self.wanted.try_lock().ok().map(|wanted| *wanted)
    }

    /// Its loop begins.
    pub(crate) fn begin(&self) {
        held(&self.seen).has_begun = true;
    }

    /// Leaves what a tick saw, with the forces that it commanded.
    pub(crate) fn leave<const SHARED: usize, const N: usize, D: Device<f32, N> + ?Sized>(
        &self,
        now_ns: u64,
        (node, forces): (&Node<SHARED, N, D>, [f32; N]),
        (newest, judging): (Option<&Second>, Option<&Judging>),
    ) {
        let Ok(mut seen) = self.seen.try_lock() else { return };
        seen.time_s = now_ns as f64 * 1e-9;
        seen.tick = node.armed_ticks;
        let stands = state(node, judging);
        let is_held = stands != "faulted" && self.order().is_some_and(|wanted| !wanted.armed);
        seen.state = if is_held { "held" } else { stands };
        // Words are made when they change, and not at every tick.
        if (seen.state == "faulted") != seen.fault.is_some() {
            seen.fault = node.fault();
        }
        let motions = node.motions();
        for (axis, observed) in node.peer.observed().into_iter().enumerate() {
            let mut observed = observed.map(f64::from);
            if node.peer.mode() != Mode::Armed {
                observed.device = motions[axis];
            }
            (seen.axes[axis], seen.force_n[axis]) = (observed, forces[axis].into());
        }
        if seen.second.as_ref().map(|second| second.time_s) != newest.map(|second| second.time_s) {
            seen.second = newest.cloned();
        }
        let verdict = judging.and_then(|judging| judging.verdict.as_ref());
        if seen.verdict.as_ref() != verdict {
            seen.verdict = verdict.cloned();
        }
    }
}

/// What is locked, also after somebody failed who held it: it is plain numbers and words.
fn held<T>(lock: &Mutex<T>) -> MutexGuard<'_, T> {
    lock.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
#[path = "../tests/inside/steering.rs"]
mod tests;
