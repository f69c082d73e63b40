//! Hold to run by a switch in the hand (`board.hold_switch`): nothing is armed without it, and released in the middle of a push the force is gone
//! within 2 ms, with the cause told.

use std::sync::Arc;

use board_bench::bench::Bench;
use board_bench::image::Firmware;
use board_bench::part::pins::{Edge, Place};
use board_bench::power::{STORE, board};
use board_bench::reviewed;
use board_bench::wire::Line;

use crate::breaks;

const SWITCH: Place = Place::of("PG14");
/// From opening it to no force: a look after this tick, and the next tick that acts on it.
const WITHIN_US: u64 = 2_000;
const OPEN: &str = "error hold the hold-to-run switch: it is open, not connected, or closed since before the start";

/// The switch of board 1 is closed, or opened, at the next stop.
pub(crate) fn close(bench: &mut Bench, closed: bool) {
    let at = bench.now_ns();
    bench.input(1).edges.push(Edge { at, place: SWITCH, high: closed });
}

/// Held for long enough, or let go.
pub(crate) fn hold(bench: &mut Bench, closed: bool) {
    close(bench, closed);
    bench.run_for_ms(60);
}

/// Motors of board 1 run only while its switch is held. From afar: it only guards more.
pub(crate) fn demand(bench: &mut Bench) {
    assert_eq!(bench.ask(1, "set board.hold_switch true"), "ok board.hold_switch = true");
    assert_eq!(bench.ask(1, "apply"), "ok applied");
}

/// A board that has such a switch, disarmed, whose user pushes once it is armed.
fn with_a_switch(firmware: &Arc<Firmware>) -> Bench {
    let mut bench = Bench::start(firmware, 1, Line::default());
    bench.set_up(&breaks::scene(&["user.1.push_n=2"])).expect("the board takes it");
    demand(&mut bench);
    bench
}

#[test]
fn released_in_the_middle_of_a_push_the_force_is_gone_in_its_time_and_the_cause_is_told() {
    let mut bench = with_a_switch(&Arc::new(Firmware::release()));
    assert_eq!(
        [bench.ask(1, "check 1"), bench.ask(1, "arm")],
        [OPEN; 2],
        "a wire that is off is a switch that is open"
    );
    // A press that bounces, and one that is too short.
    for _ in 0..3 {
        close(&mut bench, true);
        bench.run_for_ms(45);
        close(&mut bench, false);
        bench.run_for_ms(1);
    }
    close(&mut bench, true);
    assert_eq!(bench.ask(1, "check 1"), OPEN);
    hold(&mut bench, true);
    bench.arm();
    let mut longest_us = 0;
    for phase_us in (0..1_000).step_by(90) {
        bench.run_for_ms(150);
        let pushes = |bench: &Bench| bench.stopped[0].bridges.currents().map_or(0.0, |currents| currents[0].abs());
        assert!(pushes(&bench) > 0.01, "{phase_us} us: it pushes with {}", pushes(&bench));
        bench.run_for_us(phase_us);
        close(&mut bench, false);
        let begun = bench.now_ns();
        while pushes(&bench) > 0.0 {
            bench.run_for_us(20);
            assert!(bench.now_ns() < begun + 20_000_000, "the force stays");
        }
        longest_us = longest_us.max((bench.now_ns() - begun) / 1_000);
        // Back to the middle between two ticks.
        bench.run_for_us(1_000 - (phase_us + (bench.now_ns() - begun) / 1_000) % 1_000);
        bench.run_for_ms(10);
        assert!(!bench.stopped[0].bridges.on(), "off, once amplifiers have let go");
        let status = bench.ask(1, "status");
        assert!(
            status.contains(" disarmed fault 0 ")
                && status.contains("; motors off: the hold-to-run switch was released; "),
            "{status}"
        );
        assert_eq!(bench.ask(1, "arm"), OPEN);
        // Held again it stays off until somebody arms it.
        hold(&mut bench, true);
        bench.run_for_ms(100);
        assert!(!bench.stopped[0].bridges.on(), "on again by itself");
        assert_eq!(bench.ask(1, "arm"), "ok armed");
        assert!(!bench.ask(1, "status").contains("hold-to-run"), "forgotten when it was armed");
    }
    println!("no force {longest_us} us after the switch opened, at the most");
    assert!(longest_us <= WITHIN_US, "{longest_us} us");
    bench.finish().iter().for_each(reviewed::check);
}

/// A probe is a motor that is on.
#[test]
fn released_in_a_probe_it_ends() {
    let mut bench = with_a_switch(&Arc::new(Firmware::release()));
    hold(&mut bench, true);
    bench.let_go(None);
    assert!(bench.ask(1, "probe 1 sine 0.005 2 5").starts_with("ok probing"));
    bench.run_for_ms(100);
    assert!(bench.stopped[0].bridges.on());
    close(&mut bench, false);
    bench.run_for_ms(5);
    assert!(!bench.stopped[0].bridges.on());
    assert!(bench.ask(1, "status").contains(" disarmed fault 0 "));
    bench.finish();
}

#[test]
fn it_is_left_out_at_the_board_only_and_outlasts_defaults_a_start_and_settings_that_are_refused() {
    let firmware = Arc::new(Firmware::release());
    let mut bench = board(&firmware, &[]);
    assert!(bench.ask(1, "set board.hold_switch maybe").ends_with("it must be true or false"));
    for line in ["set board.hold_switch true", "apply", "defaults", "set safety.max_force_n 2.5", "apply", "save"] {
        assert!(bench.ask(1, line).starts_with("ok"), "{line}");
    }
    bench.run_for_ms(1100);
    let flash = bench.flash(1, STORE);
    bench.finish();
    // Tied down since before the start it holds nothing.
    let mut bench = Bench::power_on(&firmware, 1, Line::default(), 58, |inputs| {
        inputs.poke.extend(&flash);
        inputs.edges.push(Edge { at: 0, place: SWITCH, high: true });
    });
    bench.run_for_ms(100);
    assert_eq!([bench.ask(1, "get board.hold_switch"), bench.ask(1, "arm")], ["ok board.hold_switch = true", OPEN]);
    hold(&mut bench, false);
    hold(&mut bench, true);
    assert!(bench.ask(1, "arm").starts_with("error check first: "), "held");
    assert!(bench.ask(1, "set board.hold_switch false").starts_with("ok"));
    let refused = "error board.hold_switch = false is not what this board was set to, true: hold the blue button while saying apply";
    assert_eq!(bench.ask(1, "apply"), refused);
    bench.hold_buttons(true);
    bench.run_for_ms(10);
    assert_eq!(bench.ask(1, "apply"), "ok applied");
    hold(&mut bench, false);
    assert!(bench.ask(1, "arm").starts_with("error check first: "), "it is not asked for any more");
    bench.finish();
}
