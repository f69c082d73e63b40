//! The switch between the boards and the PC: every frame goes to every other port, late, and some not at all.
//!
//! Delay and loss are between the boards only; the PC's line is ideal. Randomness is seeded: a run is a function of its
//! seed. A frame that is to arrive between two stops arrives at the later one.

use std::collections::VecDeque;

/// Boards 1 and 2, and the PC.
pub const PORTS: usize = 3;
/// The PC's port.
pub const PC: usize = 2;

/// What the line between the boards does to frames.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// Delay, ns.
    pub delay_ns: u64,
    /// Probability that a frame is lost.
    pub loss: f64,
    /// Of everything random.
    pub seed: u64,
}

impl Default for Line {
    fn default() -> Self {
        Self { delay_ns: 4_000_000, loss: 0.0, seed: 1 }
    }
}

/// The switch.
#[derive(Debug)]
pub struct Wire {
    /// Between the boards.
    pub line: Line,
    flying: VecDeque<(u64, usize, Vec<u8>)>,
    random: u64,
    /// Frames lost between the boards.
    pub lost: u64,
}

impl Wire {
    /// An empty switch.
    pub fn new(line: Line) -> Self {
        Self { line, flying: VecDeque::new(), random: line.seed, lost: 0 }
    }

    /// The next number in [0, 1): splitmix64.
    fn draw(&mut self) -> f64 {
        self.random = self.random.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.random;
        z = (z ^ z >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ z >> 31) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Takes a frame that left `from` at `at_ns`.
    pub fn send(&mut self, from: usize, at_ns: u64, frame: &[u8]) {
        for to in (0..PORTS).filter(|to| *to != from) {
            let between_boards = from != PC && to != PC;
            if between_boards && self.line.loss > 0.0 && self.draw() < self.line.loss {
                self.lost += 1;
                continue;
            }
            let due = at_ns + if between_boards { self.line.delay_ns } else { 0 };
            self.flying.push_back((due, to, frame.to_vec()));
        }
    }

    /// What has arrived at `port` by `now_ns`, in the order it was due.
    pub fn receive(&mut self, port: usize, now_ns: u64) -> Vec<Vec<u8>> {
        let mut here: Vec<(u64, Vec<u8>)> = Vec::new();
        self.flying.retain_mut(|(due, to, frame)| {
            let arrived = *to == port && *due <= now_ns;
            if arrived {
                here.push((*due, std::mem::take(frame)));
            }
            !arrived
        });
        here.sort_by_key(|(due, _)| *due);
        here.into_iter().map(|(_, frame)| frame).collect()
    }
}
