//! What turns outputs off in hardware does so at once, and is distinguished; a board without its external clock, or whose converter does not
//! start, talks and is not armed.
//!
//! Not shown, because the emulator does not model it: that SYSCFG_CFGR connects the voltage detector and a locked-up core to the break.
//! Here the detector is connected by hand.

use std::sync::Arc;

use board_bench::bench::{Bench, CURRENT_LOOP, for_boards};
use board_bench::image::Firmware;
use board_bench::node::Inputs;
use board_bench::pc::{board_ip, board_mac, udp};
use board_bench::reviewed;
use board_bench::wire::Line;
use cohold_sim::scene::Scene;
use cohold_sim::scenes;

/// TIM1_BDTR without its main output enable, and what it is to be: break 2, both filters (8 samples at an eighth), break 1, idle levels, lock 3.
const BDTR: u64 = 0x4001_0044;
const MAIN_OUTPUT: u32 = 1 << 15;
const LOCKED: u32 = 1 << 24 | 0x99 << 16 | 1 << 12 | 1 << 11 | 1 << 10 | 3 << 8;
/// PWR_CR1 (voltage detector, level 6) and RCC_CR (clock security).
const PWR_CR1: u64 = 0x5802_4800;
const RCC_CR: u64 = 0x5802_4400;
/// DBGMCU_APB3FZ1 (bit 6: the window watchdog) and DBGMCU_APB2FZ1 (bit 0: TIM1, whose outputs are off while it stands still).
const FROZEN: [u64; 2] = [0x5C00_1034, 0x5C00_104C];

/// A scene that is built in, and what else is set.
pub(crate) fn built_in(name: &str, set: &[&str]) -> Scene {
    let mut scene = scenes::load(cohold_sim::Laws::built_in(), name).expect("built in");
    set.iter().for_each(|text| scene.apply_override(text).expect("a good override"));
    scene
}

/// The paper's passive wave for boards, and what else is set.
pub(crate) fn scene(set: &[&str]) -> Scene {
    for_boards(&built_in("paper-5.2-passive-wave-16ms", set))
}

/// Boards that have just been armed.
pub(crate) fn just_armed(firmware: &Arc<Firmware>, boards: usize, line: Line, scene: &Scene) -> Bench {
    let mut bench = Bench::start(firmware, boards, line);
    bench.set_up(scene).expect("the boards take the scene");
    bench.arm();
    bench
}

/// A board alone that has been armed for 20 ms.
pub(crate) fn armed(firmware: &Arc<Firmware>, scene: &Scene) -> Bench {
    let mut bench = just_armed(firmware, 1, Line::default(), scene);
    bench.run_for_ms(20);
    bench
}

/// A board with a part that does not answer, which starts, and is armed no more than it is checked.
pub(crate) fn silent(firmware: Firmware, scene: &Scene, dead: fn(&mut Inputs), why: &str) -> Bench {
    let mut bench = Bench::power_on(&Arc::new(firmware), 1, Line::default(), 58, dead);
    bench.set_up(scene).expect("the board takes it");
    assert!(bench.ask(1, "status").contains(" disarmed fault 0 "), "silence is no fault before the first answer");
    assert_eq!([bench.ask(1, "check 1"), bench.ask(1, "arm")], [why, why]);
    bench
}

/// Settings that a board does not apply, each with another with which it does, and what it says.
pub(crate) fn refuses(firmware: Firmware, settings: &[(&str, &str, &str)]) {
    let mut bench = Bench::start(&Arc::new(firmware), 1, Line::default());
    bench.hold_buttons(true);
    bench.run_for_ms(100);
    for (set, back, says) in settings {
        assert!(bench.ask(1, &format!("set {set}")).starts_with("ok"), "{set}");
        let refused = bench.ask(1, "apply");
        assert!(refused.starts_with("error ") && refused.contains(says), "{set}: {refused}");
        assert!(bench.ask(1, &format!("set {back}")).starts_with("ok"), "{back}");
    }
    assert_eq!(bench.ask(1, "apply"), "ok applied");
    bench.finish();
}

