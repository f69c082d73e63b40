//! Run is a lease. Whoever is on the path between a board and its operator, without the key, may drop, hold back, reorder and repeat what
//! both say, by direction, length, order and time: the motors are off within the lease after the operator's last yes, they are
//! never on without one, and an operator who says "stopped" is right.
//!
//! Virtual time, a millisecond a step. The operator's end is the one that command line and page have; the board's is its own link and
//! its own lease, as `firmware/src/port.rs` and `supervisor.rs` call them. The lease itself is explored in `protocol`.

use cohold_board_tools::operator::Session;
use cohold_core::safety::Mode;
use cohold_protocol::ends::Ends;
use cohold_protocol::key::Key;
use cohold_protocol::lease::{AtBoard, AtOperator, Motors, No, Told, Want, Word};
use cohold_protocol::lines::{self, Heard, Line, Lines, OPERATOR};
use cohold_protocol::link::{Link, Notice};
use cohold_protocol::wire::{MAX_DATAGRAM, PeerId};
use firmware_parts::hold::{self, Hold};
use firmware_parts::signals::Signals;

use super::on_path::{self, Fate, PASS, Path, Strategy};

/// `safety.operator_lost_s`, ms.
const LEASE_MS: u64 = 200;
/// How long a strategy has before the operator stops, and after.
const BEFORE_MS: u64 = 150;
const AFTER_MS: u64 = 700;
/// Strategies that are tried.
const STRATEGIES: usize = 100_000;

/// What may be wrong with a board, to see that the search finds it.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Planted {
    Nothing,
    /// Whatever is authentic keeps the motors on, as before version 3.
    AnythingHeard,
    /// A yes counts from when it comes.
    FromArrival,
    /// A stop that was heard is confirmed before motors are off, which they are at the end of the lease.
    HeardIsOff,
    /// `arm` does not look at the age of its yes.
    YesOfAnyAge,
}

struct Board {
    planted: Planted,
    link: Link,
    lines: Lines,
    signals: Signals,
    hold: Hold,
    taken: u32,
    /// The newest yes, for boards that believe in it.
    run: Option<(u8, Option<u64>)>,
}

impl Board {
    fn new(planted: Planted) -> Self {
        let ends = Ends { local: PeerId(1), remote: OPERATOR };
        let link = Link::new(lines::config(key(), ends, [9; 32])).expect("a link");
        let (signals, hold) = (Signals::at_power_on(), Hold::default());
        Self { planted, link, lines: Lines::default(), signals, hold, taken: 0, run: None }
    }

    fn is_on(&self) -> bool {
        self.signals.mode.get() == Mode::Armed
    }

    fn answer(&mut self, now_us: u64, Heard { line, word, .. }: &Heard) -> &'static str {
        let Self { signals, hold, .. } = self;
        if line != "arm" {
            hold.off(now_us, signals);
            return "ok disarmed";
        }
        if self.planted == Planted::YesOfAnyAge {
            hold.hear(now_us, (word.byte(), Some(now_us)), signals);
        }
        let lost_s = LEASE_MS as f64 / 1e3;
        let started = hold.start(now_us, (*word, false), lost_s, signals, || signals.mode.set(Mode::Armed));
        hold.started();
        started.map_or_else(No::explain, |()| "ok armed")
    }

    /// The port, every other millisecond: what came, the operator's word, a line, and what there is to say.
    fn port(&mut self, now_us: u64, came: &mut Vec<Vec<u8>>, mut out: impl FnMut(&[u8])) {
        for mut datagram in came.drain(..) {
            let _ = self.link.receive(now_us, &mut datagram);
        }
        while let Some(notice) = self.link.take_notice() {
            if let Notice::NewPeer(_) = notice {
                self.hold.step(now_us, AtBoard::Session);
                self.lines.forget();
            }
        }
        let heard = std::mem::replace(&mut self.taken, self.link.counts().taken) != self.taken;
        let said = self.link.heard();
        let (is_run, on) = (|byte: u8| Word::of_byte(byte).want == Want::Run, self.is_on());
        let said = match self.planted {
            Planted::Nothing | Planted::YesOfAnyAge => said,
            Planted::AnythingHeard if heard && on => self.run,
            Planted::AnythingHeard | Planted::FromArrival => said.filter(|_| heard),
            Planted::HeardIsOff => said.filter(|(byte, _)| is_run(*byte) || !on),
        };
        self.run = said.filter(|(byte, _)| is_run(*byte)).or(self.run);
        let arrives = matches!(self.planted, Planted::AnythingHeard | Planted::FromArrival);
        if let Some((byte, echo_us)) = said {
            let echo_us = if arrives { Some(now_us) } else { echo_us };
            self.hold.hear(now_us, (byte, echo_us), &self.signals);
        }
        if !self.lines.is_saying()
            && let Some(heard) = self.lines.hear(now_us, &mut self.link)
            && heard.is_fresh()
        {
            let answer = Line::try_from(self.answer(now_us, &heard)).expect("a short line");
            self.lines.say(&answer, Word::default());
        }
        let mut told = self.hold.told(&self.signals);
        if let (Planted::HeardIsOff, Some((byte, _))) = (self.planted, self.link.heard()) {
            told = Told { motors: Motors::Off, heard: Word::of_byte(byte).number };
        }
        self.link.say_lease(told.byte(), false);
        self.lines.push(&mut self.link);
        let mut bytes = [0; MAX_DATAGRAM];
        while let Some(length) = self.link.poll(now_us, &mut bytes) {
            out(&bytes[..length]);
        }
    }

    /// A tick, and every fifth the supervisor.
    fn tick(&mut self, now_us: u64) {
        let signals = &self.signals;
        signals.ticks.set(signals.ticks.get().wrapping_add(1));
        if signals.disarm.acquire() {
            signals.disarm.release(false);
            signals.mode.set(Mode::Disarmed);
        }
        if signals.ticks.get().is_multiple_of(hold::LOOK_EVERY) {
            self.hold.look(now_us, signals);
        }
    }
}

