//! Reads a recording, whole or cut.
//!
//! Read from the front, record by record, so that no summary is needed: a file that was cut gives everything up to the last whole
//! message, and [`Recording::cut`] says where that was. What a chunk holds whose checksum is another is not taken:
//! [`Recording::damaged`] counts these. Of other MCAP files it reads what it writes itself: protobuf messages of doubles, chunks
//! without compression.
//!
//! **Bounds**, for a file may be anybody's: what is kept of it is no larger than the file. A row has every number of its channel, a
//! channel at most [`MOST_COLUMNS`] of them, with short names; and there are at most [`MOST_CHANNELS`], [`MOST_NUMBERS`] in all,
//! and [`MOST_TEXT`] of anything else.

use std::collections::BTreeMap;
use std::io::{BufReader, Read};
use std::path::Path;

use cohold_report::{Column, Columns};
use cohold_sim::quantities::Named;

use super::mcap::{Channel, INFO, LOG, LogLine, MAGIC, op};
use super::origin::Origin;
use super::recorder::MOST_COLUMNS;
use crate::Error;

/// Column that every row of a converted table begins with.
pub const ROW: Named = ("row", "number of the row, from 0; one that is left out was lost while it was recorded");

/// Most channels of a recording.
pub const MOST_CHANNELS: usize = 64;
/// Most numbers in all rows of a recording: of two peers, three hours at 1 kHz.
pub const MOST_NUMBERS: u64 = 1 << 29;
/// Longest record of a recording, and most of what is no row, bytes.
pub const MOST_TEXT: u64 = 1 << 24;
/// Longest name of a channel or a column, bytes.
const LONGEST_NAME: usize = 128;

/// A recording read from its file.
#[derive(Clone, Debug)]
pub struct Recording {
    /// Program, settings and clock that made the recording.
    pub origin: Origin,
    /// Its channels, as they stand in the file.
    pub channels: Vec<Rows>,
    /// Rows that were lost while it was recorded, by the recorder's own account; `None` where that is missing.
    pub lost: Option<u64>,
    /// Chunks that were left out, for their rows are not those that were written: their checksum is another.
    pub damaged: u64,
    /// The damage at its end; none in a whole file.
    pub cut: Option<Cut>,
}

/// A file that ends too early.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cut {
    /// Bytes of whole records.
    pub whole: u64,
    /// Bytes after the whole records.
    pub rest: u64,
    /// Rows that were saved out of the chunk that is not whole.
    pub saved: u64,
}

impl Recording {
    /// What happened, and when that was recorded, ns of Unix time.
    pub fn log(&self) -> impl Iterator<Item = (u64, &LogLine)> {
        self.channels.iter().flat_map(|rows| rows.times_ns.iter().copied().zip(&rows.lines))
    }
}

impl Cut {
    /// The damage in words, for a person.
    pub fn summary(&self) -> String {
        let Self { whole, rest, saved } = self;
        let kept = if *saved > 0 { format!(", of which {saved} rows were saved") } else { String::new() };
        format!("the recording was cut: it has no end, and {rest} bytes after byte {whole} are no whole record{kept}")
    }
}

/// The rows of a channel.
#[derive(Clone, Debug, Default)]
pub struct Rows {
    /// Name of the channel.
    pub topic: String,
    /// What a row is: `Tick`.
    pub row: String,
    /// Names of the columns, which end in their units.
    pub names: Vec<String>,
    meanings: BTreeMap<String, String>,
    /// Field numbers of the columns.
    numbers: Vec<u64>,
    /// The number of each row, from 0: one that is left out was lost while it was recorded.
    pub sequences: Vec<f64>,
    /// When each was recorded, ns of Unix time.
    pub times_ns: Vec<u64>,
    columns: Vec<Vec<f64>>,
    /// What a log says beside its times.
    lines: Vec<LogLine>,
}

