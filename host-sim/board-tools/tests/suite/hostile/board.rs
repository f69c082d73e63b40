//! What a hostile board says, millisecond by millisecond, under keys that are right.

use cohold_protocol::lease::{Told, Want, Word};
use cohold_protocol::lines::{END, PART};
use cohold_protocol::record::{self, Record};
use cohold_protocol::wire::{Ack, Event, MAX_DATAGRAM, Message, Probe, Reply, Sample};
use cohold_sim::rng::Rng;

use super::super::format::{GREETING, Session, hello};

pub(super) const KEY: [u8; 32] = [7; 32];
/// The times of stamps.
const CLOCK: u64 = (1 << 56) - 1;
/// Between two sessions that it begins by itself, µs: no operator multiplies more often.
const APART_US: u64 = 60_000;
/// How often a lie is told at once in a flood.
const FLOOD: u64 = 64;

/// What it says beside what any board says.
#[derive(Clone, Copy, Debug)]
enum Lie {
    /// It echoes this much more than the operator's clock will show, µs; or nothing, or what it heard first.
    Echoes(i64),
    EchoesNothing,
    /// Its own clock jumps.
    Clock,
    /// It says anything of its motors, of the newest word or of any.
    Tells,
    /// It says that they are off by the operator's next word, which he has not said yet.
    Ahead,
    /// Answers, asked for or not, of this text.
    Answers(usize),
    /// A line that never ends.
    NoEnd,
    /// Any bytes as a part of a line.
    Parts,
    /// Records with this in a word by chance, and with ticks that go on by this.
    Records(u32, u32),
    /// Records and payloads of any bytes and length.
    AnyRecord,
    /// Acknowledges events that were never said.
    Acknowledges,
    /// Answers probes with times that cannot be.
    Replies,
    /// Any bytes under a good seal.
    AnyMessage,
    /// What was said before, or with a bit of it changed.
    Replays,
    /// Ends the session, and begins another.
    Leaves,
    /// Nothing at all, not even what any board says.
    Silent,
}

/// Texts of answers; those of `ok` contradict each other.
const TEXTS: [&str; 15] = [
    "ok armed",
    "ok disarmed",
    "ok board 1 armed fault 0; disarmed fault 12; the operator was silent",
    "ok board 255 probing fault 99999999999999999999",
    "ok safety.operator_lost_s = NaN",
    "ok safety.operator_lost_s = 1e308",
    "error",
    "",
    "ok \u{1b}[2J\u{1b}]0;stopped\u{7}\r\n\u{0}\u{9b}31m",
    "ok \u{202e}demra\u{2066}\u{feff}",
    "ok probe 1: running: running; agree: agree; ; : : ",
    "ok axis.shared = 18446744073709551615",
    "log 18446744073709551615 peer: \u{1b}[2J",
    "log 0 \u{202e}",
    "log -1 peer: lost",
];

/// Lies, each every so many milliseconds and so often then.
#[derive(Clone, Debug)]
pub(super) struct Program(Vec<(Lie, u64, u64)>);

impl Program {
    pub(super) fn new(rng: &mut Rng) -> Self {
        Self((0..1 + rng.below(4)).map(|_| Self::lie(rng)).collect())
    }

    fn lie(rng: &mut Rng) -> (Lie, u64, u64) {
        let echoes = [0, 1, 999, 1000, 1001, 2000, 200_000, -1000, -200_000, i64::MAX / 2];
        let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, -1e30, f32::from_bits(1), 0.0];
        let ticks = [0, 1, 4, u32::MAX, 1 << 31, 100_000, 0_u32.wrapping_sub(340)];
        let odd = odd[rng.below(odd.len() as u64) as usize].to_bits();
        let lies = [
            Lie::Echoes(echoes[rng.below(echoes.len() as u64) as usize]),
            Lie::Echoes(echoes[rng.below(echoes.len() as u64) as usize]),
            Lie::EchoesNothing,
            Lie::Clock,
            Lie::Tells,
            Lie::Ahead,
            Lie::Answers(rng.below(TEXTS.len() as u64) as usize),
            Lie::Answers(rng.below(TEXTS.len() as u64) as usize),
            Lie::NoEnd,
            Lie::Parts,
            Lie::Records(odd, ticks[rng.below(ticks.len() as u64) as usize]),
            Lie::Records(odd, ticks[rng.below(ticks.len() as u64) as usize]),
            Lie::AnyRecord,
            Lie::Acknowledges,
            Lie::Replies,
            Lie::AnyMessage,
            Lie::Replays,
            Lie::Leaves,
            Lie::Silent,
        ];
        let often = if rng.chance(0.05) { FLOOD } else { 1 + rng.below(3) };
        (lies[rng.below(lies.len() as u64) as usize], 1 + rng.below(20), often)
    }

    pub(super) fn altered(&self, rng: &mut Rng) -> Self {
        let mut altered = self.clone();
        let at = rng.below(altered.0.len() as u64) as usize;
        altered.0[at] = Self::lie(rng);
        altered
    }

    /// More than anybody takes.
    pub(super) fn flood() -> Self {
        Self(vec![(Lie::Records(0, 1), 1, FLOOD), (Lie::Answers(0), 1, FLOOD), (Lie::Answers(13), 1, FLOOD)])
    }
}

