//! What irtt and ping measured, as a network: a real file of irtt, written on loopback by irtt 0.9.0, and others by hand.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use cohold_sim::network::clocks::{Clocks, Trip};
use cohold_sim::network::rule::{Direction, of_scene};
use cohold_sim::rng::Rng;
use cohold_sim::scene::Scene;
use cohold_sim::{Laws, scenes};
use flate2::{Compression, write::GzEncoder};

const MS: u64 = 1_000_000;

fn measured() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/irtt.json")
}

fn with(file: &Path) -> Result<Scene, String> {
    let mut scene = scenes::load(Laws::built_in(), "any-network").expect("built in");
    let set = scene.apply_override(&format!("network.trace={}", file.display()));
    set.map(|()| scene).map_err(|error| error.to_string())
}

fn written(name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&file, bytes).expect("a file");
    file
}

/// Delays of the copies of packets that are sent then, ns; none of one that is lost.
fn delays(scene: &Scene, direction: Direction, sent_ns: impl Iterator<Item = u64>) -> Vec<Option<u64>> {
    let mut rule = of_scene(scene, direction, 0).expect("a trace");
    sent_ns
        .zip(0..)
        .map(|(sent, number)| rule.decide(number, sent).copies().first().map(|copy| copy.delay_ns))
        .collect()
}

/// Each delay of the file less the least of its direction, for the 10 ms that it was measured every; by the file's own numbers.
#[test]
fn a_file_of_irtt_s_own_is_the_network_that_it_measured() {
    let file: serde_json::Value = serde_json::from_slice(&std::fs::read(measured()).expect("a file")).expect("JSON");
    let scene = with(&measured()).expect("a trace");
    let trips = file["round_trips"].as_array().expect("round trips");
    for (direction, name) in [(Direction::OneToTwo, "send"), (Direction::TwoToOne, "receive")] {
        let all: Vec<i64> = trips.iter().map(|trip| trip["delay"][name].as_i64().expect("came back")).collect();
        let least = all.iter().min().expect("some");
        let wanted: Vec<_> = all.iter().map(|delay| Some((delay - least).unsigned_abs())).collect();
        // The scene sends a packet a tick: ten in each interval.
        let seen = delays(&scene, direction, (0..10 * trips.len() as u64).map(|tick| tick * MS));
        for (at, delay) in seen.iter().enumerate() {
            assert_eq!(*delay, wanted[at / 10], "{name}, tick {at}");
        }
        let around = delays(&scene, direction, (0..1).map(|_| 10 * trips.len() as u64 * MS));
        assert_eq!(around[0], wanted[0], "it begins anew");
    }
    let least = file["stats"]["rtt"]["min"].as_f64().expect("a number");
    let constant_s = scene.network_trace.expect("a trace").constant_s();
    assert!((constant_s - 0.5e-9 * least).abs() < 1e-9, "{constant_s} s");
}

/// What irtt writes without a name: the same, compressed.
#[test]
fn a_compressed_file_is_the_same_network() {
    let plain = std::fs::read(measured()).expect("a file");
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(&plain).expect("memory");
    let compressed = with(&written("irtt.json.gz", encoder.finish().expect("memory"))).expect("a trace");
    let sent = || (0..1000).map(|tick| tick * MS);
    let plain = with(&measured()).expect("a trace");
    for direction in [Direction::OneToTwo, Direction::TwoToOne] {
        assert_eq!(delays(&compressed, direction, sent()), delays(&plain, direction, sent()));
    }
    let error = with(&written("cut.json.gz", [0x1f, 0x8b, 8, 0])).expect_err("cut off");
    assert!(error.contains("cut.json.gz"), "{error}");
}