fn key() -> Key {
    Key::new([7; Key::LEN])
}

/// Fates before the stop, in the first 100 ms after, and later; to the board and to the operator.
type Lease = Strategy<3, 2>;

/// A board, its operator and what lies between them.
struct World {
    board: Board,
    operator: Session,
    path: Path<2>,
    now_ms: u64,
    /// When the operator let the motors run last.
    yes_ms: u64,
    was_on: bool,
    stopped: bool,
}

impl World {
    fn new(planted: Planted) -> Self {
        Self {
            board: Board::new(planted),
            operator: Session::new(key(), 1, [8; 32]).expect("a session"),
            path: Path::default(),
            now_ms: 1000,
            yes_ms: 0,
            was_on: false,
            stopped: false,
        }
    }

    /// A millisecond, datagrams meeting the fate that this says by direction (0: to the board) and length; what was broken, if anything.
    fn step(&mut self, fate: impl Fn(usize, usize) -> Fate + Copy) -> Result<(), String> {
        self.now_ms += 1;
        let now = self.now_ms;
        let [to_board, mut to_operator] = [0, 1].map(|direction| self.path.come(now, direction));
        let mut said = Vec::new();
        let board_us = 7_000_000 + 1000 * now;
        self.board.tick(board_us);
        if now.is_multiple_of(2) || !to_board.is_empty() {
            let mut came = to_board;
            self.board.port(board_us, &mut came, |datagram| said.push((1, datagram.to_vec())));
        }
        for datagram in &mut to_operator {
            self.operator.receive(1000 * now, datagram);
        }
        if now.is_multiple_of(2) {
            let mut out = [0; MAX_DATAGRAM];
            while let Some(length) = self.operator.poll(1000 * now, &mut out) {
                said.push((0, out[..length].to_vec()));
            }
        }
        for (direction, datagram) in said {
            self.path.say(now, direction, &datagram, fate);
        }
        let mut giver = self.operator.reins().giver();
        if giver.word(1000 * now).want == Want::Run {
            self.yes_ms = now;
        }
        self.stopped = giver.is_stopped();
        let on = self.board.is_on();
        self.was_on |= on;
        match self.stopped {
            _ if on && now > self.yes_ms + LEASE_MS => Err(format!("on {} ms after the last yes", now - self.yes_ms)),
            true if on => Err("on, and the operator says that it is stopped".to_owned()),
            _ => Ok(()),
        }
    }

    /// The person asks for motors as soon as that may be, while nobody disturbs.
    fn arm(&mut self) {
        for _ in 0..1_000 {
            if self.operator.say("arm") {
                return;
            }
            self.step(|_, _| PASS).expect("nobody disturbs");
        }
        panic!("it is known to be off");
    }

    fn stop(&self) {
        self.operator.reins().note(1000 * self.now_ms, AtOperator::Stop);
    }

