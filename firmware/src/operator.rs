//! The lines of text by which a person, or a program on the PC, arms, stops and sets up a board.
//!
//! A word and its arguments. Nothing here moves a motor but `check`, `probe` and `arm`; `disarm` is always accepted.
//!
//! What each line does stands in docs/guides/board/operate.md.

use core::str::FromStr;

use cohold_core::device::probe::{self, Shape};
use cohold_core::settings::{Choice, Value};
use cohold_protocol::record;

/// What a line asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Request<'a> {
    /// Mode, fault and progress of the board.
    Status,
    /// Motors on; `alone` without an operator who stays.
    Arm {
        /// They stay on when the operator is gone.
        alone: bool,
    },
    /// Turns the motors off.
    Disarm,
    /// A fault forgotten; the motors stay off.
    Clear,
    /// The joints are at zero where they are.
    Home,
    /// The device comes free of the world, which stands where it is.
    Clutch,
    /// It takes hold again from where it is.
    Release,
    /// Do the signs of a joint's motor and encoder agree?
    Check(u32),
    /// A motor pushed open loop.
    Probe(probe::Request),
    /// Outcome of the last check or probe.
    Probed,
    /// A key of the draft.
    Set(&'a str, Value<'a>),
    /// What a key of the draft is.
    Get(&'a str),
    /// The draft becomes the defaults.
    Defaults,
    /// The draft becomes the scene.
    Apply,
    /// The scene's settings are kept for the next start.
    Save,
    /// Every how-many-th tick to the sender; 0 is none.
    Stream(u32),
    /// Records of this many ticks in a row, without gaps.
    Capture {
        /// How many.
        ticks: u32,
        /// From the first on that has this flag of a record; 0 is at once.
        at: u8,
    },
    /// Records of the ticks before the last fault, and the PWM periods before the motors went off.
    Blackbox,
    /// Starts and faults of the board.
    History,
    /// How long ticks took on the chip, or runs of the current loop.
    Time(Whose, Time),
    /// How much of the processor both took.
    Load,
    /// The bootloader in the ROM, for another image.
    Update,
}

/// The interrupt that a time belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Whose {
    /// Once a control period.
    Tick,
    /// 20,000 times a second, while motors are on.
    CurrentLoop,
}

/// The time of a tick that is asked for ([`crate::times`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Time {
    /// From when it was due to when it began.
    Delay,
    /// From when it began to when it ended.
    Duration,
    /// How far from a period two in a row were apart.
    Spacing,
}

/// Why a line is none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Misread {
    /// It has no word in it.
    Empty,
    /// Its first word is not known.
    Word,
    /// Its arguments are not what the word takes.
    Arguments,
}

impl Misread {
    /// One sentence for a person.
    pub fn explain(self) -> &'static str {
        match self {
            Self::Empty => "send one line of text",
            Self::Word => {
                "the words are status, check, arm, disarm, clear, home, clutch, release, probe, probed, set, get, defaults, apply, save, stream, \
                 capture, blackbox, history, time, update"
            }
            Self::Arguments => {
                "the forms are arm, arm alone, check joint, probe joint pulse|swing|ramp|sine|winding duty seconds [hertz], \
                 set key value, get key, stream n, stream off, capture n, capture n at enabled|received|overrun|parted|engaged, time delay|duration|spacing"
            }
        }
    }
}

/// What the line asks for.
///
/// # Errors
/// Why the line is no request.
pub fn parse(line: &str) -> Result<Request<'_>, Misread> {
    let mut words = line.split_ascii_whitespace();
    let request = match words.next().ok_or(Misread::Empty)? {
        // Whatever else stands in the line: stopping must not fail for a slip of the finger.
        "disarm" => return Ok(Request::Disarm),
        "status" => Some(Request::Status),
        "arm" => match words.next() {
            None => Some(Request::Arm { alone: false }),
            Some(word) => (word == "alone").then_some(Request::Arm { alone: true }),
        },
        "clear" => Some(Request::Clear),
        "home" => Some(Request::Home),
        "clutch" => Some(Request::Clutch),
        "release" => Some(Request::Release),
        "check" => number(&mut words).map(Request::Check),
        "probe" => probe(&mut words).map(Request::Probe),
        "probed" => Some(Request::Probed),
        "set" => words.next().zip(words.next()).map(|(key, text)| Request::Set(key, Value::of_text(text))),
        "get" => words.next().map(Request::Get),
        "defaults" => Some(Request::Defaults),
        "apply" => Some(Request::Apply),
        "save" => Some(Request::Save),
        "stream" => words.next().and_then(|n| if n == "off" { Some(0) } else { n.parse().ok() }).map(Request::Stream),
        "capture" => number(&mut words).and_then(|ticks| match words.next() {
            None => Some(Request::Capture { ticks, at: 0 }),
            Some("at") => words.next().and_then(flag).map(|at| Request::Capture { ticks, at }),
            Some(_) => None,
        }),
        "blackbox" => Some(Request::Blackbox),
        "history" => Some(Request::History),
        "update" => Some(Request::Update),
        "time" => match words.next() {
            Some("load") => Some(Request::Load),
            Some("loop") => words.next().and_then(time).map(|time| Request::Time(Whose::CurrentLoop, time)),
            word => word.and_then(time).map(|time| Request::Time(Whose::Tick, time)),
        },
        _ => return Err(Misread::Word),
    };
    // Nothing may be missing, and nothing be left.
    request.filter(|_| words.next().is_none()).ok_or(Misread::Arguments)
}

fn time(word: &str) -> Option<Time> {
    match word {
        "delay" => Some(Time::Delay),
        "duration" => Some(Time::Duration),
        "spacing" => Some(Time::Spacing),
        _ => None,
    }
}

/// A flag of records ([`record`]).
fn flag(word: &str) -> Option<u8> {
    match word {
        "enabled" => Some(record::ENABLED),
        "received" => Some(record::RECEIVED),
        "overrun" => Some(record::OVERRUN),
        "parted" => Some(record::PARTED),
        "engaged" => Some(record::ENGAGED),
        _ => None,
    }
}

fn number<'a, T: FromStr>(words: &mut impl Iterator<Item = &'a str>) -> Option<T> {
    words.next()?.parse().ok()
}

/// `joint shape duty s [Hz]`.
fn probe<'a>(words: &mut impl Iterator<Item = &'a str>) -> Option<probe::Request> {
    Some(probe::Request {
        joint: number(words)?,
        shape: Shape::from_name(words.next()?)?,
        duty: number(words)?,
        duration_s: number(words)?,
        frequency_hz: words.next().map_or(Some(0.0), |hertz| hertz.parse().ok())?,
    })
}