/// Issue 51: a clock that was set by 30 ms, or ran 50 ppm faster, silently made the network 30 or 15 ms slower. For 5 min of round trips on
/// networks of 3 to 20 ms the delays that are found are those that were drawn to 0.2 ms, whichever clock does what. A clock that is
/// right is not touched at all.
#[test]
fn clocks_that_are_set_or_drift_change_no_delay() {
    const EVERY: i64 = 8 * MS as i64;
    let mut worst = 0_u64;
    for (seed, (steps, ppm)) in
        (1..).zip([(&[][..], 0.0), (&[30][..], 0.0), (&[], 50.0), (&[30, -45], -20.0), (&[-250, 3], 100.0)])
    {
        let mut rng = Rng::new(seed);
        // Mostly quick, now and then held up by up to 200 ms; a busy hour in the middle, in which nothing is quick.
        let mut held_up = |at: usize, least_ms: f64| {
            let tail = if rng.unit() < 0.02 { 200.0 } else { 1.0 };
            let busy = if (15_000..18_000).contains(&at) { 15.0 } else { 0.0 };
            (1e6 * (least_ms + busy * rng.unit() - tail * (1.0 - rng.unit()).ln())) as i64
        };
        let drawn: Vec<[i64; 2]> = (0..37_500).map(|at| [held_up(at, 3.0), held_up(at, 20.0)]).collect();
        let trips: Vec<Trip> = (0..)
            .zip(&drawn)
            .map(|(at, [there_ns, back_ns])| {
                let set =
                    |(nth, ms): (usize, &i64)| if at * 3 > (nth as i64 + 1) * 37_500 { ms * MS as i64 } else { 0 };
                let set: i64 = steps.iter().enumerate().map(set).sum();
                let ahead = 3_600_000 * MS as i64 + set + (1e-6 * ppm * (at * EVERY) as f64) as i64;
                Trip { at_ns: at * EVERY, there_ns: there_ns + ahead, back_ns: back_ns - ahead }
            })
            .collect();
        let found = Clocks::of(&trips).expect("round trips");
        let least = [0, 1].map(|way| drawn.iter().map(|delays| delays[way]).min().expect("some"));
        let off = |(found, drawn): (&[u64; 2], &[i64; 2])| {
            [0, 1].map(|way| found[way].abs_diff((drawn[way] - least[way]).unsigned_abs())).into_iter().max()
        };
        let off = found.delays_ns.iter().zip(&drawn).filter_map(off).max().expect("some");
        assert_eq!(found.steps, steps.len(), "{seed}: {} ppm, off by {off} ns", found.drift_ppm);
        assert!((found.drift_ppm - ppm).abs() < 3.0, "{seed}: {} ppm", found.drift_ppm);
        assert!(off == 0 || (seed > 1 && off < MS / 5), "{seed}: off by {off} ns");
        worst = worst.max(off);
    }
    println!("delays are off by at most {worst} ns");
}

/// Half of each round trip each way; the fourth is not answered, the third comes twice, two overtake each other.
#[test]
fn a_log_of_ping_is_a_network_of_half_its_round_trips() {
    let line = |second: f64, sequence: u32, ms: f64, more: &str| {
        format!("[{second:.6}] 64 bytes from 192.0.2.1: icmp_seq={sequence} ttl=64 time={ms} ms{more}\n")
    };
    let log = ["PING 192.0.2.1 (192.0.2.1) 56(84) bytes of data.\n".to_owned()]
        .into_iter()
        .chain([
            line(1_764_150_000.030, 65_534, 30.0, ""),
            line(1_764_150_000.052, 65_535, 32.0, ""),
            line(1_764_150_000.071, 0, 31.0, ""),
            line(1_764_150_000.072, 0, 32.0, " (DUP!)"),
            "no answer yet for icmp_seq=1\n".to_owned(),
            line(1_764_150_000.131, 3, 31.0, ""),
            line(1_764_150_000.150, 2, 70.0, ""),
            "\n--- 192.0.2.1 ping statistics ---\n".to_owned(),
        ])
        .collect::<String>();
    let scene = with(&written("ping.txt", &log)).expect("a trace");
    let every = || (0..6).map(|trip| 20 * MS * trip);
    let us = |number: u64| Some(1000 * number);
    for direction in [Direction::OneToTwo, Direction::TwoToOne] {
        let found = [us(0), us(1000), us(500), None, us(20_000), us(500)];
        assert_eq!(delays(&scene, direction, every()), found);
    }
    assert_eq!(scene.network_trace.expect("a trace").constant_s(), 0.015);
    for (text, why) in [
        (log.replace("[1764150000.052000] ", ""), "line 3: it does not begin with the time in brackets: ping needs -D"),
        (log.replace("time=32 ", "time=long "), "line 3: icmp_seq and time must be numbers"),
        ("PING nobody\n".to_owned(), "at least two answers of different times are needed"),
        // Few answers, and as many numbers between them as fit: they would take gigabytes.
        (
            (0..200).map(|at| line(f64::from(at), 32_000 * at % 65_536, 1.0, "")).collect(),
            "line 114: it is more than 3600000 numbers after the first",
        ),
    ] {
        let error = with(&written("refused.txt", &text)).expect_err(why);
        assert!(error.contains(why), "{error}");
    }
}

