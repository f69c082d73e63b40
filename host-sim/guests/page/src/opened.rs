//! A recording as a page shows it: a row for every tick, with the columns of the environment that was recorded.
//!
//! | recorded by | its rows are |
//! |---|---|
//! | `play` | samples as its windows had them; of the environment that was shown longest, where nobody says which |
//! | `cooperate` | both peers, tick by tick |
//! | `peer`, `board operator` | ticks of one end: the other is not there |
//! | `recording merge A B OUT` | ticks of A, beside each those of B that came at the same time by A's clock; copies where the table of all instants says |
//!
//! **Ticks.** A row stands at its tick, counted from the first: by the column `tick`, or by the numbers of the rows, so that what was lost while it was recorded is
//! a gap. Seconds in a tick are the median of what the rows' times say. What belongs beside it (other axes, the other end) is the row nearest in time, unless that is
//! [`NEAR_TICKS`] away.
//!
//! **What happened.** A sample has mode and fault of both peers behind the columns of its environment, no numbers where the recording does not
//! say them. The page opens at the first fault, or else where the copies were farthest apart. It marks that place and the lines of the recording's log.

use std::path::Path;

use cohold_live::recording::file::{Recording, Rows};
use cohold_live::recording::mcap::{ERROR, LogLine};
use cohold_live::recording::ticks::name_of;
use cohold_report::numbered;
use serde_json::{Value, json};

use super::environment::{Column, MODES};
use super::kinds::{EnvironmentKind, Kinds};
use cohold_cli::Failure;

/// Farthest in time that two rows are of one moment, ticks.
const NEAR_TICKS: f64 = 3.0;
/// Longest gap that is shown as long as it was, ticks: beyond it the recording has begun anew. Also the most ticks of all gaps together
/// that are shown beyond as many as there are rows, so that a page takes no more memory than what was recorded.
const LONGEST_GAP: usize = 100_000;
/// Most ticks, gaps included: four hours at 1 kHz.
const MOST_TICKS: usize = 1 << 24;
/// Most ticks in an answer to a page.
pub(super) const MOST_ASKED: u32 = 1 << 16;
/// Parts of the whole of which a page is told how far the copies were apart.
const PARTS: usize = 600;
/// Most lines of the log that a page is told: a file may be anybody's.
const MOST_LINES: usize = 1000;

/// A recording, laid out.
#[derive(Debug)]
pub(crate) struct Opened {
    kind: EnvironmentKind,
    /// Row after row: the columns of this kind, [`MODES`], and a count of starts.
    numbers: Vec<f32>,
    width: usize,
    period_s: f64,
    /// Time of the first tick, as the recording counts it, s.
    start_s: f64,
    unix_s: f64,
    who: String,
    file: String,
    /// Where the other copy was is only what its peer told now and then.
    told: bool,
    /// The tick at which the page opens.
    begin: usize,
    /// The farthest place of each part ([`overview`]).
    overview: Vec<(usize, f64)>,
    /// Tick, whether it stopped somebody, and words of each line of the log.
    marks: Vec<(usize, bool, String)>,
    /// What made it: a scene file.
    pub(super) scene: String,
    /// What the page is told when something of the recording is not shown.
    pub(crate) left_out: Option<String>,
}

/// A column of a channel, where it goes in a sample, and times what it is added to what is there; without that it takes its place.
type Name = (String, String, Option<f32>);

