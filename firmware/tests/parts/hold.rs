//! Motors stay on while an operator lets them, and not longer than the lease after that.

use cohold_core::safety::{Fault, Mode};
use cohold_protocol::lease::{AtBoard, Motors, No, Word};
use firmware_parts::hold::{Hold, LOOK_EVERY};
use firmware_parts::signals::Signals;

const LEASE_S: f64 = 0.2;

/// The byte of run `number`, which the operator's end says.
fn run(number: u8) -> u8 {
    number << 2 | 2
}

/// A board, and a clock of its own, µs.
struct Board {
    hold: Hold,
    signals: Signals,
    now_us: u64,
}

impl Board {
    /// On by run 1 in this mode, alone or not.
    fn on(mode: Mode, alone: bool, now_us: u64) -> Self {
        let mut board = Self { hold: Hold::default(), signals: Signals::at_power_on(), now_us };
        board.hear(run(1), 0);
        assert_eq!(board.start(run(1), alone), Ok(()));
        board.signals.mode.set(mode);
        board.hold.started();
        board
    }

    fn hear(&mut self, byte: u8, ago_us: u64) -> bool {
        self.hold.hear(self.now_us, (byte, Some(self.now_us - ago_us)), &self.signals)
    }

    fn start(&mut self, byte: u8, alone: bool) -> Result<(), No> {
        let mut given = false;
        let word = (Word::of_byte(byte), alone);
        let started = self.hold.start(self.now_us, word, LEASE_S, &self.signals, || given = true);
        assert_eq!(given, started.is_ok(), "an order is given with a start, and with nothing else");
        started
    }

    fn look(&mut self) -> bool {
        self.hold.look(self.now_us, &self.signals)
    }

    /// When a look, one each ms, turns motors off, ms.
    fn off_after(&mut self) -> Option<u64> {
        let begun_us = self.now_us;
        while self.now_us < begun_us + 1_000_000 {
            self.now_us += 1_000;
            if self.look() {
                assert!(self.signals.disarm.acquire());
                return Some((self.now_us - begun_us) / 1_000);
            }
        }
        None
    }

    fn motors(&self) -> Motors {
        self.hold.told(&self.signals).motors
    }
}

#[test]
fn motors_go_off_when_the_operator_has_been_silent() {
    let lease_ms = 200 - u64::from(LOOK_EVERY) - 1;
    for mode in [Mode::Armed, Mode::Probing] {
        let mut board = Board::on(mode, false, 7_000_000);
        assert_eq!((board.motors(), board.hold.says()), (Motors::Leased, ""));
        assert_eq!(board.off_after(), Some(lease_ms));
        assert_eq!(board.hold.says(), "motors off: the operator was silent; ");
        assert_eq!(board.motors(), Motors::Leased, "until the tick has turned them off");
        board.signals.mode.set(Mode::Disarmed);
        assert_eq!(board.motors(), Motors::Off);
        // A permission counts from the newest time of the board's that the operator knew.
        let mut board = Board::on(mode, false, 7_000_000);
        board.now_us += 190_000;
        assert!(!board.hear(run(1), 50_000));
        assert_eq!(board.off_after(), Some(lease_ms - 50));
    }
    let mut board = Board::on(Mode::Armed, true, 7_000_000);
    assert_eq!((board.off_after(), board.motors()), (None, Motors::Alone));
    assert_eq!(board.hold.says(), "armed alone; ");
}

#[test]
fn another_word_turns_off_at_once_and_a_stop_also_what_runs_alone() {
    for (alone, byte, off) in
        [(false, 2 << 2, true), (false, run(2), true), (false, 2 << 2 | 1, true), (true, 2 << 2, false)]
    {
        let mut board = Board::on(Mode::Armed, alone, 7_000_000);
        assert_eq!(board.hear(byte, 0), off, "{byte}");
        let says = if alone { "armed alone; " } else { "motors off: the operator does not let them run; " };
        assert_eq!(board.hold.says(), says);
        board.hold.look(board.now_us, &board.signals);
        assert_eq!(board.hold.says(), says);
    }
    let mut board = Board::on(Mode::Armed, true, 7_000_000);
    board.hold.step(board.now_us, AtBoard::Session);
    assert!(!board.look() && board.hear(2 << 2 | 1, 0), "a stop of any operator");
    assert_eq!(board.hold.says(), "motors off: the operator does not let them run; ");
    let mut board = Board::on(Mode::Armed, false, 7_000_000);
    board.hold.step(board.now_us, AtBoard::Session);
    assert!(board.look(), "another operator has let nothing run");
    assert_eq!(board.hold.says(), "motors off: the operator does not let them run; ");
}

#[test]
fn a_start_needs_its_own_word_and_a_fresh_one_and_motors_that_are_off() {
    let mut board = Board::on(Mode::Armed, false, 7_000_000);
    assert_eq!(board.start(run(1), false), Err(No::Used));
    assert!(board.hear(run(2), 0));
    board.signals.mode.set(Mode::Disarmed);
    // Under another number, under no run, and twice; which the model leaves out.
    for byte in [run(1), run(3), 2 << 2, 2 << 2 | 1] {
        assert_eq!(board.start(byte, false), Err(No::NotLet), "{byte}");
    }
    assert_eq!(board.start(run(2), true), Ok(()));
    board.signals.mode.set(Mode::Armed);
    assert!(!board.hear(run(3), 0), "it runs alone");
    assert_eq!(board.start(run(3), false), Err(No::On));
    // As old as the lease.
    let mut board = Board::on(Mode::Armed, false, 7_000_000);
    board.signals.mode.set(Mode::Disarmed);
    board.hear(run(2), 194_000);
    assert_eq!(board.start(run(2), true), Err(No::Stale));
    board.hear(run(2), 193_000);
    assert_eq!(board.start(run(2), true), Ok(()));
}

/// The tick turned them off by itself: a start is needed, and what was let run does not go on.
#[test]
fn what_has_gone_off_stays_off() {
    let mut board = Board::on(Mode::Armed, false, 7_000_000);
    board.signals.mode.set(Mode::Faulted(Fault::PeerLost));
    assert!(!board.look());
    assert_eq!((board.motors(), board.start(run(1), false)), (Motors::Off, Err(No::Used)));
    // An order that waits for the tick is one that turns motors on, unless the lease ends before.
    board.hear(run(2), 0);
    assert_eq!(board.start(run(2), false), Ok(()));
    assert!(!board.look() && board.motors() == Motors::Leased);
    assert!(board.hear(2 << 2 | 1, 0) && board.signals.disarm.acquire());
    board.hold.started();
    assert_eq!(board.motors(), Motors::Off);
    let mut board = Board::on(Mode::Armed, true, 7_000_000);
    board.hold.off(board.now_us, &board.signals);
    assert!(board.signals.disarm.acquire() && board.motors() == Motors::Leased);
}
