//! MCAP (mcap.dev/spec), as much of it as a recording needs: columns of numbers over time, written in chunks, closed with a summary.
//!
//! A record is an opcode, a length of 8 bytes, and that many bytes, all little-endian. In the file stand, in this order: the header;
//! what made it (metadata); every channel with its schema; chunks of messages, each followed by an index of every channel in it; more
//! metadata; and a summary, by which programs find their way without reading all. Every chunk is handed to the system whole, so a
//! file that is cut anywhere holds whole chunks up to there. Nothing is compressed.
//!
//! A message is a row of `double`s in protobuf, whose schema (a `FileDescriptorSet`) stands in the file: PlotJuggler and Foxglove
//! read both without help. Meanings of the columns are metadata of the channel.
//!
//! The last channel is the log: what happened, in words, as messages that Foxglove and Rerun know ([`LogLine`]).
//!
//! Written here and not with the `mcap` crate (0.26), which brings ten more crates and 18 s of processor time into the first build
//! for these records; `cargo xtask test` has Python's `mcap` read them.

use std::collections::BTreeMap;
use std::io::{self, Write};

use cohold_sim::quantities::Named;

/// How every file begins and ends.
pub(super) const MAGIC: &[u8; 8] = b"\x89MCAP0\r\n";
/// Name of the schemas' file and package.
const PACKAGE: &str = "haptics";
/// Schema of the log, by which programs know it.
pub(super) const LOG: &str = "foxglove.Log";
/// Level of a fault in the log.
pub const ERROR: u8 = 4;
/// Of all else.
pub const INFO: u8 = 2;
/// The schema itself: `timestamp`, `level`, `message` and `name` of Foxglove's `Log.proto`, the double `time_s`, which is ours, as its field 15,
/// and `google.protobuf.Timestamp`. Python's protobuf reads it in a test.
const LOG_SCHEMA: &[u8] = b"\n_\n\x1fgoogle/protobuf/timestamp.proto\x12\x0fgoogle.protobuf\"+\n\x09Timestamp\x12\x0f\n\x07seconds\x18\x01 \x01(\
\x03\x12\x0d\n\x05nanos\x18\x02 \x01(\x05\n\x97\x02\n\x12foxglove/Log.proto\x12\x08foxglove\x1a\x1fgoogle/protobuf/tim\
estamp.proto\"\xd5\x01\n\x03Log\x12-\n\x09timestamp\x18\x01 \x01(\x0b2\x1a.google.protobuf.Timestamp\x12\"\n\x05level\
\x18\x02 \x01(\x0e2\x13.foxglove.Log.Level\x12\x0f\n\x07message\x18\x03 \x01(\x09\x12\x0c\n\x04name\x18\x04 \x01(\x09\
\x12\x0e\n\x06time_s\x18\x0f \x01(\x01\"L\n\x05Level\x12\x0b\n\x07UNKNOWN\x10\0\x12\x09\n\x05DEBUG\x10\x01\x12\x08\n\
\x04INFO\x10\x02\x12\x0b\n\x07WARNING\x10\x03\x12\x09\n\x05ERROR\x10\x04\x12\x09\n\x05FATAL\x10\x05";

/// What a record is.
pub(super) mod op {
    pub(crate) const HEADER: u8 = 1;
    pub(crate) const FOOTER: u8 = 2;
    pub(crate) const SCHEMA: u8 = 3;
    pub(crate) const CHANNEL: u8 = 4;
    pub(crate) const MESSAGE: u8 = 5;
    pub(crate) const CHUNK: u8 = 6;
    pub(crate) const MESSAGE_INDEX: u8 = 7;
    pub(crate) const CHUNK_INDEX: u8 = 8;
    pub(crate) const STATISTICS: u8 = 11;
    pub(crate) const METADATA: u8 = 12;
    pub(crate) const METADATA_INDEX: u8 = 13;
    pub(crate) const DATA_END: u8 = 15;
}

/// A column of a channel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Field {
    /// Its name, which ends in its unit.
    pub name: String,
    /// Meaning of the field, in words; may be empty.
    pub meaning: String,
}

