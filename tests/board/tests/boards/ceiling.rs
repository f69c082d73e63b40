//! From afar limits are lowered only, whatever the operator says; who holds the board's button raises them.

use std::sync::Arc;

use board_bench::bench::Bench;
use board_bench::image::Firmware;
use board_bench::power::{STORE, board};
use board_bench::wire::Line;

/// The answer to `apply` with one more key set.
fn apply(bench: &mut Bench, key: &str, value: &str) -> String {
    let answer = bench.ask(1, &format!("set {key} {value}"));
    assert!(answer.starts_with("ok"), "{answer}");
    bench.ask(1, "apply")
}

/// The same for `safety.max_force_n`, and whether it was applied.
fn force(bench: &mut Bench, newtons: &str) -> bool {
    let answer = apply(bench, "safety.max_force_n", newtons);
    let refused = format!("error safety.max_force_n = {newtons} is above what this board was set to, ");
    assert!(answer == "ok applied" || answer.starts_with(&refused), "{answer}");
    answer == "ok applied"
}

fn hold_button(bench: &mut Bench, held: bool) {
    bench.hold_buttons(held);
    bench.run_for_ms(10);
}

/// The board's next start, with what it has saved.
fn saved(mut bench: Bench, firmware: &Arc<Firmware>) -> Bench {
    assert!(bench.ask(1, "save").starts_with("ok"));
    bench.run_for_ms(1100);
    let flash = bench.flash(1, STORE);
    bench.finish();
    board(firmware, &flash)
}

#[test]
fn limits_are_lowered_from_afar_and_raised_at_the_board_only() {
    let firmware = Arc::new(Firmware::release());
    let mut bench = board(&firmware, &[]);
    let whole = "error safety.max_force_n = 200 is above what this board was set to, 3: hold the blue button while saying apply";
    assert_eq!(apply(&mut bench, "safety.max_force_n", "200"), whole);
    // Lowered, it may be raised again as far as it was when the board started.
    for (newtons, fits) in [("2", true), ("3", true), ("3.1", false), ("1", true)] {
        assert_eq!(force(&mut bench, newtons), fits, "{newtons} N");
    }
    let other_motor = apply(&mut bench, "motor.newton_or_newton_metre_per_a", "0.01");
    assert!(
        other_motor.contains(" = 0.01 is not what this board was set to, 8: hold the blue button"),
        "{other_motor}"
    );
    assert_eq!(apply(&mut bench, "motor.newton_or_newton_metre_per_a", "8"), "ok applied");

    hold_button(&mut bench, true);
    assert!(force(&mut bench, "60"));
    let log = bench.log(&firmware, 1);
    assert_eq!(log.iter().filter(|line| line.starts_with("set at the board")).count(), 1, "a line a key: {log:?}");
    hold_button(&mut bench, false);
    for (newtons, fits) in [("61", false), ("60", true), ("2.5", true), ("59", true), ("2.5", true)] {
        assert_eq!(force(&mut bench, newtons), fits, "{newtons} N after 60 N at the board");
    }

    // Saved, what was applied is the ceiling of the next start; `defaults` does not lead beyond it.
    let mut bench = saved(bench, &firmware);
    assert!(bench.ask(1, "status").contains("settings stored 1;"));
    for (newtons, fits) in [("2.6", false), ("3", false), ("2.5", true), ("0.5", true), ("2.5", true)] {
        assert_eq!(force(&mut bench, newtons), fits, "{newtons} N after 2.5 N were saved");
    }
    assert_eq!(bench.ask(1, "defaults"), "ok the draft holds the defaults");
    assert!(bench.ask(1, "apply").starts_with("error safety.max_force_n = 3 is above "));
    // What was refused is not in force, and not saved.
    let mut bench = saved(bench, &firmware);
    assert_eq!(bench.ask(1, "get safety.max_force_n"), "ok safety.max_force_n = 2.5");
    bench.finish();
}

#[test]
fn a_button_that_is_down_at_the_start_raises_nothing_until_it_was_released() {
    let firmware = Arc::new(Firmware::release());
    let mut bench = Bench::power_on(&firmware, 1, Line::default(), 58, |inputs| inputs.button = Some(true));
    assert!(bench.ask(1, "status").contains("; the blue button is down since before the start; "));
    assert!(!force(&mut bench, "60"));
    hold_button(&mut bench, false);
    assert!(!bench.ask(1, "status").contains("blue button"));
    assert!(!force(&mut bench, "60"));
    hold_button(&mut bench, true);
    assert!(force(&mut bench, "60"));
    bench.finish();
}
