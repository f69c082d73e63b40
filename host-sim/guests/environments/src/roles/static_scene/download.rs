//! Download: what a client knows of one server's world, and what it asks next.
//!
//! ```text
//! manifest ──► regions ──► pages (which objects are in scope, their checksums) ──► objects that are not held yet
//!     ▲                                                                              │
//!     └────────── another world in any answer, or a second has passed ◄──────────────┘
//! ```
//!
//! Missing things are asked for in rounds: each once, [`BURST`] to a question, then, after the time an answer may take,
//! again those that have not come. An object is taken when its record's own checksum is right and is the one that the page
//! told; a whole world, when its checksum is right too. An object that is held already is never fetched again, whatever
//! world it came from: what counts is its checksum.
//!
//! **Memory**: `N` objects at the most. What is in scope beyond that is left out and counted, never what is held.
//! **Limits**: objects that were held stay, and are felt, until the download that replaces them is complete. An answer about
//! the 256th scope before this one looks like one about this; what comes that late a link refuses as a replay.

use cohold_protocol::wire::{Ask, Bits, Page, Part, Payload, Topic};
use heapless::Vec;

use super::server::BURST;
use crate::records::{MAX_OBJECTS, MAX_REGIONS, Manifest, Object, Region, Scope, checksum_of, world_checksum};

/// How often a client that has everything asks whether the world is still the same, µs.
const REFRESH_US: u64 = 1_000_000;
/// Pages of the largest world.
const PAGES: usize = MAX_OBJECTS / Page::OBJECTS;
const _: () = assert!(PAGES == 2 * Bits::COUNT);

/// What a part has done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Taken {
    /// Nothing new: known already, or about another scope or world.
    Nothing,
    /// Something new, but not all that is in scope yet.
    More,
    /// Everything in scope is there, and its checksums are right.
    Complete,
    /// The world is another one than before, or is seen for the first time.
    World,
    /// It is not what its checksum says; it is asked for again.
    Corrupt,
}

/// An object in scope.
#[derive(Clone, Copy, Debug)]
struct Entry {
    number: u16,
    checksum: u64,
    held: bool,
    asked: bool,
}

#[derive(Clone, Copy, Debug)]
struct Held {
    object: Object,
    checksum: u64,
}

/// Known and asked-for pages.
#[derive(Clone, Copy, Debug, Default)]
struct PageSet([Bits; 2]);

impl PageSet {
    fn has(&self, page: usize) -> bool {
        self.0.get(page / Bits::COUNT).is_some_and(|bits| bits.has(page % Bits::COUNT))
    }

    fn set(&mut self, page: usize) {
        if let Some(bits) = self.0.get_mut(page / Bits::COUNT) {
            bits.set(page % Bits::COUNT);
        }
    }
}

/// What a client knows of one server's world.
#[derive(Clone, Debug, Default)]
pub struct Download<const N: usize> {
    scope: Scope,
    tag: u8,
    announced: Option<(u64, Manifest)>,
    regions: Vec<Option<Region>, MAX_REGIONS>,
    asked_regions: u32,
    pages: PageSet,
    asked_pages: PageSet,
    entries: Vec<Entry, N>,
    left_out: u32,
    held: Vec<Held, N>,
    complete: bool,
    corrupt: u32,
    objects_taken: u32,
    /// Another world was seen in an answer.
    doubt: bool,
    /// The manifest is asked for at this time, µs.
    manifest_us: u64,
    /// What was asked for and has not come is asked for again at this time, µs.
    round_us: u64,
}

impl<const N: usize> Download<N> {
    /// From now on this part of the world is wanted. What is held stays held until the new scope is complete.
    pub fn look(&mut self, scope: Scope) {
        if scope != self.scope {
            self.scope = scope;
            self.tag = self.tag.wrapping_add(1);
            self.forget_listing();
        }
    }

    /// The part of the world that is wanted.
    pub fn scope(&self) -> Scope {
        self.scope
    }

    /// Every object that is held, by id.
    pub fn objects(&self) -> impl Iterator<Item = &Object> {
        self.held.iter().map(|held| &held.object)
    }

    /// The regions that are known, by id.
    pub fn regions(&self) -> impl Iterator<Item = &Region> {
        self.regions.iter().flatten()
    }