/// A datagram, and what it tells of the motors, where it is sealed.
#[derive(Clone)]
pub(super) struct Said {
    pub(super) datagram: Vec<u8>,
    pub(super) told: Option<Told>,
}

#[derive(Default)]
pub(super) struct Board {
    session: Option<Session>,
    sessions: u64,
    began_us: u64,
    sequence: u64,
    /// The newest time of the operator's clock that it has heard, and the first, µs.
    heard_us: [u64; 2],
    /// The operator's newest word.
    word: u8,
    clock_us: u64,
    event: u32,
    tick: u32,
    greeting: Option<Vec<u8>>,
    /// Messages that any board would say.
    due: Vec<Message>,
    past: Vec<Said>,
}

impl Board {
    /// Takes in what the operator said; how often that was a yes.
    pub(super) fn hear(&mut self, rng: &mut Rng, said: &[Vec<u8>]) -> u64 {
        let mut yeses = 0;
        for datagram in said {
            if datagram.len() == GREETING {
                let wanted = self.session.is_none() || rng.chance(0.2);
                self.greeting = wanted.then(|| datagram.clone());
                continue;
            }
            let Some(([at, echo], message)) = self.session.as_ref().and_then(|session| session.open(datagram)) else {
                continue;
            };
            self.word = (echo >> 56) as u8;
            yeses += u64::from(Word::of_byte(self.word).want == Want::Run);
            self.heard_us[0] = at & CLOCK;
            self.heard_us[1] = if self.heard_us[1] == 0 { at & CLOCK } else { self.heard_us[1] };
            let padding = (at >> 56 & 0x7f) as usize;
            match Message::parse(&message[..message.len() - padding]) {
                Ok(Message::Event(event)) => {
                    self.due.push(Ack { next: event.number.wrapping_add(1), ahead: 0 }.into());
                }
                // Of what it said before it was taken to be there, nothing was heard.
                Ok(Message::Ack(Ack { next, .. })) => self.event = next,
                Ok(Message::Probe(Probe { sent_us })) => {
                    let [probe_received_us, sent_us_here] = [self.clock_us; 2];
                    self.due.push(Reply { probe_sent_us: sent_us, probe_received_us, sent_us: sent_us_here }.into());
                }
                _ => {}
            }
        }
        yeses
    }

