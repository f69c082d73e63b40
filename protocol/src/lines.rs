//! Lines: text between a person and a machine over a link's reliable events: whole lines, once and in order.
//!
//! A line goes in parts of up to 48 bytes, as many as there is room for under way; the last part says that it is the last.
//! One line at a time is on its way in each direction: who asks waits for the answer.
//!
//! **Limits**: 384 bytes a line; what is longer is cut at a whole character. Parts of a line whose sender started anew in
//! the middle of it are dropped with the link's session ([`Lines::forget`]).

use heapless::{String, Vec};

use crate::{link::Link, wire::Event};

/// Longest line, bytes.
pub const LONGEST: usize = 384;
/// Code of an event that is part of a line, with more to follow.
pub const PART: u16 = 1;
/// Code of an event that ends a line.
pub const END: u16 = 2;

/// A line of text.
pub type Line = String<LONGEST>;

/// Both directions of one end.
#[derive(Clone, Debug, Default)]
pub struct Lines {
    saying: Line,
    /// Bytes of it that the link has taken in charge; `None`: nothing is being said.
    said: Option<usize>,
    hearing: Vec<u8, LONGEST>,
}

impl Lines {
    /// Begins to say a line; false while another one is not yet with the link.
    pub fn say(&mut self, text: &str) -> bool {
        if self.said.is_some() {
            return false;
        }
        self.saying.clear();
        let _ = text.chars().try_for_each(|character| self.saying.push(character));
        self.said = Some(0);
        true
    }

    /// Whether a line is not yet with the link.
    pub fn is_saying(&self) -> bool {
        self.said.is_some()
    }

    /// Gives the link what it has room for. Call after every [`Lines::say`] and before every [`Link::poll`].
    pub fn push(&mut self, link: &mut Link) {
        while let Some(said) = self.said {
            let rest = self.saying.as_bytes().get(said..).unwrap_or(&[]);
            let part = rest.get(..Event::MAX_PAYLOAD).unwrap_or(rest);
            let last = part.len() == rest.len();
            let Ok(event) = Event::new(if last { END } else { PART }, part) else { return };
            if link.push_event(event).is_err() {
                return;
            }
            self.said = (!last).then_some(said.saturating_add(part.len()));
        }
    }

    /// The next whole line that came, if any. Events that are no lines are dropped.
    pub fn hear(&mut self, link: &mut Link) -> Option<Line> {
        while let Some(event) = link.take_event() {
            if event.code != PART && event.code != END {
                continue;
            }
            for byte in event.payload() {
                // What is beyond the longest line is cut.
                let _ = self.hearing.push(*byte);
            }
            if event.code == END {
                let bytes = core::mem::take(&mut self.hearing);
                // A line that is no text ends where it stops to be text.
                let whole = bytes.utf8_chunks().next().map_or("", |chunk| chunk.valid());
                return Some(whole.chars().collect());
            }
        }
        None
    }

    /// Forgets what was half said and half heard: the other end has started anew.
    pub fn forget(&mut self) {
        *self = Self::default();
    }
}
