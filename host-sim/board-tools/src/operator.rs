//! The operator's end of a board's command port: one line of text there, one answer back, and what the board's ticks saw.
//!
//! A sealed link of its own beside the flow between the peers: the operator has number 0, the board its own (1 or 2), the key
//! is the operator's, which no peer but this board holds. Lines and answers are reliable events, records are samples
//! (haptic-protocol). What a line may say is in firmware/src/operator.rs; the last operator to come is the one the board
//! listens to.
//!
//! **Run is a lease** ([`Consent`]): all that is sealed here, in messages of one length, says whether the motors may run. A line that turns
//! them on gives consent, `disarm` takes it back before it is said; so does whoever has the handle.
//!
//! [`Session`] is sans-IO: whoever has a socket and a clock drives it, tests in virtual time. What a board says takes no more memory than
//! [`MOST_ANSWERS`] and [`MOST_SAMPLES`], whether somebody takes it or not.

use std::collections::VecDeque;

use haptic_protocol::link::{Config, Link, Notice, Stage};
use haptic_protocol::parameters::{Parameters, Table};
use haptic_protocol::wire::{Datagram, Event, Message, PeerId, Sample};
use haptic_protocol::{ends::Ends, key::Key, lines::Lines};

use crate::Error;
use crate::consent::{Consent, Moment, Stopped, runs};

/// The port on the board.
pub const PORT: u16 = 7702;
const OPERATOR: PeerId = PeerId(0);
/// Most answers that wait to be taken: of more, the oldest are gone.
pub const MOST_ANSWERS: usize = 64;
/// Most samples that wait to be taken, 5 s of three axes at 1 kHz: what comes beyond them is lost.
pub const MOST_SAMPLES: usize = 1 << 14;
/// Both ends poll this often, µs; after twelve times as long in silence they call anew.
const PERIOD_US: u32 = 20_000;

/// One operator and one board, whoever brings the time and the datagrams.
#[derive(Debug)]
pub struct Session {
    link: Link,
    lines: Lines,
    answers: VecDeque<String>,
    samples: Vec<(u64, Sample)>,
    consent: Consent,
    /// Consent was given when something was sealed last.
    consented: bool,
    /// From when on what is sealed here says that it was taken back, µs: after every yes, and after all that the board echoed before.
    withdrawn_us: u64,
}

impl Session {
    /// Calls board `number` (1 or 2). `entropy` must never be the same twice.
    ///
    /// # Errors
    /// The link cannot be made, such as of two ends with one number.
    pub fn new(key: Key, number: u8, entropy: [u8; Key::LEN]) -> Result<Self, Error> {
        let mut parameters = Parameters::new();
        // What the lines mean; a board that means something else is refused by name.
        parameters.add(Table::new("operator").number("version", 1.0)).map_err(|error| error.to_string())?;
        let ends = Ends { local: OPERATOR, remote: PeerId(number) };
        let link = Link::new(Config { key, ends, packet_period_us: PERIOD_US, parameters, entropy })
            .map_err(haptic_sim::Error::from)?;
        Ok(Self {
            link: link.of_one_length(Event::MAX_LEN),
            lines: Lines::default(),
            answers: VecDeque::new(),
            samples: Vec::new(),
            consent: Consent::default(),
            consented: false,
            withdrawn_us: 0,
        })
    }

    /// Takes a datagram, which is opened in place; one that is not the board's is not taken.
    pub fn receive(&mut self, now_us: u64, datagram: &mut [u8]) {
        let taken = self.link.receive(now_us, datagram);
        while let Some(notice) = self.link.take_notice() {
            if matches!(notice, Notice::NewPeer(_)) && !self.lines.is_saying() {
                self.lines.forget();
            }
        }
        if let Ok(Some(Message::Sample(sample))) = taken
            && self.samples.len() < MOST_SAMPLES
        {
            self.samples.push((self.link.sealed_us(), sample));
        }
        while let Some(heard) = self.lines.hear(now_us, &mut self.link) {
            if self.answers.len() == MOST_ANSWERS {
                self.answers.pop_front();
            }
            self.answers.push_back(haptic_io::escaped(heard.line.as_str()).into_owned());
        }
    }

    /// The next datagram to send, if any; call until there is none, at least every 20 ms.
    pub fn poll(&mut self, now_us: u64, out: &mut Datagram) -> Option<usize> {
        let consents = self.consent.is_given();
        if consents {
            self.withdrawn_us = now_us.saturating_add(1);
        } else if self.consented {
            // A board may echo a time before it has heard anything of that time.
            let guessed_us = self.link.echoed_us().map_or(0, |us| us.saturating_add(1));
            self.withdrawn_us = self.withdrawn_us.max(now_us).max(guessed_us);
        }
        self.consented = consents;
        self.link.consent(consents);
        self.lines.push(&mut self.link);
        self.link.poll(now_us, out)
    }

    /// Whether the motors may run, for whoever gives and takes back.
    pub fn consent(&self) -> Consent {
        self.consent.clone()
    }

    /// How it is known that a board that runs on for `lease_us` µs after the last yes has stopped; `None`: it may run.
    pub fn stopped(&self, now_us: u64, lease_us: u64) -> Option<Stopped> {
        if self.consented || self.consent.is_given() {
            return None;
        }
        let heard = self.link.echoed_us().is_some_and(|echoed_us| echoed_us >= self.withdrawn_us);
        let over = now_us >= self.withdrawn_us.saturating_add(lease_us);
        if heard { Some(Stopped::Heard) } else { over.then_some(Stopped::LeaseOver) }
    }

    /// Tells the board that nobody listens any more, as [`Link::goodbye`].
    pub fn goodbye(&mut self, now_us: u64, out: &mut Datagram) -> Option<usize> {
        self.link.goodbye(now_us, out)
    }

    /// Begins to say a line; false while another one is on its way.
    pub fn say(&mut self, line: &str) -> bool {
        self.say_since(line, self.consent.moment())
    }

    /// Begins to say a line that was ordered at this moment: if it turns motors on, they may run unless consent was taken back since.
    /// False while another one is on its way.
    pub fn say_since(&mut self, line: &str, moment: Moment) -> bool {
        if line.split_whitespace().next() == Some("disarm") {
            self.consent.withdraw();
        }
        let said = self.lines.say(line);
        if said && runs(line) {
            self.consent.give(moment);
        }
        said
    }

    /// Withdraws a line that the board may not have heard yet: it is not to be carried out any more.
    pub fn unsay(&mut self) {
        self.lines.unsay();
    }

    /// The next answer of the board that has not been taken.
    pub fn answer(&mut self) -> Option<String> {
        self.answers.pop_front()
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
