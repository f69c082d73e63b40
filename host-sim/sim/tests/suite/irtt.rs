//! What irtt measured, as a network: a real file of its, written on loopback by irtt 0.9.0, and one by hand.

use std::path::{Path, PathBuf};

use haptic_sim::network::rule::{Direction, of_scene};
use haptic_sim::scene::Scene;
use haptic_sim::{Laws, scenes};

const MS: u64 = 1_000_000;

fn measured() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/irtt.json")
}

fn with(file: &Path) -> Result<Scene, String> {
    let mut scene = scenes::load(Laws::built_in(), "any-network").expect("built in");
    let set = scene.apply_override(&format!("network.trace={}", file.display()));
    set.map(|()| scene).map_err(|error| error.to_string())
}

fn written(name: &str, text: &str) -> PathBuf {
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&file, text).expect("a file");
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
