//! The operator's end of a board's command port: one line of text there, one answer back, and what the board's ticks saw.
//!
//! A sealed link of its own beside the flow between the peers: the operator has number 0, the board its own (1 or 2), the key
//! is the operator's, which no peer but this board holds. Lines and answers are reliable events, records are samples
//! (cohold-protocol). What a line may say is in firmware/src/operator.rs; the last operator to come is the one the board
//! listens to.
//!
//! **Run is a lease** ([`cohold_protocol::lease`]): every datagram, all of one length, says whether the motors may run, and the board's say
//! whether they do. A line that turns them on starts a run before it is said, `disarm` is a stop before it is said. Other threads that
//! start and stop share the session's [`Reins`].
//!
//! [`Session`] is sans-IO: whoever has a socket and a clock drives it, tests in virtual time. What a board says takes no more memory than
//! [`MOST_ANSWERS`] and [`MOST_SAMPLES`], whether somebody takes it or not.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use cohold_protocol::lease::{AtOperator, Giver, No, Told, Word};
use cohold_protocol::lines::{self, Lines, OPERATOR};
use cohold_protocol::link::{Link, Notice, Stage};
use cohold_protocol::wire::{Datagram, Event, Message, PeerId, Sample};
use cohold_protocol::{ends::Ends, key::Key};

pub use cohold_protocol::lines::PORT;

use crate::Error;

/// Most answers, and most lines of the log, that wait to be taken: of more, the oldest are gone.
pub const MOST_ANSWERS: usize = 64;
/// Most samples that wait to be taken, 5 s of three axes at 1 kHz: what comes beyond them is lost.
pub const MOST_SAMPLES: usize = 1 << 14;
/// How long the board's newest word may be under way when something is to be started, µs.
const SETTLES_US: u64 = 500_000;

/// What a person is told of a stop that the board has confirmed.
pub const STOPPED: &str = "stopped: the board says that its motors are off";
/// What a person is told of a stop that is on its way.
pub const STOPPING: &str = "stop sent: the board has not confirmed it yet";
/// What a person is told of a stop that the board has not confirmed.
pub const UNCONFIRMED: &str = "stop not confirmed: press the stop at the board. Motors that this program let run go off by themselves. Motors \
                               that run alone or for another operator may be on";

/// Whether a line to a board turns motors on.
pub fn is_start(line: &str) -> bool {
    matches!(line.split_whitespace().next(), Some("arm" | "check" | "probe"))
}

/// When a line of the board's log was said, µs of its clock, and its words; none if the line is an answer.
fn logged(line: &str) -> Option<(u64, &str)> {
    let (at_us, words) = line.strip_prefix("log ")?.split_once(' ')?;
    Some((at_us.parse().ok()?, words))
}

/// Puts one more behind those that wait, of which the oldest goes if they are too many.
fn push<T>(waiting: &mut VecDeque<T>, one: T) {
    waiting.drain(..waiting.len().saturating_sub(MOST_ANSWERS - 1));
    waiting.push_back(one);
}

/// An operator's side of the lease, in the hands of all who start and all who stop.
#[derive(Clone, Debug, Default)]
pub struct Reins(Arc<Mutex<Giver>>);

impl Reins {
    /// The giver, which nobody holds for longer than a step takes.
    pub fn giver(&self) -> MutexGuard<'_, Giver> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Begins a run: the word that its line is to be said under.
    ///
    /// # Errors
    /// Why it is refused here.
    pub fn start(&self, now_us: u64) -> Result<Word, No> {
        let mut giver = self.giver();
        giver.step(now_us, AtOperator::Start)?;
        Ok(giver.word(now_us))
    }

    /// Takes in what refuses nothing: any event but a start.
    pub fn note(&self, now_us: u64, event: AtOperator) {
        let _ = self.giver().step(now_us, event);
    }
}

/// One operator and one board, whoever brings the time and the datagrams.
#[derive(Debug)]
pub struct Session {
    link: Link,
    lines: Lines,
    answers: VecDeque<String>,
    logged: VecDeque<(u64, String)>,
    samples: Vec<(u64, Sample)>,
    reins: Reins,
    /// A start that waits for the board's word that its motors are off, the word that it was said after, and until when, µs.
    waits: Option<(String, Word, u64)>,
    /// The newest time that it was called at, µs.
    now_us: u64,
}

impl Session {
    /// Calls board `number` (1 or 2). `entropy` must never be the same twice.
    ///
    /// # Errors
    /// The link cannot be made, such as of two ends with one number.
    pub fn new(key: Key, number: u8, entropy: [u8; Key::LEN]) -> Result<Self, Error> {
        let ends = Ends { local: OPERATOR, remote: PeerId(number) };
        let link = Link::new(lines::config(key, ends, entropy))?;
        Ok(Self {
            link: link.of_one_length(Event::MAX_LEN),
            lines: Lines::default(),
            answers: VecDeque::new(),
            logged: VecDeque::new(),
            samples: Vec::new(),
            reins: Reins::default(),
            waits: None,
            now_us: 0,
        })
    }

