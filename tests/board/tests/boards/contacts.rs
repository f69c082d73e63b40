//! The emergency stop's two contacts are compared, whatever the motors do: one that is bridged is found by the next long press, refuses arming, and is
//! forgotten when a press has shown that it works.

use std::sync::Arc;

use board_bench::bench::{Bench, CURRENT_LOOP};
use board_bench::image::Firmware;
use board_bench::reviewed;
use board_bench::wire::Line;

use crate::breaks;

const FIRST: &str = "the supply fell without the emergency stop's first contact. If it was switched off, press the stop once and release it. \
                     If that does not help, the first contact is bridged";
const SECOND: &str = "the supply was above 4.5 V 10 s after the emergency stop was pressed: its second contact is bridged. Repair it, then press the \
                      stop until the supply is off";

/// A board alone that drives bridges.
struct Board {
    bench: Bench,
    firmware: Arc<Firmware>,
}

impl Board {
    fn armed() -> Self {
        let firmware = Arc::new(Firmware::release());
        let mut bench = breaks::just_armed(&firmware, 1, Line::default(), &breaks::scene(&CURRENT_LOOP));
        assert_eq!(bench.ask(1, "stream off"), "ok every 0 ticks");
        Self { bench, firmware }
    }

    fn disarmed() -> Self {
        let mut board = Self::armed();
        assert_eq!(board.bench.ask(1, "disarm"), "ok disarmed");
        board
    }

    /// Presses the stop for so long, and releases it.
    fn press(&mut self, ms: u64) {
        self.bench.press_stop(1, true);
        self.bench.run_for_ms(ms);
        self.bench.press_stop(1, false);
        self.bench.run_for_ms(100);
        assert!(!self.bench.stopped[0].bridges.on());
    }

    /// How often its newest lines of log, some six, tell of the contacts.
    fn logged(&mut self) -> usize {
        let log = self.bench.log(&self.firmware, 1);
        log.iter().filter(|said| said.starts_with("contacts of the stop: ")).count()
    }

    /// This was just found: it is in the status, and was logged once.
    fn found(&mut self, why: &str) {
        self.bench.run_for_ms(200);
        assert_eq!(self.logged(), 1);
        self.says(why);
    }

    fn says(&mut self, why: &str) {
        let status = self.bench.ask(1, "status");
        assert!(status.contains(&format!("; {why}; ")), "{status}");
    }

    /// Nothing that turns motors on is taken, for this reason.
    fn refuses(&mut self, why: &str) {
        assert!(self.bench.ask(1, "clear").starts_with("ok"));
        for line in ["arm", "arm alone", "check 1"] {
            assert_eq!(self.bench.ask(1, line), format!("error {why}"), "{line}");
        }
        self.says(why);
    }

    /// Nothing stands against arming but what is to be cleared; it is armed.
    fn arms(&mut self) {
        let status = self.bench.ask(1, "status");
        assert!([FIRST, SECOND].iter().all(|why| !status.contains(why)), "{status}");
        breaks::arm_again(&mut self.bench, "the contacts work");
        self.bench.run_for_ms(5);
        assert!(self.bench.stopped[0].bridges.on());
    }

    fn finish(self) {
        self.bench.finish().iter().for_each(reviewed::check);
    }
}

#[test]
fn a_second_contact_that_is_bridged_is_found_by_a_press_of_ten_seconds() {
    for mut board in [Board::armed(), Board::disarmed()] {
        board.bench.bridged = [false, true];
        board.press(1000);
        board.bench.press_stop(1, true);
        board.bench.run_for_ms(9900);
        assert!(!board.bench.ask(1, "status").contains(SECOND), "its 10 s are not over");
        board.bench.run_for_ms(150);
        board.found(SECOND);
        board.press(5);
        board.refuses(SECOND);
        // Repaired, it is forgotten by the first press that lasts until the supply has fallen.
        board.bench.bridged[1] = false;
        board.press(1000);
        board.refuses(SECOND);
        board.press(4000);
        board.arms();
        board.finish();
    }
}

#[test]
fn a_first_contact_that_is_bridged_is_found_when_the_supply_falls() {
    for mut board in [Board::armed(), Board::disarmed()] {
        board.bench.bridged = [true, false];
        board.press(4000);
        board.found(FIRST);
        board.refuses(FIRST);
        board.press(100);
        board.refuses(FIRST);
        // Repaired, it is forgotten by the first press.
        board.bench.bridged[0] = false;
        board.press(50);
        board.arms();
        board.finish();
    }
}

/// In the same way as with a bridged contact: nobody can tell them apart until the stop is pressed.
#[test]
fn a_supply_that_is_switched_off_takes_a_press_of_the_stop() {
    let mut board = Board::armed();
    board.bench.cut_supply(1, true);
    board.bench.run_for_ms(4000);
    board.found(FIRST);
    assert!(board.bench.ask(1, "status").contains(" faulted fault 19 "));
    board.bench.cut_supply(1, false);
    board.bench.run_for_ms(100);
    board.refuses(FIRST);
    board.press(50);
    board.arms();
    board.finish();
}

#[test]
fn a_stop_that_works_is_not_suspected() {
    let mut board = Board::armed();
    for ms in [50, 1000, 3700, 10_500] {
        board.press(ms);
        assert_eq!(board.logged(), 0, "{ms} ms");
        board.arms();
    }
    board.finish();
}