    /// Nobody is on the path, until both are there and nothing is left of what was.
    fn meet(&mut self) {
        self.path.clear();
        self.was_on = false;
        for _ in 0..5_000 {
            self.step(|_, _| PASS).expect("nobody disturbs");
            while self.operator.answer().is_some() {}
            if self.operator.is_there() && self.board.link.is_up() && self.operator.say("disarm") {
                for _ in 0..30 {
                    self.step(|_, _| PASS).expect("nobody disturbs");
                }
                if self.operator.answer().is_some() && !self.board.is_on() && self.stopped {
                    return;
                }
            }
        }
        panic!("they do not meet");
    }

    /// Arms, then stops, under a strategy; how long the motors were on after the stop, ms.
    fn play(&mut self, strategy: &Lease) -> Result<u64, String> {
        self.meet();
        self.was_on = false;
        self.arm();
        let Strategy([before, soon, later]) = strategy;
        for _ in 0..BEFORE_MS {
            self.step(|direction, place| before[direction][place])?;
        }
        self.stop();
        let mut on = 0;
        for ms in 0..AFTER_MS {
            let phase = if ms < 100 { soon } else { later };
            self.step(|direction, place| phase[direction][place])?;
            on = if self.board.is_on() { ms } else { on };
        }
        Ok(on)
    }
}

/// What breaks a promise, or for how long motors were on at the most after the stop, ms.
fn search(planted: Planted, strategies: usize) -> Result<u64, (usize, String)> {
    let mut world = World::new(planted);
    let mut armed = 0;
    let longest = on_path::search(29, strategies, |strategy: &Lease| {
        let on = world.play(strategy)?;
        armed += usize::from(world.was_on);
        Ok([on])
    });
    let [longest] = longest?;
    assert!(armed > strategies / 4, "only {armed} of {strategies} strategies let it be armed at all");
    Ok(longest)
}

#[test]
fn nobody_on_the_path_keeps_motors_on_after_stop() {
    let longest = search(Planted::Nothing, STRATEGIES).unwrap_or_else(|(tried, why)| panic!("strategy {tried}: {why}"));
    // It does find that datagrams can be dropped.
    assert!((LEASE_MS - 60..=LEASE_MS).contains(&longest), "{longest} ms");
}

#[test]
fn the_search_finds_what_is_planted() {
    for planted in [Planted::AnythingHeard, Planted::FromArrival, Planted::HeardIsOff] {
        let found = search(planted, 2_000);
        assert!(found.is_err(), "{planted:?}: {found:?}");
    }
}

/// A person says `arm` and stops `before` ms later; what was said until then is held for more than the lease, what comes after is dropped.
fn a_held_yes(planted: Planted) -> Result<(), String> {
    for before in [2, 4, 6, 10] {
        for held in (201..240).step_by(3) {
            for idle in (0..60).step_by(4) {
                let mut world = World::new(planted);
                world.meet();
                for _ in 0..idle {
                    world.step(|_, _| PASS)?;
                }
                world.arm();
                for ms in 0..600 {
                    if ms == before {
                        world.stop();
                    }
                    world.step(|direction, _| match direction {
                        0 if ms < before => Fate([Some(held), None]),
                        0 => Fate([None, None]),
                        _ => PASS,
                    })?;
                }
            }
        }
    }
    Ok(())
}

/// Why: `arm` did not look at the age of its yes, so that motors went on after the lease.
#[test]
fn a_yes_that_is_older_than_the_lease_arms_nothing() {
    assert_eq!(a_held_yes(Planted::Nothing), Ok(()));
    assert!(a_held_yes(Planted::YesOfAnyAge).is_err_and(|why| why.starts_with("on ")));
}

/// The attack as it was: only what is as long as a probe or a reply goes through after Stop. Nothing tells them apart now.
#[test]
fn what_the_operator_says_has_one_length() {
    let mut world = World::new(Planted::Nothing);
    world.meet();
    let mut lengths = Vec::new();
    world.arm();
    for ms in 0..400 {
        if ms == 200 {
            assert!(world.board.is_on());
            assert!(world.operator.say("disarm"));
        }
        world.step(|_, _| PASS).expect("nobody disturbs");
        lengths.extend(world.path.under_way[0].iter().map(|(_, datagram)| datagram.len()));
    }
    lengths.sort_unstable();
    lengths.dedup();
    assert_eq!(lengths, [16 + 16 + 56 + 16]);
    assert!(world.stopped);
}
