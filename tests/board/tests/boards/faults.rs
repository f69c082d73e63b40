//! Faults injected while the motors are on: how soon the outputs are off, what is reported, and that only a command brings
//! them back. The rows become the table in docs/reference/faults.md; `COHOLD_BLESS=1` writes it, otherwise it must be there.

use std::cell::{Cell, RefCell};
use std::sync::Arc;

use board_bench::bench::{Bench, CURRENT_LOOP};
use board_bench::docs;
use board_bench::image::Firmware;
use board_bench::part::Gate;
use board_bench::pc::{board_ip, board_mac, udp};
use board_bench::wire::Line;
use cohold_protocol::wire::Flow;
use cohold_sim::scene::PlantFault;

use crate::{amplifiers, breaks, impostor::Impostor, switch};

/// The counter that goes on while a debugger halts the processor, 10 counts a millisecond.
const TIM7_CNT: u64 = 0x4000_1424;
/// Two instructions each: for ever, and one that is none.
const FOR_EVER: u32 = 0xE7FE_E7FE;
const NO_INSTRUCTION: u32 = 0xDE00_DE00;
/// push {r0-r7, lr}, and that again.
const OVERFLOW: u32 = 0xE7FD_B5FF;

struct Campaign {
    firmware: Arc<Firmware>,
    rows: Vec<String>,
    /// What the scene is besides; with windings where a current loop is.
    set: &'static [&'static str],
    /// Board 1 has a hold-to-run switch, which is held.
    by_switch: bool,
}

/// Limits that are not the scene's.
const LIMITS: [&str; 4] =
    ["safety.peer_lost_s=0.096", "safety.max_speed_m_per_s=2", "safety.stuck_duty=0.02", "safety.max_hand_power_w=20"];

/// What a fault is to come to.
struct Expected {
    /// Within so many ms; `None`: the outputs stay on.
    off_within_ms: Option<u64>,
    /// In the answer to `status` afterwards.
    reported: &'static str,
    /// The board starts anew.
    reset: bool,
    /// Arming takes `clear` first.
    latched: bool,
}

/// Something done to board 1, at a stop. Done again every millisecond until the outputs are off, with the number of it.
type Fault<'a> = &'a dyn Fn(&mut Bench, u64);

/// What undoes it.
type Mend<'a> = &'a dyn Fn(&mut Bench);

/// Done in the first millisecond alone.
fn once(fault: impl Fn(&mut Bench)) -> impl Fn(&mut Bench, u64) {
    move |bench, ms| {
        if ms == 1 {
            fault(bench);
        }
    }
}

impl Campaign {
    /// Armed boards.
    fn bench(&self, boards: usize) -> Bench {
        let scene = breaks::scene(&[&LIMITS[..], self.set].concat());
        let mut bench = Bench::start(&self.firmware, boards, Line::default());
        bench.set_up(&scene).expect("the boards take it");
        if self.by_switch {
            switch::demand(&mut bench);
            switch::hold(&mut bench, true);
        }
        bench.arm();
        bench.run_for_ms(100);
        bench
    }

