//! What a board says of its own ticks is what the emulator counts, and within the budgets.

use std::sync::Arc;

use board_bench::bench::Bench;
use board_bench::image::Firmware;
use board_bench::reviewed;
use board_bench::wire::Line;

use crate::breaks;

/// The longest of a time, and how many ticks were counted.
fn told(bench: &mut Bench, time: &str) -> (u32, u32) {
    let answer = bench.ask(1, &format!("time {time}"));
    let (_, rest) = answer.split_once("cycles of 480 MHz: most ").unwrap_or_else(|| panic!("{answer}"));
    let number = |text: &str| text.parse::<u32>().unwrap_or_else(|_| panic!("{answer}"));
    let (most, counts) = (rest.split(' ').next().expect("a number"), rest.split_once("from:ticks ").expect("counts").1);
    println!("{answer}");
    (number(most), counts.split(' ').map(|bin| number(bin.split_once(':').expect("a bin").1)).sum())
}

/// An instruction is a cycle there, so the board's cycles are the emulator's instructions: within the few at either end that one
/// of the two leaves out.
#[test]
fn a_board_tells_how_long_its_ticks_took() {
    let firmware = Arc::new(Firmware::release());
    let mut bench = Bench::start(&firmware, 1, Line::default());
    bench.count_instructions();
    bench.set_up(&breaks::scene(&[])).expect("the board takes it");
    bench.arm();
    bench.run_for_ms(500);
    let [delay, duration, spacing] = ["delay", "duration", "spacing"].map(|time| told(&mut bench, time));
    let most = *bench.meters[0].ticks.iter().max().expect("ticks");
    println!("the longest tick has {most} instructions");
    assert!((1..60).contains(&(most - duration.0)), "{} cycles, {most} instructions", duration.0);
    assert!(delay.0 <= 40, "begun {} cycles late", delay.0);
    assert!(spacing.0 <= 10, "{} cycles off", spacing.0);
    let ticks = u32::try_from(bench.now_ns() / 1_000_000).expect("a few seconds");
    for counted in [delay.1, duration.1, spacing.1] {
        assert!(counted.abs_diff(ticks) < 70, "{counted} of {ticks}");
    }
    bench.finish().iter().for_each(reviewed::check);
}
