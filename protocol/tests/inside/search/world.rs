//! Two ends, and whoever decides what of all that was ever said gets where, when and how often; and what must be true all the time.
//! Nobody but the two ends has the key.

use std::fmt::{self, Write};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::rc::Rc;

use super::explore::Model;
use super::mistakes::Mistake;
use crate::ends::Ends;
use crate::engagement::Rung;
use crate::handshake::LIFE_US;
use crate::key::Key;
use crate::lease::Word;
use crate::lines::{FRESH_US, Lines};
use crate::link::{Config, Link, MAX_DELAY_US, Notice};
use crate::parameters::Parameters;
use crate::wire::{Flow, Header, MAX_DATAGRAM, Message, PeerId, Sample};

/// The packet period of both ends, µs: so long that a session outlasts a line.
const PERIOD_US: u32 = 50_000;
/// Silence after which a session is over, µs.
const APART_US: u64 = 12 * PERIOD_US as u64;
/// Age of the oldest flow that is taken, µs.
const FLOW_US: u64 = 2 * MAX_DELAY_US as u64;
/// What each end's clock shows whenever it starts, µs.
const CLOCKS: [u64; 2] = [77, 5_000_000];
/// How much time can pass at once, µs: a little more than a packet period; than a flow or a line may be old; than anything lives.
const WAITS: [u64; 3] = [60_000, 520_000, 1_050_000];
/// How often each end can start anew, and how many lines can be said.
const RESTARTS: usize = 1;
const LINES: u8 = 1;

/// What is promised, by FORMAT.md and docs/project/security.md.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Promise {
    /// No key meets a nonce twice.
    NonceOnce,
    /// A greeting makes a session within 1 s of the challenge that it echoes, or never.
    GreetingInTime,
    /// What made a confirmed session makes no other.
    SessionOnce,
    /// A session that nothing is answered in ends within 1 s.
    UnconfirmedEnds,
    /// A session is confirmed by what was said in it, within the last second.
    ConfirmedByAnAnswer,
    /// Nothing is handed out before the other end has answered in this session.
    NothingBeforeAnAnswer,
    /// No message counts that is older than 1 s.
    MessageInTime,
    /// Nothing is taken twice.
    TakenOnce,
    /// No flow is taken that is older than twice the longest delay.
    FlowInTime,
    /// No flow is taken after a newer one.
    FlowInOrder,
    /// A line is done within 0.5 s of its being said, or never.
    LineInTime,
    /// None is done a second after it was said, for one: the delayed arming that those lives are there to prevent.
    LineOfNow,
    /// Nothing is done twice.
    DoneOnce,
    /// A peer is there only if it said something within the last 1.6 s: what lives for a second, and 12 packet periods of silence.
    PeerIsThere,
    /// Nobody is engaged with a peer that said no flow within the last 1.1 s.
    EngagedWithFlow,
}

impl Promise {
    pub(super) const ALL: [Self; 15] = [
        Self::NonceOnce,
        Self::GreetingInTime,
        Self::SessionOnce,
        Self::UnconfirmedEnds,
        Self::ConfirmedByAnAnswer,
        Self::NothingBeforeAnAnswer,
        Self::MessageInTime,
        Self::TakenOnce,
        Self::FlowInTime,
        Self::FlowInOrder,
        Self::LineInTime,
        Self::LineOfNow,
        Self::DoneOnce,
        Self::PeerIsThere,
        Self::EngagedWithFlow,
    ];
}

/// The promises that are looked at.
#[derive(Clone, Copy, Debug)]
struct Promises {
    /// This one alone, or all.
    sought: Option<Promise>,
    broken: Option<Promise>,
}

impl Promises {
    fn hold(&mut self, promise: Promise, kept: bool) {
        if !kept && self.sought.is_none_or(|sought| sought == promise) {
            self.broken = self.broken.or(Some(promise));
        }
    }
}

/// What the two ends say to each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Use {
    /// Two peers: flow, whenever time has passed.
    Flow,
    /// A board (end 0), which says a sample whenever time has passed, and an operator (end 1), who says a line.
    Line,
}

/// What can happen next. Each end is called whenever something has got there and whenever time has passed, and says all it has to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Action {
    /// So many µs pass.
    Wait(u64),
    /// What was just said to this end gets there; what does not get there before time passes is held back.
    Pass(usize),
    /// Whatever the two say gets there, until neither has anything to say.
    Exchange,
    /// One of all the datagrams that were ever said to this end, whether or not it was there before, gets there now.
    Deliver(usize, usize),
    /// An end forgets everything and starts anew, its clock too.
    Restart(usize),
    /// The operator says a line.
    Say,
}

