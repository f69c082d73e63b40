//! A pointer becomes a hand: a spring and a damper from where the pointer is to the device (a virtual coupling).
//!
//! A mouse cannot be pushed back. What its user gets instead of a force is the distance between pointer and device, which
//! *is* the force, over the stiffness. Pointers come 60 times a second, in steps, and not quite evenly: taken as they come
//! they rattle by 0.1 N. So they are played out [`DELAY`] late, straight from one to the next, as packets are on a line that jitters;
//! then a drag at constant speed has no ripple at all.
//!
//! The force is formed once a tick and held through it. SI units; positive is to the right.

use std::collections::VecDeque;

/// Stiffness, N/m: 5 mm is 1 N.
pub(crate) const STIFFNESS: f64 = 200.0;
/// Damping, N·s/m, between pointer and device: without the pointer's speed in it a drag at 0.1 m/s would feel like 1.2 N.
pub(crate) const DAMPING: f64 = 12.0;
/// A hand's strength, N.
pub(crate) const STRENGTH: f64 = 10.0;
/// Play-out, ticks: one frame of 60 Hz, and half of the next.
const DELAY: u64 = 24;
/// Fastest hand, m/s: how a frame that came too late is made good.
const FASTEST: f64 = 0.5;
/// Share of its speed that a hand takes on in a tick: a jump of a few ticks is no blow through the damper.
const AGILITY: f64 = 0.1;

/// A hand that follows a pointer.
#[derive(Clone, Debug, Default)]
pub(super) struct Hand {
    /// Where the pointer was, m, and when it said so, in ticks.
    path: VecDeque<(u64, f64)>,
    at: f64,
    speed: f64,
}

impl Hand {
    /// The pointer says where it is (m), or that it has let go. A hand takes the device where that is.
    pub(super) fn point(&mut self, tick: u64, pointer: Option<f64>, device: f64) {
        match pointer {
            None => self.path.clear(),
            Some(at) => {
                if self.path.is_empty() {
                    (self.at, self.speed) = (device, 0.0);
                }
                self.path.push_back((tick, at));
            }
        }
    }

    /// Where the hand is, m, if it holds.
    pub(super) fn holds(&self) -> Option<f64> {
        (!self.path.is_empty()).then_some(self.at)
    }

    /// Force (N) on a device at `position` (m) that moves at `velocity` (m/s), in a tick of `period` (s).
    pub(super) fn pull(&mut self, tick: u64, position: f64, velocity: f64, period: f64) -> f64 {
        let then = tick.saturating_sub(DELAY);
        while self.path.get(1).is_some_and(|next| next.0 <= then) {
            self.path.pop_front();
        }
        let to = match (self.path.front(), self.path.get(1)) {
            (Some(&(from, a)), Some(&(until, b))) if from < then => {
                a + (b - a) * (then - from) as f64 / (until - from) as f64
            }
            (Some(&(_, a)), _) => a,
            (None, _) => return 0.0,
        };
        let step = (to - self.at).clamp(-FASTEST * period, FASTEST * period);
        self.at += step;
        self.speed += AGILITY * (step / period - self.speed);
        (STIFFNESS * (self.at - position) + DAMPING * (self.speed - velocity)).clamp(-STRENGTH, STRENGTH)
    }
}

#[cfg(test)]
#[path = "../../tests/inside/hand.rs"]
mod tests;