impl Opened {
    /// Lays a recording out; of a page that showed several environments, the one that is wanted.
    ///
    /// # Errors
    /// It holds nothing that a page can show, or not what is wanted.
    pub(crate) fn new(
        path: &Path,
        recording: &Recording,
        wanted: Option<EnvironmentKind>,
        kinds: Kinds,
    ) -> Result<Self, Failure> {
        let place = path.display();
        let failed = |why: String| Failure::from(format!("{place}: {why}"));
        let Source { kind, channels, left_out } = Source::of(recording, wanted, kinds).map_err(failed)?;
        let (first, others) = channels.split_first().ok_or_else(|| failed("it has no rows to show".to_owned()))?;
        let ticks = ticks_of(first.rows);
        let count = ticks.last().map_or(0, |last| last + 1);
        if count > MOST_TICKS {
            return Err(failed(format!("it has {count} ticks, and a page shows {MOST_TICKS} at the most")));
        }
        let times_s: Vec<f64> = first.rows.times_ns.iter().map(|ns| recording.origin.since_s(*ns)).collect();
        let period_s = period_s(&ticks, &times_s).ok_or_else(|| failed("its times do not go on".to_owned()))?;
        let width = kind.columns().len() + MODES.len() + 1;
        let mut numbers = vec![f32::NAN; count * width];
        for (row, tick) in ticks.iter().enumerate() {
            let sample = &mut numbers[tick * width..(tick + 1) * width];
            sample[width - 1] = 0.0;
            first.put(row, sample);
        }
        for other in others {
            let other_s: Vec<f64> = other.rows.times_ns.iter().map(|ns| recording.origin.since_s(*ns)).collect();
            for (tick, time_s) in ticks.iter().zip(&times_s) {
                let after = other_s.partition_point(|other_s| other_s < time_s);
                let near = [after.checked_sub(1), Some(after)].into_iter().flatten();
                let away = |row: &usize| (other_s[*row] - time_s).abs();
                let near = near.filter(|row| *row < other_s.len()).min_by(|a, b| away(a).total_cmp(&away(b)));
                if let Some(row) = near.filter(|row| away(row) < NEAR_TICKS * period_s) {
                    other.put(row, &mut numbers[tick * width..(tick + 1) * width]);
                }
            }
        }
        let origin = &recording.origin;
        let place = |unix_ns| times_s.partition_point(|time_s| *time_s < origin.since_s(unix_ns));
        let mark = |(unix_ns, line): (u64, &LogLine)| {
            let tick = ticks[place(unix_ns).min(ticks.len() - 1)];
            let words = format!("{:.60}: {:.300}", line.who, line.words);
            (tick, line.level >= ERROR, words)
        };
        let mut marks: Vec<_> = recording.log().take(MOST_LINES).map(mark).collect();
        let overview = overview(kind, &numbers, width);
        let apart = overview.iter().copied().filter(|(_, mm)| *mm > 0.0);
        let farthest = apart.max_by(|(_, one), (_, other)| one.total_cmp(other));
        if let Some((tick, mm)) = farthest {
            let words = format!("the copies were farthest apart here: {mm:.1} mm");
            marks.insert(marks.partition_point(|(at, ..)| *at <= tick), (tick, false, words));
        }
        let fault = numbers.chunks_exact(width).position(|at| at[width - 4] > 0.0 || at[width - 2] > 0.0);
        let time_s = first.rows.column("time_s").and_then(|times| times.first().copied());
        Ok(Self {
            kind,
            begin: fault.or(farthest.map(|(tick, _)| tick)).unwrap_or_default(),
            marks,
            overview,
            numbers,
            width,
            period_s,
            start_s: time_s.filter(|time_s| time_s.is_finite()).unwrap_or(times_s[0]),
            unix_s: origin.start_unix_ns as f64 * 1e-9,
            who: origin.who.clone(),
            file: path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
            told: first.rows.topic.starts_with("/page/"),
            scene: origin.provenance.clone(),
            left_out,
        })
    }

    /// How long it is, s.
    pub(crate) fn seconds(&self) -> f64 {
        self.ticks() as f64 * self.period_s
    }

    fn ticks(&self) -> usize {
        self.numbers.len() / self.width
    }

    /// Whose it is.
    pub(crate) fn who(&self) -> &str {
        &self.who
    }

    /// What a page is told of it.
    pub(super) fn hello(&self) -> Value {
        json!({
            "file": self.file,
            "who": self.who,
            "kind": self.kind.number(),
            "ticks": self.ticks(),
            "start_s": self.start_s,
            "unix_s": self.unix_s,
            "told": self.told,
            "columns": MODES.map(|(name, unit, means)| json!({ "name": name, "unit": unit, "means": means })),
            "begin": self.begin,
            "marks": self.marks,
            "overview_mm": self.overview_mm(),
            "left_out": self.left_out,
        })
    }