/// A datagram, when it was said, µs, and its fingerprint.
struct SentDatagram {
    bytes: Vec<u8>,
    at: u64,
    mark: u64,
}

impl SentDatagram {
    fn is_sealed(&self) -> bool {
        self.bytes[1] == Header::KIND
    }

    /// Which of its sender's datagrams a sealed one is.
    fn sequence(&self) -> u64 {
        u64::from_le_bytes(self.bytes[8..16].try_into().expect("8 bytes"))
    }
}

/// A link and what the program of its end has beside it.
#[derive(Clone)]
struct End {
    link: Link,
    lines: Lines,
}

/// What is so with an end, as somebody knows who sees everything; times are the world's, µs.
#[derive(Clone, Debug, Default, Hash)]
struct Truth {
    /// When it started, and how often it has before.
    born: u64,
    restarts: usize,
    /// When its session began.
    began: u64,
    /// When the newest of the datagrams was said that it opened in this session.
    heard: Option<u64>,
    /// The newest flow handed out in this session: its sequence, and when it was said.
    flow: Option<(u64, u64)>,
    /// The sessions that were confirmed here.
    confirmed: Vec<u32>,
    /// Of all that was said to it, a bit each: what was just said, and what was handed out.
    waiting: u64,
    taken: u64,
}

#[derive(Clone)]
pub(super) struct World {
    usage: Use,
    mistake: Mistake,
    promises: Promises,
    now: u64,
    ends: [Rc<End>; 2],
    /// Fingerprints of the two.
    marks: [u64; 2],
    /// The ends as they start, by how often they have.
    fresh: Rc<[Vec<Rc<End>>; 2]>,
    truth: [Truth; 2],
    /// All that was ever said to each end.
    said: [Vec<Rc<SentDatagram>>; 2],
    /// How many lines were said, and when those were that were done.
    lines: u8,
    done: Vec<u64>,
}

impl World {
    /// Two ends that have started. They make this mistake, and nothing but the promise that is sought is looked at.
    pub(super) fn new(usage: Use, mistake: Mistake, sought: Option<Promise>) -> Self {
        let fresh = [0, 1].map(|peer| (0..=RESTARTS).map(|life| Rc::new(end(mistake, peer, life))).collect::<Vec<_>>());
        let mut world = Self {
            usage,
            mistake,
            promises: Promises { sought, broken: None },
            now: 0,
            ends: fresh.each_ref().map(|lives| lives[0].clone()),
            marks: [0; 2],
            fresh: Rc::new(fresh),
            truth: Default::default(),
            said: Default::default(),
            lines: 0,
            done: Vec::new(),
        };
        (0..2).for_each(|peer| world.speak(peer));
        world
    }

    /// The same after these actions.
    pub(super) fn after(mut self, actions: &[Action]) -> Self {
        actions.iter().for_each(|action| self.act(*action).expect("nothing is broken yet"));
        self
    }

    fn clock(&self, peer: usize) -> u64 {
        CLOCKS[peer] + self.now - self.truth[peer].born
    }

    /// A datagram of this end's sets out.
    fn say(&mut self, from: usize, datagram: &[u8]) {
        let (said, waiting) = (&mut self.said[1 - from], &mut self.truth[1 - from].waiting);
        if let Some(number) = said.iter().position(|before| before.bytes == datagram) {
            // The same greeting once more.
            *waiting |= 1 << number;
            return;
        }
        let key_and_nonce = |bytes: &[u8]| bytes[1] == Header::KIND && bytes[2..16] == datagram[2..16];
        self.promises.hold(Promise::NonceOnce, !said.iter().any(|before| key_and_nonce(&before.bytes)));
        *waiting |= 1u64.checked_shl(said.len() as u32).expect("at most 64 datagrams each way");
        let mark = mark(|hasher| (datagram, self.now).hash(hasher));
        said.push(Rc::new(SentDatagram { bytes: datagram.to_vec(), at: self.now, mark }));
    }

