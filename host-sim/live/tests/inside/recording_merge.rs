//! Recordings whose copies, clocks and networks are known, written and read as any are.

use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};

use cohold_sim::quantities;

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
    // Tests beside each other record under the same names.
    static MADE: AtomicU32 = AtomicU32::new(0);
    let (process, made) = (std::process::id(), MADE.fetch_add(1, Ordering::Relaxed));
    let path: PathBuf = std::env::temp_dir().join(format!("haptic-{name}-{process}-{made}.mcap"));
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
    let merged = merge(&one, &two, None).expect("they share a session");
    assert!(merged.instants > 9_900, "{merged:?}");
    for mm in [merged.true_discrepancy_mm, merged.rms_true_discrepancy_mm, merged.largest_true_discrepancy_mm] {
        assert!((mm - 3.0).abs() < 2e-3, "{merged:?}");
    }
    // 0.126 m/s at the most, times half of 300 µs and some.
    assert!((150.0..175.0).contains(&merged.clock_error_us), "{merged:?}");
    assert!((0.018..0.022).contains(&merged.largest_clock_error_mm), "{merged:?}");
    assert!((merged.clock_drift_ppm - 20.0).abs() < 0.5 && merged.clock_by.contains("314 exchanges"), "{merged:?}");
    // From the other side it is the same.
    let back = merge(&two, &one, None).expect("they share a session");
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
    assert!((merge(&one, &late, None).expect("they share a session").largest_true_discrepancy_mm - 3.25).abs() < 0.02);
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
    let merged = merge(&recordings[0], &recordings[1], None).expect("one machine recorded both");
    assert_eq!(merged.instants, 4000, "{merged:?}");
    let found = merged.table.column("true_discrepancy_m").expect("a column");
    for (tick, found) in (0..4000).zip(found) {
        let wanted = (f64::from(at(0, tick)) - f64::from(at(1, tick))).abs();
        assert_eq!(found.to_bits(), wanted.to_bits(), "tick {tick}");
    }
    assert!((200.0..260.0).contains(&merged.clock_error_us), "both boards' errors: {merged:?}");
}

/// A peer with a clock of its own, whose copy is on a course along so many axes, and its exchanges of a session with a true clock.
fn at_hub(
    name: &str,
    axes: usize,
    session: f64,
    [ahead_s, behind_m]: [f64; 2],
    odd: &[(usize, [f64; 2])],
) -> Recording {
    recorded(name, &origin(&name.replace('_', " "), name, 0), ticks::channels(name, axes), |row| {
        for at in 0..4000 {
            let (at_s, (object_m, speed)) = (1.0 + 1e-3 * at as f64, course(1.0 + 1e-3 * at as f64));
            for axis in 0..axes {
                let odd = odd.iter().find(|(odd, _)| axis == 0 && at == *odd).map(|(_, numbers)| *numbers);
                let [object_m, speed] = odd.unwrap_or([object_m - behind_m, speed]);
                row(ticks::of_axis(axis, ticks::SECONDS), tick(at_s + ahead_s, object_m, speed));
            }
            if at % 64 == 0 {
                row(1, vec![at_s + ahead_s, at_s + 150e-6, at_s + 650e-6, at_s + 800e-6 + ahead_s, session]);
            }
        }
    })
}

/// The true clock, with a line to each of the two.
fn hub() -> Recording {
    recorded("hub", &origin("hub", "hub", 0), ticks::hub_channels(2, 1), |row| {
        for (line, there_s) in [(0.0, 2.5002), (1.0, -6.9998)] {
            row(1, vec![0.5, there_s, there_s + 1e-4, 0.5005, 3.0 + line, line]);
        }
    })
}

/// Two peers on machines of their own have no session with each other, but each has one with the hub, which knows both.
#[test]
fn two_peers_of_a_hub_are_compared_by_its_clock() {
    let (one, two) = (at_hub("peer_1", 1, 3.0, [2.0, 0.0], &[]), at_hub("peer_2", 1, 4.0, [-7.5, 0.002], &[]));
    let hub = recorded("hub", &origin("hub", "hub", 0), ticks::hub_channels(2, 1), |row| {
        for line in [0.0, 1.0] {
            row(
                1,
                vec![0.5, [2.5002, -6.9998][line as usize], [2.5003, -6.9997][line as usize], 0.5005, 3.0 + line, line],
            );
        }
    });
    let why = merge(&one, &two, None).expect_err("they do not know each other").to_string();
    assert!(why.contains("in no session with each other") && why.contains("--hub"), "{why}");
    let merged = merge(&one, &two, Some(&hub)).expect("the hub knows both");
    assert!((merged.true_discrepancy_mm - 2.0).abs() < 2e-3 && merged.instants > 3990, "{merged:?}");
    assert!((merged.clock_offset_us + 9.5e6).abs() < 20.0 && merged.clock_by.ends_with("and their hub"), "{merged:?}");
    let why = merge(&one, &two, Some(&one)).expect_err("it is no hub of both").to_string();
    assert!(why.contains("is of no session with that hub"), "{why}");
}

