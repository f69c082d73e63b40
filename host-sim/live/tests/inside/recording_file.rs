//! A recording is what was put in, whole or cut anywhere.

use std::path::{Path, PathBuf};

use super::super::mcap::{Channel, ERROR, INFO};
use super::super::origin::Origin;
use super::super::recorder::{Ended, Recorder};
use super::{Recording, read};

fn place(name: &str) -> PathBuf {
    let path = std::env::temp_dir().join(format!("cohold-file-{name}-{}.mcap", std::process::id()));
    let _ = std::fs::remove_file(&path);
    path
}

fn origin() -> Origin {
    let text = |text: &str| text.to_owned();
    let (version, provenance, who, clock) = (text("1"), text("[object]\nmass_kg = 2\n"), text("peer 1"), text("boot"));
    Origin { version, provenance, who, start_unix_ns: 5, clock, start_clock_ns: 77 }
}

/// The log has what was said and when, by whom and how bad it was, and no more lines at once than it may.
#[test]
fn the_log_says_what_happened() {
    let path = place("log");
    let channels = vec![Channel::new("/a/ticks", "Tick", [("x_m", "")])];
    let recorder = Recorder::create(&path, &origin(), channels).expect("a file");
    recorder.put_all(0, 7_000_000, &[1.0]);
    let mut last = [0.0; 2];
    for (ms, now) in [(1, [1.0, 0.0]), (2, [1.0, 0.0]), (3, [f64::NAN; 2]), (4, [2.0, 3.0]), (5, [2.0, 24.0])] {
        recorder.log_mode(1_000_000 * ms, "peer 2", &mut last, now);
    }
    recorder.log(recorder.now_ns(), INFO, "it is said");
    (0..1100).for_each(|_| recorder.log(8_000_000, INFO, "too often"));
    let ended = recorder.finish();
    let recording = read(&path).expect("a recording");
    let said = recording.log().map(|(at_ns, line)| (at_ns, line.who.as_str(), line.level, line.words.as_str()));
    let speed = "fault 3: braking did not keep the device below 1.5 times safety.max_speed_m_per_s or encoder.max_speed_m_per_s";
    let socket = "fault 24: the device stopped, or its socket or bus is closed";
    let wanted = [
        (1_000_005, "peer 2", INFO, "armed"),
        (4_000_005, "peer 2", ERROR, speed),
        (5_000_005, "peer 2", ERROR, socket),
        (7_000_005, "peer 1", INFO, "it is said"),
    ];
    assert_eq!(said.take(4).collect::<Vec<_>>(), wanted);
    let log = recording.channels.last().expect("a log");
    assert_eq!((log.topic.as_str(), &log.column("time_s").expect("times")[..2]), ("/log", &[0.001, 0.004][..]));
    // A second or so has passed at the most.
    let count = recording.log().count() as u64;
    assert!((1000..1010).contains(&count) && (ended.rows, ended.lost) == (1, 1104 - count), "{count} {ended:?}");
}

/// Two channels of many and odd numbers.
fn write(path: &Path, rows: u32) -> Ended {
    let wide: Vec<(String, &str)> = (0..12).map(|at| (format!("column_{at}_m"), "a place")).collect();
    let channels = vec![Channel::new("/a/ticks", "Tick", wide), Channel::new("/a/seconds", "Second", [("x_s", "")])];
    let recorder = Recorder::create(path, &origin(), channels).expect("a file");
    for at in 0..rows {
        recorder.put_all(0, u64::from(at) * 1_000_000, &values(at));
        if at % 10 == 0 {
            recorder.put_all(1, u64::from(at) * 1_000_000, &[-0.0]);
        }
        // Chunks by time.
        if at % 250 == 249 {
            std::thread::sleep(std::time::Duration::from_millis(300));
        }
    }
    recorder.finish()
}

fn values(at: u32) -> [f64; 12] {
    let odd = [f64::NAN, f64::INFINITY, -0.0, 5e-324, f64::MAX];
    std::array::from_fn(|column| if column < 5 { odd[column] } else { f64::from(at) + 0.1 * column as f64 })
}

/// The rows of both channels, which are those that were put in first.
fn check(recording: &Recording) -> [usize; 2] {
    let mut counts = [0; 2];
    for (rows, count) in recording.channels.iter().zip(&mut counts) {
        *count = rows.len();
        for column in &rows.names {
            assert_eq!(rows.column(column).map(<[f64]>::len), Some(rows.len()));
        }
    }
    if let [ticks, _, _] = &recording.channels[..] {
        for at in 0..ticks.len() {
            let found = ticks.names.iter().map(|name| ticks.column(name).expect("it is named")[at].to_bits());
            assert!(found.eq(values(at as u32).map(f64::to_bits)), "row {at}");
            assert_eq!(ticks.times_ns[at], 5 + 1_000_000 * at as u64);
        }
        assert_eq!(ticks.meaning("column_7_m"), "a place");
    }
    counts
}

