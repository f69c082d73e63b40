//! cohold's bring-up as far as the emergency stop, with the rig's orders where a person would press it and release it.

use std::cell::RefCell;
use std::path::Path;

use cohold_board_tools::Error;
use cohold_board_tools::bringup::{Plan, bring_up};
use cohold_board_tools::calibrate::board::{Board, Tick};
use cohold_board_tools::calibrate::counts::Distance;
use cohold_board_tools::calibrate::motor::Against;
use cohold_board_tools::calibrate::winding::Sheet;
use cohold_board_tools::calibrate::{Person, Task};
use cohold_rig::run::{Boards, Outcome};
use firmware_parts::record::Record;

/// Boards whose records can be taken.
pub(super) trait Records: Boards {
    /// What came since this was asked last.
    fn take(&mut self) -> Vec<Record>;
}

/// The board, and who stands at it.
struct AtTheBoard<'a, B>(&'a RefCell<&'a mut B>);

impl<B: Records> Board for AtTheBoard<'_, B> {
    fn ask(&mut self, line: &str) -> Result<String, Error> {
        Ok(self.0.borrow_mut().ask(line)?)
    }

    fn ticks(&mut self, seconds: f64) -> Result<Vec<Tick>, Error> {
        let mut boards = self.0.borrow_mut();
        boards.wait_ms((1e3 * seconds).round() as u64)?;
        Ok(boards.take().iter().filter_map(|record| Tick::from_record(&record.bytes())).collect())
    }
}

/// Who presses and releases the stop.
struct Presses<'a, B> {
    boards: &'a RefCell<&'a mut B>,
    pressed: &'a [&'a str],
    released: &'a [&'a str],
}

impl<B: Records> Person for Presses<'_, B> {
    fn please(&mut self, task: &Task) -> Result<(), Error> {
        let orders = match task {
            Task::PressStop => self.pressed,
            Task::ReleaseStop => self.released,
            _ => &[],
        };
        let mut boards = self.boards.borrow_mut();
        for line in orders {
            boards.order(line)?;
            let answer = boards.answer(1000)?;
            if answer != "ok" {
                return Err(format!("the rig says to `{line}`: {answer}").into());
            }
        }
        Ok(boards.wait_ms(5)?)
    }

    /// What comes after the stop is not the rig's.
    fn reading(&mut self, what: &str) -> Result<f64, Error> {
        Err(format!("nobody reads {what}").into())
    }
}

/// What bring-up says of the stop.
pub(super) fn seen<B: Records>(boards: &mut B, pressed: &[&str], released: &[&str]) -> Outcome {
    let boards = RefCell::new(boards);
    boards.borrow_mut().take();
    // It ends before any of it is needed.
    let sheet = Sheet { resistance_ohm: None, inductance_h: None, tolerance: 0.3 };
    let plan =
        Plan { joint: 1, distance: Distance::Metres(0.05), sheet, against: Against::Mass(0.2), file: Path::new("") };
    let (mut board, mut person) = (AtTheBoard(&boards), Presses { boards: &boards, pressed, released });
    let mut stop = None;
    let ended = bring_up(&mut board, &mut person, plan, |passed| {
        if passed.step == "emergency stop" {
            stop = Some(passed.seen.clone());
        }
    });
    match (stop, ended) {
        (Some(seen), _) => Ok(seen),
        (None, Err(why)) => Err(why.to_string()),
        (None, Ok(_)) => Err("bring-up has no step of the emergency stop".to_owned()),
    }
}
