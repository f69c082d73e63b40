//! A board whose motor has a controller of its own, a moteus on its CAN bus: it holds one cube with a board behind whose PWM amplifiers are, and with
//! one whose bridges the board's own current loop drives, bit for bit what cohold computes; and its motor is off within a stated time of
//! whatever goes wrong, with the cause told.
//!
//! Longer: `COHOLD_SECONDS=10 cargo test -p board-bench --test boards hold_one_cube`, which runs both pairs over 10 s instead of 2.

use std::sync::Arc;

use board_bench::bench::Bench;
use board_bench::cost::MedianAndMost;
use board_bench::image::Firmware;
use board_bench::node::Inputs;
use board_bench::part::fdcan::BusFault;
use board_bench::part::moteus::Planted;
use board_bench::trial;
use board_bench::twin::{self, Equal};
use board_bench::{node::Report, reviewed};
use cohold_sim::scene::Scene;
use firmware_parts::moteus::{LOST, WATCHDOG_MS};

use crate::{breaks, current_loop};

/// GPIOD_MODER and GPIOD_AFRL.
const PORT_D: [u64; 2] = [0x5802_0C00, 0x5802_0C20];

fn scene() -> Scene {
    breaks::scene(&[])
}

/// What two boards computed, one that drives its motor by this other scene, and one with a moteus, for so long.
pub(crate) fn run(other: &Scene, seconds: u64) -> (Equal, MedianAndMost, Vec<Report>) {
    let scenes = [other, &scene()];
    let images = [Firmware::release(), Firmware::with("moteus").alone()].map(Arc::new);
    let mut bench = Bench::mixed(&images, trial::line(other).expect("a wire can do it"));
    bench.set_up_each(&scenes.map(Scene::clone)).expect("the boards take the scenes");
    bench.arm();
    bench.count_instructions();
    bench.run_for_ms(1000 * seconds);
    let instructions = MedianAndMost::of(bench.meters[1].ticks.iter().copied());
    bench.drain();
    assert!(!bench.stopped[1].controller.pulled, "gains, an integrator, or a watchdog that never ends");
    let boards = bench.both_since_armed(1000 * seconds);
    // They hold it: the cube moves, and both hands feel it.
    let moved = boards
        .map(|board| board.records.iter().map(|record| record.observed().object.position.abs()).fold(0.0, f32::max));
    assert!(moved.iter().all(|moved| *moved > 0.001), "{moved:?}");
    let equal = twin::closed_loop_late(scenes, boards, [false, true]);
    // A board that heard in time would compute something else.
    assert_ne!(twin::closed_loop_late(scenes, boards, [false, false]).first_difference, None);
    (equal, instructions, bench.finish())
}

fn hold_one_cube(other: &Scene) {
    let seconds = std::env::var("COHOLD_SECONDS").map_or(2, |seconds| seconds.parse().expect("seconds"));
    let wall = std::time::Instant::now();
    let (equal, instructions, reports) = run(other, seconds);
    println!("{seconds} s in {:.0} s: {equal:?}, {instructions:?}", wall.elapsed().as_secs_f64());
    assert_eq!(equal.first_difference, None);
    assert!(instructions.max <= 1300, "{instructions:?}");
    reports.iter().for_each(reviewed::check);
}

#[test]
fn a_board_with_amplifiers_and_one_with_a_moteus_hold_one_cube() {
    hold_one_cube(&scene());
}

#[test]
fn a_board_with_bridges_and_its_own_current_loop_and_one_with_a_moteus_hold_one_cube() {
    hold_one_cube(&current_loop::scene(&[]));
}

/// A board alone with a moteus, armed.
fn armed() -> Bench {
    let mut bench = breaks::armed(&Arc::new(Firmware::with("moteus")), &scene());
    assert!(bench.stopped[0].bridges.on(), "its torque is on");
    let pins = bench.peek(1, PORT_D);
    assert_eq!((pins[0] & 15, pins[1] & 0xFF), (0b1010, 0x99), "PD0 and PD1 lead to FDCAN1");
    bench
}

type Cause = fn(&mut Inputs);

/// What goes wrong, what undoes it, within how many ms the torque is gone, and what is told.
const CAUSES: [(&str, Cause, Cause, u64, &str); 11] = [
    ("no supply", |i| i.controller = Some(Planted::Dead), mended, 1, "fault 65"),
    ("answers nothing", |i| i.controller = Some(Planted::Mute), mended, LOST as u64 + 2, "fault 65"),
    ("a wire of the bus is off", |i| i.bus = Some((BusFault::Open, 0)), mended, WATCHDOG_MS as u64 + 1, "fault 65"),
    ("the bus is shorted", |i| i.bus = Some((BusFault::Shorted, 0)), mended, WATCHDOG_MS as u64 + 1, "fault 65"),
    (
        "the bus is shorted, after many errors",
        |i| i.bus = Some((BusFault::Shorted, 248)),
        mended,
        WATCHDOG_MS as u64 + 1,
        "fault 68",
    ),
    ("its fault 38", |i| i.controller = Some(Planted::Fails(38)), mended, 1, "fault 66"),
    ("81 °C", |i| i.controller = Some(Planted::Warm(81)), mended, 3, "fault 67"),
    ("56 V", |i| i.controller = Some(Planted::Supply(112)), mended, 3, "fault 19"),
    ("a position that is none", |i| i.controller = Some(Planted::NotANumber), mended, 3, "fault 1 "),
    ("it lets go", |i| i.controller = Some(Planted::LetsGo), mended, 1, "fault 69"),
    (
        "the emergency stop",
        |i| i.press = Some(true),
        |i| {
            mended(i);
            i.press = Some(false);
        },
        2,
        "disarmed fault 0",
    ),
];

