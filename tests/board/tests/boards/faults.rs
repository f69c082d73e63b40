//! Faults injected while the motors are on: how soon the outputs are off, what is reported, and that only a command brings
//! them back. The rows become the table in docs/hardware.md; `HAPTIC_BLESS=1` writes it, otherwise it must be there.

use std::cell::{Cell, RefCell};
use std::sync::Arc;

use board_bench::bench::{Bench, CURRENT_LOOP, for_boards};
use board_bench::docs;
use board_bench::image::Firmware;
use board_bench::part::Gate;
use board_bench::pc::{board_ip, board_mac, udp};
use board_bench::wire::Line;
use haptic_protocol::wire::Flow;
use haptic_sim::scene::PlantFault;
use haptic_sim::scenes;

use crate::{amplifiers, breaks, impostor::Impostor, switch};

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
    /// Boards that got over the fault before, armed, and what they are besides: the next may come to them.
    standing: Option<(Bench, Besides)>,
}

/// How many boards, what their scene is besides, and whether there is a switch.
type Besides = (usize, &'static [&'static str], bool);

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
type Fault<'a> = &'a dyn Fn(&mut Bench, &Firmware, u64);

impl Campaign {
    fn besides(&self, boards: usize) -> Besides {
        (boards, self.set, self.by_switch)
    }

    /// Armed boards: those that stand there, if they are such, or others from power-on.
    fn bench(&mut self, boards: usize) -> Bench {
        let besides = self.besides(boards);
        match self.standing.take() {
            Some((bench, stand)) if stand == besides => return bench,
            other => finish(other),
        }
        let mut scene = scenes::load(haptic_sim::Laws::built_in(), "paper-5.2-passive-wave-16ms").expect("built in");
        scene.apply_override("safety.peer_lost_s=0.096").expect("a good override");
        for limit in ["safety.max_speed_m_per_s=2", "safety.stuck_duty=0.02", "safety.max_hand_power_w=20"] {
            scene.apply_override(limit).expect("a good override");
        }
        for set in self.set {
            scene.apply_override(set).expect("a good override");
        }
        let mut bench = Bench::start(&self.firmware, boards, Line::default());
        bench.set_up(&for_boards(&scene)).expect("the boards take it");
        if self.by_switch {
            switch::demand(&mut bench);
            switch::hold(&mut bench, true);
        }
        bench.arm();
        bench.run_for_ms(100);
        bench
    }