    /// How far the copies were apart at the most in each part of the whole, mm; of what is no pair, nothing.
    fn overview_mm(&self) -> Vec<f32> {
        self.overview.iter().map(|(_, mm)| *mm as f32).collect()
    }

    pub(super) fn period_s(&self) -> f64 {
        self.period_s
    }

    pub(super) fn kind(&self) -> EnvironmentKind {
        self.kind
    }

    /// The samples of so many ticks from one on, as many as there are, as a page gets them behind a header.
    pub(super) fn samples(&self, from: u32, count: u32) -> impl Iterator<Item = &f32> {
        let to = from.saturating_add(count.min(MOST_ASKED)) as usize;
        let [from, to] = [from as usize, to].map(|at| at.min(self.ticks()) * self.width);
        self.numbers[from..to].iter()
    }
}

/// The tick in each part of the whole at which the copies were farthest apart, and how far, mm. Empty where there is no pair.
fn overview(kind: EnvironmentKind, numbers: &[f32], width: usize) -> Vec<(usize, f64)> {
    let at = |name: &str| kind.columns().iter().position(|(known, ..)| *known == name);
    let axis = |suffix: &str| Some([at(&format!("object_1{suffix}"))?, at(&format!("object_2{suffix}"))?]);
    let axes: Vec<_> = SUFFIXES.into_iter().map_while(axis).collect();
    let apart = |tick: usize| {
        let sample = &numbers[tick * width..];
        let square = |[one, two]: &[usize; 2]| (f64::from(sample[*one]) - f64::from(sample[*two])).powi(2);
        (tick, 1e3 * axes.iter().map(square).sum::<f64>().sqrt())
    };
    let part = |part: usize| {
        let [from, to] = [part, part + 1].map(|part| part * (numbers.len() / width) / PARTS);
        let all = (from..to).map(apart);
        // A distance that is no number is none.
        all.fold((from, 0.0), |most, this| if this.1 >= most.1 { this } else { most })
    };
    (0..PARTS).take_while(|_| !axes.is_empty()).map(part).collect()
}

/// A channel, and where its numbers go.
struct Laid<'a> {
    rows: &'a Rows,
    moves: Vec<(&'a [f64], usize, Option<f32>)>,
}

impl<'a> Laid<'a> {
    /// A channel whose columns go to those of a sample.
    fn new(rows: &'a Rows, kind: EnvironmentKind, names: impl IntoIterator<Item = Name>) -> Self {
        let place = |(from, to, adds): Name| {
            let to = columns(kind).position(|(name, ..)| *name == to)?;
            Some((rows.column(&from)?, to, adds))
        };
        Self { rows, moves: names.into_iter().filter_map(place).collect() }
    }

    /// Puts a row into a sample.
    fn put(&self, row: usize, sample: &mut [f32]) {
        for (column, to, adds) in &self.moves {
            let value = column[row] as f32;
            sample[*to] = match adds {
                None => value,
                Some(times) if sample[*to].is_nan() => times * value,
                Some(times) => sample[*to] + times * value,
            };
        }
    }
}

/// What of a recording is shown: the first channel counts the ticks.
struct Source<'a> {
    kind: EnvironmentKind,
    channels: Vec<Laid<'a>>,
    left_out: Option<String>,
}

