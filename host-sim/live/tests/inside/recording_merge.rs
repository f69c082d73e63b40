//! Recordings whose copies, clocks and networks are known, written and read as any are.

use std::path::PathBuf;

use haptic_sim::quantities;

use super::super::file::{Recording, read};
use super::super::mcap::Channel;
use super::super::origin::Origin;
use super::super::recorder::Recorder;
use super::super::ticks;
use super::{both, merge};

const SESSION: f64 = 7.0;

fn origin(who: &str, clock: &str, start_clock_ns: u64) -> Origin {
    let (version, provenance, who, clock) = ("0".to_owned(), "[made]\n".to_owned(), who.to_owned(), clock.to_owned());
    Origin { version, provenance, who, start_unix_ns: 1_700_000_000_000_000_000, clock, start_clock_ns }
}

fn recorded(
    name: &str,
    origin: &Origin,
    channels: Vec<Channel>,
    rows: impl Fn(&mut dyn FnMut(u16, Vec<f64>)),
) -> Recording {
    let path: PathBuf = std::env::temp_dir().join(format!("haptic-{name}-{}.mcap", std::process::id()));
    let _ = std::fs::remove_file(&path);
    let recorder = Recorder::create(&path, origin, channels).expect("a file");
    let mut at = 0;
    rows(&mut |channel, values| {
        at += 1_000;
        recorder.put_all(channel, at, &values);
    });
    let ended = recorder.finish();
    assert_eq!((ended.lost, ended.failed), (0, None));
    let recording = read(&path).expect("a recording");
    std::fs::remove_file(&path).expect("it is there");
    assert!(recording.cut.is_none() && recording.lost == Some(0) && recording.origin == *origin);
    recording
}

/// A row of ticks: armed, with a copy at a place.
fn tick(time_s: f64, object_m: f64, object_m_per_s: f64) -> Vec<f64> {
    let mut row = vec![0.0; ticks::TICK.len()];
    for (name, number) in
        [("time_s", time_s), ("mode", 1.0), ("object_m", object_m), ("object_m_per_s", object_m_per_s)]
    {
        row[quantities::place(&ticks::TICK, name)] = number;
    }
    row
}

/// Where a copy is at a true time, and how fast.
fn course(at_s: f64) -> (f64, f64) {
    let rate = std::f64::consts::TAU;
    (0.02 * (rate * at_s).sin(), 0.02 * rate * (rate * at_s).cos())
}

/// Peer 1's clock is true; peer 2's is 3.25 s ahead and gains 20 ppm. Its ticks are 0.4 ms later, its copy 3 mm behind, and each way
/// takes 150 µs.
#[test]
fn two_peers_on_clocks_of_their_own() {
    let other = |at_s: f64| at_s + 3.25 + 2e-5 * at_s;
    let exchange = |at_s: f64| vec![other(at_s), at_s + 150e-6, at_s + 650e-6, other(at_s + 800e-6), SESSION];
    let one = recorded("one", &origin("peer 1", "here", 0), ticks::channels("peer_1", 1), |row| {
        for at in 0..10_000 {
            let at_s = 1.0 + 1e-3 * f64::from(at);
            row(0, tick(at_s, course(at_s).0, course(at_s).1));
            if at % 64 == 0 {
                let times = [at_s, other(at_s + 150e-6), other(at_s + 650e-6), at_s + 800e-6];
                row(1, [&times[..], &[SESSION]].concat());
            }
        }
    });
    let two = recorded("two", &origin("peer 2", "there", 0), ticks::channels("peer_2", 1), |row| {
        for at in 0..10_000 {
            let at_s = 1.0004 + 1e-3 * f64::from(at);
            row(0, tick(other(at_s), course(at_s).0 - 0.003, course(at_s).1));
            if at % 64 == 0 {
                row(1, exchange(at_s));
            }
        }
    });
    let merged = merge(&one, &two).expect("they share a session");
    assert!(merged.instants > 9_900, "{merged:?}");
    for mm in [merged.true_discrepancy_mm, merged.rms_true_discrepancy_mm, merged.largest_true_discrepancy_mm] {
        assert!((mm - 3.0).abs() < 2e-3, "{merged:?}");
    }
    // 0.126 m/s at the most, times half of 300 µs and some.
    assert!((150.0..175.0).contains(&merged.clock_error_us), "{merged:?}");
    assert!((0.018..0.022).contains(&merged.largest_clock_error_mm), "{merged:?}");
    assert!((merged.clock_drift_ppm - 20.0).abs() < 0.5 && merged.clock_by.contains("314 exchanges"), "{merged:?}");
    // From the other side it is the same.
    let back = merge(&two, &one).expect("they share a session");
    assert!((back.rms_true_discrepancy_mm - merged.rms_true_discrepancy_mm).abs() < 2e-3, "{back:?}");
    assert!((back.clock_offset_us + merged.clock_offset_us).abs() < 2.0, "{back:?} {merged:?}");
    // Were its ticks 2 ms late, at 0.126 m/s, it would show.
    let late = recorded("late", &origin("peer 2", "there", 0), ticks::channels("peer_2", 1), |row| {
        for at in 0..10_000 {
            let at_s = 1.0004 + 1e-3 * f64::from(at);
            row(0, tick(other(at_s) + 0.002, course(at_s).0 - 0.003, course(at_s).1));
            if at % 64 == 0 {
                row(1, exchange(at_s));
            }
        }
    });
    assert!((merge(&one, &late).expect("they share a session").largest_true_discrepancy_mm - 3.25).abs() < 0.02);
}

