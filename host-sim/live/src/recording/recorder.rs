//! A recorder: rows go into a queue, a thread of its own writes them.
//!
//! **The beat never waits**: [`Recorder::put`] copies a row into a queue of 8192 places, and one that finds it full is counted
//! and gone; its number is left out in the file, so that the gap is seen. **Complete**: at least every quarter of a second what has come is a
//! chunk of its own that the system has: an end by signal, by SIGKILL or by a full disk costs no more than that. It is not forced onto
//! the disk: a machine that loses its power loses what its system had not written.
//!
//! **The log.** Whoever records says what happens ([`Recorder::log`]), every change of a peer's mode among it ([`Recorder::log_mode`]). At most
//! 1,000 lines at once and one a second go into the file: somebody on the network may cause them. Others are counted as lost.
//!
//! **A disk that is full** ends the recording, not the run: what is not whole is cut off, and the file says what is missing.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, Sender, SyncSender, TryRecvError, channel, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crate::allowance::Allowance;
use cohold_core::safety::Fault;
use cohold_sim::device::DeviceFault;

use super::mcap::{Channel, ERROR, INFO, LogLine, Writer, log_channel};
use super::origin::Origin;
use crate::Error;

/// Rows that may wait: seconds of two peers at 1 kHz.
const QUEUE: usize = 8192;
/// Longest that a row waits for its chunk.
const EVERY: Duration = Duration::from_millis(250);
/// Largest chunk of rows, bytes.
const LARGEST: usize = 1 << 17;
/// How often the thread looks for rows: nobody wakes it, for that would take the beat's time.
const LOOK: Duration = Duration::from_millis(10);
/// Lines of the log that are taken each second, and at once.
const LINES: [f64; 2] = [1.0, 1000.0];
/// Most columns of a channel.
pub const MOST_COLUMNS: usize = 64;

/// One row on its way.
struct Row {
    channel: u16,
    sequence: u32,
    time_ns: u64,
    count: usize,
    values: [f64; MOST_COLUMNS],
}

/// What became of a recording.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Ended {
    /// Path of the file.
    pub file: PathBuf,
    /// Number of rows in the file.
    pub rows: u64,
    /// Rows that are not, because they came quicker than they could be written, or after an error.
    pub lost: u64,
    /// Why it ended early.
    pub failed: Option<String>,
}

impl Ended {
    /// What there is to say of it, in a line.
    pub fn summary(&self) -> String {
        let failed = self.failed.as_ref().map_or(String::new(), |why| format!("; {why}"));
        let lost = if self.lost > 0 { format!(", {} rows are missing", self.lost) } else { String::new() };
        format!("recorded {} rows in {}{lost}{failed}", self.rows, self.file.display())
    }
}

/// Writes rows to a file until it is dropped.
#[derive(Debug)]
pub struct Recorder {
    queue: Option<SyncSender<Row>>,
    lines: Sender<(u64, u64, LogLine)>,
    sequences: Vec<AtomicU32>,
    /// Whose recording it is.
    pub who: String,
    start_unix_ns: u64,
    newest_ns: AtomicU64,
    lost: Arc<AtomicU64>,
    thread: Option<JoinHandle<Ended>>,
}

impl Recorder {
    /// Begins a recording of these channels in a file that is not there yet.
    ///
    /// # Errors
    /// The file exists or cannot be written.
    pub fn create(path: &Path, origin: &Origin, mut channels: Vec<Channel>) -> Result<Self, Error> {
        if let Some(wide) = channels.iter().find(|channel| channel.fields.len() > MOST_COLUMNS) {
            let count = wide.fields.len();
            return Err(format!("{} has {count} columns: a recording has at most {MOST_COLUMNS}", wide.topic).into());
        }
        let failed = |cause: io::Error| match cause.kind() {
            io::ErrorKind::AlreadyExists => {
                Error::from(format!("{} exists: a recording is never written over another file", path.display()))
            }
            _ => cohold_sim::Error::cannot("write", &path.display())(cause).into(),
        };
        let file = cohold_io::begin(path).map_err(failed)?;
        let sequences = channels.iter().map(|_| AtomicU32::new(0)).collect();
        channels.push(log_channel());
        let mut writer = Writer::begin(file, &format!("cohold {}", origin.version), channels).map_err(failed)?;
        writer
            .metadata("recording", origin.facts().iter().map(|(name, text)| (*name, text.as_str())))
            .map_err(failed)?;
        let ((queue, rows), (lines, said)) = (sync_channel(QUEUE), channel());
        let lost = Arc::new(AtomicU64::new(0));
        let own = (path.to_owned(), lost.clone());
        let thread =
            std::thread::Builder::new().name("recorder".to_owned()).spawn(move || write(writer, &rows, &said, own));
        let thread = Some(thread.map_err(failed)?);
        let (who, start_unix_ns) = (origin.who.clone(), origin.start_unix_ns);
        Ok(Self {
            queue: Some(queue),
            lines,
            sequences,
            newest_ns: AtomicU64::new(0),
            who,
            start_unix_ns,
            lost,
            thread,
        })
    }

    /// Time of the newest row, ns after the start.
    pub fn now_ns(&self) -> u64 {
        self.newest_ns.load(Ordering::Relaxed)
    }

    /// Records what happened, `time_ns` after the start; [`ERROR`] if it stopped whose recording this is, or else [`INFO`]. Never waits.
    pub fn log(&self, time_ns: u64, level: u8, words: impl Into<String>) {
        self.log_line(time_ns, LogLine::new(&self.who, level, words));
    }

