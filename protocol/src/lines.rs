//! Lines: text between a person and a machine over a link's reliable events: whole lines, once and in order.
//!
//! A line goes in parts of up to 48 bytes, as many as there is room for under way; the last part says that it is the last.
//! One line at a time is on its way in each direction: who asks waits for the answer.
//!
//! The last part also has a token, the newest time of the receiver's clock that the sender knew when it began to say the line. So
//! the receiver knows how long ago that was ([`Heard::age_us`]), from its own clock alone and however often the parts were sent; a
//! machine does only what was said to it within [`FRESH_US`]. The token's last byte is the [`Word`] that the line was said under.
//!
//! **Limits**: 384 bytes a line; what is longer is cut at a whole character. Parts of a line whose sender started anew in
//! the middle of it are dropped with the link's session ([`Lines::forget`]).

use heapless::{String, Vec};

use crate::link::{Config, Link};
use crate::parameters::{Parameters, Table};
use crate::wire::{Event, PeerId, Stamps};
use crate::{ends::Ends, key::Key, lease::Word};

/// The UDP port of a board's operator.
pub const PORT: u16 = 7702;
/// The operator's number.
pub const OPERATOR: PeerId = PeerId(0);
/// Both ends poll this often, µs; after twelve times as long in silence they call anew.
const PERIOD_US: u32 = 20_000;

/// Longest line of text, bytes.
pub const LONGEST: usize = 384;
/// Code of an event that is part of a line, with more to follow.
pub const PART: u16 = 1;
/// Code of an event that ends a line.
pub const END: u16 = 2;

/// How long ago a line may have been said at the most, for a machine to do what it says, µs.
pub const FRESH_US: u64 = 500_000;
/// Bytes of the token at the front of the last part.
const TOKEN: usize = 8;

/// A line of text.
pub type Line = String<LONGEST>;

/// A line that was heard.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Heard {
    /// The text of the line.
    pub line: Line,
    /// The word that it was said under.
    pub word: Word,
    /// How long ago it was said, at the most, µs; `None`: before this session.
    pub age_us: Option<u64>,
}

impl Heard {
    /// Whether it was said within [`FRESH_US`].
    pub fn is_fresh(&self) -> bool {
        self.age_us.is_some_and(|age_us| age_us <= FRESH_US)
    }
}

/// Both directions of one end.
#[derive(Clone, Debug, Default)]
pub struct Lines {
    saying: Line,
    under: Word,
    /// Bytes of it that the link has taken in charge; `None`: nothing is being said.
    said: Option<usize>,
    /// The token that it goes with, once it has begun to be said.
    token: Option<u64>,
    hearing: Vec<u8, LONGEST>,
}

/// The link between a board's operator and the board, as one of these ends has it: `entropy` must never be the same twice.
pub fn config(key: Key, ends: Ends, entropy: [u8; Key::LEN]) -> Config {
    let mut parameters = Parameters::new();
    // What lines mean: an end that means something else is refused by name. There is room for one.
    let _ = parameters.add(Table::new("operator").number("version", 2.0));
    Config { key, ends, packet_period_us: PERIOD_US, parameters, entropy }
}

impl Lines {
    /// Begins to say a line under a word; false while another one is not yet with the link.
    pub fn say(&mut self, text: &str, under: Word) -> bool {
        if self.said.is_some() {
            return false;
        }
        self.saying.clear();
        let _ = text.chars().try_for_each(|character| self.saying.push(character));
        (self.said, self.token, self.under) = (Some(0), None, under);
        true
    }

    /// Takes back what is being said, as far as the link does not have it.
    pub fn unsay(&mut self) {
        self.said = None;
    }

    /// Whether a line is not yet with the link.
    pub fn is_saying(&self) -> bool {
        self.said.is_some()
    }

    /// Gives the link what it has room for, once there is a session. Call after every [`Lines::say`] and before every [`Link::poll`].
    pub fn push(&mut self, link: &mut Link) {
        while let Some(said) = self.said {
            let Some(token) = self.token.or(link.token()) else { return };
            self.token = Some(token);
            let token = token & Stamps::CLOCK | u64::from(self.under.byte()) << 56;
            let rest = self.saying.as_bytes().get(said..).unwrap_or(&[]);
            let part = rest.get(..Event::MAX_PAYLOAD).unwrap_or(rest);
            let last = rest.len() <= Event::MAX_PAYLOAD - TOKEN;
            let event = if last {
                let mut payload = [0; Event::MAX_PAYLOAD];
                payload.iter_mut().zip(token.to_le_bytes().iter().chain(part)).for_each(|(to, from)| *to = *from);
                Event::new(END, payload.get(..TOKEN.saturating_add(part.len())).unwrap_or(&payload))
            } else {
                Event::new(PART, part)
            };
            let Ok(event) = event else { return };
            if link.push_event(event).is_err() {
                return;
            }
            self.said = (!last).then_some(said.saturating_add(part.len()));
        }
    }

    /// The next whole line that came, if any. Events that are no lines are dropped.
    pub fn hear(&mut self, now: u64, link: &mut Link) -> Option<Heard> {
        while let Some(event) = link.take_event() {
            if event.code != PART && event.code != END {
                continue;
            }
            let (token, text) = match event.payload().split_first_chunk::<TOKEN>() {
                Some((token, text)) if event.code == END => (u64::from_le_bytes(*token), text),
                // A last part without a token was never said.
                _ => (0, event.payload()),
            };
            // What is beyond the longest line is cut.
            let _ = text.iter().try_for_each(|byte| self.hearing.push(*byte));
            if event.code == END {
                let bytes = core::mem::take(&mut self.hearing);
                // A line that is no text ends where it stops to be text.
                let whole = bytes.utf8_chunks().next().map_or("", |chunk| chunk.valid());
                let (word, age_us) =
                    (Word::of_byte((token >> 56) as u8), link.token_age_us(now, token & Stamps::CLOCK));
                return Some(Heard { line: whole.chars().collect(), word, age_us });
            }
        }
        None
    }

    /// Forgets what was half said and half heard: the other end has started anew.
    pub fn forget(&mut self) {
        *self = Self::default();
    }
}