impl Rows {
    /// The values of a column.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        self.names.iter().position(|known| known == name).map(|at| self.columns[at].as_slice())
    }

    /// What a column means; empty where nobody said.
    pub fn meaning(&self, name: &str) -> &str {
        self.meanings.get(name).map_or("", String::as_str)
    }

    /// As a channel that another recording may have.
    pub fn channel(&self) -> Channel {
        let fields = self.names.iter().map(|name| (name.as_str(), self.meaning(name)));
        Channel::new(self.topic.as_str(), &self.row, fields)
    }

    /// The numbers of a row.
    pub fn values(&self, row: usize) -> impl Iterator<Item = f64> {
        self.columns.iter().map(move |column| column[row])
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.times_ns.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.times_ns.is_empty()
    }

    /// As a table: the number of each row, and its values.
    pub fn table(&self) -> Columns {
        let mut table = Columns::default();
        table.push(Column::numbers(ROW.0, ROW.1, self.sequences.clone()));
        for (name, values) in self.names.iter().zip(&self.columns) {
            table.push(Column::numbers(name.as_str(), self.meaning(name), values.clone()));
        }
        if self.row == LOG {
            let lines = Columns::of(&self.lines).value("level", |line| line.level).means(self.meaning("level"));
            let lines = lines.value("message", |line| line.words.as_str()).means(self.meaning("message"));
            let lines = lines.value("name", |line| line.who.as_str()).means(self.meaning("name"));
            lines.done().into_iter().for_each(|column| table.push(column));
        }
        table
    }
}

/// Takes bytes apart from the front; `None` where they end too early.
#[derive(Clone, Copy)]
struct Parse<'a>(&'a [u8]);

impl<'a> Parse<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(taken)
    }

    fn number<const N: usize>(&mut self) -> Option<u64> {
        let mut bytes = [0; 8];
        bytes[..N].copy_from_slice(self.take(N)?);
        Some(u64::from_le_bytes(bytes))
    }

    fn counted(&mut self) -> Option<&'a [u8]> {
        let count = self.number::<4>()?;
        self.take(usize::try_from(count).ok()?)
    }

    fn text(&mut self) -> Option<String> {
        self.counted().map(|bytes| String::from_utf8_lossy(bytes).into_owned())
    }

    fn map(&mut self) -> Option<BTreeMap<String, String>> {
        let mut inner = Self(self.counted()?);
        let mut map = BTreeMap::new();
        while !inner.0.is_empty() {
            map.insert(inner.text()?, inner.text()?);
        }
        Some(map)
    }

    /// Opcode and content of the next record.
    fn record(&mut self) -> Option<(u8, Self)> {
        let mut ahead = *self;
        let (opcode, length) = (ahead.number::<1>()? as u8, ahead.number::<8>()?);
        let content = ahead.take(usize::try_from(length).ok()?)?;
        *self = ahead;
        Some((opcode, Self(content)))
    }

    fn varint(&mut self) -> Option<u64> {
        let mut value = 0_u64;
        for shift in (0..64).step_by(7) {
            let byte = self.number::<1>()?;
            value |= (byte & 0x7f) << shift;
            if byte < 0x80 {
                return Some(value);
            }
        }
        None
    }

    /// The next field of a protobuf message: its number, and its value as bytes and as a number.
    fn field(&mut self) -> Option<(u64, &'a [u8], u64)> {
        let key = self.varint()?;
        let none = &self.0[..0];
        let (bytes, number) = match key & 7 {
            0 => (none, self.varint()?),
            1 => (none, self.number::<8>()?),
            2 => {
                let count = self.varint()?;
                (self.take(usize::try_from(count).ok()?)?, 0)
            }
            5 => (none, self.number::<4>()?),
            _ => return None,
        };
        Some((key >> 3, bytes, number))
    }

    /// All of them with this number.
    fn fields(self, wanted: u64) -> impl Iterator<Item = (&'a [u8], u64)> {
        let mut rest = self;
        std::iter::from_fn(move || rest.field()).filter(move |(number, ..)| *number == wanted).map(|(_, b, n)| (b, n))
    }

    /// The first of them that is a message or a text.
    fn inner(self, wanted: u64) -> Option<Self> {
        self.fields(wanted).next().map(|(bytes, _)| Self(bytes))
    }
}

/// Numbers and names of the doubles in the message of a `FileDescriptorSet` that is called so.
fn doubles(set: Parse<'_>, name: &str) -> Option<Vec<(u64, String)>> {
    const DOUBLE: u64 = 1;
    let last = name.rsplit('.').next()?;
    let called = |message: &Parse<'_>| message.inner(1).is_some_and(|own| own.0 == last.as_bytes());
    let mut messages = set.fields(1).flat_map(|(file, _)| Parse(file).fields(4)).map(|(message, _)| Parse(message));
    let fields = messages.find(called)?.fields(2).map(|(field, _)| Parse(field));
    let is_double = |field: &Parse<'_>| field.fields(5).next().is_some_and(|(_, kind)| kind == DOUBLE);
    let column =
        |field: Parse<'_>| Some((field.fields(3).next()?.1, String::from_utf8_lossy(field.inner(1)?.0).into_owned()));
    fields.filter(is_double).map(column).collect()
}