#[test]
fn a_whole_file_and_one_that_is_cut_anywhere() {
    let path = place("cut");
    let ended = write(&path, 600);
    assert_eq!((ended.rows, ended.lost, ended.failed), (660, 0, None));
    let whole = read(&path).expect("a recording");
    assert_eq!((whole.cut, whole.lost, check(&whole)), (None, Some(0), [600, 60]));
    assert_eq!(whole.origin, origin());
    let bytes = std::fs::read(&path).expect("it is there");
    let (mut before, mut saved) = ([0; 2], 0);
    for length in (8..bytes.len()).step_by(1499) {
        std::fs::write(&path, &bytes[..length]).expect("it is there");
        let cut = read(&path).expect("what is left of a recording");
        let told = cut.cut.expect("it is cut");
        assert_eq!(told.whole + told.rest, length as u64);
        saved += told.saved;
        let counts = check(&cut);
        assert!(
            (0..2).all(|channel| counts[channel] >= before[channel]),
            "{length} bytes: {counts:?} after {before:?}"
        );
        // No row is in the file and not given: the first of a chunk that is not whole are there, too.
        before = counts;
    }
    assert!(before == [600, 60] && saved > 0);
    // What is no recording, and a bit of one that turned.
    std::fs::write(&path, b"time_s\n0\n").expect("it is there");
    assert!(read(&path).expect_err("no recording").to_string().contains("is no recording"));
    let mut turned = bytes.clone();
    for at in (8..2000).step_by(13) {
        turned[at] ^= 0x55;
        std::fs::write(&path, &turned).expect("it is there");
        let _ = read(&path);
        turned[at] ^= 0x55;
    }
    assert!(
        Recorder::create(&path, &origin(), Vec::new())
            .expect_err("it is there")
            .to_string()
            .contains("never written over")
    );
    std::fs::remove_file(&path).expect("it is there");
}

/// A bit that turned on a disk is no row: the chunk that it is in is left out, and said; the others are there.
#[test]
fn a_chunk_that_is_not_what_was_written_is_left_out() {
    let path = place("damaged");
    assert_eq!(write(&path, 600).rows, 660);
    let mut bytes = std::fs::read(&path).expect("it is there");
    let value = values(300)[7].to_le_bytes();
    let at = bytes.windows(8).position(|eight| eight == value).expect("row 300");
    bytes[at] ^= 1;
    std::fs::write(&path, &bytes).expect("it is there");
    let damaged = read(&path).expect("a recording");
    std::fs::remove_file(&path).expect("it is there");
    let numbers = damaged.channels[0].table().column("row").expect("its number").to_vec();
    assert!((1..=2).contains(&damaged.damaged) && damaged.cut.is_none(), "{:?}", damaged.damaged);
    assert!(!numbers.contains(&300.0) && numbers.contains(&0.0) && numbers.contains(&599.0), "{}", numbers.len());
}

/// Who puts in quicker than can be written does not wait: what did not fit is counted, and its numbers are left out.
#[test]
fn the_beat_never_waits() {
    let path = place("quick");
    let recorder =
        Recorder::create(&path, &origin(), vec![Channel::new("/a/ticks", "Tick", [("x_m", "")])]).expect("a file");
    const ROWS: u64 = 200_000;
    let start = std::time::Instant::now();
    (0..ROWS).for_each(|at| recorder.put(0, at, &[at as f64]));
    assert!(start.elapsed().as_secs_f64() < 2.0, "{:?}", start.elapsed());
    let ended = recorder.finish();
    assert!(ended.rows + ended.lost == ROWS && ended.lost > 0, "{ended:?}");
    assert!(ended.summary().contains(&format!("{} rows are missing", ended.lost)));
    let recording = read(&path).expect("a recording");
    std::fs::remove_file(&path).expect("it is there");
    assert_eq!(recording.lost, Some(ended.lost));
    let numbers = recording.channels[0].table();
    let (number, value) = (numbers.column("row").expect("its number"), numbers.column("x_m").expect("its value"));
    assert_eq!(number, value);
    assert_eq!(number.len() as u64, ended.rows);
}