/// Clears what stopped a board's motors, which turns nothing on, and arms it; whether signs had to be checked again, as after a reset or a fault
/// that puts encoders in doubt.
pub(crate) fn arm_again(bench: &mut Bench, what: &str) -> bool {
    assert_eq!(bench.ask(1, "clear"), "ok disarmed", "{what}");
    bench.run_for_ms(3);
    assert!(!bench.stopped[0].bridges.on(), "{what}: clearing turned them on");
    let mut answer = bench.ask(1, "arm");
    let is_checked = answer.starts_with("error check first: ");
    if is_checked {
        bench.check(1).expect(what);
        answer = bench.ask(1, "arm");
    }
    assert_eq!(answer, "ok armed", "{what}");
    is_checked
}

#[test]
fn what_guards_the_outputs_is_set_and_locked() {
    let mut bench = armed(&Arc::new(Firmware::release()), &scene(&[]));
    let frozen = bench.peek(1, FROZEN);
    assert_eq!(
        (frozen[0] >> 6 & 1, frozen[1] & 1),
        (1, 1),
        "a debugger's halt stops the watchdog, and the outputs with it"
    );
    let set = bench.peek(1, [BDTR, PWR_CR1, RCC_CR]);
    assert_eq!(set[0] & !MAIN_OUTPUT, LOCKED, "{:#010x}", set[0]);
    assert_eq!((set[1] >> 4 & 1, set[1] >> 5 & 7, set[2] >> 19 & 1), (1, 6, 1));
    bench.finish();
}

/// Between two ticks: nobody but the timer can have done it.
#[test]
fn outputs_are_off_a_microsecond_later_and_the_cause_is_told() {
    let firmware = Arc::new(Firmware::release());
    type Cause = fn(&mut Inputs);
    let causes: [(&str, Cause, Cause, &str); 4] = [
        ("stop", |i| i.press = Some(true), |i| i.press = Some(false), "the emergency stop was pressed"),
        ("bridge", |i| i.bridge_fails = Some(true), |i| i.bridge_fails = Some(false), "faulted, fault 14"),
        ("supply", |i| i.supply_dips = true, |_| {}, "faulted, fault 15"),
        (
            "bridge and stop",
            |i| (i.press, i.bridge_fails) = (Some(true), Some(true)),
            |i| (i.press, i.bridge_fails) = (Some(false), Some(false)),
            "the emergency stop was pressed",
        ),
    ];
    for (what, breaks, mends, told) in causes {
        let mut bench = armed(&firmware, &scene(&[]));
        assert!(bench.stopped[0].bridges.outputs);
        breaks(bench.input(1));
        bench.run_for_us(1);
        assert!(!bench.stopped[0].bridges.outputs && bench.stopped[0].bridges.enable, "{what}: no software was there");
        mends(bench.input(1));
        bench.run_for_us(998);
        bench.run_for_ms(3);
        assert!(!bench.stopped[0].bridges.enable, "{what}");
        let answer = bench.ask(1, "arm");
        assert!(answer.ends_with(told), "{what}: {answer}");
        bench.finish();
    }
}

/// It may be low while a bridge wakes; later it is a fault, and outputs were never on.
#[test]
fn a_bridge_may_report_a_fault_while_it_wakes_and_no_longer() {
    let firmware = Arc::new(Firmware::release());
    for (ms, fault) in [(1, "fault 0"), (2, "fault 0"), (5, "fault 14")] {
        let mut bench = armed(&firmware, &scene(&CURRENT_LOOP));
        assert_eq!(bench.ask(1, "disarm"), "ok disarmed");
        bench.input(1).bridge_fails = Some(true);
        bench.run_for_ms(1);
        bench.send(1, "arm");
        while !bench.stopped[0].bridges.enable {
            bench.step();
        }
        for _ in 1..ms {
            assert!(!bench.stopped[0].bridges.outputs);
            bench.step();
        }
        bench.input(1).bridge_fails = Some(false);
        bench.run_for_ms(5);
        // The first answer is that to `arm`, if it has not come yet.
        let status = Some(bench.ask(1, "status"))
            .filter(|said| said.contains("board"))
            .unwrap_or_else(|| bench.ask(1, "status"));
        assert!(status.contains(&format!(" {fault} ")), "low for {ms} ms: {status}");
        assert_eq!(bench.stopped[0].bridges.on(), fault == "fault 0");
        bench.finish();
    }
}

