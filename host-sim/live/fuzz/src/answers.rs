//! Any text as what a board answers, line by line: no panic, and no setting that no board can have.

use cohold_board_tools::calibrate::board::{Board, Tick, probed, settings, take};
use cohold_board_tools::status::{Probed, Status};
use cohold_board_tools::{Error, calibrate::settings_file::named};
use cohold_core::settings::Settings;

/// A board that answers with these lines, from the first again after the last.
struct Says<'a>(std::iter::Cycle<std::str::Lines<'a>>);

impl Board for Says<'_> {
    fn ask(&mut self, _: &str) -> Result<String, Error> {
        Ok(self.0.next().unwrap_or_default().to_owned())
    }

    fn ticks(&mut self, _: f64) -> Result<Vec<Tick>, Error> {
        Ok(Vec::new())
    }
}

/// Every value is one that its key accepts.
fn check(settings: &Settings) {
    for key in Settings::keys() {
        let value = settings.get(key.name).expect("a key that there is");
        assert!(Settings::default().set(key.name, value).is_ok(), "{} = {value}", key.name);
    }
}

/// Runs one fuzz input.
pub(super) fn run(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    let mut board = Says(text.lines().cycle());
    for line in text.lines() {
        let _ = (Status::parse(line), Probed::parse(line), Tick::from_record(line.as_bytes()), named(line));
    }
    let _ = probed(&mut board);
    if let Ok(settings) = settings(&mut board) {
        check(&settings);
    }
    let mut own = Settings::default();
    for key in ["axis.shared", "timing.control_period_s", "coordination.comm", "contact.one_sided"] {
        let _ = take(&mut board, &mut own, key);
    }
    check(&own);
}
