//! Outputs go off within 2 ms of the last tick, whatever keeps the next one from coming; and the board says so afterwards.

use std::sync::Arc;

use board_bench::image::Firmware;
use board_bench::reviewed;

use crate::breaks;

/// b .; b .
const FOR_EVER: u32 = 0xE7FE_E7FE;
/// cpsid i; b .
const MASKED: u32 = 0xE7FE_B672;
/// cpsid f; b .
const FAULTS_MASKED: u32 = 0xE7FE_B671;
/// cpsid f; and no instruction: a fault where none can be taken.
const LOCKED_UP: u32 = 0xDE00_B671;
/// RCC_GCR, DBGMCU_APB3FZ1.
const SCOPE: u64 = 0x5802_44A0;
const FROZEN: u64 = 0x5C00_1034;

/// Nanoseconds from the last tick to the outputs being off, with this word at the start of a function of an armed board.
fn off_after_ns(firmware: &Arc<Firmware>, function: &str, word: u32) -> u64 {
    const STEP_US: u64 = 10;
    let mut bench = breaks::armed(firmware, &breaks::scene(&[]));
    // Nothing else here would show that one of them is missing.
    let bits = bench.peek(1, [SCOPE, FROZEN]);
    assert_eq!((bits[0] & 1, bits[1] >> 6 & 1), (1, 1), "it resets the whole chip, and halts with the processor");

    let (tick, broken) = (firmware.address("TIM6_DAC"), firmware.address(function));
    bench.input(1).watch.push(tick);
    bench.step();
    assert!(bench.stopped[0].bridges.on(), "{function}: on before");
    let mut last = bench.stopped[0].hits.last().expect("the tick runs").at.0;
    bench.input(1).poke.push((broken, word));
    let begun = bench.now_ns();
    while bench.stopped[0].bridges.on() {
        bench.run_for_us(STEP_US);
        // One that hangs as it begins is none.
        last = bench.stopped[0].hits.last().filter(|_| broken != tick).map_or(last, |hit| hit.at.0);
        assert!(bench.now_ns() < begun + 20_000_000, "{function}: they stay on");
    }
    let after = bench.now_ns() - last;
    bench.input(1).poke.push((broken, firmware.word(broken)));
    bench.run_for_ms(1300);
    bench.meet(1);
    let status = bench.ask(1, "status");
    assert!(status.ends_with("; started: no tick came for 2 ms"), "{status}");
    assert_eq!(bench.ask(1, "arm"), "error clear first: no tick came for 2 ms");
    for report in bench.finish() {
        assert_eq!(report.resets, ["Model(\"WWDG\")"]);
        reviewed::check(&report);
    }
    after
}

#[test]
fn outputs_go_off_within_2_ms_of_the_last_tick() {
    let firmware = Arc::new(Firmware::release());
    for (what, function, word) in [
        ("the tick hangs", "TIM6_DAC", FOR_EVER),
        ("a task masks interrupts for ever", "UART4", MASKED),
        ("a task masks faults for ever", "UART4", FAULTS_MASKED),
        ("the core locks up", "UART4", LOCKED_UP),
    ] {
        let after = off_after_ns(&firmware, function, word);
        println!("{what}: outputs off {} us after the last tick", after / 1000);
        assert!((1_900_000..=2_000_000).contains(&after), "{what}: {after} ns");
    }
}
