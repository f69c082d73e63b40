//! An operator who holds the key and says whatever comes: it is answered, starts no motor but by a line that starts one, raises no limit, and
//! resets nothing.
//!
//! `COHOLD_LINES=100000` says more of them than a check has time for.

use std::sync::Arc;

use board_bench::bench::Bench;
use board_bench::image::Firmware;
use board_bench::reviewed;
use board_bench::wire::Line;
use cohold_core::settings::Settings;
use firmware_parts::operator::{Request, parse};

/// Lines in a check.
const LINES: u64 = 600;
/// First words, and forms of what follows: K is a key, V a value, N a number, S a shape of a probe.
const FORMS: [&str; 23] = [
    "status",
    "arm",
    "arm alone",
    "disarm",
    "clear",
    "home",
    "clutch",
    "release",
    "check N",
    "probe N S V V V",
    "probed",
    "set K V",
    "set K V",
    "set K V",
    "get K",
    "defaults",
    "apply",
    "save",
    "stream N",
    "capture N",
    "capture N at V",
    "blackbox",
    "history",
];
const VALUES: [&str; 21] = [
    "0",
    "1",
    "-1",
    "0.5",
    "1e-9",
    "1e9",
    "1e300",
    "-1e300",
    "nan",
    "inf",
    "-inf",
    "true",
    "false",
    "off",
    "amplifier",
    "bridge",
    "power",
    "wave",
    "self-timed",
    "midpoint",
    "engaged",
];
const NUMBERS: [&str; 8] = ["0", "1", "2", "3", "4294967295", "4294967296", "-1", "x"];
const SHAPES: [&str; 6] = ["pulse", "swing", "ramp", "sine", "winding", "none"];
/// What is no line, or has more in it than it needs.
const OTHERS: [&str; 6] =
    ["", " ", "disarm now", "ärm", "\u{1}\u{7f}", "set set set set set set set set set set set set set set"];

/// SplitMix64.
struct Random(u64);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mixed = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((mixed ^ mixed >> 31) % end as u64) as usize
    }

    fn one<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.below(of.len())]
    }
}

/// A line that means something, or one of whose letters was changed, or none at all.
fn line(random: &mut Random, keys: &[&str]) -> String {
    if random.below(20) == 0 {
        return random.one(&OTHERS).to_owned();
    }
    let words = random.one(&FORMS).split(' ').map(|word| match word {
        "K" => random.one(keys),
        "V" => random.one(&VALUES),
        "N" => random.one(&NUMBERS),
        "S" => random.one(&SHAPES),
        word => word,
    });
    let mut line = words.collect::<Vec<_>>().join(" ").into_bytes();
    if random.below(4) == 0 {
        let at = random.below(line.len());
        line[at] = 0x20 + random.below(0x5F) as u8;
    }
    String::from_utf8(line).expect("of ASCII")
}

#[test]
fn no_line_does_what_it_does_not_say() {
    let lines = std::env::var("COHOLD_LINES").ok().and_then(|lines| lines.parse().ok()).unwrap_or(LINES);
    let keys: Vec<_> = Settings::keys().map(|key| key.name).collect();
    let mut bench = Bench::start(&Arc::new(Firmware::release()), 1, Line::default());
    bench.tell_of_amplifiers(1);
    bench.check(1).expect("it passes");
    let mut random = Random(1);
    let (mut done, mut armed) = (0, 0);
    for number in 0..lines {
        let said = line(&mut random, &keys);
        let request = parse(&said);
        // It leads to the bootloader, which is another program's test.
        if request == Ok(Request::Update) {
            continue;
        }
        let answer = bench.ask(1, &said);
        let told = format!("line {number}, {said:?}: {answer:?}");
        assert!(answer.starts_with("ok ") || answer.starts_with("error "), "{told}");
        let is_done = answer.starts_with("ok ");
        assert!(request.is_ok() || !is_done, "{told}");
        let starts = matches!(request, Ok(Request::Arm { .. } | Request::Check(_) | Request::Probe(_))) && is_done;
        (done, armed) = (done + u64::from(is_done), armed + u64::from(starts));
        if starts {
            // What it starts ends by `disarm`, whatever was set before.
            bench.run_for_ms(1 + random.below(20) as u64);
            assert_eq!(bench.ask(1, "disarm"), "ok disarmed", "{told}");
        }
        bench.run_for_ms(2);
        assert!(!bench.stopped[0].bridges.on(), "{told}");
    }
    // From afar no limit is above what the board was set to, whatever was applied and saved meanwhile.
    bench.run_for_ms(1500);
    assert!(bench.ask(1, "defaults").starts_with("ok "));
    for key in ["safety.max_force_n", "safety.max_slew_n_per_s", "safety.max_speed_m_per_s"] {
        assert!(bench.ask(1, &format!("set {key} 100")).starts_with("ok "));
        let refused = bench.ask(1, "apply");
        assert!(refused.contains(" what this board was set to, "), "{key}: {refused}");
        assert!(bench.ask(1, "defaults").starts_with("ok "));
    }
    assert!(done > lines / 10 && armed > 0, "{done} lines of {lines} did something, {armed} of them with motors");
    assert!(bench.ask(1, "status").starts_with("ok board 1 "));
    reviewed::check_all(&bench.finish());
}