    /// What the world is, and its checksum; `None` before the server was heard.
    pub fn world(&self) -> Option<(u64, Manifest)> {
        self.announced
    }

    /// Whether everything in scope is held.
    pub fn is_complete(&self) -> bool {
        self.complete
    }

    /// Objects in scope as far as is known: those that are held, and all.
    pub fn progress(&self) -> (usize, usize) {
        (self.entries.iter().filter(|entry| entry.held).count(), self.entries.len())
    }

    /// Objects in scope for which there is no room.
    pub fn left_out(&self) -> u32 {
        self.left_out
    }

    /// Parts that were not what their checksum said.
    pub fn corrupt(&self) -> u32 {
        self.corrupt
    }

    /// Objects that came and were taken, since the beginning.
    pub fn objects_taken(&self) -> u32 {
        self.objects_taken
    }

    /// The next question, to be asked now; at most one each call, so call it once a packet period. An answer may take
    /// `timeout_us`.
    pub fn poll(&mut self, now: u64, timeout_us: u64) -> Option<Ask> {
        if now >= self.manifest_us || core::mem::take(&mut self.doubt) {
            self.manifest_us =
                now.saturating_add(if self.announced.is_some() { REFRESH_US } else { timeout_us.max(1) });
            return self.ask(Topic::Manifest, 0..1);
        }
        self.announced?;
        // Once more when a round is over: what has not come in it is due again.
        for _ in 0..2 {
            if let Some(ask) = self.missing() {
                self.round_us = now.saturating_add(timeout_us);
                return Some(ask);
            }
            if self.complete || now < self.round_us {
                return None;
            }
            self.asked_regions = 0;
            self.asked_pages = PageSet::default();
            self.entries.iter_mut().for_each(|entry| entry.asked = false);
        }
        None
    }

    /// A question for these numbers, or as many of them as fit into one: [`BURST`], of the 256 from the first.
    fn ask(&self, topic: Topic, numbers: impl Iterator<Item = usize>) -> Option<Ask> {
        let mut numbers = numbers.peekable();
        let first = *numbers.peek()?;
        let number = u16::try_from(first).ok()?;
        let mut ask = Ask { topic, first: number, scope: self.scope, tag: self.tag, ..Ask::default() };
        let fitting = numbers.filter(|number| (first..first + Bits::COUNT).contains(number)).take(BURST);
        fitting.for_each(|number| ask.wanted.set(number.saturating_sub(first)));
        Some(ask)
    }

    /// A question for things that are missing and were not asked for in this round.
    fn missing(&mut self) -> Option<Ask> {
        let regions = (0..).zip(&self.regions).filter(|(_, known)| known.is_none()).map(|(number, _)| number);
        if let Some(ask) = self.ask(Topic::Region, regions.filter(|number| self.asked_regions >> number & 1 == 0)) {
            ask.numbers().for_each(|number| self.asked_regions |= 1 << number);
            return Some(ask);
        }
        let pages = (0..self.page_count()).filter(|at| !self.pages.has(*at) && !self.asked_pages.has(*at));
        if let Some(ask) = self.ask(Topic::Page, pages) {
            ask.numbers().for_each(|number| self.asked_pages.set(number));
            return Some(ask);
        }
        let missing = self.entries.iter().filter(|entry| !entry.held && !entry.asked);
        let ask = self.ask(Topic::Object, missing.map(|entry| usize::from(entry.number)))?;
        for entry in &mut self.entries {
            entry.asked |= entry.number.checked_sub(ask.first).is_some_and(|bit| ask.wanted.has(bit.into()));
        }
        Some(ask)
    }

    fn page_count(&self) -> usize {
        self.announced.map_or(0, |(_, manifest)| usize::from(manifest.objects).div_ceil(Page::OBJECTS))
    }

    /// Forgets which objects are in scope, so that they are listed anew; the objects stay.
    fn forget_listing(&mut self) {
        self.pages = PageSet::default();
        self.asked_pages = PageSet::default();
        self.entries.clear();
        self.left_out = 0;
        self.complete = false;
    }