    /// What comes at the operator's end a millisecond later.
    pub(super) fn speak(&mut self, rng: &mut Rng, now_us: u64, program: &Program) -> Vec<Said> {
        let mut said = Vec::new();
        self.clock_us += 1000;
        if let Some(heard) = self.greeting.take()
            && (self.sessions == 0 || now_us >= self.began_us + APART_US)
        {
            self.sessions += 1;
            let secret = std::array::from_fn(|at| (self.sessions >> (8 * (at % 8))) as u8 ^ at as u8);
            let datagram = hello(&KEY, &heard, secret);
            self.session = Some(Session::of(&KEY, &heard, &datagram, secret));
            (self.began_us, self.heard_us, self.event) = (now_us, [0; 2], 0);
            said.push(Said { datagram, told: None });
        }
        let lies: Vec<_> = program.0.iter().filter(|(_, every, _)| (now_us / 1000).is_multiple_of(*every)).collect();
        let mut messages: Vec<Vec<u8>> = std::mem::take(&mut self.due).iter().map(bytes_of).collect();
        let mut echo_us = self.heard_us[0];
        // On while they may run.
        let mut told = self.word & !3 | u8::from(Word::of_byte(self.word).want == Want::Run);
        for (lie, _, often) in lies {
            match lie {
                Lie::Silent => return said,
                Lie::Echoes(more) => echo_us = (now_us + 1000).saturating_add_signed(*more - 1000),
                Lie::EchoesNothing => echo_us = if rng.chance(0.5) { 0 } else { self.heard_us[1] },
                Lie::Tells if rng.chance(0.5) => told = rng.below(256) as u8,
                Lie::Tells => told = self.word & !3 | rng.below(4) as u8,
                Lie::Ahead => told = (self.word & !3).wrapping_add(4),
                Lie::Clock => self.clock_us = rng.below(u64::MAX) >> rng.below(60),
                Lie::Leaves => {
                    messages.push(vec![7, 0, 0, 0]);
                    self.session = self.session.take().filter(|_| rng.chance(0.5));
                }
                Lie::Replays => {
                    for _ in 0..*often {
                        let Some(past) = self.past.get(rng.below(64) as usize) else { continue };
                        // What came before the operator had this session comes for the first time.
                        let (mut datagram, told) = (past.datagram.clone(), past.told);
                        let (at, bit) = (rng.below(datagram.len() as u64) as usize, rng.below(8));
                        datagram[at] ^= u8::from(rng.chance(0.5)) << bit;
                        said.push(Said { datagram, told });
                    }
                }
                _ => (0..*often).for_each(|_| messages.extend(self.lie(rng, *lie))),
            }
        }
        let Some(session) = &self.session else { return said };
        for message in messages {
            self.sequence += 1;
            let stamps = [(self.clock_us & CLOCK).max(1), echo_us & CLOCK | u64::from(told) << 56];
            let datagram = session.seal(1, 0, self.sequence, stamps, &message);
            let (place, new) = (self.sequence as usize % 64, Said { datagram, told: Some(Told::of_byte(told)) });
            self.past.resize(64, new.clone());
            self.past[place].clone_from(&new);
            said.push(new);
        }
        said
    }

    fn lie(&mut self, rng: &mut Rng, lie: Lie) -> Vec<Vec<u8>> {
        let mut any = |most: u64| (0..rng.below(most + 1)).map(|_| rng.below(256) as u8).collect::<Vec<u8>>();
        let message: Message = match lie {
            Lie::Answers(text) => {
                let token = self.clock_us.to_le_bytes();
                return vec![self.event(END, &[&token[..], TEXTS[text].as_bytes()].concat())];
            }
            Lie::NoEnd => return vec![self.event(PART, &[b'x'; Event::MAX_PAYLOAD])],
            Lie::Parts => {
                let bytes = any(Event::MAX_PAYLOAD as u64);
                let code = [PART, END, 0, u16::MAX][rng.below(4) as usize];
                return vec![self.event(code, &bytes)];
            }
            Lie::Records(odd, on) => {
                self.tick = self.tick.wrapping_add(on);
                let mut record = Record::default();
                record.0[record::word::TICK] = self.tick;
                record.0[record::word::MODE] = rng.below(4) as u32 | (rng.below(20) as u32) << 8;
                record.put(7 + rng.below(8) as usize, f32::from_bits(odd));
                Sample::new(record::CODE, &record.bytes()).expect("a record").into()
            }
            Lie::AnyRecord => Sample::new(rng.below(8) as u16, &any_record(rng)).expect("a sample").into(),
            Lie::Acknowledges => Ack { next: rng.below(40) as u32, ahead: rng.below(1 << 32) as u32 }.into(),
            Lie::Replies => {
                let mut time = || rng.below(u64::MAX) >> rng.below(64);
                Reply { probe_sent_us: time(), probe_received_us: time(), sent_us: time() }.into()
            }
            _ => return vec![any(124)],
        };
        vec![bytes_of(&message)]
    }

    /// The next event, in its turn.
    fn event(&mut self, code: u16, payload: &[u8]) -> Vec<u8> {
        let payload = &payload[..payload.len().min(Event::MAX_PAYLOAD)];
        let event = Event::new(code, payload).expect("a short one").numbered(self.event);
        self.event = self.event.wrapping_add(1);
        bytes_of(&event.into())
    }
}

fn any_record(rng: &mut Rng) -> Vec<u8> {
    let length = if rng.chance(0.5) { record::BYTES as u64 } else { rng.below(Sample::MAX_PAYLOAD as u64 + 1) };
    (0..length).map(|_| rng.below(256) as u8).collect()
}

fn bytes_of(message: &Message) -> Vec<u8> {
    let mut bytes = [0; MAX_DATAGRAM];
    let length = message.emit(&mut bytes).expect("a message with finite numbers");
    bytes[..length].to_vec()
}
