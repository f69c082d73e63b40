//! What is left of a fault: the ticks before it and the periods of the current loop, which survive a reset, and a line of history, which
//! survives power.

use std::sync::Arc;

use board_bench::bench::{Bench, CURRENT_LOOP};
use board_bench::image::Firmware;
use board_bench::wire::Line;
use cohold_core::safety::{Fault, Mode};
use cohold_live::recording::file::read;
use cohold_sim::scene::PlantFault;
use firmware_parts::history::FIRST;
use firmware_parts::record::{ENABLED, Record};
use firmware_parts::recorder::TICKS;

use crate::breaks;

/// The sector of the keys; behind them the history.
const KEYS: u64 = 0x081A_0000;
const HISTORY: u64 = KEYS + 32 * FIRST as u64;
const FOR_EVER: u32 = 0xE7FE_E7FE;

/// What board 1 streamed until now, and what it has kept.
fn kept(bench: &mut Bench) -> (Vec<Record>, Vec<Record>) {
    bench.drain();
    let streamed = bench.pc.records[0].clone();
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
    let file = std::env::temp_dir().join(format!("blackbox-{}.mcap", std::process::id()));
    let _ = std::fs::remove_file(&file);
    bench.pc.record(1, 1, &file);
    let (streamed, told) = kept(&mut bench);
    bench.pc.end_recordings();
    let recording = read(&file).expect("a recording");
    std::fs::remove_file(&file).expect("it is there");
    let from = streamed.iter().position(|record| record.tick() == told[0].tick()).expect("it was streamed, too");
    assert_eq!(streamed[from..from + TICKS], told, "bit for bit");
    let [.., before, last] = &told[..] else { panic!("{} records", told.len()) };
    assert_eq!((before.mode(), last.mode()), (Mode::Armed, Mode::Faulted(Fault::CurrentSensor)));
    assert_eq!([before, last].map(|record| record.flags() & ENABLED), [ENABLED, 0]);

    // The periods that the faulted tick saw are the twenty before the one that had begun.
    let periods = recording.channels.iter().find(|channel| channel.topic == "/board_1/periods").expect("it is there");
    let [numbers, sensed, currents, voltages] =
        ["period", "current_1", "current_2", "voltage_1"].map(|name| periods.column(name).expect("it is named"));
    assert!(periods.len() == 30 && numbers.windows(2).all(|two| two[1] == two[0] + 1.0), "{numbers:?}");
    let seen = last.stage().expect("a current loop");
    let mean = |of: &[f64]| of[9..29].iter().sum::<f64>() / 20.0;
    // The sensor of motor 1 reads more than a period can tell.
    let (codes, counts) = (32767.0 * mean(currents), f64::from(seen.supply_counts) * mean(voltages));
    assert!((codes - f64::from(seen.motors[1].mean)).abs() <= 1.0, "{codes}, {seen:?}: {currents:?}");
    assert!((counts - f64::from(seen.motors[0].voltage)).abs() <= 1.0, "{counts}, {seen:?}: {voltages:?}");
    let at_its_end = sensed.iter().position(|current| *current == 1.0).expect("within the last 30");
    assert!(at_its_end > 0 && sensed[at_its_end..].iter().all(|current| *current == 1.0), "{sensed:?}");

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
