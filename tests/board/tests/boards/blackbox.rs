//! What is left of a fault: the ticks before it and the periods of the current loop, which survive a reset, and a line of history, which
//! survives power.

use std::sync::Arc;

use board_bench::bench::{Bench, CURRENT_LOOP};
use board_bench::image::Firmware;
use board_bench::wire::Line;
use firmware_parts::history::FIRST;
use firmware_parts::record::{ENABLED, Period, Record};
use firmware_parts::recorder::TICKS;
use haptic_core::safety::{Fault, Mode};
use haptic_sim::scene::PlantFault;

use crate::breaks;

/// The sector of the keys; behind them the history.
const KEYS: u64 = 0x081A_0000;
const HISTORY: u64 = KEYS + 32 * FIRST as u64;
const FOR_EVER: u32 = 0xE7FE_E7FE;

/// What board 1 streamed until now, and what it has kept.
fn kept(bench: &mut Bench) -> (Vec<Record>, Vec<Record>) {
    bench.drain();
    let streamed = bench.pc.records[0].clone();
    bench.pc.periods[0].clear();
    assert_eq!(bench.ask(1, "blackbox"), "ok 256 ticks, 30 PWM periods");
    bench.run_for_ms(200);
    let kept = bench.pc.records[0][streamed.len()..].to_vec();
    assert_eq!(kept.len(), TICKS);
    assert!(kept.windows(2).all(|two| two[1].tick() == two[0].tick() + 1), "in a row");
    (streamed, kept)
}

#[test]
fn a_fault_leaves_its_ticks_its_periods_and_a_line() {
    let (firmware, scene) = (Arc::new(Firmware::release()), breaks::scene(&CURRENT_LOOP));
    let mut bench = breaks::just_armed(&firmware, 2, Line::default(), &scene);
    let nothing = "error no fault has turned the motors off since power came on";
    assert_eq!(bench.ask(1, "blackbox"), nothing);
    assert_eq!(bench.ask(1, "stream 1"), "ok every 1 ticks");
    bench.run_for_ms(400);
    bench.fail(1, PlantFault::SenseAtEnd);
    bench.run_for_ms(50);
    bench.mend(1);
    assert!(!bench.stopped[0].bridges.on());
    let (streamed, told) = kept(&mut bench);
    let from = streamed.iter().position(|record| record.tick() == told[0].tick()).expect("it was streamed, too");
    assert_eq!(streamed[from..from + TICKS], told, "bit for bit");
    let [.., before, last] = &told[..] else { panic!("{} records", told.len()) };
    assert_eq!((before.mode(), last.mode()), (Mode::Armed, Mode::Faulted(Fault::CurrentSensor)));
    assert_eq!([before, last].map(|record| record.flags() & ENABLED), [ENABLED, 0]);

    // The periods that the faulted tick saw are the twenty before the one that had begun.
    let periods = bench.pc.periods[0].clone();
    assert!(periods.len() == 30 && periods.windows(2).all(|two| two[1].0 == two[0].0 + 1), "{periods:?}");
    let seen = last.stage().expect("a current loop");
    let mean =
        |of: fn(&Period) -> i16| periods[9..29].iter().map(|(_, period)| f64::from(of(period))).sum::<f64>() / 20.0;
    // The sensor of motor 1 reads more than a period can tell.
    let (current, voltage) = (mean(|period| period.currents[1]), mean(|period| period.voltages[0]));
    assert!((current - f64::from(seen.motors[1].mean)).abs() <= 1.0, "{current}, {seen:?}: {periods:?}");
    let counts = voltage / 32767.0 * f64::from(seen.supply_counts);
    assert!((counts - f64::from(seen.motors[0].voltage)).abs() <= 1.0, "{counts}, {seen:?}: {periods:?}");
    let at_its_end = periods.iter().position(|(_, period)| period.currents[0] == i16::MAX).expect("within the last 30");
    assert!(periods[at_its_end..].iter().all(|(_, period)| period.currents[0] == i16::MAX) && at_its_end > 0);

    // A tick that hangs: the reset leaves what led to it.
    breaks::arm_again(&mut bench, "after the fault");
    assert_eq!(bench.ask(1, "stream 1"), "ok every 1 ticks");
    bench.run_for_ms(300);
    let tick = firmware.address("TIM6_DAC");
    let sound = firmware.word(tick);
    bench.input(1).poke.push((tick, FOR_EVER));
    bench.run_for_ms(20);
    assert_eq!(bench.stopped[0].resets, 1);
    bench.input(1).poke.push((tick, sound));
    bench.run_for_ms(500);
    bench.align(&firmware);
    bench.meet(1);
    let (streamed, told) = kept(&mut bench);
    assert!(told.iter().all(|record| record.mode() == Mode::Armed));
    let both = streamed.iter().filter(|record| told.contains(record)).count();
    assert!(both > TICKS - 20, "{both} of them were streamed before");
    let history = bench.ask(1, "history");
    let since = "ok newest first; start: no tick came for 2 ms; fault 18 at ";
    assert!(history.starts_with(since) && history.ends_with(" s; start: power came on"), "{history}");

    // Power takes the ticks and leaves the lines.
    let flash = bench.flash(1, HISTORY..HISTORY + 0x400);
    let mut bench = Bench::start_with(&firmware, 1, Line::default(), &flash);
    assert_eq!(bench.ask(1, "blackbox"), nothing);
    let told = bench.ask(1, "history");
    assert_eq!(told, history.replacen("; ", "; start: power came on; ", 1));
}
