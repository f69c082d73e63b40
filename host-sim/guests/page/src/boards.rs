//! One or two boards as their operator has them: what their ticks see, and the few lines that a page may say to them.
//!
//! A board moves a motor against a person, so a page says no line of its own making: arm, clear a fault, check a joint,
//! and stop. Whether motors may be on is the lease's to say ([`cohold_protocol::lease`]). **Stop** is said from the next datagram on, to
//! every board, whatever its thread waits for, until the board confirms it; it also ends what runs alone or for another operator. **Hold
//! to run**: permission ends when no page of the operator has asked for [`SILENCE_US`], because it was closed, hidden or is stuck; motors
//! also go off when this process is silent (`safety.operator_lost_s`). A page shows motors as off only while the board's own word on
//! that is new. The pointer pulls nothing: whoever holds the device feels the other one's hand.
//!
//! Each board has a thread, which may wait for an answer; the control loop only tries its lock. Ticks come in batches
//! and some are lost: they are played out [`BEHIND`] late, each held until the next.

use std::collections::VecDeque;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use cohold_board_tools::calibrate::board::{Board, FAULTED, Joint, settings};
use cohold_board_tools::calibrate::simulated::SharedSimulation;
use cohold_board_tools::operator::{Reins, STOPPED, STOPPING, UNCONFIRMED, is_start};
use cohold_board_tools::recording::{COLUMNS, row};
use cohold_board_tools::status::Probed;
use cohold_core::safety::Fault;
use cohold_live::endpoint::stand_back;
use cohold_live::operator::Operator;
use cohold_protocol::lease::{AtBoard, AtOperator, Holder, Motors, No, Word};
use cohold_sim::quantities::place;
use cohold_sim::scene::Scene;
use serde::Serialize;
use serde_json::json;

use super::boards_line::Line;
use super::environment::{ALONE, ARMED, Command, Environment, FAULT, OFF, Sample, Standing, WAITS};
use super::pair_columns::{OF_BOTH, sample};
use super::session::PERIOD_S;
use cohold_cli::Failure;

/// After so long without a page of the operator the motors go off, µs.
const SILENCE_US: u64 = 1_000_000;
/// Lease of a simulated board, µs.
const LEASE_US: u64 = 200_000;
/// From one look at a board to the next, s.
const LOOK_S: f64 = 0.02;
/// From one question for its status to the next.
const STATUS: Duration = Duration::from_millis(500);
/// Every how-many-th millisecond a tick is sent; rows count milliseconds, whatever the board's tick is.
const EVERY: u32 = 4;
/// How far behind its newest tick a board is shown, ticks, and how far before what is shown begins anew.
const BEHIND: f64 = 60.0;
const FARTHEST: f64 = 250.0;
/// How far a board's thread stands back behind the control loop.
const NICENESS: i32 = 5;
/// Answers that are shown.
const ANSWERS: usize = 6;
/// Rows of a board that wait to be shown, several times what lies between the newest and what is shown.
const ROWS: usize = 1024;
/// What is shown instead of a status that is older than the board's newest word may be.
const SILENT: &str = "nothing is heard of it";
/// Numbers of a tick: how it went, as [`COLUMNS`] has them.
const NUMBERS: usize = COLUMNS.len();
const TICK: usize = place(&COLUMNS, "tick");
const MODE: usize = place(&COLUMNS, "mode");
const FAULT_NUMBER: usize = place(&COLUMNS, "fault");
const DEVICE: usize = place(&COLUMNS, "device_m");
/// What is shown of both boards.
const SHOWN: [usize; 5] = [
    DEVICE,
    place(&COLUMNS, "object_m"),
    place(&COLUMNS, "decoded_m"),
    place(&COLUMNS, "contact_n"),
    place(&COLUMNS, "coordination_n"),
];
const RECEIVED: usize = place(&COLUMNS, "energy_received_j");
const SENT: usize = place(&COLUMNS, "energy_sent_j");

/// Where a board is.
#[derive(Clone, Debug)]
pub(crate) enum Place {
    /// On the network, under the operator's key of this file.
    At(SocketAddr, PathBuf),
    /// A board with a software device in this process, to practise on.
    Simulated,
}

/// What a page gets about a board.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
struct BoardStatus {
    name: String,
    there: bool,
    /// What it said of itself last.
    status: String,
    /// The newest lines and answers, oldest first.
    said: VecDeque<(String, String)>,
}

