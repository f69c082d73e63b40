//! Run is a lease. Whoever is on the path between a board and its operator, without the key, may drop, hold back, reorder and repeat what
//! both say, by direction, length, order and time: the motors are off within the lease after the operator's last yes, they are
//! never on without one, and an operator who says "stopped" is right.
//!
//! Virtual time, a millisecond a step. The operator's end is the one that command line and page have; the board's is its own link, its
//! own supervisor's look and its own note of the operator's word, as `firmware/src/port.rs` calls them.

use firmware_parts::hold;
use firmware_parts::operator::is_timeless;
use firmware_parts::signals::Signals;
use haptic_board_tools::consent::Stopped;
use haptic_board_tools::operator::Session;
use haptic_core::safety::Mode;
use haptic_protocol::ends::Ends;
use haptic_protocol::key::Key;
use haptic_protocol::lines::{Line, Lines};
use haptic_protocol::link::{Config, Link, Notice};
use haptic_protocol::parameters::{Parameters, Table};
use haptic_protocol::wire::{MAX_DATAGRAM, PeerId};

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
    /// A yes is not taken back by a no.
    NoIsNothing,
}

struct Board {
    planted: Planted,
    link: Link,
    lines: Lines,
    signals: Signals,
    taken: u32,
}

impl Board {
    fn new(planted: Planted) -> Self {
        let mut parameters = Parameters::new();
        parameters.add(Table::new("operator").number("version", 1.0)).expect("room for one");
        let ends = Ends { local: PeerId(1), remote: PeerId(0) };
        let config = Config { key: key(), ends, packet_period_us: 20_000, parameters, entropy: [9; 32] };
        let link = Link::new(config).expect("a link");
        Self { planted, link, lines: Lines::default(), signals: Signals::at_power_on(), taken: 0 }
    }

    fn is_on(&self) -> bool {
        self.signals.mode.get() == Mode::Armed
    }

    fn answer(&self, line: &str) -> &'static str {
        match line {
            "arm" if !self.signals.consent.get() => "error the operator's end does not let the motors run",
            "arm" => {
                self.signals.patience.set(hold::patience(LEASE_MS as u32));
                self.signals.mode.set(Mode::Armed);
                "ok armed"
            }
            _ => {
                self.signals.disarm.release(true);
                "ok disarmed"
            }
        }
    }

    /// The port, every other millisecond: what came, the operator's word, a line, and what there is to say.
    fn port(&mut self, now_us: u64, came: &mut Vec<Vec<u8>>, mut out: impl FnMut(&[u8])) {
        for mut datagram in came.drain(..) {
            let _ = self.link.receive(now_us, &mut datagram);
        }
        while let Some(notice) = self.link.take_notice() {
            if let Notice::NewPeer(_) = notice {
                self.lines.forget();
            }
        }
        let heard = std::mem::replace(&mut self.taken, self.link.counts().taken) != self.taken;
        let said = self.link.consented_us();
        let notes = match self.planted {
            Planted::Nothing => Some(said),
            Planted::AnythingHeard => heard.then_some(Some(now_us)),
            Planted::FromArrival => heard.then(|| said.map(|_| now_us)),
            Planted::NoIsNothing => said.map(Some),
        };
        if let Some(word) = notes.filter(|_| self.link.is_up()) {
            hold::note(&self.signals, now_us, word);
            hold::let_go(&self.signals);
        }
        if !self.lines.is_saying()
            && let Some(heard) = self.lines.hear(now_us, &mut self.link)
            && (heard.is_fresh() || is_timeless(&heard.line))
        {
            let answer = Line::try_from(self.answer(&heard.line)).expect("a short line");
            self.lines.say(&answer);
        }
        self.lines.push(&mut self.link);
        let mut bytes = [0; MAX_DATAGRAM];
        while let Some(length) = self.link.poll(now_us, &mut bytes) {
            out(&bytes[..length]);
        }
    }

    /// A tick, and every fifth the supervisor.
    fn tick(&mut self) {
        let signals = &self.signals;
        signals.ticks.set(signals.ticks.get().wrapping_add(1));
        if signals.disarm.acquire() {
            signals.disarm.release(false);
            signals.mode.set(Mode::Disarmed);
        }
        if signals.ticks.get().is_multiple_of(hold::LOOK_EVERY) {
            hold::let_go(signals);
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
    stopped: Option<Stopped>,
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
            stopped: None,
        }
    }

    /// A millisecond, datagrams meeting the fate that this says by direction (0: to the board) and length; what was broken, if anything.
    fn step(&mut self, fate: impl Fn(usize, usize) -> Fate + Copy) -> Result<(), String> {
        self.now_ms += 1;
        let now = self.now_ms;
        let [to_board, mut to_operator] = [0, 1].map(|direction| self.path.come(now, direction));
        let mut said = Vec::new();
        self.board.tick();
        if now.is_multiple_of(2) || !to_board.is_empty() {
            let mut came = to_board;
            self.board.port(7_000_000 + 1000 * now, &mut came, |datagram| said.push((1, datagram.to_vec())));
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
        if self.operator.consent().is_given() {
            self.yes_ms = now;
        }
        let on = self.board.is_on();
        self.was_on |= on;
        self.stopped = self.operator.stopped(1000 * now, 1000 * LEASE_MS);
        match self.stopped {
            _ if on && now > self.yes_ms + LEASE_MS => Err(format!("on {} ms after the last yes", now - self.yes_ms)),
            Some(stopped) if on => Err(format!("on, and the operator says: {}", stopped.explain())),
            _ => Ok(()),
        }
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
                if self.operator.answer().is_some() && !self.board.is_on() {
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
        self.operator.say("arm");
        let Strategy([before, soon, later]) = strategy;
        for _ in 0..BEFORE_MS {
            self.step(|direction, place| before[direction][place])?;
        }
        self.operator.consent().withdraw();
        let (mut on, mut stopped) = (0, false);
        for ms in 0..AFTER_MS {
            let phase = if ms < 100 { soon } else { later };
            self.step(|direction, place| phase[direction][place])?;
            on = if self.board.is_on() { ms } else { on };
            stopped |= self.stopped.is_some();
        }
        if stopped { Ok(on) } else { Err("an operator waits for ever to hear that it stopped".to_owned()) }
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
    for planted in [Planted::AnythingHeard, Planted::FromArrival, Planted::NoIsNothing] {
        let found = search(planted, 2_000);
        assert!(found.is_err(), "{planted:?}: {found:?}");
    }
}

/// The attack as it was: only what is as long as a probe or a reply goes through after Stop. Nothing tells them apart now.
#[test]
fn what_the_operator_says_has_one_length() {
    let mut world = World::new(Planted::Nothing);
    world.meet();
    let mut lengths = Vec::new();
    world.operator.say("arm");
    for ms in 0..400 {
        if ms == 200 {
            assert!(world.board.is_on());
            world.operator.say("disarm");
        }
        world.step(|_, _| PASS).expect("nobody disturbs");
        lengths.extend(world.path.under_way[0].iter().map(|(_, datagram)| datagram.len()));
    }
    lengths.sort_unstable();
    lengths.dedup();
    assert_eq!(lengths, [16 + 16 + 56 + 16]);
    assert_eq!(world.stopped, Some(Stopped::Heard));
}