/// What was read so far.
#[derive(Default)]
struct Reading {
    /// What a row of each schema is, and its columns.
    schemas: BTreeMap<u64, (String, Vec<(u64, String)>)>,
    channels: BTreeMap<u64, Rows>,
    facts: BTreeMap<String, BTreeMap<String, String>>,
    rows: u64,
    numbers: u64,
    /// Bytes of what is no row.
    text: u64,
    damaged: u64,
    ended: bool,
}

impl Reading {
    /// Takes in a record; an error is a file that nobody here has written, `None` one that is broken.
    fn take(&mut self, opcode: u8, mut content: Parse<'_>) -> Result<Option<()>, Error> {
        if matches!(opcode, op::SCHEMA | op::CHANNEL | op::METADATA) {
            self.text += content.0.len() as u64;
            bounded("bytes that are no rows", self.text, MOST_TEXT)?;
        }
        match opcode {
            op::SCHEMA => {
                let (Some(id), Some(name), Some(encoding)) = (content.number::<2>(), content.text(), content.text())
                else {
                    return Ok(None);
                };
                cohold_sim::refuse_if!(
                    encoding != "protobuf",
                    "schema {name} is in {encoding}: only protobuf is read here"
                );
                let Some(columns) = content.counted().and_then(|set| doubles(Parse(set), &name)) else {
                    return Ok(None);
                };
                bounded("columns in a channel", columns.len() as u64, MOST_COLUMNS as u64)?;
                for (_, column) in &columns {
                    bounded("bytes in the name of a column", column.len() as u64, LONGEST_NAME as u64)?;
                }
                let last = name.rsplit('.').next().filter(|_| name != LOG);
                let row = last.unwrap_or(&name).to_owned();
                self.schemas.insert(id, (row, columns));
            }
            op::CHANNEL => {
                let taken = self.channel(content);
                bounded("channels", self.channels.len() as u64, MOST_CHANNELS as u64)?;
                return Ok(taken);
            }
            op::MESSAGE => {
                let taken = self.message(content);
                bounded("numbers", self.numbers, MOST_NUMBERS)?;
                bounded("bytes that are no rows", self.text, MOST_TEXT)?;
                return Ok(taken);
            }
            op::METADATA => {
                let (Some(name), Some(facts)) = (content.text(), content.map()) else { return Ok(None) };
                self.facts.insert(name, facts);
            }
            op::FOOTER => self.ended = true,
            _ => {}
        }
        Ok(Some(()))
    }

    fn channel(&mut self, mut content: Parse<'_>) -> Option<()> {
        let (id, schema) = (content.number::<2>()?, content.number::<2>()?);
        let (topic, _, meanings) = (content.text()?, content.text()?, content.map()?);
        let (row, columns) = self.schemas.get(&schema)?;
        let (row, (numbers, names)): (_, (Vec<_>, Vec<_>)) = (row.clone(), columns.iter().cloned().unzip());
        let columns = vec![Vec::new(); names.len()];
        // It stands in the summary once more.
        let new = Rows { topic, row, names, meanings, numbers, columns, ..Rows::default() };
        self.channels.entry(id).or_insert(new);
        Some(())
    }

    fn message(&mut self, mut content: Parse<'_>) -> Option<()> {
        let (id, sequence, time_ns) = (content.number::<2>()?, content.number::<4>()?, content.number::<8>()?);
        content.number::<8>()?;
        let rows = self.channels.get_mut(&id)?;
        let said = content;
        let mut values = [None; MOST_COLUMNS];
        while let Some((number, _, bits)) = content.field() {
            if let Some(at) = rows.numbers.iter().position(|known| *known == number) {
                values[at] = Some(f64::from_bits(bits));
            }
        }
        // All of them, or it is none of ours.
        let values: Vec<f64> = values[..rows.columns.len()].iter().copied().collect::<Option<_>>()?;
        rows.columns.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
        if rows.row == LOG {
            let text = |number| said.inner(number).map_or(&[][..], |text| text.0);
            let [who, words] = [4, 3].map(|number| String::from_utf8_lossy(text(number)));
            let level = said.fields(2).next().map_or(INFO, |(_, level)| level as u8);
            rows.lines.push(LogLine::new(&who, level, words));
            // A line takes room beside its words.
            self.text += (size_of::<LogLine>() + said.0.len()) as u64;
        }
        self.numbers += rows.columns.len() as u64 + 2;
        rows.sequences.push(sequence as f64);
        rows.times_ns.push(time_ns);
        self.rows += 1;
        Some(())
    }