/// 2 mm along each of two axes are 2.83 mm; and the file of both on one clock says the same.
#[test]
fn every_shared_axis_counts() {
    let (one, two) = (at_hub("peer_1", 2, 3.0, [2.0, 0.0], &[]), at_hub("peer_2", 2, 4.0, [-7.5, 0.002], &[]));
    let hub = hub();
    let merged = merge(&one, &two, Some(&hub)).expect("the hub knows both");
    assert_eq!(merged.axes, 2);
    assert!((merged.largest_true_discrepancy_mm - 8.0_f64.sqrt()).abs() < 3e-3, "{merged:?}");
    let path = std::env::temp_dir().join(format!("cohold-together-{}.mcap", std::process::id()));
    let _ = std::fs::remove_file(&path);
    let ended = super::super::together::write(&path, [&one, &two], Some(&hub), &merged).expect("a file");
    assert_eq!((ended.lost, &ended.failed), (0, &None));
    let together = read(&path).expect("a recording");
    std::fs::remove_file(&path).expect("it is there");
    let again = both(&together).expect("both ends");
    assert_eq!((again.axes, again.instants), (2, merged.instants));
    assert_eq!(again.rms_true_discrepancy_mm.to_bits(), merged.rms_true_discrepancy_mm.to_bits());
    // The same instant of both was recorded at the same time of one clock.
    let first = |topic: &str| {
        let rows = together.channels.iter().find(|rows| rows.topic == topic).expect("a channel");
        (rows.len(), rows.times_ns[rows.len() / 2])
    };
    let [(ticks, one_ns), (others, two_ns)] = ["/peer_1/ticks", "/peer_2/ticks"].map(first);
    assert_eq!((ticks, others), (4000, 4000));
    // These were put in as fast as they came, with clocks 9.5 s apart.
    let apart_s = 1e-9 * (two_ns as f64 - one_ns as f64);
    assert!((apart_s - 9.5).abs() < 1e-3, "{apart_s} s");
    let line = at_hub("peer_3", 1, 3.0, [0.0; 2], &[]);
    let why = merge(&one, &line, Some(&hub)).expect_err("another object").to_string();
    assert!(why.contains("the recording of peer 1 shares 2 axes, and the recording of peer 3 1"), "{why}");
}

/// What no copy does is left out and counted: no numbers, and a leap of a metre and back.
#[test]
fn what_is_no_motion_is_left_out() {
    let odd = [(500, [f64::NAN, 0.0]), (1000, [0.0, f64::INFINITY]), (2000, [1.0, 0.1])];
    let (one, two) = (at_hub("peer_1", 1, 3.0, [0.0, 0.0], &odd), at_hub("peer_2", 1, 3.0, [0.0, 0.001], &[]));
    let merged = merge(&one, &two, None).expect("a session of both");
    assert_eq!(merged.left_out, [4, 0], "the leap is a row there and one back");
    assert!((merged.largest_true_discrepancy_mm - 1.0).abs() < 2e-3, "{merged:?}");
}

#[test]
fn what_cannot_be_merged_is_said() {
    let peer = |name: &str, clock: &str| {
        recorded(name, &origin(name, clock, 0), ticks::channels(name, 1), |row| row(0, tick(1.0, 0.0, 0.0)))
    };
    let (one, two) = (peer("peer_1", "here"), peer("peer_2", "there"));
    // Even where both name one machine's clock.
    for two in [&two, &peer("peer_2", "here")] {
        let why = merge(&one, two, None).expect_err("no session").to_string();
        assert!(why.contains("in no session with each other"), "{why}");
    }
    for same in [&one, &peer("peer_1", "there")] {
        let why = merge(&one, same, None).expect_err("one end").to_string();
        assert!(why.contains("both are recordings of peer 1: one of each end is needed"), "{why}");
    }
    assert!(both(&one).expect_err("one end").to_string().contains("holds one end only"));
    let pair = recorded(
        "pair",
        &origin("both peers", "", 0),
        vec![Channel::new("/both/ticks", "Tick", [("time_s", ""), ("object_1_m", ""), ("object_2_m", "")])],
        |row| (0..4).for_each(|at| row(0, vec![f64::from(at), 0.001, -0.001])),
    );
    let merged = both(&pair).expect("both ends");
    assert_eq!((merged.instants, merged.rms_true_discrepancy_mm, merged.clock_error_us), (4, 2.0, 0.0));
    assert!(merge(&one, &pair, None).expect_err("no copy").to_string().contains("holds both ends already"));
    // In one session, but never both armed at once.
    let at = |name: &str, at_s: f64| {
        recorded(name, &origin(name, "here", 0), ticks::channels(name, 1), |row| {
            row(0, tick(at_s, 0.0, 0.0));
            row(1, vec![1.0, 1.0, 1.0, 1.0, SESSION]);
        })
    };
    let why = merge(&at("peer_1", 1.0), &at("peer_2", 5.0), None).expect_err("no instant").to_string();
    assert!(why.contains("no instant in common"), "{why}");
}