fn by_hand(trips: &str) -> String {
    format!("{{\"config\": {{\"params\": {{\"interval\": 20000000}}}}, \"round_trips\": [{trips}]}}")
}

/// Lost there, lost back, lost somewhere; no clock at the server; a clock that is behind.
#[test]
fn what_is_lost_is_lost_in_its_direction() {
    let text = by_hand(
        r#"{"seqno": 0, "lost": "false", "delay": {"rtt": 30000000, "send": -4000000, "receive": 34000000}},
           {"seqno": 1, "lost": "true_up", "delay": {}},
           {"seqno": 2, "lost": "true_down", "delay": {}},
           {"seqno": 3, "lost": true},
           {"seqno": 4, "lost": false, "delay": {"rtt": 39000000, "send": 1000000, "receive": 38000000}}"#,
    );
    let scene = with(&written("by-hand.json", &text)).expect("a trace");
    let every = || (0..5).map(|trip| 20 * MS * trip);
    let ms = |number: u64| Some(number * MS);
    assert_eq!(delays(&scene, Direction::OneToTwo, every()), [ms(0), None, ms(0), None, ms(5)]);
    assert_eq!(delays(&scene, Direction::TwoToOne, every()), [ms(0), ms(0), None, None, ms(4)]);
    let text = by_hand(
        r#"{"seqno": 0, "lost": false, "delay": {"rtt": 30000000}}, {"seqno": 1, "lost": false, "delay": {"rtt": 36000000}}"#,
    );
    let scene = with(&written("no-clock.json", &text)).expect("a trace");
    for direction in [Direction::OneToTwo, Direction::TwoToOne] {
        assert_eq!(delays(&scene, direction, every().take(2)), [ms(0), ms(3)]);
    }
}

#[test]
fn what_is_no_measurement_is_refused_by_name() {
    for (text, why) in [
        ("{}", "not what irtt writes: missing field `config`"),
        (&by_hand(""), "no round trip came back"),
        (&by_hand(r#"{"seqno": 0, "lost": "true", "delay": {}}"#), "no round trip came back"),
        (&by_hand(r#"{"seqno": 1, "lost": false, "delay": {"rtt": 1}}"#), "round_trips[0]: seqno 1 must be 0"),
        (
            &by_hand(r#"{"seqno": 0, "lost": "perhaps", "delay": {"rtt": 1}}"#),
            "round_trips[0]: lost must be false, true, true_up or true_down",
        ),
        (
            &by_hand(r#"{"seqno": 0, "lost": false, "delay": {"rtt": 1}}, {"seqno": 1, "lost": false}"#),
            "round_trips[1]: it is not lost and has no delay",
        ),
        (&by_hand(r#"{"seqno": 0, "lost": false, "delay": {"rtt": 1}}"#).replace("20000000", "0"), "interval = 0"),
    ] {
        let error = with(&written("refused.json", text)).expect_err(why);
        assert!(error.contains(why) && error.contains("refused.json"), "{error}");
    }
}
