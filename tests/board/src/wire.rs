//! The switch between the boards and the PC: a frame goes to the port it is addressed to, or to every other one.
//!
//! Delay and bad luck are between the boards only; the PC's line is ideal. What becomes of each frame there is cohold's to
//! say ([`Rule`]: drawn from the scene's network, or read from a trace): greetings and ARP fare as flow does. A frame that is to
//! arrive between two stops arrives at the later one.

use std::collections::VecDeque;

use cohold_sim::network::rule::{Arrival, Direction, Fate, Rule, of_scene};
use cohold_sim::scene::Scene;

use crate::pc::{MAC, board_mac};

/// Boards 1 and 2, and the PC.
pub const PORTS: usize = 3;
/// Port of the PC.
pub const PC: usize = 2;

/// The line between the boards.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// Delay, ns. What leaves after a tick arrives at the first stop after it, in the middle between two ticks, and is heard at the
    /// tick after that: a period later than the delay.
    pub delay_ns: u64,
    /// Whether every frame is dropped.
    pub silent: bool,
}

/// Heard 8 ms after the tick that sent it: the one packet period that the papers' scenes have.
impl Default for Line {
    fn default() -> Self {
        Self { delay_ns: 7_000_000, silent: false }
    }
}

/// The switch between boards and PC.
pub struct Wire {
    /// The line between the boards.
    pub line: Line,
    /// What becomes of frames from board 1 and from board 2; `None`: they arrive.
    rules: [Option<Box<dyn Rule>>; 2],
    sent: [u64; 2],
    flying: VecDeque<(u64, usize, Vec<u8>)>,
    /// Frames lost between the boards.
    pub lost: u64,
    /// Frames that arrived twice.
    pub doubled: u64,
    /// Frames broken on purpose.
    pub corrupt: u64,
}

impl Wire {
    /// A switch with no frame under way.
    pub fn new(line: Line) -> Self {
        Self { line, rules: [None, None], sent: [0; 2], flying: VecDeque::new(), lost: 0, doubled: 0, corrupt: 0 }
    }

    /// From now on the line between the boards is as bad as the scene's network.
    pub fn impair(&mut self, scene: &Scene) {
        self.rules = [Direction::OneToTwo, Direction::TwoToOne].map(|direction| of_scene(scene, direction, 0));
    }

    /// The copies of a frame from a board that arrive at the other.
    fn copies(&mut self, from: usize, at_ns: u64) -> Vec<Arrival> {
        if self.line.silent {
            return Vec::new();
        }
        let number = self.sent[from];
        self.sent[from] += 1;
        self.rules[from].as_mut().map_or(Fate::Pass, |rule| rule.decide(number, at_ns)).copies()
    }

    /// Takes a frame that left `from` at `at_ns`.
    pub fn send(&mut self, from: usize, at_ns: u64, frame: &[u8]) {
        let known = [board_mac(1), board_mac(2), MAC];
        let addressed = known.iter().position(|mac| frame.get(..6) == Some(mac));
        for to in (0..PORTS).filter(|to| *to != from && addressed.is_none_or(|only| only == *to)) {
            if from == PC || to == PC {
                self.flying.push_back((at_ns, to, frame.to_vec()));
                continue;
            }
            let copies = self.copies(from, at_ns);
            self.lost += u64::from(copies.is_empty());
            self.doubled += copies.len().saturating_sub(1) as u64;
            for copy in copies {
                let mut frame = frame.to_vec();
                if copy.corrupt {
                    let middle = frame.len() / 2;
                    frame[middle] ^= 0x10;
                    self.corrupt += 1;
                }
                let due = at_ns + self.line.delay_ns + copy.delay_ns;
                self.flying.push_back((due, to, frame));
            }
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