impl<'a> Source<'a> {
    fn of(recording: &'a Recording, wanted: Option<EnvironmentKind>, kinds: Kinds) -> Result<Self, String> {
        let channels = || recording.channels.iter().filter(|rows| !rows.is_empty());
        let called = |topic: &str| channels().find(|rows| rows.topic == topic);
        let is_end = |rows: &&Rows| {
            (rows.topic.starts_with("/peer_") || rows.topic.starts_with("/board_")) && rows.topic.ends_with("/ticks")
        };
        let ends: Vec<&Rows> = channels().filter(is_end).collect();
        if !ends.is_empty() {
            return Self::of_ends(&ends, &called, wanted);
        }
        if let Some(both) = called("/both/ticks").filter(|rows| rows.column("energy_sent_1_j").is_some()) {
            return Self::of_run(both, &called, wanted);
        }
        let page = channels().filter_map(|rows| Some((of_page(rows, kinds)?, rows)));
        let mut shown: Vec<_> = page.filter(|(kind, _)| wanted.is_none_or(|wanted| wanted == *kind)).collect();
        shown.sort_by_key(|(_, rows)| std::cmp::Reverse(rows.len()));
        let all: Vec<_> = channels().filter_map(|rows| Some((of_page(rows, kinds)?, rows.len()))).collect();
        let Some((kind, rows)) = shown.first().copied() else {
            let there: Vec<_> = all.iter().map(|(kind, _)| kind.name()).collect();
            return Err(if let (Some(wanted), false) = (wanted, there.is_empty()) {
                format!("{} was not shown while it was recorded: there is {}", wanted.name(), there.join(", "))
            } else if channels().any(|rows| rows.topic.starts_with("/hub/")) {
                "it is the recording of a hub, where no device is: open that of a peer".to_owned()
            } else {
                "it has no ticks of a peer, a page or a run".to_owned()
            });
        };
        let others: Vec<_> = all.iter().filter(|(other, _)| *other != kind).collect();
        let said = |(kind, rows): &&(EnvironmentKind, usize)| format!("{rows} ticks of {}", kind.name());
        let left_out = (!others.is_empty()).then(|| {
            let others: Vec<_> = others.iter().map(said).collect();
            format!("{} is shown; --environment chooses another: {}", kind.name(), others.join(", "))
        });
        let names = columns(kind).map(|(name, unit, _)| (in_unit(name, unit), (*name).to_owned(), None));
        Ok(Self { kind, channels: vec![Laid::new(rows, kind, names)], left_out })
    }

    /// Of one end or of two.
    fn of_ends(
        ends: &[&'a Rows],
        called: &dyn Fn(&str) -> Option<&'a Rows>,
        wanted: Option<EnvironmentKind>,
    ) -> Result<Self, String> {
        let axis = |end: &Rows, axis: usize| {
            let (end, _) = end.topic.rsplit_once('/')?;
            called(&format!("{end}/{}", name_of(axis)))
        };
        let axes = (0..3).take_while(|at| ends.iter().all(|end| axis(end, *at).is_some())).count();
        let kind = pair_of(axes, wanted)?;
        let mut channels = Vec::new();
        for (index, end) in ends.iter().take(2).enumerate() {
            // One end alone keeps its number; of two the first is 1, as in the table of all instants.
            let own = end.topic.trim_start_matches(|letter: char| !letter.is_ascii_digit()).starts_with('2');
            let number = if ends.len() == 1 && own { 2 } else { index + 1 };
            for (at, rows) in (0..axes).filter_map(|at| Some((at, axis(end, at)?))) {
                // What is on its way takes two to know.
                let names = of_axis(number, at, str::to_owned).filter(|(.., adds)| ends.len() > 1 || adds.is_none());
                channels.push(Laid::new(rows, kind, names));
            }
        }
        if let Some(both) = called("/both/ticks") {
            let place = |at: usize, end: usize| {
                let to = format!("object_{end}{}", SUFFIXES[at]);
                (format!("{to}_m"), to, None)
            };
            let names = (0..axes).flat_map(|at| [1, 2].map(|end| place(at, end)));
            channels.push(Laid::new(both, kind, names));
        }
        Ok(Self { kind, channels, left_out: None })
    }

    /// Of a run of both peers.
    fn of_run(
        both: &'a Rows,
        called: &dyn Fn(&str) -> Option<&'a Rows>,
        wanted: Option<EnvironmentKind>,
    ) -> Result<Self, String> {
        let further = (1..3).map_while(|axis| called(&format!("/both/{}", name_of(axis))));
        let all: Vec<_> = std::iter::once(both).chain(further).collect();
        let kind = pair_of(all.len(), wanted)?;
        let names = |at| (1..=2).flat_map(move |end| of_axis(end, at, move |name| numbered(name, end)));
        let channels = all.iter().enumerate().map(|(at, rows)| Laid::new(rows, kind, names(at))).collect();
        Ok(Self { kind, channels, left_out: None })
    }
}

/// Columns of a peer along an axis, which a recording calls `from` so, and those of the peer as a whole, which it has with the first one.
fn of_axis(number: usize, at: usize, from: impl Fn(&str) -> String + Copy) -> impl Iterator<Item = Name> {
    let moves = "device_m object_m decoded_m contact_n coordination_n".split(' ').map(move |name| {
        let (what, _) = name.rsplit_once('_').unwrap_or((name, ""));
        (from(name), format!("{what}_{number}{}", SUFFIXES[at]), None)
    });
    let energy = [("energy_sent_j", 1.0), ("energy_received_j", -1.0)];
    let energy = energy.map(|(name, times)| (from(name), "line".to_owned(), Some(times)));
    let whole = ["live", "mode", "fault"].map(|name| (from(name), format!("{name}_{number}"), None));
    let whole = whole.into_iter().filter(move |_| at == 0);
    moves.chain(energy).chain(whole)
}

/// What is in a sample of a recording, but for the count of starts.
fn columns(kind: EnvironmentKind) -> impl Iterator<Item = &'static Column> {
    kind.columns().iter().chain(&MODES)
}

