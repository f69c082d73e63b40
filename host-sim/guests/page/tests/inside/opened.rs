//! Recordings whose rows are known, laid out as a page shows them.

use std::path::PathBuf;

use cohold_live::recording::file::read;
use cohold_live::recording::mcap::Channel;
use cohold_live::recording::merge::COLUMNS;
use cohold_live::recording::origin::Origin;
use cohold_live::recording::recorder::Recorder;
use cohold_live::recording::ticks;

use super::*;

/// A recording of these rows: channel, time in ms, numbers.
fn recorded(name: &str, channels: Vec<Channel>, rows: &[(u16, u64, Vec<f64>)]) -> (PathBuf, Recording) {
    let path = std::env::temp_dir().join(format!("cohold-opened-{name}-{}.mcap", std::process::id()));
    let _ = std::fs::remove_file(&path);
    let text = |text: &str| text.to_owned();
    let origin = Origin {
        version: text("0"),
        provenance: text("[made]\n"),
        who: text("a test"),
        start_unix_ns: 1_700_000_000_000_000_000,
        clock: String::new(),
        start_clock_ns: 0,
    };
    let recorder = Recorder::create(&path, &origin, channels).expect("a file");
    rows.iter().for_each(|(channel, at_ms, values)| recorder.put_all(*channel, 1_000_000 * at_ms, values));
    assert_eq!(recorder.finish().lost, 0);
    let recording = read(&path).expect("a recording");
    std::fs::remove_file(&path).expect("it is there");
    (path, recording)
}

/// A row of ticks with these columns, else 0.
fn tick(columns: &[(&str, f64)]) -> Vec<f64> {
    ticks::TICK
        .iter()
        .map(|(name, _)| columns.iter().find(|(known, _)| known == name).map_or(0.0, |(_, x)| *x))
        .collect()
}

/// A column at a tick, as a page gets it.
fn value(opened: &Opened, name: &str, tick: u32) -> f32 {
    let at = opened.kind.columns().iter().position(|(known, ..)| *known == name).expect("a column");
    *opened.samples(tick, 1).nth(at).unwrap_or(&f32::NAN)
}

#[test]
fn two_ends_stand_beside_each_other_and_gaps_are_gaps() {
    let channels = [ticks::channels("peer_1", 1), ticks::channels("peer_2", 1)].concat();
    let channels = [channels, vec![Channel::new("/both/ticks", "Instant", COLUMNS)]].concat();
    let mut rows = Vec::new();
    // Ticks 40 to 49 of peer 1 were lost; peer 2 began 20 ms later.
    for at in (0..100_u32).filter(|at| !(40..50).contains(at)) {
        let x = f64::from(at);
        let one = [("time_s", 5.0 + 1e-3 * x), ("tick", 700.0 + x), ("object_m", 1e-3 * x), ("energy_sent_j", 3.0)];
        rows.push((0, 10 + u64::from(at), tick(&one)));
        if at >= 20 {
            let two =
                [("time_s", 9.0), ("tick", x), ("object_m", 7.0), ("device_m", 2e-3 * x), ("energy_received_j", 1.0)];
            rows.push((3, 10 + u64::from(at), tick(&two)));
            rows.push((6, 10 + u64::from(at), vec![5.0 + 1e-3 * x, 1e-3 * x, 4e-3 * x, 3e-3 * x, 0.0]));
        }
    }
    let (path, recording) = recorded("ends", channels, &rows);
    let opened = Opened::new(&path, &recording, None, Kinds::default()).expect("two ends");
    assert_eq!((opened.kind, opened.ticks(), opened.period_s), (EnvironmentKind::Pair, 100, 0.001));
    assert!((opened.start_s - 5.0).abs() < 1e-9);
    // Copies are those of the table of all instants; forces and devices those of the ends.
    assert_eq!([1, 2].map(|n| value(&opened, &format!("object_{n}"), 60)), [0.060, 0.240]);
    assert_eq!(value(&opened, "device_2", 60), 0.120);
    assert_eq!(value(&opened, "line", 60), 2.0);
    assert!(value(&opened, "device_2", 10).is_nan() && value(&opened, "object_1", 10) == 0.010);
    assert!((40..50).all(|tick| value(&opened, "object_1", tick).is_nan()));
    // 3 mm a tick apart: the overview's last part is the last tick.
    let overview = opened.overview_mm();
    assert!((f64::from(*overview.last().expect("parts")) - 297.0).abs() < 1e-3, "{:?}", overview.last());
    // No more than there is, and never more than may be asked for.
    assert_eq!(opened.samples(98, u32::MAX).count(), 2 * opened.width);
    assert_eq!(opened.samples(u32::MAX, 9).count(), 0);
    let why = Opened::new(&path, &recording, Some(EnvironmentKind::Plane), Kinds::default()).expect_err("a pair");
    assert!(why.to_string().contains("plane is not what was recorded: that is pair"), "{why}");
}