/// Rows of the same columns.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    /// What programs call it: `/peer_1/ticks`.
    pub topic: String,
    /// What a row is: `Tick`.
    pub row: String,
    /// Columns of the channel.
    pub fields: Vec<Field>,
}

impl Channel {
    /// With these columns, a name and a meaning each.
    pub fn new<N: Into<String>, M: Into<String>>(
        topic: impl Into<String>,
        row: &str,
        fields: impl IntoIterator<Item = (N, M)>,
    ) -> Self {
        let field = |(name, meaning): (N, M)| Field { name: name.into(), meaning: meaning.into() };
        Self { topic: topic.into(), row: row.to_owned(), fields: fields.into_iter().map(field).collect() }
    }
}

/// Since when a recording's times count.
pub(super) const TIME: Named = ("time_s", "since the recording's clock began");

/// Something that happened, as the log says it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LogLine {
    /// Who says it: `peer 1`, `board 2`, `hub`.
    pub who: String,
    /// [`ERROR`] of a fault, which stopped whoever says it; [`INFO`] of all else.
    pub level: u8,
    /// What happened.
    pub words: String,
}

impl LogLine {
    /// What `who` says.
    pub fn new(who: &str, level: u8, words: impl Into<String>) -> Self {
        let (who, words) = (who.to_owned(), words.into());
        Self { who, level, words }
    }
}

/// The channel of the log.
pub fn log_channel() -> Channel {
    let level = ("level", "4: a fault, which stopped whoever says it; 2: else");
    let (message, name) = (("message", "what happened"), ("name", "who says it"));
    Channel::new("/log", LOG, [TIME, level, message, name])
}

/// Bytes of a record that is being made.
#[derive(Default)]
struct Bytes(Vec<u8>);

impl Bytes {
    fn raw(mut self, bytes: &[u8]) -> Self {
        self.0.extend_from_slice(bytes);
        self
    }

    fn two(self, value: u16) -> Self {
        self.raw(&value.to_le_bytes())
    }

    fn four(self, value: u32) -> Self {
        self.raw(&value.to_le_bytes())
    }

    fn eight(self, value: u64) -> Self {
        self.raw(&value.to_le_bytes())
    }

    /// With their length before them.
    fn counted(self, bytes: &[u8]) -> Self {
        self.four(bytes.len() as u32).raw(bytes)
    }

    fn text(self, text: &str) -> Self {
        self.counted(text.as_bytes())
    }

    fn map<'a>(self, entries: impl Iterator<Item = (&'a str, &'a str)>) -> Self {
        let inner = entries.fold(Self::default(), |inner, (name, value)| inner.text(name).text(value));
        self.counted(&inner.0)
    }

    /// A field of a protobuf message that is a message or a text.
    fn proto(self, number: u8, bytes: &[u8]) -> Self {
        self.raw(&[number << 3 | 2]).varint(bytes.len() as u64).raw(bytes)
    }

    fn proto_number(self, number: u8, value: u64) -> Self {
        self.raw(&[number << 3]).varint(value)
    }

    fn varint(mut self, mut value: u64) -> Self {
        while value >= 0x80 {
            self.0.push(value as u8 | 0x80);
            value >>= 7;
        }
        self.0.push(value as u8);
        self
    }

    fn record(self, opcode: u8) -> Vec<u8> {
        Self(vec![opcode]).eight(self.0.len() as u64).raw(&self.0).0
    }
}

/// The schema of a channel: one message of optional doubles (proto2, so that 0 is distinct from a missing value), in a file of its own.
fn schema(channel: &Channel) -> Vec<u8> {
    const OPTIONAL: u64 = 1;
    const DOUBLE: u64 = 1;
    let field = |message: Bytes, (number, field): (u64, &Field)| {
        let own = Bytes::default().proto(1, field.name.as_bytes()).proto_number(3, number);
        let own = own.proto_number(4, OPTIONAL).proto_number(5, DOUBLE);
        message.proto(2, &own.0)
    };
    let message = (1..).zip(&channel.fields).fold(Bytes::default().proto(1, channel.row.as_bytes()), field);
    let name = format!("{PACKAGE}/{}.proto", channel.topic.trim_start_matches('/'));
    let file = Bytes::default().proto(1, name.as_bytes()).proto(2, PACKAGE.as_bytes()).proto(4, &message.0);
    Bytes::default().proto(1, &file.0).0
}

