//! The store: what a board keeps in flash, so that a power cut at any instant leaves the old or the new, whole.
//!
//! A record is what a person would type: one line `key value` for every key, so that an image with more, fewer or other
//! keys reads it for what it says. A key that is not known any more, or a value that is not allowed any more, spoils the
//! record: better the defaults, said aloud, than half of what somebody chose. Keys that are new take their default.
//!
//! | word | holds |
//! |---|---|
//! | 0 | magic, format (1), generation, length of the text in bytes, CRC-32 of text and these: 5 × u32, little-endian |
//! | 1… | the text, filled up with zeros |
//!
//! Records stand in slots of 8 kB, 16 in each of two sectors, and none is ever written over. The text is programmed
//! first, word 0 last: only then the record exists. The newest sound one counts. When its sector is full the other one
//! is erased and takes the next; the erase touches nothing that counts. A sector without a sound record is erased before
//! it is used, however blank it looks: an erase that was cut short looks so too.
//!
//! **Limits**: a flash word can be programmed once between erases; one that a power cut caught half-way may read as
//! anything or not at all ([`Medium::read`] gives `None`). 10,000 erases a sector are 320,000 saves.

use core::fmt::{self, Write};

use heapless::String;

use crate::kept::Kept;
use cohold_core::settings::Value;

/// The unit in which flash is programmed, 32 bytes.
pub type Word = [u8; 32];
const BYTES: usize = size_of::<Word>();
/// Words in a slot.
const SLOT: u32 = 256;
/// Slots in a sector.
const SLOTS: u32 = 16;
/// Words in a sector: 128 kB.
pub const SECTOR: u32 = SLOT * SLOTS;
const MAGIC: u32 = 0x5370_6148;
const FORMAT: u32 = 1;
const LINE: usize = 96;

/// The two sectors, as words from 0 to 2·[`SECTOR`].
#[allow(async_fn_in_trait)] // One thread, one executor: nobody asks whether the future is Send.
pub trait Medium {
    /// A word; `None` if its bits are lost.
    fn read(&self, at: u32) -> Option<Word>;
    /// Programs a word that is blank.
    fn program(&mut self, at: u32, word: &Word) -> Result<(), Broken>;
    /// Makes sector 0 or 1 blank; takes seconds.
    async fn erase(&mut self, sector: u32) -> Result<(), Broken>;
}

/// The flash does not take what it is given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Broken;

/// Why a record is not taken.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unreadable {
    /// The first line that means nothing.
    pub line: String<LINE>,
    /// A line before it says that there is a hold-to-run switch.
    pub hold_switch: bool,
}

/// The records that flash holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Store {
    /// Slot and generation of the newest.
    newest: Option<(u32, u32)>,
    /// A blank slot behind it.
    free: Option<u32>,
}

struct Header {
    generation: u32,
    length: u32,
    crc: u32,
}

impl Header {
    /// Word 0 of a record.
    fn emit(&self) -> Word {
        let mut word = [0; BYTES];
        let fields = [MAGIC, FORMAT, self.generation, self.length, self.crc];
        for (bytes, field) in word.chunks_exact_mut(4).zip(fields) {
            bytes.copy_from_slice(&field.to_le_bytes());
        }
        word
    }

    fn parse(word: &Word) -> Option<Self> {
        let [magic, format, generation, length, crc, rest @ ..]: [u32; BYTES / 4] =
            core::array::from_fn(|at| word.as_chunks().0.get(at).map_or(0, |bytes| u32::from_le_bytes(*bytes)));
        let fits = length.div_ceil(BYTES as u32) < SLOT;
        (magic == MAGIC && format == FORMAT && fits && rest == [0; 3]).then_some(Self { generation, length, crc })
    }

    fn sealed(self, text: Crc) -> Self {
        let crc = [MAGIC, FORMAT, self.generation, self.length]
            .into_iter()
            .flat_map(u32::to_le_bytes)
            .fold(text, Crc::with)
            .value();
        Self { crc, ..self }
    }
}

/// CRC-32 (ISO-HDLC), as zip computes it.
#[derive(Clone, Copy)]
struct Crc(u32);

impl Crc {
    const START: Self = Self(u32::MAX);

    fn with(self, byte: u8) -> Self {
        Self((0..8).fold(self.0 ^ u32::from(byte), |crc, _| crc >> 1 ^ if crc & 1 == 1 { 0xEDB8_8320 } else { 0 }))
    }

    fn value(self) -> u32 {
        !self.0
    }
}

/// The text of a record, byte by byte; `None` where it is lost.
fn text(medium: &impl Medium, slot: u32, length: u32) -> impl Iterator<Item = Option<u8>> {
    let words = (0..length.div_ceil(BYTES as u32)).map(move |nth| medium.read(slot * SLOT + 1 + nth));
    words.flat_map(|word| (0..BYTES).map(move |at| word.and_then(|word| word.get(at).copied()))).take(length as usize)
}

/// The generation of a slot's record, if it is sound.
fn sound(medium: &impl Medium, slot: u32) -> Option<u32> {
    let header = Header::parse(&medium.read(slot * SLOT)?)?;
    let crc = text(medium, slot, header.length).try_fold(Crc::START, |crc, byte| Some(crc.with(byte?)))?;
    (Header { crc: 0, ..header }.sealed(crc).crc == header.crc).then_some(header.generation)
}