    /// Injects, waits, asks, and arms again.
    fn inject(&mut self, what: &str, boards: usize, expected: &Expected, fault: Fault<'_>, mend: Mend<'_>) {
        let mut bench = self.bench(boards);
        assert!(bench.stopped[0].bridges.on(), "{what}: the motors are on before");
        let patience = expected.off_within_ms.unwrap_or(200);
        let mut off_after = None;
        for ms in 1..=patience {
            fault(&mut bench, ms);
            bench.step();
            if !bench.stopped[0].bridges.on() {
                off_after = Some(ms);
                break;
            }
        }
        assert_eq!(off_after.is_some(), expected.off_within_ms.is_some(), "{what}: off after {off_after:?} ms");
        for _ in 0..30 {
            bench.step();
            assert!(expected.off_within_ms.is_none() || !bench.stopped[0].bridges.on(), "{what}: on again by itself");
        }
        assert_eq!(bench.stopped[0].resets > 0, expected.reset, "{what}: resets");
        mend(&mut bench);
        // A board that started anew brings its link up soon after this.
        let stays_off_ms = if expected.reset { 500 } else { 200 };
        for _ in 0..stays_off_ms {
            bench.step();
            assert!(expected.off_within_ms.is_none() || !bench.stopped[0].bridges.on(), "{what}: on again by itself");
        }
        if expected.reset {
            bench.align(&self.firmware);
        }
        bench.meet(1);
        assert!(expected.off_within_ms.is_none() || !bench.stopped[0].bridges.on(), "{what}: on again by itself");
        if expected.reset {
            // Its settings are the defaults again, and nobody held the device meanwhile.
            bench.hold_buttons(true);
            let amplifier = Some("motor.drive amplifier").filter(|_| self.set.is_empty());
            let limits = ["safety.workspace_m 100", "safety.max_speed_m_per_s 2", "safety.max_hand_power_w 20"];
            for setting in amplifier.into_iter().chain(limits) {
                assert!(bench.ask(1, &format!("set {setting}")).starts_with("ok"));
            }
            assert_eq!(bench.ask(1, "apply"), "ok applied");
            bench.hold_buttons(false);
        }
        let status = bench.ask(1, "status");
        assert!(status.contains(expected.reported), "{what}: {status}");
        let mut refusal = "-".to_owned();
        if !expected.latched && expected.off_within_ms.is_some() {
            assert_eq!(bench.ask(1, "arm"), "ok armed", "{what}: arming takes nothing else");
        }
        if expected.latched {
            let answer = bench.ask(1, "arm");
            assert!(answer.starts_with("error"), "{what}: {answer}");
            refusal = answer.trim_start_matches("error ").to_owned();
            bench.run_for_ms(3);
            assert!(!bench.stopped[0].bridges.on(), "{what}: on although refused");
            breaks::arm_again(&mut bench, what);
            bench.run_for_ms(3);
            assert!(bench.stopped[0].bridges.on(), "{what}: on after clear and arm");
        }
        let off = off_after.map_or("stay on".to_owned(), |ms| format!("{ms} ms"));
        let row = format!("| {what} | {off} | {} | {refusal} |", expected.reported);
        println!("{row}");
        self.rows.push(row);
        if !expected.reset {
            if boards == 2 && !bench.stopped[1].bridges.on() {
                // It let go when its partner did.
                for (order, answer) in [("clear", "ok disarmed"), ("arm", "ok armed")] {
                    assert_eq!(bench.ask(2, order), answer, "{what}: the partner");
                }
            }
            bench.run_for_ms(200);
            let all_on = bench.stopped.iter().all(|stopped| stopped.bridges.on());
            assert!(all_on, "{what}: all hold again");
        }
    }

    /// Puts words at the start of a function, 30 ms long; `mend` puts back what was there.
    fn break_code(&mut self, what: &str, expected: &Expected, symbol: &str, words: &[u32]) {
        let firmware = self.firmware.clone();
        let start = firmware.address(symbol);
        assert_eq!(start % 4, 0, "{symbol} starts on a word");
        let before: Vec<u32> = (0..).zip(words).map(|(nth, _)| firmware.word(start + 4 * nth)).collect();
        let put = |bench: &mut Bench, words: &[u32]| {
            let places = (0..).map(|nth| start + 4 * nth).zip(words.iter().copied());
            bench.input(1).poke.extend(places);
        };
        // The board goes on with sound code, as after a fault that passes.
        self.inject(what, 1, expected, &once(|bench| put(bench, words)), &|bench| put(bench, &before));
    }
}

/// Where the encoder was put by the device, moved.
fn move_encoder(bench: &mut Bench, by: i64) {
    if let Some(counts) = &mut bench.input(1).counts {
        counts[0] += by;
    }
}

fn nothing(_: &mut Bench) {}

