//! A board that holds a valid session and says what it likes to the PC that operates it: random programs, and alterations of those that
//! kept a stop waiting longest or were answered most. Virtual time, a millisecond a step; the board is the second implementation of the
//! protocol, so that it may echo times that it never heard.
//!
//! At the operator's end: no panic; what waits to be taken is within its bounds; texts are without orders to a terminal and rows finite;
//! "stopped" is said only if the board has said that its motors are off, with the number of this very stop; no yes is sent after a stop
//! until the person asks again; and however much comes, little is said.
//!
//! `HOSTILE_PROGRAMS` says how many programs (2,000 by default), `HOSTILE_SEED` with which they begin.

mod board;

use cohold_board_tools::operator::{MOST_ANSWERS, MOST_SAMPLES, Session};
use cohold_board_tools::recording::{COLUMNS, row, row_of};
use cohold_board_tools::status::{Probed, Status};
use cohold_core::sample::SAMPLE;
use cohold_protocol::key::Key;
use cohold_protocol::lease::{AtOperator, Motors, Told};
use cohold_protocol::lines::LONGEST;
use cohold_protocol::record::Record;
use cohold_protocol::wire::{MAX_DATAGRAM, Sample};
use cohold_sim::rng::Rng;

use board::{Board, KEY, Program, Said};

/// How long a program goes on after the stop.
const AFTER_MS: u64 = 220;
/// Between two polls of an operator, as its endpoint has them.
const LOOK_MS: u64 = 2;
/// Most datagrams of an operator in a step: a window of events, a reply, an acknowledgement, a probe and greetings.
const MOST_SAID: usize = 16;

/// What may be wrong with an operator's end, to see that the search finds it.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Planted {
    Nothing,
    /// Anything authentic that comes after a stop is taken for the board's word on it.
    AnythingHeard,
    /// A board that says that it is armed is taken for one that may be.
    ArmedIsAYes,
    /// Numbers of records are shown as they come.
    AsTheyCome,
}

/// A person at an operator's end, and a board.
struct World {
    planted: Planted,
    session: Session,
    board: Board,
    rng: Rng,
    now_ms: u64,
    /// When the person stopped, ms; none while the motors may run.
    stop_ms: Option<u64>,
    /// The board has said that its motors are off, with the number of this stop.
    word: bool,
    /// Datagrams taken when the person stopped.
    taken: u32,
    coming: Vec<Said>,
    /// Yeses, answers, rows and confirmed stops that there were.
    seen: [u64; 4],
}

impl World {
    fn new(planted: Planted, seed: u64) -> Self {
        Self {
            planted,
            session: Session::new(Key::new(KEY), 1, [8; 32]).expect("a session"),
            board: Board::default(),
            rng: Rng::new(seed),
            now_ms: 1000,
            stop_ms: None,
            word: false,
            taken: 0,
            coming: Vec::new(),
            seen: [0; 4],
        }
    }

    fn now_us(&self) -> u64 {
        1000 * self.now_ms
    }

    fn stop(&mut self) {
        if self.rng.chance(0.5) || !self.session.say("disarm") {
            self.session.reins().note(self.now_us(), AtOperator::Stop);
        }
        (self.stop_ms, self.word) = (Some(self.now_ms), self.session.reins().giver().is_stopped());
        self.taken = self.session.link().counts().taken;
    }

    fn hear(&mut self) {
        for mut said in std::mem::take(&mut self.coming) {
            let now_us = self.now_us();
            let heard = self.session.reins().giver().word(now_us).number;
            let taken = self.session.link().counts().taken;
            self.session.receive(now_us, &mut said.datagram);
            let is_taken = self.session.link().counts().taken != taken;
            self.word |= is_taken && said.told == Some(Told { motors: Motors::Off, heard });
        }
    }