/// Issue 52, finding 9: mode and fault are part of a sample, and the page opens at the first fault.
#[test]
fn the_first_fault_is_found() {
    let row = |at: u32| {
        let stopped = f64::from(u8::from(at >= 40));
        tick(&[
            ("time_s", 1e-3 * f64::from(at)),
            ("tick", at.into()),
            ("mode", 1.0 + stopped),
            ("fault", 3.0 * stopped),
        ])
    };
    let rows: Vec<_> = (0..100).map(|at| (0, u64::from(at), row(at))).collect();
    let (path, recording) = recorded("fault", ticks::channels("peer_2", 1), &rows);
    let opened = Opened::new(&path, &recording, None, Kinds::default()).expect("a peer's");
    let [modes, faults] = [[39, 1], [40, 2]].map(|[tick, mode]| {
        let at = |column: usize| *opened.samples(tick, 1).nth(opened.width - 1 - column).expect("a number");
        assert!(at(4).is_nan() && at(3).is_nan(), "nobody knows of peer 1");
        (at(2) == mode as f32, at(1))
    });
    assert_eq!((modes, faults, opened.begin), ((true, 0.0), (true, 3.0), 40));
    assert_eq!(opened.hello()["columns"][2]["name"], "mode_2");
}

/// Issue 52: a recording of 19 kB took 1.64 GB, because each of its rows was a long time after the one before.
#[test]
fn gaps_take_no_more_room_than_rows() {
    let rows: Vec<_> = (0..200_u32)
        .map(|at| (0, 10 + u64::from(at), tick(&[("time_s", f64::from(at)), ("tick", 90_000.0 * f64::from(at))])))
        .collect();
    let (_, recording) = recorded("gaps", ticks::channels("peer_1", 1), &rows);
    let shown = ticks_of(&recording.channels[0]);
    assert!(shown.len() == 200 && shown.windows(2).all(|two| two[1] > two[0]));
    // The first gap is as long as it was; no second one has room.
    assert_eq!((shown[1], shown[199]), (90_000, 90_198));
}

#[test]
fn of_a_page_the_longest_is_shown_or_what_is_wanted() {
    let channels = super::super::control_loop::channels(Kinds::default(), "/both/ticks");
    let at = |kind: EnvironmentKind| u16::from(kind.number());
    let row = |kind: EnvironmentKind, x: f64| vec![x; 1 + columns(kind).count()];
    let rows = |kind, from: u64, count: u64| {
        (from..from + count).map(move |ms| (at(kind), ms, row(kind, ms as f64))).collect::<Vec<_>>()
    };
    let all = [rows(EnvironmentKind::Pair, 0, 20), rows(EnvironmentKind::Delay, 20, 30)].concat();
    let (path, recording) = recorded("page", channels, &all);
    let opened = Opened::new(&path, &recording, None, Kinds::default()).expect("a page's");
    assert_eq!((opened.kind, opened.ticks()), (EnvironmentKind::Delay, 30));
    assert!(opened.left_out.as_ref().is_some_and(|said| said.contains("20 ticks of pair")), "{:?}", opened.left_out);
    assert_eq!(value(&opened, "object_2", 29), 49.0);
    assert!(opened.overview_mm().len() == PARTS);
    let opened = Opened::new(&path, &recording, Some(EnvironmentKind::Pair), Kinds::default()).expect("a pair");
    assert_eq!((opened.kind, opened.ticks(), value(&opened, "device_1", 7)), (EnvironmentKind::Pair, 20, 7.0));
    let why =
        Opened::new(&path, &recording, Some(EnvironmentKind::TooStiff), Kinds::default()).expect_err("no picture");
    assert!(why.to_string().contains("too-stiff was not shown while it was recorded: there is pair, delay"), "{why}");
}

#[test]
fn what_cannot_be_shown_says_why() {
    let hub = ticks::hub_channels(2, 1);
    let row = vec![0.0; hub[0].fields.len()];
    let (path, recording) = recorded("hub", hub, &[(0, 0, row.clone()), (0, 1, row)]);
    let why = Opened::new(&path, &recording, None, Kinds::default()).expect_err("a hub").to_string();
    assert!(why.contains("of a hub") && why.contains("cohold-opened-hub"), "{why}");
    let (path, recording) = recorded("one", ticks::channels("peer_1", 1), &[(0, 0, tick(&[]))]);
    let why = Opened::new(&path, &recording, None, Kinds::default()).expect_err("one tick").to_string();
    assert!(why.contains("its times do not go on"), "{why}");
    let (path, recording) = recorded("none", ticks::channels("peer_1", 1), &[]);
    let why = Opened::new(&path, &recording, None, Kinds::default()).expect_err("nothing").to_string();
    assert!(why.contains("it has no ticks"), "{why}");
}
