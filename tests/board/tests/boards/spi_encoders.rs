//! A board whose joints are read by absolute encoders on SPI: it holds one cube with a board with quadrature encoders, bit for bit what cohold
//! computes, and two of them do with current loops. Whatever goes wrong with an encoder or its wires turns the motors off within a stated
//! time, with the cause told; a single wrong bit does not.
//!
//! Longer: `COHOLD_SECONDS=10 cargo test -p board-bench --test boards spi_encoders::`, which runs the first of these over 10 s instead of 2.

use std::sync::Arc;

use board_bench::bench::Bench;
use board_bench::cost::MedianAndMost;
use board_bench::image::Firmware;
use board_bench::node::Inputs;
use board_bench::part::as5047p::Planted;
use board_bench::reviewed;
use board_bench::trial;
use board_bench::twin::{self, Equal};
use board_bench::wire::Line;
use firmware_parts::as5047p::BAD;

use crate::{breaks, current_loop};

/// MODER and AFRL of port F (PF7, PF8, PF9 reach into AFRH), MODER of ports C and A, AFRH of port C.
const PINS: [u64; 6] = [0x5802_1400, 0x5802_1420, 0x5802_1424, 0x5802_0800, 0x5802_0824, 0x5802_0000];
/// CFG1 and CFG2 of SPI5 and SPI3.
const CONFIGURED: [u64; 4] = [0x4001_5008, 0x4001_500C, 0x4000_3C08, 0x4000_3C0C];
/// What a frame of 16 bits takes at 7.5 MHz, and what an AS5047P wants before its clock and between frames, ns.
const FRAME_NS: u64 = 2133;
const PAUSE_NS: u64 = 350;

/// What a board with the usual image and one with encoders on SPI computed, for so long, and the instructions of the latter's ticks.
pub(crate) fn run(seconds: u64) -> (Equal, MedianAndMost) {
    let scene = breaks::scene(&[]);
    let images = [Firmware::release(), Firmware::with("spi-encoders").alone()].map(Arc::new);
    let mut bench = Bench::mixed(&images, trial::line(&scene).expect("a wire can do it"));
    bench.set_up(&scene).expect("the boards take the scene");
    bench.arm();
    bench.count_instructions();
    bench.run_for_ms(1000 * seconds);
    let instructions = MedianAndMost::of(bench.meters[1].ticks.iter().copied());
    bench.drain();
    let boards = bench.both_since_armed(1000 * seconds);
    for board in boards {
        // They hold it: the cube moves, and both hands feel it.
        let moved = board.records.iter().map(|record| record.observed().object.position.abs()).fold(0.0, f32::max);
        assert!(moved > 0.001, "{moved}");
    }
    let equal = twin::closed_loop_given(&scene, boards);
    let frames = bench.stopped[1].encoders.map(|encoder| encoder.frames);
    assert!(frames.iter().all(|frames| *frames >= 2000 * seconds), "{frames:?}");
    bench.finish().iter().for_each(reviewed::check);
    (equal, instructions)
}

#[test]
fn a_board_with_quadrature_and_one_with_encoders_on_spi_hold_one_cube() {
    let seconds = std::env::var("COHOLD_SECONDS").map_or(2, |seconds| seconds.parse().expect("seconds"));
    let (equal, instructions) = run(seconds);
    println!("{seconds} s: {equal:?}, {instructions:?}");
    assert_eq!(equal.first_difference, None);
}

#[test]
fn two_boards_with_encoders_on_spi_and_windings_equal_cohold() {
    let (firmware, scene) = (Arc::new(Firmware::with("spi-encoders")), current_loop::scene(&["axis.count=2"]));
    let mut bench = breaks::just_armed(&firmware, 2, Line::default(), &scene);
    bench.run_for_ms(1000);
    let boards = [bench.armed_ticks(1), bench.armed_ticks(2)];
    let ticks = boards[0].len().min(boards[1].len()) as u64;
    assert!(ticks >= 1000, "only {ticks} ticks were recorded");
    assert_eq!(twin::closed_loop(&scene, boards), Equal { ticks, first_difference: None });
    bench.finish().iter().for_each(reviewed::check);
}