/// The external clock stops. The emulator has no wire from the clock's watch to the processor: an interrupt that a frame brings is
/// led to the handler instead, until [`mend_clock`].
pub(crate) fn stop_clock(bench: &mut Bench, firmware: &Firmware) {
    let (from, to) = (firmware.address("ETH"), firmware.address("NonMaskableInt") as u32);
    assert_eq!(from % 4, 0, "the jump's target stands on a word");
    // ldr.w pc, [pc]; the address.
    bench.input(1).poke.extend([(from, 0xF000_F8DF), (from + 4, to | 1)]);
    bench.input(1).clock_stops = true;
    let frame = udp(([2, 0, 0, 0, 0, 0x66], [192, 168, 77, 66], 9), (board_mac(1), board_ip(1), 9), &[0; 18]);
    bench.input(1).frames.push(frame);
}

/// Puts back what [`stop_clock`] led elsewhere.
pub(crate) fn mend_clock(bench: &mut Bench, firmware: &Firmware) {
    let from = firmware.address("ETH");
    bench.input(1).poke.extend([0, 4].map(|at| (from + at, firmware.word(from + at))));
}

#[test]
fn a_board_whose_external_clock_stops_starts_anew_and_says_so() {
    let firmware = Arc::new(Firmware::release());
    let mut bench = armed(&firmware, &scene(&[]));
    stop_clock(&mut bench, &firmware);
    bench.run_for_us(1);
    assert!(!bench.stopped[0].bridges.outputs);
    bench.run_for_us(99);
    mend_clock(&mut bench, &firmware);
    bench.run_for_ms(1300);
    bench.meet(1);
    assert_eq!(bench.ask(1, "arm"), "error clear first: the external clock stopped");
    assert_eq!(bench.ask(1, "clear"), "ok disarmed");
    for report in bench.finish() {
        assert_eq!(report.resets, ["Core"]);
        reviewed::check(&report);
    }
}

/// One board that starts with this talks, says why it is not to be armed, and is not.
fn talks_and_is_not_armed(reported: &str, why: &str, first: impl Fn(&mut Inputs)) {
    let firmware = Arc::new(Firmware::release());
    let mut bench = Bench::power_on(&firmware, 1, Line::default(), 200, first);
    let status = bench.ask(1, "status");
    assert!(status.starts_with("ok board 1 ") && status.contains(reported), "{status}");
    for line in ["arm", "check 1", "clear", "arm"] {
        let answer = bench.ask(1, line);
        assert_eq!(answer, if line == "clear" { "ok disarmed".to_owned() } else { format!("error {why}") });
    }
    assert!(bench.log(&firmware, 1).iter().any(|line| line.starts_with("not to be armed: ")));
    bench.finish().iter().for_each(reviewed::check);
}

#[test]
fn a_board_without_its_external_clock_talks_and_is_not_armed() {
    let why = "the external clock did not come: see to the 8 MHz of the ST-LINK and start anew";
    talks_and_is_not_armed(" disarmed fault 0 ", why, |inputs| inputs.clock_missing = true);
}

/// Why: the start looked 100,000 times whether the converter was calibrated, which is a millisecond, and went on in any case.
#[test]
fn a_board_whose_converter_does_not_start_talks_and_is_not_armed() {
    // Its clock is on (RCC_AHB1ENR), and it is being calibrated (ADC1_CR) when the start writes to it, so that the calibration never ends.
    const CALIBRATES: [(u64, u32); 2] = [(0x5802_44D8, 1 << 5), (0x4002_2008, 1 << 31 | 1 << 28)];
    let why = "the current sensors' converter did not start: power off and on";
    talks_and_is_not_armed(" faulted fault 18 ", why, |inputs| inputs.poke.extend(CALIBRATES));
}