    /// All that this end has to say sets out.
    fn speak(&mut self, peer: usize) {
        let (now, mistake, mut out) = (self.clock(peer), self.mistake, [0; MAX_DATAGRAM]);
        loop {
            let End { link, lines } = Rc::make_mut(&mut self.ends[peer]);
            lines.push(link);
            let Some(len) = mistake.poll(link, now, &mut out) else { break };
            self.say(peer, &out[..len]);
        }
        let End { link, lines } = Rc::make_mut(&mut self.ends[peer]);
        while let Some(notice) = link.take_notice() {
            if matches!(notice, Notice::NewPeer(_)) {
                lines.forget();
            }
        }
        // What was counted changes nothing.
        link.past = Default::default();
        let all = format_args!("{link:?} {lines:?}");
        self.marks[peer] = mark(|hasher| write!(Text(hasher), "{all}").expect("a hasher takes everything"));
    }

    /// What this end says whenever time has passed, if anything.
    fn stream(&mut self, peer: usize) {
        let message = match (self.usage, peer) {
            (Use::Flow, _) => Message::Flow(Flow::default()),
            (Use::Line, 0) => Message::Sample(Sample::new(0, &[]).expect("a short payload")),
            (Use::Line, _) => return,
        };
        let (now, mut out) = (self.clock(peer), [0; MAX_DATAGRAM]);
        let sent = self.mistake.send(&mut Rc::make_mut(&mut self.ends[peer]).link, now, message, &mut out);
        if let Some(len) = sent {
            self.say(peer, &out[..len]);
        }
    }

    /// What was just said to this end gets there.
    fn pass(&mut self, to: usize) {
        let waiting = self.truth[to].waiting;
        (0..self.said[to].len())
            .filter(|number| waiting & 1 << number != 0)
            .for_each(|number| self.deliver(to, number));
    }

    /// A datagram gets to this end.
    fn deliver(&mut self, to: usize, number: usize) {
        let said = self.said[to][number].clone();
        let (now, clock, mistake) = (self.now, self.clock(to), self.mistake);
        let (truth, promises) = (&mut self.truth[to], &mut self.promises);
        let link = &mut Rc::make_mut(&mut self.ends[to]).link;
        let before = (link.session_number(), link.is_up());
        let result = mistake.receive(link, clock, &mut said.bytes.clone());
        let (session, is_up) = (link.session_number(), link.is_up());
        truth.waiting &= !(1 << number);
        let is_fresh = now - said.at < LIFE_US;
        if let Some(number) = session.filter(|_| session != before.0) {
            (truth.began, truth.heard, truth.flow) = (now, None, None);
            let echo = &said.bytes[24..40];
            let offered = self.said[1 - to].iter().find(|said| !said.is_sealed() && said.bytes[8..24] == *echo);
            promises.hold(Promise::GreetingInTime, offered.is_some_and(|offered| now - offered.at < LIFE_US));
            promises.hold(Promise::SessionOnce, !truth.confirmed.contains(&number));
        }
        let is_opened = said.is_sealed() && result.is_ok();
        if is_opened {
            truth.heard = truth.heard.max(Some(said.at));
        }
        let is_an_answer = is_opened && said.at >= truth.began;
        if is_up && !before.1 {
            promises.hold(Promise::ConfirmedByAnAnswer, is_an_answer && is_fresh);
            truth.confirmed.extend(session);
        }
        if let Ok(Some(message)) = result {
            promises.hold(Promise::NothingBeforeAnAnswer, is_up && is_an_answer);
            promises.hold(Promise::MessageInTime, is_fresh);
            promises.hold(Promise::TakenOnce, truth.taken & 1 << number == 0);
            truth.taken |= 1 << number;
            if let Message::Flow(_) = message {
                promises.hold(Promise::FlowInTime, now - said.at <= FLOW_US);
                promises.hold(Promise::FlowInOrder, truth.flow.is_none_or(|(newest, _)| newest <= said.sequence()));
                truth.flow = Some((said.sequence(), said.at));
            }
        }
        self.hear(to);
        self.speak(to);
    }

    /// This end hears lines, and does what they say.
    fn hear(&mut self, peer: usize) {
        let clock = self.clock(peer);
        let End { link, lines } = Rc::make_mut(&mut self.ends[peer]);
        while let Some(heard) = lines.hear(clock, link) {
            if self.mistake.does(heard.is_fresh()) {
                // A line says when it was said.
                let at = heard.line.parse().expect("nothing else was said");
                self.promises.hold(Promise::LineInTime, self.now - at <= FRESH_US);
                self.promises.hold(Promise::LineOfNow, self.now - at < LIFE_US);
                self.promises.hold(Promise::DoneOnce, !self.done.contains(&at));
                self.done.push(at);
            }
        }
    }