    /// [`Recorder::log`] of a line that somebody else says.
    pub fn log_line(&self, time_ns: u64, line: LogLine) {
        // A recording that has ended takes no more.
        let _ = self.lines.send((self.start_unix_ns, time_ns, line));
    }

    /// [`Recorder::log`] of the mode and the fault of `who` `now`, unless they are the `last` ones or not known.
    pub fn log_mode(&self, time_ns: u64, who: &str, last: &mut [f64; 2], now: [f64; 2]) {
        if now.iter().all(|number| number.is_finite()) && std::mem::replace(last, now) != now {
            let level = if now[1] > 0.0 { ERROR } else { INFO };
            self.log_line(time_ns, LogLine::new(who, level, mode_words(now.map(|number| number as u8))));
        }
    }

    fn row(&self, channel: u16, time_ns: u64, values: &[f64]) -> Row {
        let sequence = self.sequences[usize::from(channel)].fetch_add(1, Ordering::Relaxed);
        self.newest_ns.store(time_ns, Ordering::Relaxed);
        let (mut kept, count) = ([0.0; MOST_COLUMNS], values.len().min(MOST_COLUMNS));
        kept[..count].copy_from_slice(&values[..count]);
        Row { channel, sequence, time_ns: self.start_unix_ns + time_ns, count, values: kept }
    }

    /// Records a row of a channel, `time_ns` after the start. Never waits.
    pub fn put(&self, channel: u16, time_ns: u64, values: &[f64]) {
        if let Some(queue) = &self.queue
            && queue.try_send(self.row(channel, time_ns, values)).is_err()
        {
            self.lost.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// [`Recorder::put`] for a caller that no clock drives: waits for room in the queue.
    pub fn put_all(&self, channel: u16, time_ns: u64, values: &[f64]) {
        if let Some(queue) = &self.queue
            && queue.send(self.row(channel, time_ns, values)).is_err()
        {
            self.lost.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Writes what has come and closes the file.
    pub fn finish(mut self) -> Ended {
        self.close().unwrap_or_default()
    }

    fn close(&mut self) -> Option<Ended> {
        self.queue = None;
        self.thread.take().and_then(|thread| thread.join().ok())
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        self.close();
    }
}

/// A mode and a fault by their numbers, in words.
pub(crate) fn mode_words([mode, fault]: [u8; 2]) -> String {
    let of_device = DeviceFault::from_number(fault).map(DeviceFault::explain);
    let why = Fault::from_number(fault).map(Fault::explain).or(of_device);
    let names = ["disarmed", "armed", "faulted", "probing"];
    let name = || names[usize::from(mode.min(3))].to_owned();
    why.map_or_else(name, |why| format!("fault {fault}: {why}"))
}

/// Writes rows until nobody gives any more, or the file takes no more.
fn write(
    mut writer: Writer<File>,
    rows: &Receiver<Row>,
    lines: &Receiver<(u64, u64, LogLine)>,
    (file, lost): (PathBuf, Arc<AtomicU64>),
) -> Ended {
    let mut allowance = Allowance::new(LINES[1], Instant::now());
    let (mut written, mut waiting, mut flushed, mut failed) = (0, 0, Instant::now(), None::<String>);
    loop {
        let open = match rows.try_recv() {
            Ok(row) => {
                writer.row(row.channel, row.sequence, row.time_ns, &row.values[..row.count]);
                waiting += 1;
                true
            }
            Err(TryRecvError::Empty) => {
                std::thread::sleep(LOOK);
                true
            }
            Err(TryRecvError::Disconnected) => false,
        };
        for (start_ns, time_ns, line) in lines.try_iter() {
            match allowance.takes(Instant::now(), 1.0, LINES) {
                true => writer.log(start_ns + time_ns, 1e-9 * time_ns as f64, &line),
                false => _ = lost.fetch_add(1, Ordering::Relaxed),
            }
        }
        if open && writer.waiting() < LARGEST && flushed.elapsed() < EVERY {
            continue;
        }
        flushed = Instant::now();
        match flush(&mut writer) {
            Ok(()) => written += std::mem::take(&mut waiting),
            Err(cause) => {
                lost.fetch_add(std::mem::take(&mut waiting), Ordering::Relaxed);
                failed = Some(format!("{} takes no more ({cause}): the recording has ended", file.display()));
                cohold_io::say(format_args!("warning: {}", failed.as_deref().unwrap_or_default()));
                // Whoever waits for room is told by its being gone; what is on its way is lost.
                break;
            }
        }
        if !open {
            break;
        }
    }
    let missing = lost.load(Ordering::Relaxed);
    let (rows_text, lost_text) = (written.to_string(), missing.to_string());
    let ended = [("rows", rows_text.as_str()), ("lost", &lost_text), ("failed", failed.as_deref().unwrap_or(""))];
    let closed = writer.metadata("end", ended.into_iter()).and_then(|()| writer.end());
    if let Err(cause) = closed
        && failed.is_none()
    {
        failed = Some(format!(
            "its summary could not be written ({cause}): `cohold recording convert` reads it as a cut file"
        ));
    }
    Ended { file, rows: written, lost: missing, failed }
}

/// One chunk more; of one that the file does not take whole, nothing stays.
fn flush(writer: &mut Writer<File>) -> io::Result<()> {
    let whole = writer.at;
    let flushed = writer.flush();
    if flushed.is_err() {
        // What cannot be cut off is left to `recording convert`.
        let file = &mut writer.out;
        let _ = file.set_len(whole).and_then(|()| io::Seek::seek(file, io::SeekFrom::Start(whole)));
    }
    flushed
}