impl BoardStatus {
    /// One more line and its answer, which takes the place of [`STOPPING`]; of more than [`ANSWERS`] the oldest is gone.
    fn say(&mut self, line: &str, answer: String) {
        if self.said.back().is_some_and(|last| (last.0.as_str(), last.1.as_str()) == (line, STOPPING)) {
            self.said.pop_back();
        }
        if self.said.len() == ANSWERS {
            self.said.pop_front();
        }
        self.said.push_back((line.to_owned(), answer));
    }
}

/// More rows that wait to be shown; of more than [`ROWS`] the oldest are gone, whatever ticks a board says that they are of.
fn wait_for(waiting: &mut VecDeque<[f64; NUMBERS]>, rows: impl IntoIterator<Item = [f64; NUMBERS]>) {
    waiting.extend(rows);
    waiting.drain(..waiting.len().saturating_sub(ROWS));
}

/// What lies between a board's thread and the control loop.
#[derive(Debug, Default)]
struct BoardMailbox {
    /// To be said, oldest first, with the run that it starts; a stop comes before all of it.
    lines: VecDeque<(Line, Option<Word>)>,
    stop: bool,
    rows: VecDeque<[f64; NUMBERS]>,
    reported: BoardStatus,
}

/// A board and its thread.
struct Seat {
    /// 0 or 1.
    index: usize,
    mailbox: Arc<Mutex<BoardMailbox>>,
    reins: Reins,
    /// When the clock of the reins began.
    clock: Instant,
    over: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
    /// Tick that is shown, and what it saw.
    at: f64,
    shown: Option<[f64; NUMBERS]>,
    rows: VecDeque<[f64; NUMBERS]>,
    /// Its newest word is too old.
    silent: bool,
}

/// Whoever answers lines and gives ticks.
trait BoardLink {
    /// Says a line, under the word of the run that it starts, and gives the answer.
    fn ask(&mut self, line: &str, run: Option<Word>) -> Result<String, Failure>;
    /// Stops, and waits until the board says that its motors are off.
    fn stop(&mut self) -> Result<(), Failure>;
    /// Lets so much time pass, and gives what came.
    fn rows(&mut self, seconds: f64) -> Result<Vec<[f64; NUMBERS]>, Failure>;
}

impl BoardLink for Operator {
    fn ask(&mut self, line: &str, run: Option<Word>) -> Result<String, Failure> {
        Ok(self.ask_under(line, run)?)
    }

    fn stop(&mut self) -> Result<(), Failure> {
        Ok(Self::stop(self)?)
    }

    fn rows(&mut self, seconds: f64) -> Result<Vec<[f64; NUMBERS]>, Failure> {
        let samples = self.samples(Duration::from_secs_f64(seconds))?;
        Ok(samples.iter().filter_map(|sample| first_row(sample.payload())).collect())
    }
}

/// A row of the first shared axis.
fn first_row(payload: &[u8]) -> Option<[f64; NUMBERS]> {
    row(payload, PERIOD_S).filter(|(axis, _)| *axis == 0).map(|(_, row)| row)
}

/// How a board's thread begins.
type Open = Box<dyn FnOnce() -> Result<Box<dyn BoardLink>, Failure> + Send>;

/// A board's side of the lease, for one that is in this process.
struct Near {
    holder: Holder,
    reins: Reins,
    clock: Instant,
}

impl Near {
    fn new(reins: Reins, clock: Instant) -> Self {
        Self { holder: Holder::new(LEASE_US), reins, clock }
    }

    /// Both ends hear each other once, while motors are driven or not: whether they are to go off.
    fn exchange(&mut self, driven: bool) -> bool {
        let now_us = self.clock.elapsed().as_micros() as u64;
        let word = self.reins.giver().word(now_us);
        let off = (!driven).then_some(AtBoard::Off);
        for event in off.into_iter().chain([AtBoard::Heard { word, echo_us: Some(now_us) }, AtBoard::Look]) {
            // Nothing but a start is refused.
            let _ = self.holder.step(now_us, event);
        }
        self.reins.note(now_us, AtOperator::Heard { told: self.holder.told(driven), echo_us: Some(now_us) });
        driven && self.holder.motors() == Motors::Off
    }

    fn start(&mut self, word: Word) -> Result<(), No> {
        let now_us = self.clock.elapsed().as_micros() as u64;
        self.holder.step(now_us, AtBoard::Start { word, alone: false })
    }

    fn stopped(&self) -> Result<(), Failure> {
        if self.reins.giver().is_stopped() { Ok(()) } else { Err(UNCONFIRMED.into()) }
    }
}

/// A simulated board, kept in real time.
struct Practice {
    board: SharedSimulation,
    near: Near,
    m_per_count: f64,
    zero: Option<u16>,
    due: Instant,
}