    /// Takes a datagram, which is opened in place; one that is not the board's is not taken.
    pub fn receive(&mut self, now_us: u64, datagram: &mut [u8]) {
        self.now_us = now_us;
        let (before, taken) = (self.link.heard(), self.link.receive(now_us, datagram));
        while let Some(notice) = self.link.take_notice() {
            if matches!(notice, Notice::NewPeer(_)) {
                self.reins.note(now_us, AtOperator::Session);
                if !self.lines.is_saying() {
                    self.lines.forget();
                }
            }
        }
        // What the board said before this, and before a stop, says nothing of that stop.
        if let Some((told, echo_us)) = self.link.heard().filter(|heard| Some(*heard) != before) {
            self.reins.note(now_us, AtOperator::Heard { told: Told::of_byte(told), echo_us });
        }
        if let Ok(Some(Message::Sample(sample))) = taken
            && self.samples.len() < MOST_SAMPLES
        {
            self.samples.push((self.link.sealed_us(), sample));
        }
        while let Some(heard) = self.lines.hear(now_us, &mut self.link) {
            let line = cohold_io::escaped(heard.line.as_str());
            match logged(&line) {
                None => push(&mut self.answers, line.into_owned()),
                Some((at_us, words)) => {
                    // What was said before this end's clock began has no time on it.
                    let at_us = now_us.checked_sub(self.link.sealed_us().saturating_sub(at_us));
                    at_us.into_iter().for_each(|at_us| push(&mut self.logged, (at_us, words.to_owned())));
                }
            }
        }
    }

    /// The next datagram to send, if any; call until there is none, at least every 20 ms.
    pub fn poll(&mut self, now_us: u64, out: &mut Datagram) -> Option<usize> {
        self.now_us = now_us;
        self.begin();
        let mut giver = self.reins.giver();
        self.link.say_lease(giver.word(now_us).byte(), giver.is_eager());
        drop(giver);
        self.lines.push(&mut self.link);
        self.link.poll(now_us, out)
    }

    /// The operator's side of the lease.
    pub fn reins(&self) -> &Reins {
        &self.reins
    }

    /// Tells the board that nobody listens any more, as [`Link::goodbye`].
    pub fn goodbye(&mut self, now_us: u64, out: &mut Datagram) -> Option<usize> {
        self.link.goodbye(now_us, out)
    }

    /// Begins to say a line; false while another one is on its way. `disarm` is a stop. One that turns motors on begins a run; it is
    /// refused by an answer if the board does not say within half a second that its motors are off.
    pub fn say(&mut self, line: &str) -> bool {
        if line.split_whitespace().next() == Some("disarm") {
            self.reins.note(self.now_us, AtOperator::Stop);
            self.waits = None;
        }
        let word = self.reins.giver().word(self.now_us);
        if self.waits.is_some() || !is_start(line) {
            return self.waits.is_none() && self.lines.say(line, word);
        }
        let free = !self.lines.is_saying();
        self.waits = free.then(|| (line.to_owned(), word, self.now_us.saturating_add(SETTLES_US)));
        self.begin();
        free
    }

    /// Begins the run of a line that waits, or refuses it: too late, or stopped meanwhile.
    fn begin(&mut self) {
        let Some((line, after, until_us)) = self.waits.take() else { return };
        let is_stopped = self.reins.giver().word(self.now_us) != after;
        let run = if is_stopped { Err(No::NotLet) } else { self.reins.start(self.now_us) };
        match run {
            Ok(word) => drop(self.lines.say(&line, word)),
            Err(No::Unknown | No::On) if self.now_us < until_us => self.waits = Some((line, after, until_us)),
            Err(no) => push(&mut self.answers, format!("error {}", no.explain())),
        }
    }

    /// Begins to say a line under the word of a run that has begun; false while another one is on its way.
    pub fn say_under(&mut self, line: &str, word: Word) -> bool {
        self.lines.say(line, word)
    }

    /// Withdraws a line that the board may not have heard yet: it is not to be carried out any more.
    pub fn unsay(&mut self) {
        self.lines.unsay();
        self.waits = None;
    }

    /// The next answer of the board that has not been taken.
    pub fn answer(&mut self) -> Option<String> {
        self.answers.pop_front()
    }

    /// The oldest line of the board's log that has not been taken: when it was said, µs of the caller's clock, and its words.
    pub fn logged(&mut self) -> Option<(u64, String)> {
        self.logged.pop_front()
    }

    /// What the board's ticks saw since the last time; lost if it was lost.
    pub fn take_samples(&mut self) -> Vec<Sample> {
        self.take_stamped().into_iter().map(|(_, sample)| sample).collect()
    }

    /// [`Session::take_samples`], each with the time of the board's clock at which it was sealed, µs.
    pub fn take_stamped(&mut self) -> Vec<(u64, Sample)> {
        std::mem::take(&mut self.samples)
    }

    /// The link to the board: its clock, its session.
    pub fn link(&self) -> &Link {
        &self.link
    }

    /// Sets how long the datagram that is received next has waited since it came, µs.
    pub fn waited(&mut self, us: u64) {
        self.link.waited(us);
    }

    /// Whether the board has answered under the key.
    pub fn is_there(&self) -> bool {
        self.link.is_up()
    }

    /// Whether the board takes lines to mean something else.
    pub fn is_refused(&self) -> bool {
        self.link.stage() == Stage::Refused
    }
}
