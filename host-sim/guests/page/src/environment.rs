//! What a page's control loop steps and its windows draw: one mechanism for two peers, one peer of two machines, and
//! every shared environment.
//!
//! An environment has up to two hands that people hold, and gives a sample a tick. What is in a sample its list of
//! columns says; the last column of all is how often it has started anew, so that a window lets go of a world that is
//! no more.

use std::sync::Arc;

use cohold_core::safety::Mode;
pub(super) use cohold_live::playable::Column;
use cohold_live::playable::MOST_COLUMNS;
use cohold_live::recording::recorder::Recorder;
use cohold_live::road::PathReport;
use cohold_live::verdict::Verdict;
use cohold_sim::scene::Scene;
use serde::Serialize;

use super::boards_line::Line;
use super::partner::Model;
use cohold_cli::Failure;

/// Numbers in a sample, at the most; what a column is missing for is no number. The last one of all says how often it has started anew.
pub(super) const MOST: usize = MOST_COLUMNS + 1;

/// The numbers of one tick.
pub(super) type Sample = [f32; MOST];

/// These lists one after the other, which have `N` columns in all; in a constant, others are a compile error.
pub(super) const fn joined<const N: usize>(parts: &[&[Column]]) -> [Column; N] {
    let mut all = [("", "", ""); N];
    let (mut part, mut at) = (0, 0);
    while part < parts.len() {
        let mut column = 0;
        while column < parts[part].len() {
            all[at] = parts[part][column];
            (column, at) = (column + 1, at + 1);
        }
        part += 1;
    }
    assert!(at == N);
    all
}

/// A peer's mode as one number, as windows get it.
pub(super) const OFF: u8 = 0;
pub(super) const ARMED: u8 = 1;
/// It waits for the other end. Of a board: it has not said lately how its motors are, they may be on.
pub(super) const WAITS: u8 = 2;
/// A board whose motors run without an operator.
pub(super) const ALONE: u8 = 3;
pub(super) const FAULT: u8 = 100;

/// The number of a mode: [`OFF`], [`ARMED`], or [`FAULT`] and the number of the fault.
pub(super) fn number_of(mode: Mode) -> u8 {
    match mode {
        Mode::Armed => ARMED,
        Mode::Faulted(fault) => FAULT + fault.number(),
        Mode::Disarmed | Mode::Probing => OFF,
    }
}

/// What a recording has of both peers behind the columns of a sample.
pub(super) const MODES: [Column; 4] = [
    ("mode_1", "", "peer 1: 0 disarmed, 1 armed, 2 faulted"),
    ("fault_1", "", "peer 1: number of the fault, 0 none"),
    ("mode_2", "", "the same of peer 2"),
    ("fault_2", "", "the same of peer 2"),
];

/// The numbers of [`MODES`] of a peer; none while its other end has not said them.
pub(super) fn mode_and_fault(mode: u8) -> [f64; 2] {
    match mode {
        WAITS => [f64::NAN; 2],
        FAULT.. => [2.0, (mode - FAULT).into()],
        _ => [u8::from(mode != OFF).into(), 0.0],
    }
}

/// What acts at the next tick, without a question.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Command {
    /// Turns the motors off.
    Stop,
    /// Starts the environment anew, from rest.
    Start,
    /// The line is cut, or joined.
    Cut(bool),
    /// Who holds the hands that nobody holds.
    Partner(Model),
    /// A line to a board, 1 or 2.
    Board(u8, Line),
}

/// How it stands, in a few bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Standing {
    /// Of both peers, as [`number_of`] has them.
    pub(super) modes: [u8; 2],
    pub(super) cut: bool,
    /// Index of the partner, in [`Model`]'s list.
    pub(super) partner: u8,
}

/// What a report has of the line to a partner elsewhere, as a `peer`'s has it.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct LineReport {
    /// Smoothed; null while it is not known.
    pub(super) round_trip_us: Option<u32>,
    /// Which way it went, and what both ways were like; absent where the other one was called at an address.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) path: Option<PathReport>,
    /// What the scene is at the delays that were measured last.
    pub(super) verdict: Option<Verdict>,
    /// Every change of that, and when, s.
    pub(super) verdicts: Vec<(f64, String)>,
}

/// Something that a page's hands act on.
pub(super) trait Environment {
    /// Does what acts without a question.
    fn command(&mut self, command: Command) -> Result<(), Failure>;

    /// A page of the operator has asked: somebody looks who can stop it.
    fn attend(&mut self) {}

    /// Takes another scene, which is what every setting is from now on.
    fn set(&mut self, scene: Scene) -> Result<(), Failure>;

    /// What a person's pointer says before the next tick: where it is, m, along, across and up, or that it lets go. Where it says so of
    /// a world that was before the last start, it has let go.
    fn point(&mut self, hand: usize, at: Option<[f64; 3]>, restarts: u32);

    /// Who plays when nobody holds this hand holds it in the next tick: nobody, where the simulated hands are left alone.
    fn play(&mut self, hand: usize) {
        self.point(hand, None, 0);
    }

    /// Steps the environment by one tick.
    fn step(&mut self) -> Result<Sample, Failure>;

    /// Modes of the peers, line and partner as they are now.
    fn standing(&self) -> Standing;

    /// It is recorded from now on: what a recording of it has beside its samples it puts there itself, into channels that come first.
    fn record(&mut self, _recorder: Arc<Recorder>) {}

    /// What there is to report of a line to another process, where there is one.
    fn line(&self) -> Option<LineReport> {
        None
    }

    /// Nothing changes before it is started anew: it is not stepped, and what was seen last stays.
    fn stands(&self) -> bool {
        false
    }

    /// Other news for every window, if there are any.
    fn news(&mut self) -> Option<String> {
        None
    }
}

/// An environment that is opened on the control loop's own thread.
pub(super) type Opening = Box<dyn FnOnce() -> Result<Box<dyn Environment>, Failure> + Send>;
