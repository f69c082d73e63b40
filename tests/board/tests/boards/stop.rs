//! A press of the emergency stop is never lost, however short it is and whenever it comes.

use std::sync::Arc;

use board_bench::image::Firmware;
use board_bench::wire::Line;

use crate::breaks;

/// From a stop of the bench to the tick, ns.
const TO_TICK_NS: u64 = 500_000;

/// 50 us over a whole period; and half a microsecond, as contacts bounce, from before the tick begins until after it has ended.
#[test]
fn a_short_press_at_any_phase_of_a_tick_is_kept() {
    let mut bench = breaks::just_armed(&Arc::new(Firmware::release()), 1, Line::default(), &breaks::scene(&[]));
    let long = (0..20).map(|nth| (47_000 * nth, 50_000));
    let short = (0..60).map(|nth| (TO_TICK_NS - 1_000 + 100 * nth, 500));
    for (after_ns, length_ns) in long.chain(short) {
        let what = format!("{length_ns} ns, {after_ns} ns after a stop");
        assert!(bench.stopped[0].bridges.on(), "{what}: on before");
        bench.press_for(1, after_ns, length_ns);
        bench.step();
        for _ in 0..10 {
            assert!(!bench.stopped[0].bridges.on(), "{what}: on");
            bench.step();
        }
        let answer = bench.ask(1, "arm");
        assert_eq!(answer, "error clear first: the emergency stop was pressed", "{what}");
        assert_eq!(bench.ask(1, "clear"), "ok disarmed", "{what}");
        assert_eq!(bench.ask(1, "arm"), "ok armed", "{what}");
        bench.run_for_ms(3);
    }
    bench.finish();
}