fn mended(inputs: &mut Inputs) {
    (inputs.controller, inputs.bus) = (Some(Planted::None), Some((BusFault::None, 0)));
}

/// What `status` says besides of some of them.
fn explained(what: &str) -> &'static str {
    match what {
        "no supply" | "answers nothing" | "a wire of the bus is off" | "the bus is shorted" => {
            "; the motor's controller does not answer: "
        }
        "the bus is shorted, after many errors" => "; the board is off the motor's bus: ",
        "its fault 38" => "; the motor's controller, its fault 38: too warm; ",
        "56 V" => "; the motor's controller has less than motor.min_supply_v, or more than motor.max_supply_v; ",
        _ => "",
    }
}

#[test]
fn the_torque_is_gone_within_its_time_and_the_cause_is_told() {
    for (what, breaks, mends, within_ms, told) in CAUSES {
        let mut bench = armed();
        breaks(bench.input(1));
        let begun = bench.now_ns();
        while bench.stopped[0].bridges.on() {
            bench.run_for_us(100);
            assert!(bench.now_ns() <= begun + (within_ms + 1) * 1_000_000, "{what}: the torque stays");
        }
        let after_ms = (bench.now_ns() - begun) as f64 / 1e6;
        println!("{what}: gone after {after_ms} ms");
        assert!(after_ms <= within_ms as f64 + 0.1, "{what}: gone after {after_ms} ms");
        bench.run_for_ms(40);
        let status = bench.ask(1, "status");
        assert!(status.contains(told) && status.contains(explained(what)), "{what}: {status}");
        assert!(!bench.stopped[0].bridges.on(), "{what}: on again by itself");
        // It is not armed while that lasts, and only after an order when it is over.
        assert!(bench.ask(1, "arm").starts_with("error "), "{what}");
        mends(bench.input(1));
        bench.run_for_ms(20);
        assert!(!bench.stopped[0].bridges.on(), "{what}: on again by itself");
        breaks::arm_again(&mut bench, what);
        bench.run_for_ms(20);
        assert!(bench.stopped[0].bridges.on(), "{what}: on after clear and arm");
        bench.finish().iter().for_each(reviewed::check);
    }
}

/// Nothing that computes is needed for the controller to let go.
#[test]
fn a_board_that_stands_sends_nothing_and_the_motor_lets_go_by_itself() {
    /// b .; b .
    const FOR_EVER: u32 = 0xE7FE_E7FE;
    let firmware = Arc::new(Firmware::with("moteus"));
    let mut bench = armed();
    bench.input(1).poke.push((firmware.address("TIM6_DAC"), FOR_EVER));
    let begun = bench.now_ns();
    while bench.stopped[0].bridges.on() {
        bench.run_for_us(100);
        assert!(bench.now_ns() < begun + 20_000_000, "the torque stays");
    }
    let after_ns = bench.now_ns() - begun;
    println!("gone {} ms after the tick stood still", after_ns as f64 / 1e6);
    assert!(after_ns <= u64::from(WATCHDOG_MS) * 1_000_000 + 200_000, "{after_ns} ns");
    bench.finish();
}

#[test]
fn a_board_without_an_answering_motor_starts_and_is_not_armed() {
    let why = "error the motor's controller does not answer: look at its supply, its bus, its identifier (1)";
    let dead = |inputs: &mut Inputs| inputs.controller = Some(Planted::Dead);
    let mut bench = breaks::silent(Firmware::with("moteus"), &scene(), dead, why);
    bench.input(1).controller = Some(Planted::None);
    bench.run_for_ms(5);
    bench.check(1).expect("it passes");
    assert_eq!(bench.ask(1, "arm"), "ok armed");
    bench.finish();
}

#[test]
fn what_one_motor_cannot_do_is_refused() {
    let current = "amplifier, because a moteus makes the current of its torque by itself";
    let settings = [
        ("axis.count 2", "axis.count 1", "1, because the image for a moteus drives one motor"),
        ("motor.drive current-loop", "motor.drive amplifier", current),
    ];
    breaks::refuses(Firmware::with("moteus"), &settings);
}
