//! What a sweep, or another long study, has found so far, in a folder, so that it goes on where it was stopped.
//!
//! | file | holds |
//! |---|---|
//! | `sweep.toml`, `study.toml`, … | the question: the scene, and in its table `[made]` what is varied, seeds, time, version and commit |
//! | `rows-I-of-N.csv` | the runs of shard I of N, a line each, in the order in which they ended |
//!
//! What they are called, and what a row is, the rows say themselves ([`Kept`]).
//!
//! Rows are only ever appended, whole lines at a time, and reach the disk within [`SYNC`] and at the end. A line without an end,
//! which a kill may leave, is cut off by the process that goes on, and its run is done again. One process writes a file at a time, which
//! a lock sees to where the file system has locks. Every file of the folder is read, so that shards know of each other's runs.

use std::collections::BTreeMap;
use std::fs::{self, File, TryLockError};
use std::io::{ErrorKind, Write};
use std::marker::PhantomData;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use cohold_io::{Kind, Most};
use cohold_report::files::{write_csv, write_parquet};
use cohold_report::{Column, Columns, Provenance};

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::row::Row;
use crate::Error;

/// A row that a [`Journal`] keeps: fields, in the order of the heading, none of them a list of unknown length.
pub trait Kept: Serialize + DeserializeOwned {
    /// How the files of rows are called: `rows`, and then `-I-of-N.csv`.
    const ROWS: &'static str;
    /// What tells a row from the others of the study, in their order.
    type Key: Ord;

    /// Which row it is.
    fn key(&self) -> Self::Key;
    /// The columns of a file of rows.
    fn columns() -> Columns;
    /// Its first line, with the end of it.
    fn heading() -> String {
        Self::columns().data().map(Column::name).collect::<Vec<_>>().join(",") + "\n"
    }
}

/// Longest that a row waits for the disk while others come, if the machine itself stops.
const SYNC: Duration = Duration::from_secs(1);

/// Longest files of a folder.
const QUESTION: Most = Most::new(1 << 26, "the question of a study");
const ROWS: Most = Most::new(1 << 32, "a file of rows");

/// A file of rows that is being written.
#[derive(Debug)]
pub struct Journal<R = Row> {
    path: PathBuf,
    /// And when it last reached the disk.
    file: Mutex<(File, Instant)>,
    rows: PhantomData<fn(R)>,
}

impl<R: Kept> Journal<R> {
    /// Goes on with the study in this folder, or begins it there; returns every row that is there. `study` is what is asked, for an error,
    /// and the name of the file that holds the question (`sweep`, `sweep.toml`), `shard` is I and N.
    ///
    /// # Errors
    /// The folder holds another question, or a file cannot be read or written.
    pub fn open(
        folder: &Path,
        study: &str,
        question: &Provenance,
        shard: (usize, usize),
    ) -> Result<(Self, Vec<R>), Error> {
        fs::create_dir_all(folder).map_err(cohold_sim::Error::cannot("make", &folder.display()))?;
        same_question(folder, &question.toml(), study)?;
        let path = folder.join(format!("{}-{}-of-{}.csv", R::ROWS, shard.0, shard.1));
        let failed = cohold_sim::Error::cannot::<std::io::Error>("write", &path.display());
        let mut file = cohold_io::append(&path).map_err(&failed)?;
        if let Err(TryLockError::WouldBlock) = file.try_lock() {
            return Err(format!("{} is being written by another process: wait for its end", path.display()).into());
        }
        let whole = whole_lines(&path)?;
        file.set_len(whole.len() as u64).map_err(&failed)?;
        if whole.is_empty() {
            file.write_all(R::heading().as_bytes()).map_err(&failed)?;
        }
        file.sync_all().map_err(&failed)?;
        let rows = rows_in(folder)?;
        Ok((Self { path, file: Mutex::new((file, Instant::now())), rows: PhantomData }, rows))
    }

    /// Adds these rows to the file.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn append(&self, rows: &[R]) -> Result<(), Error> {
        let lines = lines(rows)?;
        let mut guard = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        let (file, synced) = &mut *guard;
        let mut written = file.write_all(&lines);
        if synced.elapsed() >= SYNC {
            written = written.and_then(|()| file.sync_data());
            *synced = Instant::now();
        }
        Ok(written.map_err(cohold_sim::Error::cannot("write", &self.path.display()))?)
    }

    /// Has everything reach the disk.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn finish(&self) -> Result<(), Error> {
        let (file, _) = &*self.file.lock().unwrap_or_else(PoisonError::into_inner);
        Ok(file.sync_all().map_err(cohold_sim::Error::cannot("write", &self.path.display()))?)
    }
}

/// Rows that are found one by one: those that a folder has, and new ones, which it keeps. Without a folder there are none, and nothing is kept.
#[derive(Debug)]
pub struct Book<R: Kept> {
    there: BTreeMap<R::Key, R>,
    journal: Option<Journal<R>>,
}