/// One row as protobuf.
fn message(values: &[f64]) -> Vec<u8> {
    (1_u64..)
        .zip(values)
        .fold(Bytes::default(), |out, (number, value)| out.varint(number << 3 | 1).eight(value.to_bits()))
        .0
}

/// A line of the log as protobuf, with its time since the start, s.
fn log_message(time_ns: u64, time_s: f64, line: &LogLine) -> Vec<u8> {
    const SECOND: u64 = 1_000_000_000;
    let time = Bytes::default().proto_number(1, time_ns / SECOND);
    let time = time.proto_number(2, time_ns % SECOND);
    let said = Bytes::default().proto(1, &time.0).proto_number(2, line.level.into());
    let said = said.proto(3, line.words.as_bytes());
    let said = said.proto(4, line.who.as_bytes());
    said.varint(15 << 3 | 1).eight(time_s.to_bits()).0
}

/// A number of each channel.
fn of_channels(numbers: &BTreeMap<u16, u64>) -> Bytes {
    numbers.iter().fold(Bytes::default(), |out, (channel, number)| out.two(*channel).eight(*number))
}

/// A chunk that is in the file.
struct Placed {
    times: (u64, u64),
    start: u64,
    length: u64,
    /// Where the index of each channel is.
    indices: BTreeMap<u16, u64>,
    index_length: u64,
    size: u64,
}

/// Messages that are on their way into the file.
#[derive(Default)]
struct Chunk {
    records: Vec<u8>,
    times: Option<(u64, u64)>,
    /// Time and place of each message, channel by channel.
    messages: BTreeMap<u16, Vec<(u64, u64)>>,
}

/// A file that is being written.
pub(super) struct Writer<W> {
    pub(super) out: W,
    /// Bytes in the file.
    pub(super) at: u64,
    channels: Vec<Channel>,
    chunk: Chunk,
    chunks: Vec<Placed>,
    counts: BTreeMap<u16, u64>,
    metadata: Vec<(String, u64, u64)>,
    /// Lines of the log.
    lines: u32,
}

impl<W: Write> Writer<W> {
    /// Begins a file of these channels.
    pub(super) fn begin(out: W, library: &str, channels: Vec<Channel>) -> io::Result<Self> {
        let (chunk, counts) = (Chunk::default(), BTreeMap::new());
        let mut writer =
            Self { out, at: 0, channels, chunk, chunks: Vec::new(), counts, metadata: Vec::new(), lines: 0 };
        let header = Bytes::default().text("").text(library).record(op::HEADER);
        writer.put(&[MAGIC, &header[..]].concat())?;
        let channels = writer.described();
        writer.put(&channels)?;
        Ok(writer)
    }

    fn put(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.out.write_all(bytes)?;
        self.at += bytes.len() as u64;
        Ok(())
    }

    /// Bytes of all schemas and channels.
    fn described(&self) -> Vec<u8> {
        let one = |(id, channel): (u16, &Channel)| {
            let (name, schema) = match &*channel.row {
                LOG => (LOG.to_owned(), LOG_SCHEMA.to_vec()),
                row => (format!("{PACKAGE}.{row}"), schema(channel)),
            };
            let own = Bytes::default().two(id + 1).text(&name).text("protobuf").counted(&schema);
            let meanings = channel.fields.iter().filter(|field| !field.meaning.is_empty());
            let meanings = meanings.map(|field| (field.name.as_str(), field.meaning.as_str()));
            let about = Bytes::default().two(id).two(id + 1).text(&channel.topic).text("protobuf").map(meanings);
            [own.record(op::SCHEMA), about.record(op::CHANNEL)].concat()
        };
        (0..).zip(&self.channels).flat_map(one).collect()
    }