    /// The records in a chunk: as far as they are there, if it is not whole.
    fn chunk(&mut self, mut content: Parse<'_>, whole: bool) -> Result<Option<()>, Error> {
        let head = (|| {
            content.take(8 + 8 + 8)?;
            Some((content.number::<4>()?, content.text()?, content.number::<8>()?))
        })();
        let Some((checksum, compression, size)) = head else { return Ok(None) };
        cohold_sim::refuse_if!(
            !compression.is_empty(),
            "its chunks are compressed ({compression}): they are read here as they are written here, as they are"
        );
        // A checksum of 0 is none.
        let is_other = || checksum != 0 && u64::from(crc32fast::hash(content.0)) != checksum;
        if whole && (size != content.0.len() as u64 || is_other()) {
            self.damaged += 1;
            return Ok(Some(()));
        }
        while let Some((opcode, record)) = content.record() {
            if self.take(opcode, record)?.is_none() {
                return Ok(None);
            }
        }
        Ok(content.0.is_empty().then_some(()))
    }
}

/// There are not more of these than there may be.
fn bounded(what: &str, there: u64, most: u64) -> Result<(), Error> {
    if there <= most {
        return Ok(());
    }
    Err(Error::Refused(format!("it has more than {most} {what}, which no recording has")))
}

/// Reads a recording, whole or cut.
///
/// # Errors
/// The file cannot be read, is no recording, or holds more than one may.
pub fn read(path: &Path) -> Result<Recording, Error> {
    let place = path.display();
    let failed = cohold_sim::Error::cannot::<std::io::Error>("read", &place);
    let file = cohold_io::open(path).map_err(&failed)?;
    let size = file.metadata().map_err(&failed)?.len();
    read_from(BufReader::new(file), size).map_err(|why| match why {
        Error::Refused(why) => Error::Refused(format!("{place}: {why}")),
        why => why,
    })
}

/// [`read`] of so many bytes.
///
/// # Errors
/// They cannot be read, are no recording, or hold more than one may.
pub fn read_from(mut file: impl Read, size: u64) -> Result<Recording, Error> {
    let failed = cohold_sim::Error::cannot::<std::io::Error>("read", &"a recording");
    let mut magic = [0; MAGIC.len()];
    let begins = file.read_exact(&mut magic).is_ok() && magic == *MAGIC;
    cohold_sim::refuse_if!(!begins, "this is no recording: it does not begin as an MCAP file does");
    let (mut reading, mut at, mut saved, mut content) = (Reading::default(), MAGIC.len() as u64, 0, Vec::new());
    while !reading.ended {
        let mut head = [0; 9];
        if file.read_exact(&mut head).is_err() {
            break;
        }
        let mut parse = Parse(&head[1..]);
        let length = parse.number::<8>().unwrap_or(0);
        let there = length.min(size.saturating_sub(at + 9));
        bounded("bytes in a record", there, MOST_TEXT)?;
        content.clear();
        file.by_ref().take(there).read_to_end(&mut content).map_err(&failed)?;
        let before = reading.rows;
        let taken = match head[0] {
            op::CHUNK => reading.chunk(Parse(&content), there == length),
            _ if there < length => Ok(None),
            opcode => reading.take(opcode, Parse(&content)),
        };
        if taken?.is_none() || there < length {
            saved = reading.rows - before;
            break;
        }
        at += 9 + length;
    }
    let cut = (!reading.ended).then_some(Cut { whole: at, rest: size.saturating_sub(at), saved });
    let fact = |of: &str, name: &str| reading.facts.get(of).and_then(|facts| facts.get(name)).cloned();
    let origin = Origin::of_facts(|name| fact("recording", name).unwrap_or_default());
    let lost = fact("end", "lost").and_then(|lost| lost.parse().ok());
    Ok(Recording { origin, channels: reading.channels.into_values().collect(), lost, damaged: reading.damaged, cut })
}

#[cfg(test)]
#[path = "../../tests/inside/recording_file.rs"]
mod tests;