    /// What must be so whatever has happened.
    fn check(&mut self) {
        for (end, truth) in self.ends.iter().zip(&self.truth) {
            let (link, promises) = (&end.link, &mut self.promises);
            let within = |at: Option<u64>, us: u64| at.is_some_and(|at| self.now - at <= us);
            let unconfirmed = link.session.as_ref().is_some_and(|session| !session.is_confirmed());
            promises.hold(Promise::UnconfirmedEnds, !unconfirmed || self.now - truth.began < LIFE_US);
            promises.hold(Promise::PeerIsThere, !link.is_up() || within(truth.heard, LIFE_US + APART_US));
            let flow = truth.flow.map(|(_, at)| at);
            promises.hold(
                Promise::EngagedWithFlow,
                link.engagement.rung() == Rung::Disengaged || within(flow, FLOW_US + APART_US),
            );
        }
    }
}

impl Model for World {
    type Action = Action;
    type Promise = Promise;

    fn actions(&self) -> Vec<Action> {
        let mut actions: Vec<_> = WAITS.map(Action::Wait).into();
        for end in 0..2 {
            if self.truth[end].waiting != 0 {
                actions.push(Action::Pass(end));
            }
            actions.extend((0..self.said[end].len()).map(|number| Action::Deliver(end, number)));
            if self.truth[end].restarts < RESTARTS {
                actions.push(Action::Restart(end));
            }
        }
        if self.truth.iter().any(|truth| truth.waiting != 0) {
            actions.push(Action::Exchange);
        }
        if self.usage == Use::Line && self.lines < LINES && self.ends[1].link.is_up() {
            actions.push(Action::Say);
        }
        actions
    }

    fn act(&mut self, action: Action) -> Result<(), Promise> {
        match action {
            Action::Wait(us) => {
                self.now += us;
                self.truth.iter_mut().for_each(|truth| truth.waiting = 0);
                for peer in 0..2 {
                    self.stream(peer);
                    self.speak(peer);
                }
            }
            Action::Pass(to) => self.pass(to),
            Action::Exchange => {
                while let Some(to) = (0..2).find(|to| self.truth[*to].waiting != 0) {
                    self.pass(to);
                }
            }
            Action::Deliver(to, number) => self.deliver(to, number),
            Action::Restart(peer) => {
                let Truth { restarts, confirmed, waiting, taken, .. } = std::mem::take(&mut self.truth[peer]);
                let restarts = restarts + 1;
                self.truth[peer] = Truth { born: self.now, restarts, confirmed, waiting, taken, ..Truth::default() };
                self.ends[peer] = self.fresh[peer][restarts].clone();
                self.speak(peer);
            }
            Action::Say => {
                let said = Rc::make_mut(&mut self.ends[1]).lines.say(&self.now.to_string(), Word::default());
                self.lines += u8::from(said);
                self.speak(1);
            }
        }
        self.check();
        self.promises.broken.map_or(Ok(()), Err)
    }

    fn fingerprint(&self) -> u64 {
        mark(|hasher| {
            (self.now, self.marks, &self.truth, self.lines, &self.done).hash(hasher);
            self.said.iter().for_each(|said| said.iter().map(|said| said.mark).collect::<Vec<_>>().hash(hasher));
        })
    }
}

/// This end in its n-th life.
fn end(mistake: Mistake, peer: usize, life: usize) -> End {
    let number = |peer: usize| PeerId(peer as u8 + 1);
    let config = Config {
        key: Key::new([7; Key::LEN]),
        ends: Ends { local: number(peer), remote: number(1 - peer) },
        packet_period_us: PERIOD_US,
        parameters: Parameters::new(),
        entropy: mistake.entropy(peer as u8 + 1, life as u8 + 1),
    };
    End { link: mistake.made(Link::new(config).expect("a sound configuration")), lines: Lines::default() }
}

/// What a hasher makes of it.
fn mark(of: impl FnOnce(&mut DefaultHasher)) -> u64 {
    let mut hasher = DefaultHasher::new();
    of(&mut hasher);
    hasher.finish()
}

/// All that an end holds is what it prints; but for keys, which come of what it has heard and said.
struct Text<'a>(&'a mut DefaultHasher);

impl Write for Text<'_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.0.write(text.as_bytes());
        Ok(())
    }
}