impl Practice {
    fn new(truth: &Scene, near: Near) -> Result<Self, Failure> {
        let mut board = SharedSimulation::new(truth)?;
        let m_per_count = Joint::of(&settings(&mut board)?, 1)?.m_per_count;
        Ok(Self { board, near, m_per_count, zero: None, due: Instant::now() })
    }

    fn exchange(&mut self) -> Result<(), Failure> {
        if self.near.exchange(self.board.is_driven()) {
            Board::ask(&mut self.board, "disarm")?;
            self.near.exchange(self.board.is_driven());
        }
        Ok(())
    }
}

impl BoardLink for Practice {
    fn ask(&mut self, line: &str, run: Option<Word>) -> Result<String, Failure> {
        self.exchange()?;
        if let Some(Err(no)) = run.map(|run| self.near.start(run)) {
            return Ok(format!("error {}", no.explain()));
        }
        Ok(Board::ask(&mut self.board, line)?)
    }

    fn stop(&mut self) -> Result<(), Failure> {
        self.exchange()?;
        self.near.stopped()
    }

    fn rows(&mut self, seconds: f64) -> Result<Vec<[f64; NUMBERS]>, Failure> {
        self.exchange()?;
        self.due += Duration::from_secs_f64(seconds);
        std::thread::sleep(self.due.saturating_duration_since(Instant::now()));
        let ticks = self.board.ticks(seconds)?;
        Ok(ticks
            .iter()
            .map(|tick| {
                let zero = *self.zero.get_or_insert(tick.counts[0]);
                let mut numbers = [f64::NAN; NUMBERS];
                (numbers[TICK], numbers[MODE], numbers[FAULT_NUMBER]) = (tick.number.into(), tick.mode.into(), 0.0);
                numbers[DEVICE] = self.m_per_count * f64::from(tick.counts[0].wrapping_sub(zero).cast_signed());
                numbers
            })
            .collect())
    }
}

/// Talks to a board until it is over.
fn attend(link: &mut dyn BoardLink, mailbox: &Mutex<BoardMailbox>, over: &AtomicBool) {
    let lock = || mailbox.lock().unwrap_or_else(PoisonError::into_inner);
    let note = |line: &str, answer: Result<String, Failure>| {
        let mut mailbox = lock();
        let is_there = answer.is_ok();
        let answer = answer.unwrap_or_else(|why| why.to_string());
        if line == "status" || !is_there {
            // `ok board 1 disarmed …`: which it is stands above.
            let own = answer.strip_prefix("ok board ").and_then(|rest| rest.split_once(' '));
            mailbox.reported.status = own.map_or(answer.as_str(), |(_, own)| own).to_owned();
            mailbox.reported.there = is_there;
        }
        if line != "status" {
            mailbox.reported.say(line, answer.clone());
        }
        answer
    };
    let (mut asked, mut came, mut probing, mut tick_ms) = (None::<Instant>, Instant::now(), false, 1.0);
    while !over.load(Ordering::Relaxed) {
        let (stop, line) = {
            let mut mailbox = lock();
            let stop = std::mem::take(&mut mailbox.stop);
            (stop, if stop { None } else { mailbox.lines.pop_front() })
        };
        if stop {
            note("stop", link.stop().map(|()| STOPPED.to_owned()));
            asked = None;
        } else if let Some((line, run)) = line {
            let text = line.text();
            let answer = note(&text, link.ask(&text, run));
            asked = None;
            probing = matches!(line, Line::Check(_)) && answer.starts_with("ok");
        } else if asked.is_none_or(|asked| asked.elapsed() >= STATUS) {
            asked = Some(Instant::now());
            note("status", link.ask("status", None));
            if probing {
                let outcome = link.ask("probed", None).unwrap_or_else(|why| why.to_string());
                probing =
                    outcome.strip_prefix("ok ").is_some_and(|said| Probed::parse(said).is_ok_and(|it| it.is_running()));
                if !probing {
                    lock().reported.say("what the check found", outcome);
                }
            }
            // A board that was away, or has started anew, has forgotten what it was asked for.
            if came.elapsed() >= STATUS && lock().reported.there {
                let said = link.ask("get timing.control_period_s", None).unwrap_or_default();
                tick_ms = said.rsplit(' ').next().and_then(|text| text.parse().ok()).map_or(1.0, |s: f64| 1e3 * s);
                let _ = link.ask(&format!("stream {}", (f64::from(EVERY) / tick_ms).round()), None);
                came = Instant::now();
            }
        }
        match link.rows(LOOK_S) {
            Ok(rows) if rows.is_empty() => {}
            Ok(mut rows) => {
                came = Instant::now();
                rows.iter_mut().for_each(|row| row[TICK] *= tick_ms);
                wait_for(&mut lock().rows, rows);
            }
            Err(why) => {
                let mut mailbox = lock();
                (mailbox.reported.there, mailbox.reported.status) = (false, why.to_string());
            }
        }
    }
    // What is said from here on lets nothing run.
    let _ = link.ask("stream off", None);
}