fn blank(medium: &impl Medium, slot: u32) -> bool {
    (slot * SLOT..(slot + 1) * SLOT).all(|at| medium.read(at) == Some([0xFF; BYTES]))
}

/// The first blank slot from `slot` to the end of its sector.
fn blank_from(medium: &impl Medium, slot: u32, sector: u32) -> Option<u32> {
    (slot..(sector + 1) * SLOTS).find(|slot| blank(medium, *slot))
}

/// Writes text into flash words as it comes.
struct Pen<'m, M> {
    medium: &'m mut M,
    slot: u32,
    word: Word,
    length: u32,
    crc: Crc,
}

impl<M: Medium> Pen<'_, M> {
    fn put(&mut self, byte: u8) -> Result<(), Broken> {
        let at = self.length as usize % BYTES;
        self.word[at] = byte;
        self.length += 1;
        self.crc = self.crc.with(byte);
        if at + 1 == BYTES { self.flush() } else { Ok(()) }
    }

    /// Programs the word that `length` has reached into.
    fn flush(&mut self) -> Result<(), Broken> {
        let nth = self.length.div_ceil(BYTES as u32);
        if nth >= SLOT {
            return Err(Broken);
        }
        self.medium.program(self.slot * SLOT + nth, &self.word)?;
        self.word = [0; BYTES];
        Ok(())
    }
}

impl<M: Medium> Write for Pen<'_, M> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        text.bytes().try_for_each(|byte| self.put(byte)).map_err(|Broken| fmt::Error)
    }
}

fn write<M: Medium>(medium: &mut M, slot: u32, generation: u32, kept: &Kept) -> Result<(), Broken> {
    let mut pen = Pen { medium, slot, word: [0; BYTES], length: 0, crc: Crc::START };
    for key in Kept::keys() {
        if let Some(value) = kept.get(key) {
            writeln!(pen, "{key} {value}").map_err(|fmt::Error| Broken)?;
        }
    }
    if !(pen.length as usize).is_multiple_of(BYTES) {
        pen.flush()?;
    }
    let header = Header { generation, length: pen.length, crc: 0 }.sealed(pen.crc);
    pen.medium.program(slot * SLOT, &header.emit())
}

impl Store {
    /// Looks through both sectors.
    pub fn open(medium: &impl Medium) -> Self {
        let header = |slot: u32| Header::parse(&medium.read(slot * SLOT)?).map(|header| (header.generation, slot));
        let mut below = None;
        // The newest first: as a rule it is sound, and no other is read.
        while let Some((generation, slot)) =
            (0..2 * SLOTS).filter_map(header).filter(|found| below.is_none_or(|below| *found < below)).max()
        {
            if sound(medium, slot) == Some(generation) {
                let free = blank_from(medium, slot + 1, slot / SLOTS);
                return Self { newest: Some((slot, generation)), free };
            }
            below = Some((generation, slot));
        }
        Self::default()
    }

    /// How often something was saved; 0: there is nothing.
    pub fn generation(&self) -> u32 {
        self.newest.map_or(0, |(_, generation)| generation)
    }

    /// What was saved last, `None` if nothing was.
    /// An error is the first line that means nothing to this image.
    pub fn load(&self, medium: &impl Medium) -> Option<Result<Kept, Unreadable>> {
        let (slot, _) = self.newest?;
        let length = Header::parse(&medium.read(slot * SLOT)?)?.length;
        let (mut kept, mut line) = (Kept::default(), String::<LINE>::new());
        for byte in text(medium, slot, length) {
            match byte {
                Some(b'\n') => {
                    let set = line.split_once(' ').map(|(key, value)| kept.set(key, Value::of_text(value)));
                    if !matches!(set, Some(Ok(()))) {
                        return Some(Err(Unreadable { line, hold_switch: kept.hold_switch }));
                    }
                    line.clear();
                }
                Some(byte) if line.push(byte.into()).is_ok() => {}
                _ => return Some(Err(Unreadable { line, hold_switch: kept.hold_switch })),
            }
        }
        Some(Ok(kept))
    }

    /// Saves, and gives the generation. Tries a second slot where the first does not take.
    /// Where neither does, what was saved before stands.
    pub async fn save(&mut self, medium: &mut impl Medium, kept: &Kept) -> Result<u32, Broken> {
        let generation = self.generation() + 1;
        for _ in 0..2 {
            let slot = match self.free {
                Some(slot) => slot,
                None => {
                    let other = self.newest.map_or(0, |(slot, _)| 1 - slot / SLOTS);
                    medium.erase(other).await?;
                    other * SLOTS
                }
            };
            let written = write(medium, slot, generation, kept).is_ok() && sound(medium, slot) == Some(generation);
            self.free = blank_from(medium, slot + 1, slot / SLOTS);
            if written {
                self.newest = Some((slot, generation));
                return Ok(generation);
            }
        }
        // Whatever is wrong there: the next time begins with an erase.
        self.free = None;
        Err(Broken)
    }
}
