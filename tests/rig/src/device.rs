//! The device that the rig plays: a mass with friction like a fluid's, moved by what the board commands, in steps of 50 µs; and where its
//! encoder is.
//!
//! It is the device that a board's default settings describe: 40 N at full current, 200 000 counts a metre; its winding and the sensor of its
//! current too.

use crate::order::Moves;

/// Mass, kg, and damping, N·s/m.
const MASS_KG: f32 = 0.1;
const DAMPING_N_S_PER_M: f32 = 1.0;
/// Full current, A, and the force at it, N.
const FULL_A: f32 = 5.0;
const FULL_N: f32 = 40.0;
/// Supply, V, resistance of the winding, Ω, and the part of a change of its current that comes in a step: 1 − e^(−R·T/L), with 0.5 mH.
const SUPPLY_V: f32 = 24.0;
const RESISTANCE_OHM: f32 = 4.8;
const FOLLOWS: f32 = 0.381;
/// The sensor at no current, and for each share of full current, of 4095: 6.875 A would be its end.
const MIDDLE: f32 = 2048.0;
const SENSED: f32 = MIDDLE * FULL_A / 6.875;
/// Counts of the encoder for a metre.
const COUNTS_PER_M: f32 = 200_000.0;
/// A step, s.
const STEP_S: f32 = 50e-6;
/// Fastest that it moves, counts in a step.
pub const FASTEST: i32 = 16;

/// A device on one axis.
#[derive(Clone, Copy, Debug, Default)]
pub struct Device {
    /// What moves it.
    moves: Moves,
    position_m: f32,
    velocity_m_per_s: f32,
    /// What a hand pushes with, N.
    push_n: f32,
    /// Current of the winding, as a share of full current.
    current: f32,
    /// Where the encoder is, counts.
    counts: i32,
    /// Of what moves by itself: steps since it moved last, and which way it goes.
    waited: u32,
    downward: bool,
    start: i32,
}

impl Device {
    /// From here on this moves it, from rest.
    pub fn moved_by(&mut self, moves: Moves) {
        *self = Self {
            moves,
            position_m: self.counts as f32 / COUNTS_PER_M,
            current: self.current,
            counts: self.counts,
            start: self.counts,
            ..Self::default()
        };
    }

    /// A hand pushes with so many mN from here on.
    pub fn push(&mut self, milli_n: u32, upward: bool) {
        self.push_n = milli_n as f32 * if upward { 1e-3 } else { -1e-3 };
    }

    /// Its encoder was turned by so many counts.
    pub fn turned(&mut self, counts: i32) {
        self.counts = self.counts.wrapping_add(counts);
        self.moved_by(Moves::Held);
    }

    /// 50 µs under a voltage, as a share of the supply, or without one: the current of the winding, as a share of full current, and its sensor,
    /// of 4095.
    pub fn wind(&mut self, voltage: Option<f32>) -> (f32, u16) {
        self.current = voltage.map_or(0.0, |voltage| {
            let emf_v = self.velocity_m_per_s * (FULL_N / FULL_A);
            let settled = (voltage * SUPPLY_V - emf_v) / (RESISTANCE_OHM * FULL_A);
            self.current + (settled - self.current) * FOLLOWS
        });
        // A cast takes what is beyond an integer, and what is no number, to one.
        (self.current, ((MIDDLE + self.current * SENSED) as u16).min(4095))
    }

    /// 50 µs under a command, as a share of full current: by how many counts the encoder moves.
    pub fn step(&mut self, share: f32) -> i32 {
        let before = self.counts;
        match self.moves {
            Moves::Held => {}
            Moves::Free => {
                let force_n = share * FULL_N + self.push_n - DAMPING_N_S_PER_M * self.velocity_m_per_s;
                self.velocity_m_per_s += force_n * (STEP_S / MASS_KG);
                self.position_m += self.velocity_m_per_s * STEP_S;
                // A cast takes what is beyond an integer, and what is no number, to one.
                let there = (self.position_m * COUNTS_PER_M) as i32;
                // Not `clamp`, which panics where its ends are the wrong way round.
                self.counts = there.max(before.saturating_sub(FASTEST)).min(before.saturating_add(FASTEST));
            }
            Moves::Sweep(counts, every, span) => {
                self.waited += 1;
                if self.waited >= every {
                    self.waited = 0;
                    let counts = counts.min(FASTEST.unsigned_abs()).cast_signed();
                    self.counts = self.counts.wrapping_add(if self.downward { -counts } else { counts });
                    let beyond = self.counts.wrapping_sub(self.start);
                    self.downward = if self.downward { beyond > 0 } else { beyond >= span };
                }
            }
        }
        self.counts.wrapping_sub(before)
    }
}

/// Levels of an encoder's channels A and B where it is at this count: A rises first on the way up.
pub fn levels(counts: i32) -> [bool; 2] {
    match counts & 3 {
        0 => [false, false],
        1 => [true, false],
        2 => [true, true],
        _ => [false, true],
    }
}

#[cfg(test)]
#[path = "../tests/inside/device.rs"]
mod tests;