    /// Takes in an answer.
    pub fn take(&mut self, part: &Part) -> Taken {
        let known = self.announced.is_some_and(|(world, _)| world == part.world);
        if let Payload::Manifest(manifest) = part.payload {
            if known && self.announced.is_some_and(|(_, announced)| announced == manifest) {
                return Taken::Nothing;
            }
            self.announced = Some((part.world, manifest));
            self.regions.clear();
            let _ = self.regions.resize(usize::from(manifest.regions), None);
            self.asked_regions = 0;
            self.forget_listing();
            return if self.settle() == Taken::Complete { Taken::Complete } else { Taken::World };
        }
        if !known {
            self.doubt = self.announced.is_some();
            return Taken::Nothing;
        }
        if part.tag != self.tag {
            return Taken::Nothing;
        }
        match &part.payload {
            Payload::Manifest(_) => Taken::Nothing,
            Payload::Region(record) => self.region(usize::from(part.number), record),
            Payload::Page(page) => self.page(usize::from(part.number), page),
            Payload::Object(record) => self.object(part.number, record),
        }
    }

    fn region(&mut self, number: usize, record: &[u8; Region::LEN]) -> Taken {
        let Some(place) = self.regions.get_mut(number).filter(|place| place.is_none()) else { return Taken::Nothing };
        let Ok(region) = Region::parse(record) else { return self.corrupted() };
        *place = Some(region);
        self.settle()
    }

    fn page(&mut self, number: usize, page: &Page) -> Taken {
        if number >= self.page_count() || self.pages.has(number) {
            return Taken::Nothing;
        }
        self.pages.set(number);
        for (at, checksum) in page.checksums.iter().enumerate().filter(|(at, _)| page.mask >> at & 1 == 1) {
            let Ok(number) = u16::try_from(number * Page::OBJECTS + at) else { continue };
            let held = self.held.iter().any(|held| held.checksum == *checksum);
            if self.entries.push(Entry { number, checksum: *checksum, held, asked: false }).is_err() {
                self.left_out = self.left_out.saturating_add(1);
            }
        }
        self.settle()
    }

    fn object(&mut self, number: u16, record: &[u8; Object::LEN]) -> Taken {
        let Some(at) = self.entries.iter().position(|entry| entry.number == number && !entry.held) else {
            return Taken::Nothing;
        };
        let checksum = checksum_of(record);
        let announced = self.entries.get(at).is_some_and(|entry| entry.checksum == checksum);
        let (Ok(object), true) = (Object::parse(record), announced) else { return self.corrupted() };
        self.hold(Held { object, checksum });
        if let Some(entry) = self.entries.get_mut(at) {
            entry.held = true;
        }
        self.objects_taken = self.objects_taken.saturating_add(1);
        self.settle()
    }

    /// Keeps an object; in place of the one with its id, or, where there is no room, of one that is out of scope.
    fn hold(&mut self, new: Held) {
        self.held.retain(|held| held.object.id != new.object.id);
        if self.held.is_full() {
            let entries = &self.entries;
            let listed = |held: &Held| entries.iter().any(|entry| entry.checksum == held.checksum);
            if let Some(at) = self.held.iter().position(|held| !listed(held)) {
                self.held.remove(at);
            }
        }
        let at = self.held.partition_point(|held| held.object.id < new.object.id);
        // There is room: entries and objects held have the same limit.
        let _ = self.held.insert(at, new);
    }

    fn corrupted(&mut self) -> Taken {
        self.corrupt = self.corrupt.saturating_add(1);
        Taken::Corrupt
    }

    /// Whether that was the last part that was missing.
    fn settle(&mut self) -> Taken {
        let Some((world, manifest)) = self.announced else { return Taken::Nothing };
        let pages = (0..self.page_count()).all(|page| self.pages.has(page));
        let regions = self.regions.iter().all(Option::is_some);
        if self.complete || !pages || !regions || self.entries.iter().any(|entry| !entry.held) {
            return Taken::More;
        }
        let entries = &self.entries;
        self.held.retain(|held| entries.iter().any(|entry| entry.checksum == held.checksum));
        if self.held.len() == usize::from(manifest.objects) {
            let sum = world_checksum(&manifest, self.regions.iter().flatten(), self.objects());
            if sum != Ok(world) {
                // Every record is right and the whole is not: begin anew, with nothing.
                self.held.clear();
                self.regions.iter_mut().for_each(|region| *region = None);
                self.asked_regions = 0;
                self.forget_listing();
                return self.corrupted();
            }
        }
        self.complete = true;
        Taken::Complete
    }
}