    /// A millisecond; how many datagrams the operator said in it.
    fn step(&mut self, program: &Program, stops: bool) -> Result<usize, String> {
        self.now_ms += 1;
        let first = self.rng.chance(0.5);
        if stops && first {
            self.stop();
        }
        let came = !self.coming.is_empty();
        self.hear();
        if stops && !first {
            self.stop();
        }
        let (mut said, mut out) = (Vec::new(), [0; MAX_DATAGRAM]);
        if came || self.now_ms.is_multiple_of(LOOK_MS) {
            while let Some(length) = self.session.poll(self.now_us(), &mut out) {
                said.push(out[..length].to_vec());
                if said.len() > MOST_SAID {
                    return Err(format!("{} datagrams said in a step", said.len()));
                }
            }
        }
        let yeses = self.board.hear(&mut self.rng, &said);
        self.seen[0] += yeses;
        if yeses > 0 && self.stop_ms.is_some() {
            return Err("a yes after the stop".to_owned());
        }
        let now_us = self.now_us();
        self.coming = self.board.speak(&mut self.rng, now_us, program);
        self.stopped()?;
        Ok(said.len())
    }

    /// What the operator says of the motors is what it may.
    fn stopped(&mut self) -> Result<(), String> {
        let mut stopped = self.session.reins().giver().is_stopped();
        if self.planted == Planted::AnythingHeard && self.session.link().counts().taken != self.taken {
            stopped = self.stop_ms.is_some();
        }
        let Some(stop_ms) = self.stop_ms else { return Ok(()) };
        self.seen[3] += u64::from(stopped);
        if stopped && !self.word {
            return Err(format!("stopped, {} ms after the stop, without a word on it", self.now_ms - stop_ms));
        }
        Ok(())
    }

    /// What has come is taken, and is as it may be.
    fn take(&mut self) -> Result<(), String> {
        let answers: Vec<String> = std::iter::from_fn(|| self.session.answer()).collect();
        let samples = self.session.take_samples();
        let log: Vec<_> = std::iter::from_fn(|| self.session.logged()).collect();
        if answers.len() > MOST_ANSWERS || samples.len() > MOST_SAMPLES || log.len() > MOST_ANSWERS {
            let [answers, samples, log] = [answers.len(), samples.len(), log.len()];
            return Err(format!("{answers} answers, {samples} samples and {log} lines of the log wait"));
        }
        if let Some((at_us, _)) = log.iter().find(|(at_us, _)| *at_us > self.now_us()) {
            return Err(format!("a line of the log is of {at_us} µs, which will be"));
        }
        for answer in answers.iter().chain(log.iter().map(|(_, words)| words)) {
            // Of a character that is an order, the six that spell it out.
            let order = |character: char| character.is_control() && character != '\t';
            if answer.contains(order) || answer.chars().count() > 6 * LONGEST {
                return Err(format!("an answer is shown as {answer:?}"));
            }
            let _ = (Status::parse(answer), Probed::parse(answer));
            if self.planted == Planted::ArmedIsAYes && answer.starts_with("ok armed") {
                self.session.say("arm");
            }
        }
        self.seen[1] += answers.len() as u64;
        let shown: Vec<_> = samples.iter().filter_map(|sample| self.shown(sample)).collect();
        self.seen[2] += shown.len() as u64;
        for numbers in shown {
            if let Some(at) = numbers.iter().position(|number| !number.is_finite()) {
                return Err(format!("{} is shown as {}", COLUMNS[at].0, numbers[at]));
            }
        }
        Ok(())
    }

    fn shown(&self, sample: &Sample) -> Option<[f64; COLUMNS.len()]> {
        match self.planted {
            Planted::AsTheyCome => Record::from_bytes(sample.payload()).map(|record| row_of(&SAMPLE, &record, 1e-3)),
            _ => row(sample.payload(), 1e-3).map(|(_, row)| row),
        }
    }