#[test]
fn outputs_go_off_and_stay_off() {
    let mut campaign =
        Campaign { firmware: Arc::new(Firmware::release()), rows: Vec::new(), set: &[], by_switch: false };
    let faulted = |off_within_ms, reported| Expected {
        off_within_ms: Some(off_within_ms),
        reported,
        reset: false,
        latched: true,
    };
    let restarted =
        |off_within_ms, reported| Expected { off_within_ms: Some(off_within_ms), reported, reset: true, latched: true };

    let firmware = campaign.firmware.clone();
    let jumped = once(|bench| move_encoder(bench, 4000));
    campaign.inject("encoder jumped by 4000 counts", 1, &faulted(1, "fault 2"), &jumped, &nothing);

    // By where it was at the first of them, in every period after it, and where it would be.
    let stood = Cell::new(0);
    let reads = |instead: fn(i64, i64) -> i64| {
        let stood = &stood;
        move |bench: &mut Bench, ms: u64| {
            if let Some(counts) = &mut bench.input(1).counts {
                if ms == 1 {
                    stood.set(counts[0]);
                }
                counts[0] = instead(stood.get(), counts[0]);
            }
        }
    };
    // Every edge of the wire that is left is one count on or back.
    let by_one = |stood: i64, now: i64| stood + (now - stood).rem_euclid(2);
    for (what, within, reported, instead) in [
        ("encoder stuck (force changed by 0.8 N, as set)", 4000, "fault 8", (|stood, _| stood) as fn(i64, i64) -> i64),
        ("one wire of an encoder cut (force changed by 0.8 N, as set)", 4000, "fault 8", by_one),
        ("encoder reversed (20 W, as set)", 3000, "fault 9", |stood, now| 2 * stood - now),
    ] {
        campaign.inject(what, 2, &faulted(within, reported), &reads(instead), &nothing);
    }

    // The force falls first.
    let (lost, silent) = (faulted(200, "fault 5"), |bench: &mut Bench, is: bool| bench.wire.line.silent = is);
    let what = "peer silent (12 packets, as set)";
    campaign.inject(what, 2, &lost, &once(|bench| silent(bench, true)), &|bench| silent(bench, false));

    let cable = |bench: &mut Bench, is_in: bool| bench.input(1).cable = Some(is_in);
    let what = "cable out (12 packets, as set)";
    campaign.inject(what, 2, &lost, &once(|bench| cable(bench, false)), &|bench| cable(bench, true));

    let let_go = Expected { latched: false, ..faulted(200, "motors off: the operator was silent") };
    let away = once(|bench| bench.pc.away = true);
    campaign.inject("operator silent (0.2 s)", 1, &let_go, &away, &|bench| bench.pc.away = false);

    let let_go = Expected { latched: false, ..faulted(3, "motors off: the hold-to-run switch was released") };
    let released = once(|bench| switch::close(bench, false));
    campaign.by_switch = true;
    let what = "hold-to-run switch released (`board.hold_switch`)";
    campaign.inject(what, 1, &let_go, &released, &|bench| switch::close(bench, true));
    campaign.by_switch = false;

    let mut bytes = [0; Flow::LEN];
    let flow = Flow { engaged: true, tick: 1 << 20, ..Flow::default() };
    flow.emit(&mut bytes).expect("it fits");
    bytes[12..16].copy_from_slice(&f32::NAN.to_le_bytes());
    let not_a_number = once(|bench| {
        let frame = udp((board_mac(2), board_ip(2), 7701), (board_mac(1), board_ip(1), 7701), &bytes);
        bench.input(1).frames.push(frame);
    });
    let on = Expected { off_within_ms: None, reported: "refused 1", reset: false, latched: false };
    campaign.inject("packet with a NaN, not sealed (refused on arrival)", 1, &on, &not_a_number, &nothing);

    // For longer than a session lives that nothing is heard in.
    let impostor = RefCell::new(Impostor::default());
    let sealed = |bench: &mut Bench, ms: u64| {
        if ms == 1 {
            // By then the board has looked for its peer, and calls again as often as it does in the end.
            bench.run_for_ms(1000);
        }
        let mut impostor = impostor.borrow_mut();
        impostor.tick(bench);
        // 40 ms are enough to meet.
        if ms > 40 && ms.is_multiple_of(8) {
            assert!(impostor.seal(bench, &bytes), "there is a session");
        }
    };
    let on = Expected { off_within_ms: None, reported: "refused 20", reset: false, latched: false };
    campaign.inject("20 packets with a NaN, sealed under the key (refused on arrival)", 1, &on, &sealed, &nothing);
    let Impostor { sent, called, .. } = impostor.into_inner();
    assert_eq!((sent, called), (20, 0), "the board took the keys for good, and the packets for the other peer's");

    let press = |bench: &mut Bench, is: bool| bench.input(1).press = Some(is);
    let what = "emergency stop pressed, later released";
    let pressed = once(|bench| press(bench, true));
    campaign.inject(what, 1, &faulted(1, "disarmed"), &pressed, &|bench| press(bench, false));

    let halt = once(|bench| {
        let count = bench.peek_now(1, [TIM7_CNT])[0];
        bench.input(1).poke.push((TIM7_CNT, (count + 50) & 0xFFFF));
    });
    campaign.inject("a debugger halts the processor for 5 ms", 1, &faulted(1, "fault 72"), &halt, &nothing);

    let fail = |bench: &mut Bench, fails: bool| bench.input(1).bridge_fails = Some(fails);
    let what = "a bridge reports a fault (nFAULT)";
    let fails = once(|bench| fail(bench, true));
    campaign.inject(what, 1, &faulted(1, "fault 14"), &fails, &|bench| fail(bench, false));

    let (most, [_, refused]) = amplifiers::armed_behind(Gate::EnableAlone, false);
    assert_eq!(most, 0.0);
    let refused = refused.trim_start_matches("error ");
    campaign.rows.push(format!(
        "| amplifiers without a gate, at arming | enabled for 1 ms at no current | fault 31 | {refused} |"
    ));
    let gate = |bench: &mut Bench, gate: Gate, fails: bool| {
        (bench.input(1).gate, bench.input(1).bridge_fails) = (Some(gate), Some(fails));
    };
    let what = "amplifiers' gate stays open when the outputs go off (nFAULT)";
    let ungated = once(|bench| gate(bench, Gate::EnableAlone, true));
    campaign.inject(what, 1, &faulted(1, "fault 31"), &ungated, &|bench| gate(bench, Gate::Both, false));

    let dips = |bench: &mut Bench, ms: u64| bench.input(1).supply_dips = ms == 1;
    campaign.inject("supply of the chip dips", 1, &faulted(1, "fault 15"), &dips, &nothing);

    let stopped = once(|bench| breaks::stop_clock(bench, &firmware));
    let runs = |bench: &mut Bench| breaks::mend_clock(bench, &firmware);
    campaign.inject("external clock stops", 1, &restarted(1, "external clock stopped"), &stopped, &runs);

    let (_, (panics, _)) =
        firmware.symbols.iter().find(|(name, _)| name.ends_with("4core9panicking5panic")).expect("it can panic");
    let panics = *panics as u32;
    // ldr.w pc, [pc]; the address.
    campaign.break_code("panic in a task", &restarted(6, "excludes"), "UART4", &[0xF000_F8DF, panics | 1]);
    campaign.break_code(
        "instruction that is none",
        &restarted(6, "refused an instruction"),
        "UART4",
        &[NO_INSTRUCTION],
    );
    // movs r0, #0x60; lsls r0, r0, #24; ldr r0, [r0]; b.
    let outside = [0x0600_2060, FOR_EVER & 0xFFFF_0000 | 0x6800];
    campaign.break_code(
        "access where external memory would be",
        &restarted(6, "refused an instruction"),
        "UART4",
        &outside,
    );
    campaign.break_code("stack overflow in a task", &restarted(6, "refused an instruction"), "UART4", &[OVERFLOW]);
    campaign.break_code("supervisor hangs", &restarted(32, "no progress"), "UART4", &[FOR_EVER]);
    campaign.break_code("tick hangs", &restarted(2, "no tick came"), "TIM6_DAC", &[FOR_EVER]);

    // With windings and the current loop, noise included.
    campaign.set = &CURRENT_LOOP;
    for (what, fault, within, reported) in [
        ("current sensor shorted: it reads no current", PlantFault::DeadSense, 400, "fault 17"),
        ("current sensor at the end of its range", PlantFault::SenseAtEnd, 4, "fault 18"),
        ("a wire of the motor off", PlantFault::OpenMotor, 400, "fault 17"),
        ("supply of the bridges low", PlantFault::LowSupply, 40, "fault 19"),
        ("supply of the bridges high", PlantFault::HighSupply, 40, "fault 19"),
    ] {
        let fails = once(|bench| bench.fail(1, fault));
        campaign.inject(what, 2, &faulted(within, reported), &fails, &|bench| bench.mend(1));
    }
    for (what, misses) in
        [("one conversion of the current loop is missing", 1), ("the current loop's trigger stops", u32::MAX)]
    {
        let miss = |bench: &mut Bench, misses: u32| bench.input(1).misses = Some(misses);
        let missing = once(|bench| miss(bench, misses));
        campaign.inject(what, 1, &faulted(1, "fault 64"), &missing, &|bench| miss(bench, 0));
    }
    // TIM1_CR2: the update is TRGO, and nothing is TRGO2 (MMS2).
    let stops = once(|bench| bench.input(1).poke.push((0x4001_0004, 2 << 4)));
    let goes_on = |bench: &mut Bench| bench.input(1).poke.push((0x4001_0004, 14 << 20 | 2 << 4));
    campaign.inject(
        "the trigger of the current loop's second sample stops",
        1,
        &faulted(1, "fault 64"),
        &stops,
        &goes_on,
    );
    campaign.break_code("current loop hangs", &restarted(3, "no tick came"), "ADC", &[FOR_EVER]);
    let words = board_bench::power::cuts(&firmware);
    campaign.rows.push(format!(
        "| power cut after each of the {words} words of a save | were off | settings old or new, whole | - |"
    ));

    docs::table(
        "reference/faults.md",
        "faults",
        "| fault | outputs off after | status says | arming is refused with |",
        &campaign.rows,
    );
}