    /// Injects, waits, asks, and arms again.
    fn inject(&mut self, what: &str, boards: usize, expected: &Expected, fault: Fault<'_>, mend: Fault<'_>) {
        let mut bench = self.bench(boards);
        assert!(bench.stopped[0].bridges.on(), "{what}: the motors are on before");
        let patience = expected.off_within_ms.unwrap_or(200);
        let mut off_after = None;
        for ms in 1..=patience {
            fault(&mut bench, &self.firmware, ms);
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
        mend(&mut bench, &self.firmware, 0);
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
        if expected.reset {
            // Its settings are not the scene's any more.
            bench.finish();
        } else {
            if boards == 2 && !bench.stopped[1].bridges.on() {
                // It let go when its partner did.
                for (order, answer) in [("clear", "ok disarmed"), ("arm", "ok armed")] {
                    assert_eq!(bench.ask(2, order), answer, "{what}: the partner");
                }
            }
            bench.run_for_ms(200);
            let all_on = bench.stopped.iter().all(|stopped| stopped.bridges.on());
            assert!(all_on, "{what}: all hold again");
            self.standing = Some((bench, self.besides(boards)));
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
        let fault = |bench: &mut Bench, _: &Firmware, ms: u64| {
            if ms == 1 {
                put(bench, words);
            }
        };
        // The board goes on with sound code, as after a fault that passes.
        let mend = |bench: &mut Bench, _: &Firmware, _: u64| put(bench, &before);
        self.inject(what, 1, expected, &fault, &mend);
    }
}

/// Ends what stands.
fn finish(standing: Option<(Bench, Besides)>) {
    if let Some((bench, _)) = standing {
        bench.finish();
    }
}

/// Where the encoder was put by the device, moved.
fn move_encoder(bench: &mut Bench, by: i64) {
    if let Some(counts) = &mut bench.input(1).counts {
        counts[0] += by;
    }
}

fn nothing(_: &mut Bench, _: &Firmware, _: u64) {}

#[test]
fn outputs_go_off_and_stay_off() {
    let mut campaign = Campaign {
        firmware: Arc::new(Firmware::release()),
        rows: Vec::new(),
        set: &[],
        by_switch: false,
        standing: None,
    };
    let faulted = |off_within_ms, reported| Expected {
        off_within_ms: Some(off_within_ms),
        reported,
        reset: false,
        latched: true,
    };
    let restarted =
        |off_within_ms, reported| Expected { off_within_ms: Some(off_within_ms), reported, reset: true, latched: true };

    let jumped = |bench: &mut Bench, _: &Firmware, ms: u64| {
        if ms == 1 {
            move_encoder(bench, 4000)
        }
    };
    campaign.inject("encoder jumped by 4000 counts", 1, &faulted(1, "fault 2"), &jumped, &nothing);

    // Where it was at the first of them, in every period after it.
    let stood = Cell::new(0);
    let stuck = |bench: &mut Bench, _: &Firmware, ms: u64| {
        if let Some(counts) = &mut bench.input(1).counts {
            if ms == 1 {
                stood.set(counts[0]);
            }
            counts[0] = stood.get();
        }
    };
    campaign.inject("encoder stuck (force changed by 0.8 N, as set)", 2, &faulted(4000, "fault 8"), &stuck, &nothing);

    let cut = |bench: &mut Bench, _: &Firmware, ms: u64| {
        if let Some(counts) = &mut bench.input(1).counts {
            if ms == 1 {
                stood.set(counts[0]);
            }
            // Every edge of the wire that is left is one count on or back.
            counts[0] = stood.get() + (counts[0] - stood.get()).rem_euclid(2);
        }
    };
    let what = "one wire of an encoder cut (force changed by 0.8 N, as set)";
    campaign.inject(what, 2, &faulted(4000, "fault 8"), &cut, &nothing);

    let mirrored = |bench: &mut Bench, _: &Firmware, ms: u64| {
        if let Some(counts) = &mut bench.input(1).counts {
            if ms == 1 {
                stood.set(counts[0]);
            }
            counts[0] = 2 * stood.get() - counts[0];
        }
    };
    campaign.inject("encoder reversed (20 W, as set)", 2, &faulted(3000, "fault 9"), &mirrored, &nothing);

    let silent = |bench: &mut Bench, _: &Firmware, _: u64| bench.wire.line.silent = true;
    let heard = |bench: &mut Bench, _: &Firmware, _: u64| bench.wire.line.silent = false;
    campaign.inject("peer silent (12 packets, as set)", 2, &faulted(112, "fault 5"), &silent, &heard);

    let pulled = |bench: &mut Bench, _: &Firmware, _: u64| bench.input(1).cable = Some(false);
    let put_in = |bench: &mut Bench, _: &Firmware, _: u64| bench.input(1).cable = Some(true);
    campaign.inject("cable out (12 packets, as set)", 2, &faulted(112, "fault 5"), &pulled, &put_in);

    let away = |bench: &mut Bench, _: &Firmware, _: u64| bench.pc.away = true;
    let back = |bench: &mut Bench, _: &Firmware, _: u64| bench.pc.away = false;
    let let_go = Expected { latched: false, ..faulted(200, "motors off: the operator was silent") };
    campaign.inject("operator silent (0.2 s)", 1, &let_go, &away, &back);

    let released = |bench: &mut Bench, _: &Firmware, _: u64| switch::close(bench, false);
    let held = |bench: &mut Bench, _: &Firmware, _: u64| switch::close(bench, true);
    let let_go = Expected { latched: false, ..faulted(3, "motors off: the hold-to-run switch was released") };
    campaign.by_switch = true;
    campaign.inject("hold-to-run switch released (`board.hold_switch`)", 1, &let_go, &released, &held);
    campaign.by_switch = false;

    let mut bytes = [0; Flow::LEN];
    let flow = Flow { engaged: true, tick: 1 << 20, ..Flow::default() };
    flow.emit(&mut bytes).expect("it fits");
    bytes[12..16].copy_from_slice(&f32::NAN.to_le_bytes());
    let not_a_number = |bench: &mut Bench, _: &Firmware, ms: u64| {
        if ms == 1 {
            let frame = udp((board_mac(2), board_ip(2), 7701), (board_mac(1), board_ip(1), 7701), &bytes);
            bench.input(1).frames.push(frame);
        }
    };
    let on = Expected { off_within_ms: None, reported: "refused 1", reset: false, latched: false };
    campaign.inject("packet with a NaN, not sealed (refused on arrival)", 1, &on, &not_a_number, &nothing);

    // For longer than a session lives that nothing is heard in, to a board that has refused none yet.
    finish(campaign.standing.take());
    let impostor = RefCell::new(Impostor::default());
    let sealed = |bench: &mut Bench, _: &Firmware, ms: u64| {
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

    let pressed = |bench: &mut Bench, _: &Firmware, ms: u64| {
        if ms == 1 {
            bench.input(1).press = Some(true)
        }
    };
    let released = |bench: &mut Bench, _: &Firmware, _: u64| bench.input(1).press = Some(false);
    campaign.inject("emergency stop pressed, later released", 1, &faulted(1, "disarmed"), &pressed, &released);

    let fails = |bench: &mut Bench, _: &Firmware, ms: u64| {
        if ms == 1 {
            bench.input(1).bridge_fails = Some(true)
        }
    };
    let recovers = |bench: &mut Bench, _: &Firmware, _: u64| bench.input(1).bridge_fails = Some(false);
    campaign.inject("a bridge reports a fault (nFAULT)", 1, &faulted(1, "fault 14"), &fails, &recovers);

    let (most, [_, refused]) = amplifiers::armed_behind(Gate::EnableAlone, false);
    assert_eq!(most, 0.0);
    let refused = refused.trim_start_matches("error ");
    campaign.rows.push(format!(
        "| amplifiers without a gate, at arming | enabled for 1 ms at no current | fault 31 | {refused} |"
    ));
    let ungated = |bench: &mut Bench, _: &Firmware, ms: u64| {
        if ms == 1 {
            (bench.input(1).gate, bench.input(1).bridge_fails) = (Some(Gate::EnableAlone), Some(true));
        }
    };
    let gated = |bench: &mut Bench, _: &Firmware, _: u64| {
        (bench.input(1).gate, bench.input(1).bridge_fails) = (Some(Gate::Both), Some(false));
    };
    let what = "amplifiers' gate stays open when the outputs go off (nFAULT)";
    campaign.inject(what, 1, &faulted(1, "fault 31"), &ungated, &gated);

    let dips = |bench: &mut Bench, _: &Firmware, ms: u64| bench.input(1).supply_dips = ms == 1;
    campaign.inject("supply of the chip dips", 1, &faulted(1, "fault 15"), &dips, &nothing);

    let stopped = |bench: &mut Bench, firmware: &Firmware, ms: u64| {
        if ms == 1 {
            breaks::stop_clock(bench, firmware);
        }
    };
    let runs = |bench: &mut Bench, firmware: &Firmware, _: u64| breaks::mend_clock(bench, firmware);
    campaign.inject("external clock stops", 1, &restarted(1, "external clock stopped"), &stopped, &runs);

    let panics = campaign.firmware.address_ending("4core9panicking5panic") as u32;
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
    let fails = |fault: PlantFault| {
        move |bench: &mut Bench, _: &Firmware, ms: u64| {
            if ms == 1 {
                bench.fail(1, fault);
            }
        }
    };
    let mended = |bench: &mut Bench, _: &Firmware, _: u64| bench.mend(1);
    for (what, fault, within, reported) in [
        ("current sensor shorted: it reads no current", PlantFault::DeadSense, 400, "fault 17"),
        ("current sensor at the end of its range", PlantFault::SenseAtEnd, 4, "fault 18"),
        ("a wire of the motor off", PlantFault::OpenMotor, 400, "fault 17"),
        ("supply of the bridges low", PlantFault::LowSupply, 40, "fault 19"),
        ("supply of the bridges high", PlantFault::HighSupply, 40, "fault 19"),
    ] {
        campaign.inject(what, 2, &faulted(within, reported), &fails(fault), &mended);
    }
    for (what, misses) in
        [("one conversion of the current loop is missing", 1), ("the current loop's trigger stops", u32::MAX)]
    {
        let missing = move |bench: &mut Bench, _: &Firmware, ms: u64| {
            if ms == 1 {
                bench.input(1).misses = Some(misses);
            }
        };
        let converts = |bench: &mut Bench, _: &Firmware, _: u64| bench.input(1).misses = Some(0);
        campaign.inject(what, 1, &faulted(1, "fault 64"), &missing, &converts);
    }
    campaign.break_code("current loop hangs", &restarted(3, "no tick came"), "ADC", &[FOR_EVER]);
    campaign.set = &[];

    finish(campaign.standing.take());
    let words = board_bench::power::cuts(&campaign.firmware);
    campaign.rows.push(format!(
        "| power cut after each of the {words} words of a save | were off | settings old or new, whole | - |"
    ));

    docs::table("faults", "| fault | outputs off after | status says | arming is refused with |", &campaign.rows);
}