/// A board alone with encoders on SPI, armed.
fn armed() -> Bench {
    let bench = breaks::armed(&Arc::new(Firmware::with("spi-encoders")), &breaks::scene(&[]));
    assert!(bench.stopped[0].bridges.on(), "the motors are on");
    bench
}

#[test]
fn buses_and_pins_are_as_the_encoders_want_them() {
    let mut bench = armed();
    let [mode_f, low_f, high_f, mode_c, high_c, mode_a] = bench.peek(1, PINS)[..] else { panic!("six words") };
    assert_eq!((mode_f >> 14 & 0x3F, low_f >> 28, high_f & 0xFF), (0b10_1010, 5, 0x55), "PF7 to PF9 lead to SPI5");
    assert_eq!((mode_c >> 20 & 0x3F, high_c >> 8 & 0xFFF), (0b10_1010, 0x666), "PC10 to PC12 lead to SPI3");
    assert_eq!((mode_a >> 8 & 3, mode_a >> 30), (1, 1), "PA4 and PA15 are outputs");
    let configured = bench.peek(1, CONFIGURED);
    for pair in configured.chunks(2) {
        // 16 bits, an eighth of the kernel's clock and a half; CPHA alone, and a master.
        assert_eq!((pair[0] & 0x1F, pair[0] >> 28 & 7), (15, 3), "{pair:x?}");
        assert_eq!((pair[1] >> 22 & 0xF, pair[1] >> 17 & 3), (0b0101, 0), "{pair:x?}");
    }
    for encoder in bench.stopped[0].encoders {
        let [frame, pause] = encoder.shortest_ns;
        println!("{} frames: {frame} ns from select to end at the least, {pause} ns between two", encoder.frames);
        assert!(frame >= PAUSE_NS + FRAME_NS && pause >= PAUSE_NS, "{:?}", encoder.shortest_ns);
    }
    bench.finish();
}

/// What goes wrong with the first encoder, within how many ms the motors are off, and what is told.
const CAUSES: [(&str, Planted, u64, &str, &str); 9] = [
    ("no supply, or chip select off", Planted::Dead, BAD as u64, "fault 70", "encoder 1 does not answer"),
    ("its line at ground", Planted::Shorted, BAD as u64, "fault 70", "encoder 1 does not answer"),
    ("it hears nothing", Planted::Deaf, BAD as u64 + 1, "fault 70", "encoder 1 does"),
    (
        "every frame from it has a wrong bit",
        Planted::Told(1 << 3),
        BAD as u64,
        "fault 70",
        "encoder 1 and the board do not",
    ),
    (
        "every frame to it has a wrong bit",
        Planted::Heard(1 << 9),
        BAD as u64 + 1,
        "fault 70",
        "encoder 1 and the board do not",
    ),
    ("its error flag", Planted::Told(1 << 14 | 1 << 15), BAD as u64, "fault 70", "encoder 1 and the board do not"),
    ("its magnet is off", Planted::Weak, BAD as u64 + 1, "fault 71", "encoder 1 sees too weak a field"),
    ("another magnet", Planted::Strong, BAD as u64 + 1, "fault 71", "encoder 1 sees too strong a field"),
    ("its magnet slipped by a fifth of a turn", Planted::Slipped(3277), 1, "fault 2 ", ""),
];

#[test]
fn the_motors_are_off_within_their_time_and_the_cause_is_told() {
    for (what, planted, within_ms, told, explained) in CAUSES {
        let mut bench = armed();
        bench.input(1).encoder = Some((0, planted));
        let begun = bench.now_ns();
        while bench.stopped[0].bridges.on() {
            bench.run_for_us(100);
            assert!(bench.now_ns() <= begun + (within_ms + 1) * 1_000_000, "{what}: the motors stay on");
        }
        let after_ms = (bench.now_ns() - begun) as f64 / 1e6;
        println!("{what}: off after {after_ms} ms");
        // A tick comes half a period after what goes wrong.
        assert!(after_ms <= within_ms as f64, "{what}: off after {after_ms} ms");
        bench.run_for_ms(40);
        let status = bench.ask(1, "status");
        assert!(status.contains(told) && status.contains(explained), "{what}: {status}");
        // It is not armed while that lasts, and only after an order when it is over.
        assert!(bench.ask(1, "arm").starts_with("error "), "{what}");
        bench.input(1).encoder = Some((0, Planted::None));
        bench.run_for_ms(20);
        assert!(!bench.stopped[0].bridges.on(), "{what}: on again by itself");
        assert!(breaks::arm_again(&mut bench, what), "{what}: it may have lost count, and nobody checked signs again");
        bench.run_for_ms(20);
        assert!(bench.stopped[0].bridges.on(), "{what}: on after clear, check and arm");
        bench.finish().iter().for_each(reviewed::check);
    }
}