impl<R: Kept> Book<R> {
    /// As [`Journal::open`], of a study that is in one piece.
    ///
    /// # Errors
    /// The folder holds another question, or a file cannot be read or written.
    pub fn open(folder: Option<(&Path, &Provenance)>, study: &str) -> Result<Self, Error> {
        let opened =
            folder.map(|(folder, question)| Journal::<R>::open(folder, study, question, (1, 1))).transpose()?;
        let (journal, there) = opened.map_or((None, Vec::new()), |(journal, there)| (Some(journal), there));
        Ok(Self { there: there.into_iter().map(|row| (row.key(), row)).collect(), journal })
    }

    /// The row that was there.
    pub fn known(&self, key: &R::Key) -> Option<&R> {
        self.there.get(key)
    }

    /// A new row, kept.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn kept(&self, row: R) -> Result<R, Error> {
        self.journal.iter().try_for_each(|journal| journal.append(std::slice::from_ref(&row)))?;
        Ok(row)
    }

    /// Has everything reach the disk.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn finish(&self) -> Result<(), Error> {
        self.journal.iter().try_for_each(Journal::finish)
    }
}

/// The rows as `STUDY.csv` and `STUDY.parquet` in this folder, each whole or as it was before; returns the paths of what the folder
/// holds then. One process at a time does so: the one that holds the only journal of all points.
///
/// # Errors
/// A file cannot be written.
pub fn write(folder: &Path, study: &str, rows: &Columns, question: &Provenance) -> Result<Vec<PathBuf>, Error> {
    let [csv, parquet, toml] = ["csv", "parquet", "toml"].map(|ending| folder.join(format!("{study}.{ending}")));
    write_csv(rows, &csv, Kind::Named)?;
    write_parquet(rows, &parquet, &question.toml(), Kind::Named)?;
    Ok(vec![csv, parquet, toml])
}

/// Rows as lines of a file of rows.
///
/// # Errors
/// A row that cannot be written as CSV.
pub(super) fn lines<R: Kept>(rows: &[R]) -> Result<Vec<u8>, Error> {
    let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
    rows.iter().try_for_each(|row| writer.serialize(row)).map_err(|cause| cause.to_string())?;
    Ok(writer.into_inner().map_err(|cause| cause.to_string())?)
}

/// The rows that these lines hold, each as it is read.
pub(super) fn read<R: Kept>(lines: &[u8]) -> impl Iterator<Item = csv::Result<R>> {
    csv::ReaderBuilder::new().has_headers(false).from_reader(lines).into_deserialize()
}

/// Sees to it that the question in this folder asks just this.
fn same_question(folder: &Path, question: &str, study: &str) -> Result<(), Error> {
    let path = folder.join(format!("{study}.toml"));
    // Never over another's.
    match cohold_io::write(&path, question.as_bytes(), Kind::New) {
        Err(cause) if cause.kind() != ErrorKind::AlreadyExists => {
            return Err(cohold_sim::Error::cannot("write", &path.display())(cause).into());
        }
        _ => {}
    }
    let there = cohold_io::text(&path, QUESTION).map_err(cohold_sim::Error::cannot("read", &path.display()))?;
    let (there, here) = (asked(&there), asked(question));
    let line =
        |of: &[String], at: usize| of.get(at).map_or_else(|| "nothing more".to_owned(), |line| format!("`{line}`"));
    match (0..there.len().max(here.len())).find(|at| there.get(*at) != here.get(*at)) {
        None => Ok(()),
        Some(at) => Err(Error::Refused(format!(
            "{} is of another {study}: it says {}, this one {}; each {study} needs a folder of its own",
            path.display(),
            line(&there, at),
            line(&here, at)
        ))),
    }
}

/// The lines of a question that matter: not when it was asked.
pub(super) fn asked(text: &str) -> Vec<String> {
    text.lines().filter(|line| !line.starts_with("started = ")).map(str::to_owned).collect()
}

/// The text of a file up to the end of its last whole line.
fn whole_lines(path: &Path) -> Result<Vec<u8>, Error> {
    let mut bytes = cohold_io::read(path, ROWS).map_err(cohold_sim::Error::cannot("read", &path.display()))?;
    bytes.truncate(bytes.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1));
    Ok(bytes)
}

/// Every row of every shard, the first one of each run, in their order.
fn rows_in<R: Kept>(folder: &Path) -> Result<Vec<R>, Error> {
    let failed = cohold_sim::Error::cannot::<std::io::Error>("read", &folder.display());
    let mut paths = Vec::new();
    for entry in fs::read_dir(folder).map_err(&failed)? {
        let path = entry.map_err(&failed)?.path();
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        if name.strip_prefix(R::ROWS).is_some_and(|rest| rest.starts_with('-')) && name.ends_with(".csv") {
            paths.push(path);
        }
    }
    paths.sort();
    let mut rows = Vec::new();
    for path in &paths {
        let text = whole_lines(path)?;
        let heading = R::heading();
        let Some(lines) = text.strip_prefix(heading.as_bytes()) else {
            if text.is_empty() {
                continue;
            }
            return Err(format!("{}:1: it must be {}", path.display(), heading.trim_end()).into());
        };
        for (at, row) in read::<R>(lines).enumerate() {
            let wrong =
                |cause| format!("{}:{}: {cause}; without this line its run is done again", path.display(), at + 2);
            rows.push(row.map_err(wrong)?);
        }
    }
    rows.sort_by_key(R::key);
    rows.dedup_by(|one, other| one.key() == other.key());
    Ok(rows)
}