/// Two boards in step, recorded by operators on one machine: to the bit.
#[test]
fn two_boards_to_the_bit() {
    let columns = ["time_s", "tick", "mode", "object_m", "object_m_per_s", "sealed_s"];
    let at = |board: usize, tick: u32| course(1e-3 * f64::from(tick) + 0.01 * board as f64).0 as f32;
    // What each board's clock shows beside the machine's, and the tick that it counts while the other counts 0.
    let boards = [(40.0, 0.0), (-3.0, 512.0)];
    let recordings = [0, 1].map(|board| {
        let (ahead_s, from) = boards[board];
        let channels = vec![
            Channel::new(format!("/board_{}/ticks", board + 1), "Tick", columns.map(|name| (name, ""))),
            Channel::new(format!("/board_{}/exchanges", board + 1), "Exchange", ticks::EXCHANGE),
        ];
        let who = format!("operator of board {}", board + 1);
        // The second operator's recording began 2.5 s after the first one's.
        let began_s = 2.5 * board as f64;
        recorded(&format!("board{board}"), &origin(&who, "here", (1e9 * began_s) as u64), channels, |row| {
            for tick in 0..4000_u32 {
                let true_s = 1e-3 * f64::from(tick);
                // Each is sealed some time after its tick; now and then at once.
                let sealed_s = true_s + ahead_s + 0.0003 * f64::from(tick % 7);
                let count = f64::from(tick) + from;
                row(0, vec![1e-3 * count, count, 1.0, at(board, tick).into(), 0.1, sealed_s]);
                if tick % 100 == 0 {
                    let own_s = true_s - began_s;
                    row(
                        1,
                        vec![
                            own_s,
                            true_s + ahead_s + 1e-4,
                            true_s + ahead_s + 2e-4,
                            own_s + 3e-4,
                            SESSION + board as f64,
                        ],
                    );
                }
            }
        })
    });
    let merged = merge(&recordings[0], &recordings[1]).expect("one machine recorded both");
    assert_eq!(merged.instants, 4000, "{merged:?}");
    let found = merged.table.column("true_discrepancy_m").expect("a column");
    for (tick, found) in (0..4000).zip(found) {
        let wanted = (f64::from(at(0, tick)) - f64::from(at(1, tick))).abs();
        assert_eq!(found.to_bits(), wanted.to_bits(), "tick {tick}");
    }
    assert!((200.0..260.0).contains(&merged.clock_error_us), "both boards' errors: {merged:?}");
}

#[test]
fn what_cannot_be_merged_is_said() {
    let peer = |name: &str, clock: &str| {
        recorded(name, &origin(name, clock, 0), ticks::channels(name, 1), |row| row(0, tick(1.0, 0.0, 0.0)))
    };
    let (one, two) = (peer("peer_1", "here"), peer("peer_2", "there"));
    let why = merge(&one, &two).expect_err("no session, two machines").to_string();
    assert!(why.contains("no clock in common"), "{why}");
    assert!(both(&one).expect_err("one end").to_string().contains("holds one end only"));
    let pair = recorded(
        "pair",
        &origin("both peers", "", 0),
        vec![Channel::new("/both/ticks", "Tick", [("time_s", ""), ("object_1_m", ""), ("object_2_m", "")])],
        |row| (0..4).for_each(|at| row(0, vec![f64::from(at), 0.001, -0.001])),
    );
    let merged = both(&pair).expect("both ends");
    assert_eq!((merged.instants, merged.rms_true_discrepancy_mm, merged.clock_error_us), (4, 2.0, 0.0));
    assert!(merge(&one, &pair).expect_err("no copy").to_string().contains("has no column mode"));
    // On one machine, without a word with each other; but never both armed at once.
    let other = recorded("other", &origin("peer 2", "here", 5_000_000_000), ticks::channels("x", 1), |row| {
        row(0, tick(1.0, 0.0, 0.0));
    });
    assert!(merge(&one, &other).expect_err("no instant").to_string().contains("no instant in common"));
}
