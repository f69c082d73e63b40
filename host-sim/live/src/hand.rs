//! A pointer becomes a hand: a spring and a damper from where the pointer is to the device (a virtual coupling). So does what else says 60
//! times a second where a hand at a simulated device is to be ([`crate::steering`]).
//!
//! A mouse cannot be pushed back. What its user gets instead of a force is the distance between pointer and device, which
//! *is* the force, over the stiffness. Pointers come 60 times a second, in steps, and not quite evenly: taken as they come
//! they rattle by 0.1 N. So they are played out `DELAY` late, straight from one to the next, as packets are on a line that jitters;
//! then a drag at constant speed has no ripple at all.
//!
//! The force is formed once a tick and held through it. SI units; positive is to the right, away from the person, and up. Of several axes
//! a hand's strength and its speed are limited as the lengths of their vectors.

use std::array::from_fn;
use std::collections::VecDeque;

use cohold_core::num::Motion;

/// Stiffness, N/m: 5 mm is 1 N.
pub const STIFFNESS: f64 = 200.0;
/// Damping, N·s/m, between pointer and device: without the pointer's speed in it a drag at 0.1 m/s would feel like 1.2 N.
pub const DAMPING: f64 = 12.0;
/// A hand's strength, N.
pub const STRENGTH: f64 = 10.0;
/// Play-out, ticks: one frame of 60 Hz, and half of the next.
const DELAY: u64 = 24;
/// Fastest hand, m/s: how a frame that came too late is made good.
pub const FASTEST: f64 = 0.5;
/// Share of its speed that a hand takes on in a tick: a jump of a few ticks is no blow through the damper.
const AGILITY: f64 = 0.1;

/// Farthest that a device goes from the middle, m.
pub const REACH_M: f64 = 0.12;
/// The ends of its travel, N/m and N·s/m.
pub const END_STIFFNESS: f64 = 500.0;
const END_DAMPING: f64 = 5.0;

/// Force of a device's end of travel against a pull, N.
pub fn end_of_travel(Motion { position, velocity }: Motion<f64>) -> f64 {
    let beyond = position - position.clamp(-REACH_M, REACH_M);
    if beyond == 0.0 { 0.0 } else { END_STIFFNESS * beyond + END_DAMPING * velocity }
}

/// A hand that follows a pointer along `N` axes.
#[derive(Clone, Debug)]
pub struct Hand<const N: usize = 1> {
    /// Where the pointer was, m, and when it said so, in ticks.
    path: VecDeque<(u64, [f64; N])>,
    at: [f64; N],
    speed: [f64; N],
}

impl<const N: usize> Default for Hand<N> {
    fn default() -> Self {
        Self { path: VecDeque::new(), at: [0.0; N], speed: [0.0; N] }
    }
}

/// A vector in the same direction, no longer than `most`.
fn within<const N: usize>(vector: [f64; N], most: f64) -> [f64; N] {
    let length = vector.iter().map(|part| part * part).sum::<f64>().sqrt();
    if length <= most { vector } else { vector.map(|part| part / length * most) }
}

impl<const N: usize> Hand<N> {
    /// The pointer says where it is (m), or that it has let go. A hand takes the device where that is.
    pub fn point(&mut self, tick: u64, pointer: Option<[f64; N]>, device: [f64; N]) {
        match pointer {
            None => self.path.clear(),
            Some(at) => {
                if self.path.is_empty() {
                    (self.at, self.speed) = (device, [0.0; N]);
                }
                self.path.push_back((tick, at));
            }
        }
    }

    /// Where the hand is, m, if it holds.
    pub fn holds(&self) -> Option<[f64; N]> {
        (!self.path.is_empty()).then_some(self.at)
    }

    /// Force (N) on a device where it is (m) and as fast as it moves (m/s), in a tick of `period` (s).
    pub fn pull(&mut self, tick: u64, device: [Motion<f64>; N], period: f64) -> [f64; N] {
        let then = tick.saturating_sub(DELAY);
        while self.path.get(1).is_some_and(|next| next.0 <= then) {
            self.path.pop_front();
        }
        let to = match (self.path.front(), self.path.get(1)) {
            (Some(&(from, a)), Some(&(until, b))) if from < then => {
                from_fn(|axis| a[axis] + (b[axis] - a[axis]) * (then - from) as f64 / (until - from) as f64)
            }
            (Some(&(_, a)), _) => a,
            (None, _) => return [0.0; N],
        };
        let step = within::<N>(from_fn(|axis| to[axis] - self.at[axis]), FASTEST * period);
        for (axis, step) in step.into_iter().enumerate() {
            self.at[axis] += step;
            self.speed[axis] += AGILITY * (step / period - self.speed[axis]);
        }
        let force = |axis: usize| {
            let Motion { position, velocity } = device[axis];
            STIFFNESS * (self.at[axis] - position) + DAMPING * (self.speed[axis] - velocity)
        };
        within(from_fn(force), STRENGTH)
    }
}

#[cfg(test)]
#[path = "../tests/inside/hand.rs"]
mod tests;