#[test]
fn a_wrong_bit_for_a_tick_turns_nothing_off() {
    let mut bench = armed();
    for bit in 0..16 {
        for planted in [Planted::Told(1 << bit), Planted::Heard(1 << bit)] {
            bench.input(1).encoder = Some((0, planted));
            bench.run_for_ms(1);
            bench.input(1).encoder = Some((0, Planted::None));
            bench.run_for_ms(5);
            assert!(bench.stopped[0].bridges.on(), "{planted:?}: {}", bench.ask(1, "status"));
        }
    }
    bench.finish().iter().for_each(reviewed::check);
}

/// CR1 of SPI5, with SSI alone and with what runs; RCC_APB2ENR, and the bit of SPI5 in it.
const CR1: u64 = 0x4001_5000;
const STOPPED: u32 = 1 << 12;
const RUNS: u32 = STOPPED | 1 << 9 | 1;
const APB2ENR: u64 = 0x5802_44F0;
const SPI5EN: u32 = 1 << 20;

#[test]
fn a_bus_that_was_stopped_is_started_anew_by_the_next_tick() {
    let mut bench = armed();
    bench.input(1).poke.push((CR1, STOPPED));
    bench.run_for_ms(1);
    assert_eq!(bench.peek(1, [CR1])[0] & RUNS, RUNS);
    let before = bench.stopped[0].encoders[0].frames;
    bench.run_for_ms(20);
    let frames = bench.stopped[0].encoders[0].frames - before;
    assert!(bench.stopped[0].bridges.on() && frames >= 40, "{frames} frames: {}", bench.ask(1, "status"));
    bench.finish();
}

/// What looks at it looks for a bounded time.
#[test]
fn a_bus_without_a_clock_turns_the_motors_off_in_the_third_tick() {
    let mut bench = armed();
    bench.count_instructions();
    let enabled = bench.peek(1, [APB2ENR])[0];
    assert_ne!(enabled & SPI5EN, 0, "it has one");
    bench.input(1).poke.push((APB2ENR, enabled & !SPI5EN));
    bench.run_for_ms(BAD.into());
    assert!(!bench.stopped[0].bridges.on(), "{}", bench.ask(1, "status"));
    bench.run_for_ms(40);
    let (status, longest) = (bench.ask(1, "status"), MedianAndMost::of(bench.meters[0].ticks.iter().copied()).max);
    println!("a tick without an answer: {longest} instructions");
    assert!(status.contains("fault 70") && status.contains("encoder 1 does not answer"), "{status}");
    assert!(status.contains("overruns 0") && longest < 24_000, "{longest}: {status}");
    bench.finish();
}

#[test]
fn a_board_without_an_encoder_in_use_starts_and_is_not_armed() {
    let why = "error encoder 1 does not answer: look at its supply, its chip select (PA4) and its wires";
    let dead = |inputs: &mut Inputs| inputs.encoder = Some((0, Planted::Dead));
    let mut bench = breaks::silent(Firmware::with("spi-encoders"), &breaks::scene(&[]), dead, why);
    // The second encoder's joint is not in use.
    bench.input(1).encoder = Some((0, Planted::None));
    bench.run_for_ms(5);
    bench.input(1).encoder = Some((1, Planted::Dead));
    bench.run_for_ms(5);
    bench.check(1).expect("it passes");
    assert_eq!(bench.ask(1, "arm"), "ok armed");
    bench.finish();
}

#[test]
fn a_speed_that_an_angle_cannot_be_followed_at_is_refused() {
    let settings = [("encoder.counts_per_m 400000", "encoder.max_speed_m_per_s 5", "encoder.max_speed_m_per_s")];
    breaks::refuses(Firmware::with("spi-encoders"), &settings);
}