    /// Puts in named texts.
    pub(super) fn metadata<'a>(
        &mut self,
        name: &str,
        entries: impl Iterator<Item = (&'a str, &'a str)>,
    ) -> io::Result<()> {
        let record = Bytes::default().text(name).map(entries).record(op::METADATA);
        self.metadata.push((name.to_owned(), self.at, record.len() as u64));
        self.put(&record)
    }

    /// Takes a row of a channel, which goes into the file with its chunk.
    pub(super) fn row(&mut self, channel: u16, sequence: u32, time_ns: u64, values: &[f64]) {
        self.message(channel, sequence, time_ns, &message(values));
    }

    /// Takes a line of the log, which is the last channel, as well.
    pub(super) fn log(&mut self, time_ns: u64, time_s: f64, line: &LogLine) {
        let (channel, message) = (self.channels.len() as u16 - 1, log_message(time_ns, time_s, line));
        self.message(channel, self.lines, time_ns, &message);
        self.lines += 1;
    }

    fn message(&mut self, channel: u16, sequence: u32, time_ns: u64, message: &[u8]) {
        let head = Bytes::default().two(channel).four(sequence).eight(time_ns).eight(time_ns);
        let (first, last) = self.chunk.times.unwrap_or((time_ns, time_ns));
        self.chunk.times = Some((first.min(time_ns), last.max(time_ns)));
        self.chunk.messages.entry(channel).or_default().push((time_ns, self.chunk.records.len() as u64));
        self.chunk.records.extend(head.raw(message).record(op::MESSAGE));
    }

    /// Bytes that wait for [`Self::flush`].
    pub(super) fn waiting(&self) -> usize {
        self.chunk.records.len()
    }

    /// Hands what was taken to the system.
    pub(super) fn flush(&mut self) -> io::Result<()> {
        let Chunk { records, times, messages } = std::mem::take(&mut self.chunk);
        let Some(times) = times else { return Ok(()) };
        let (size, crc) = (records.len() as u64, crc32fast::hash(&records));
        let head = Bytes::default().eight(times.0).eight(times.1).eight(size).four(crc).text("").eight(size);
        let mut bytes = head.raw(&records).record(op::CHUNK);
        let (start, length) = (self.at, bytes.len() as u64);
        let mut indices = BTreeMap::new();
        for (channel, places) in &messages {
            indices.insert(*channel, start + bytes.len() as u64);
            let entries = places.iter().fold(Bytes::default(), |out, (time, at)| out.eight(*time).eight(*at));
            bytes.extend(Bytes::default().two(*channel).counted(&entries.0).record(op::MESSAGE_INDEX));
        }
        let index_length = bytes.len() as u64 - length;
        self.put(&bytes)?;
        for (channel, places) in messages {
            *self.counts.entry(channel).or_default() += places.len() as u64;
        }
        self.chunks.push(Placed { times, start, length, indices, index_length, size });
        Ok(())
    }

    /// Closes the file with its summary.
    pub(super) fn end(mut self) -> io::Result<()> {
        self.flush()?;
        self.put(&Bytes::default().four(0).record(op::DATA_END))?;
        let summary = self.at;
        let mut bytes = self.described();
        for chunk in &self.chunks {
            let places = of_channels(&chunk.indices);
            let record =
                Bytes::default().eight(chunk.times.0).eight(chunk.times.1).eight(chunk.start).eight(chunk.length);
            let record =
                record.counted(&places.0).eight(chunk.index_length).text("").eight(chunk.size).eight(chunk.size);
            bytes.extend(record.record(op::CHUNK_INDEX));
        }
        for (name, at, length) in &self.metadata {
            bytes.extend(Bytes::default().eight(*at).eight(*length).text(name).record(op::METADATA_INDEX));
        }
        let first = self.chunks.iter().map(|chunk| chunk.times.0).min().unwrap_or(0);
        let last = self.chunks.iter().map(|chunk| chunk.times.1).max().unwrap_or(0);
        let channels = self.channels.len();
        let counts = of_channels(&self.counts);
        let statistics = Bytes::default().eight(self.counts.values().sum()).two(channels as u16).four(channels as u32);
        let statistics = statistics.four(0).four(self.metadata.len() as u32).four(self.chunks.len() as u32);
        bytes.extend(statistics.eight(first).eight(last).counted(&counts.0).record(op::STATISTICS));
        // Without an index of the summary and without its checksum: both may be left out.
        bytes.extend(Bytes::default().eight(summary).eight(0).four(0).record(op::FOOTER));
        bytes.extend(MAGIC);
        self.put(&bytes)
    }
}