impl Seat {
    /// Gets in touch with a board; one that does not answer is an error that names it. `index` is where a simulated one stands.
    fn open(place: Place, index: usize) -> Result<Self, Failure> {
        match place {
            Place::Simulated => {
                let (reins, clock) = (Reins::default(), Instant::now());
                let near = Near::new(reins.clone(), clock);
                let practice = move || Ok(Box::new(Practice::new(&Scene::default(), near)?) as Box<dyn BoardLink>);
                Self::attend(format!("simulated board {}", index + 1), index, (reins, clock), Box::new(practice))
            }
            Place::At(at, key_file) => {
                let operator = Operator::connect(at, &key_file)?;
                let (number, reins) = (operator.number, (operator.reins(), operator.start()));
                let board = move || Ok(Box::new(operator) as Box<dyn BoardLink>);
                Self::attend(format!("board {number} at {at}"), usize::from(number) - 1, reins, Box::new(board))
            }
        }
    }

    /// The seat of a board that is opened on its thread.
    fn attend(name: String, index: usize, (reins, clock): (Reins, Instant), open: Open) -> Result<Self, Failure> {
        reins.giver().silence_us = SILENCE_US;
        let reported = BoardStatus { name, status: SILENT.to_owned(), ..BoardStatus::default() };
        let (mailbox, over) =
            (Arc::new(Mutex::new(BoardMailbox { reported, ..BoardMailbox::default() })), Arc::default());
        let (theirs, stop) = (Arc::clone(&mailbox), Arc::clone(&over));
        let work = move || {
            stand_back(NICENESS);
            match open() {
                Ok(mut link) => attend(&mut *link, &theirs, &stop),
                Err(why) => theirs.lock().unwrap_or_else(PoisonError::into_inner).reported.status = why.to_string(),
            }
        };
        let thread = Some(std::thread::Builder::new().name("board".into()).spawn(work)?);
        Ok(Self {
            index,
            mailbox,
            reins,
            clock,
            over,
            thread,
            at: 0.0,
            shown: None,
            rows: VecDeque::new(),
            silent: true,
        })
    }

    /// The board's mailbox, which its thread holds for microseconds.
    fn mailbox(&self) -> MutexGuard<'_, BoardMailbox> {
        self.mailbox.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn now_us(&self) -> u64 {
        self.clock.elapsed().as_micros() as u64
    }

    /// A line of a page's: what starts motors begins a run now, or not at all.
    fn order(&self, line: Line) {
        let run = is_start(&line.text()).then(|| self.reins.start(self.now_us())).transpose();
        let mut mailbox = self.mailbox();
        match run {
            Err(no) => mailbox.reported.say(&line.text(), format!("error {}", no.explain())),
            Ok(run) if mailbox.lines.len() < ANSWERS => mailbox.lines.push_back((line, run)),
            Ok(_) => {}
        }
    }

    fn stop(&self) {
        self.reins.note(self.now_us(), AtOperator::Stop);
        // What waits is forgotten.
        let mut mailbox = self.mailbox();
        mailbox.stop = true;
        mailbox.reported.say("stop", STOPPING.to_owned());
        mailbox.lines.clear();
    }

    /// Takes what its thread has laid down, if that does not hold it just now; what is reported is new, if it is.
    fn look(&mut self, reported: &mut BoardStatus) -> bool {
        let silent = self.mode() == WAITS;
        let Ok(mut mailbox) = self.mailbox.try_lock() else { return false };
        wait_for(&mut self.rows, mailbox.rows.drain(..));
        let news = mailbox.reported != *reported || silent != self.silent;
        self.silent = silent;
        if news {
            reported.clone_from(&mailbox.reported);
        }
        news
    }

    /// Plays back the recorded rows by a millisecond.
    fn play(&mut self) {
        let Some(newest) = self.rows.back().map(|row| row[TICK]) else { return };
        self.at += 1.0;
        // It has begun, slept, or started anew.
        if (newest - BEHIND - self.at).abs() > FARTHEST {
            self.at = newest - BEHIND;
        }
        while self.rows.front().is_some_and(|row| row[TICK] <= self.at || row[TICK] > self.at + 2.0 * FARTHEST)
            && self.rows.len() > 1
        {
            self.shown = self.rows.pop_front();
        }
    }