    /// Arms, stops, and waits: how long it was not known that the motors are off, ms, and most datagrams said in a step.
    fn play(&mut self, program: &Program) -> Result<[u64; 2], String> {
        self.session.unsay();
        self.stop_ms = None;
        // The person asks, which is refused while nothing says that motors are off.
        self.session.say("arm");
        let ordered = self.session.reins().giver().word(self.now_us());
        let (stops_at, takes) = (1 + self.rng.below(100), self.rng.chance(0.7));
        let mut most = [0; 2];
        for ms in 0..stops_at + AFTER_MS {
            let said = self.step(program, ms == stops_at)?;
            most[1] = most[1].max(said as u64);
            if self.stop_ms.is_some() {
                most[0] += u64::from(!self.session.reins().giver().is_stopped());
                // An order from before the stop, which is carried out only now.
                if self.rng.chance(0.01) {
                    self.session.say_under("arm", ordered);
                }
            }
            if takes {
                self.take()?;
            }
        }
        self.take()?;
        Ok(most)
    }
}

/// Plays so many programs: what there was, or the number of the one that broke a promise, and how.
fn search(planted: Planted, seed: u64, programs: u64) -> Result<[u64; 4], String> {
    let (mut world, mut rng) = (World::new(planted, seed), Rng::new(seed ^ 0x5eed));
    let (mut best, mut most): ([Option<Program>; 2], [u64; 2]) = Default::default();
    for number in 1..=programs {
        let from = best[rng.below(2) as usize].as_ref().filter(|_| rng.chance(0.25));
        let program = match from {
            Some(program) => program.altered(&mut rng),
            None => Program::new(&mut rng),
        };
        let scores = world.play(&program).map_err(|why| format!("program {number}: {why}: {program:?}"))?;
        for ((score, most), best) in scores.into_iter().zip(&mut most).zip(&mut best) {
            if score > *most {
                (*most, *best) = (score, Some(program.clone()));
            }
        }
    }
    println!("{programs} programs: yeses, answers, rows, stopped {:?}; {most:?}", world.seen);
    Ok(world.seen)
}

/// A number from the environment, or this one.
fn asked(name: &str, otherwise: u64) -> u64 {
    std::env::var(name).map_or(otherwise, |text| text.parse().unwrap_or_else(|_| panic!("{name}={text} is no number")))
}

#[test]
fn whatever_a_board_says_its_operator_holds() {
    let programs = asked("HOSTILE_PROGRAMS", 2000);
    let seen = search(Planted::Nothing, asked("HOSTILE_SEED", 1), programs).unwrap_or_else(|why| panic!("{why}"));
    // All of it was tried.
    assert!(seen.iter().all(|times| *times > programs), "{seen:?}");
}

#[test]
fn what_is_planted_in_an_operator_is_found() {
    for (planted, how) in [
        (Planted::AnythingHeard, "without a word on it"),
        (Planted::ArmedIsAYes, "a yes after the stop"),
        (Planted::AsTheyCome, " is shown as "),
    ] {
        let found = search(planted, 1, 2000);
        assert!(found.as_ref().is_err_and(|why| why.contains(how)), "{planted:?}: {found:?}");
    }
}

/// A board that answers what was never asked, and tells of more ticks than there are, while nobody takes any of it.
#[test]
fn what_nobody_takes_has_a_bound() {
    let mut world = World::new(Planted::Nothing, 1);
    let flood = Program::flood();
    while world.session.link().counts().taken < 3 * MOST_SAMPLES as u32 + 10_000 {
        world.step(&flood, false).expect("all is well");
        assert!(world.now_ms < 10_000, "it is not flooded");
    }
    let answers = std::iter::from_fn(|| world.session.answer()).count();
    let log = std::iter::from_fn(|| world.session.logged()).count();
    assert_eq!((answers, log, world.session.take_samples().len()), (MOST_ANSWERS, MOST_ANSWERS, MOST_SAMPLES));
}
