//! A wall that the device meets, whoever holds it: a one-sided spring and damper in the room of a follower, or a stop.
//!
//! F = −(K·d + B·ḋ) where the device is d > 0 past the wall, and only as a push. The device is then another exact linear plant, of K and
//! B more; which of both it is, is decided every 50 µs. What a crossing between two of these makes or takes is below ½K·(v·50 µs)²: 0.3 µJ for
//! 1 kN/m at 0.5 m/s.

use cohold_core::num::Motion;

use super::linear::Linear;

/// Longest step between two looks at which side of the wall the device is, s.
pub(super) const LOOK_S: f64 = 50e-6;

/// A wall along the free axis.
#[derive(Clone, Debug)]
pub(super) struct Wall {
    /// Away from the other peer: 1 toward positive x, or −1.
    away: f64,
    at_m: f64,
    stiffness: f64,
    damping: f64,
    free: Linear,
    pressed: Linear,
    /// Looks in a step of the plant.
    looks: u32,
    /// Share of the step in which the force before still acts.
    late: f64,
    /// What it pushed with at the end of the last step, N toward the other peer.
    pub(super) force_n: f64,
}

/// What moves: mass (kg), damping (N·s/m), stiffness (N/m).
pub(super) struct Moving {
    pub(super) mass: f64,
    pub(super) damping: f64,
    pub(super) stiffness: f64,
}

impl Wall {
    /// At this place of the axis (m), of a stiffness (N/m) and damping (N·s/m), for what moves in steps of `step_s` with the force before
    /// acting for a share `late` of each.
    pub(super) fn new(
        (away, at_m): (f64, f64),
        [stiffness, damping]: [f64; 2],
        moving: &Moving,
        (step_s, late): (f64, f64),
    ) -> Self {
        let looks = (step_s / LOOK_S).round().max(1.0);
        let of = |damping, stiffness| Linear::new(moving.mass, damping, stiffness, 0.0, step_s / looks);
        Self {
            away,
            at_m,
            stiffness,
            damping,
            free: of(moving.damping, moving.stiffness),
            pressed: of(moving.damping + damping, moving.stiffness + stiffness),
            looks: looks as u32,
            late,
            force_n: 0.0,
        }
    }

    /// Force of the wall on a device in this motion, N along the axis.
    pub(super) fn push(&self, at: Motion<f64>) -> f64 {
        let depth = self.away * (at.position - self.at_m);
        let push = self.stiffness * depth + self.damping * self.away * at.velocity;
        if depth > 0.0 { -self.away * push.max(0.0) } else { 0.0 }
    }

    /// The motion one step later, under the forces before and now.
    pub(super) fn advance(&mut self, mut motion: Motion<f64>, before: f64, now: f64) -> Motion<f64> {
        for look in 0..self.looks {
            // The share of this look in which the force before still acts.
            let late = (self.late * f64::from(self.looks) - f64::from(look)).clamp(0.0, 1.0);
            let force = late * before + (1.0 - late) * now;
            motion = if self.push(motion) == 0.0 {
                self.free.advance(motion, force, force)
            } else {
                // About the wall: what the device's own spring, if it has one, draws to is elsewhere.
                let force = force + self.stiffness * self.at_m;
                self.pressed.advance(motion, force, force)
            };
        }
        self.see(motion);
        motion
    }

    /// Takes in where the device is that others have moved.
    pub(super) fn see(&mut self, motion: Motion<f64>) {
        self.force_n = self.push(motion).abs();
    }
}