    /// By the board's own word, and by nothing else. A row only says why motors are off.
    fn mode(&self) -> u8 {
        match (self.reins.giver().shown(self.now_us()), self.shown) {
            (None, _) => WAITS,
            (Some(Motors::Leased), _) => ARMED,
            (Some(Motors::Alone), _) => ALONE,
            (Some(Motors::Off), Some(row)) if row[MODE] == f64::from(FAULTED) => FAULT + row[FAULT_NUMBER] as u8,
            (Some(Motors::Off), _) => OFF,
        }
    }
}

impl Drop for Seat {
    fn drop(&mut self) {
        self.reins.note(self.now_us(), AtOperator::Leave);
        self.over.store(true, Ordering::Relaxed);
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

/// One or two boards.
pub(crate) struct Boards {
    seats: Vec<Seat>,
    reported: Vec<BoardStatus>,
    restarts: u32,
    news: bool,
}

impl Boards {
    /// Gets in touch with all of them.
    pub(crate) fn open(places: Vec<Place>) -> Result<Self, Failure> {
        let seats = places.into_iter().enumerate().map(|(index, place)| Seat::open(place, index));
        let seats = seats.collect::<Result<Vec<_>, _>>()?;
        if let [one, two] = seats.as_slice()
            && one.index == two.index
        {
            return Err(format!(
                "both boards say that they are board {}: one must be 1 and the other 2",
                one.index + 1
            )
            .into());
        }
        Ok(Self::of_seats(seats))
    }

    fn of_seats(seats: Vec<Seat>) -> Self {
        Self { reported: vec![BoardStatus::default(); seats.len()], seats, restarts: 1, news: true }
    }

    fn of(&self, index: usize) -> Option<(&Seat, &BoardStatus)> {
        self.seats.iter().zip(&self.reported).find(|(seat, _)| seat.index == index)
    }
}

impl Environment for Boards {
    fn command(&mut self, command: Command) -> Result<(), Failure> {
        match command {
            Command::Stop => self.seats.iter().for_each(Seat::stop),
            Command::Board(number, line) => {
                let seat = self.seats.iter().find(|seat| seat.index + 1 == usize::from(number));
                seat.into_iter().for_each(|seat| seat.order(line));
            }
            Command::Start | Command::Cut(_) | Command::Partner(_) => {}
        }
        Ok(())
    }

    fn set(&mut self, _: Scene) -> Result<(), Failure> {
        Ok(())
    }

    fn attend(&mut self) {
        self.seats.iter().for_each(|seat| seat.reins.note(seat.now_us(), AtOperator::Asked));
    }

    fn point(&mut self, _: usize, _: Option<[f64; 3]>, _: u32) {}

    fn step(&mut self) -> Result<Sample, Failure> {
        for (seat, reported) in self.seats.iter_mut().zip(&mut self.reported) {
            self.news |= seat.look(reported);
            seat.play();
        }
        let both = |column: usize| {
            [0, 1].map(|index| {
                let row = self.of(index).and_then(|(seat, _)| seat.shown);
                row.map_or(f32::NAN, |row| row[column] as f32)
            })
        };
        let (nothing, [device, object, decoded, contact, coordination]) = ([f32::NAN; 2], SHOWN.map(both));
        let in_line: f32 = both(SENT).into_iter().sum::<f32>() - both(RECEIVED).into_iter().sum::<f32>();
        let pairs = [nothing, device, object, decoded, contact, coordination, nothing, nothing];
        let mut rest = [f32::NAN; OF_BOTH];
        rest[0] = in_line;
        Ok(sample([pairs], rest, self.restarts))
    }

    fn standing(&self) -> Standing {
        // A place without a board is as a board that is off.
        let modes = [0, 1].map(|index| self.of(index).map_or(OFF, |(seat, _)| seat.mode()));
        Standing { modes, cut: false, partner: 0 }
    }

    fn news(&mut self) -> Option<String> {
        std::mem::take(&mut self.news).then(|| {
            let boards: Vec<_> = (self.seats.iter().zip(&self.reported))
                .map(|(seat, reported)| {
                    let mode = seat.mode();
                    let fault = mode.checked_sub(FAULT).and_then(Fault::from_number).map(Fault::explain);
                    let mut told = reported.clone();
                    if mode == WAITS && told.there {
                        (told.there, told.status) = (false, SILENT.to_owned());
                    }
                    json!({ "number": seat.index + 1, "told": told, "fault": fault })
                })
                .collect();
            json!({ "boards": boards }).to_string()
        })
    }
}

#[cfg(test)]
#[path = "../tests/inside/boards.rs"]
mod tests;