/// What stands behind a column's name for each axis.
const SUFFIXES: [&str; 3] = ["", "_y", "_z"];

/// Two peers along so many axes, which is what is wanted if anything is.
fn pair_of(axes: usize, wanted: Option<EnvironmentKind>) -> Result<EnvironmentKind, String> {
    let all = [EnvironmentKind::Pair, EnvironmentKind::Plane, EnvironmentKind::Space];
    let kind = all[axes.clamp(1, 3) - 1];
    match wanted {
        Some(wanted) if wanted != kind => {
            Err(format!("{} is not what was recorded: that is {}", wanted.name(), kind.name()))
        }
        _ => Ok(kind),
    }
}

/// A column's name with its unit, as a recording has it.
pub(super) fn in_unit(name: &str, unit: &str) -> String {
    if unit.is_empty() { name.to_owned() } else { format!("{name}_{}", unit.to_lowercase()) }
}

/// What a page showed whose recording this channel is.
fn of_page(rows: &Rows, kinds: Kinds) -> Option<EnvironmentKind> {
    let (place, leaf) = rows.topic.rsplit_once('/')?;
    if !["/both", "/page", "/boards"].contains(&place) {
        return None;
    }
    let kind = if leaf == "ticks" { EnvironmentKind::Pair } else { kinds.named(leaf)? };
    let (name, unit, _) = kind.columns().first()?;
    rows.column(&in_unit(name, unit)).map(|_| kind)
}

/// The tick of each row, from 0.
fn ticks_of(rows: &Rows) -> Vec<usize> {
    let counted = rows.column("tick").unwrap_or(&rows.sequences);
    let mut ticks = Vec::with_capacity(counted.len());
    let (mut tick, mut before) = (0_usize, None);
    let mut left = counted.len() + LONGEST_GAP;
    for now in counted {
        if let Some(before) = before.replace(*now) {
            let on: f64 = now - before;
            let gap = if on >= 1.0 { on as usize - 1 } else { 0 };
            let shown = if gap < LONGEST_GAP.min(left) { gap } else { 0 };
            left -= shown;
            tick += 1 + shown;
        }
        ticks.push(tick);
    }
    ticks
}

/// Seconds in a tick: the median of what the rows say, to a hundredth of a millisecond.
fn period_s(ticks: &[usize], times_s: &[f64]) -> Option<f64> {
    let pairs = ticks.windows(2).zip(times_s.windows(2));
    let mut periods: Vec<f64> = pairs.map(|(tick, time)| (time[1] - time[0]) / (tick[1] - tick[0]) as f64).collect();
    periods.sort_by(f64::total_cmp);
    let median = periods.get(periods.len() / 2)?;
    let rounded = (median * 1e5).round() * 1e-5;
    (rounded > 0.0).then_some(rounded)
}

#[cfg(test)]
#[path = "../tests/inside/opened.rs"]
mod tests;
