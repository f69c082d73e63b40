//! The same bits: what two boards compute, tick by tick, is what cohold computes, and one wrong constant is seen at once.

use std::sync::Arc;

use board_bench::cost::MedianAndMost;
use board_bench::image::Firmware;
use board_bench::twin::{self, Equal};
use board_bench::wire::Line;
use cohold_core::num::Fixed;

use crate::breaks;

#[test]
fn two_boards_equal_cohold() {
    // The same scene for 20 s: `papers_comms::passive_wave`.
    let seconds = 1;
    let scene = breaks::scene(&[]);
    let wall = std::time::Instant::now();
    let armed = || breaks::just_armed(&Arc::new(Firmware::release()), 2, Line::default(), &scene);
    drop(armed());
    let mut bench = armed();
    assert!(bench.nodes.iter().all(|board| board.told().1 > 0), "both are forked from boards that were armed before");
    bench.run_for_ms(1000 * seconds);
    println!("{} s of two boards in {:.1} s", seconds, wall.elapsed().as_secs_f64());
    let boards = [bench.armed_ticks(1), bench.armed_ticks(2)];
    for records in boards {
        assert!(records.windows(2).all(|two| two[1].tick() == two[0].tick() + 1), "telemetry lost ticks");
    }
    let ticks = boards[0].len().min(boards[1].len()) as u64;
    assert!(ticks >= 1000 * seconds, "only {ticks} ticks were recorded");
    let equal = twin::closed_loop(&scene, boards);
    assert_eq!(equal, Equal { ticks, first_difference: None });
    for (settings, records) in scene.peers().iter().zip(boards) {
        let equal = twin::replay(settings, records);
        assert_eq!(equal, Equal { ticks: records.len() as u64, first_difference: None });
    }

    // A constant that is off by one part in 10⁷ on one side.
    let mut wrong = scene.clone();
    wrong.peer.coordination.stiffness_n_per_m *= 1.0 + 2e-7;
    let (closed, open) = (twin::closed_loop(&wrong, boards), twin::replay(&wrong.peers()[0], boards[0]));
    println!("a constant off by 2e-7 shows at tick {closed:?} in closed loop, {open:?} in replay");
    assert!(closed.first_difference.is_some_and(|tick| tick < 100));
    assert!(open.first_difference.is_some_and(|tick| tick < 100));
}

/// Two boards compute in fixed point for so long. Each record is computed again on this PC. Gives the instructions of a tick.
pub(crate) fn in_fixed_point(seconds: u64) -> MedianAndMost {
    let scene = breaks::scene(&[]);
    let mut bench = breaks::just_armed(&Arc::new(Firmware::with("fixed-point")), 2, Line::default(), &scene);
    bench.count_instructions();
    bench.run_for_ms(1000 * seconds);
    let instructions = MedianAndMost::of(bench.meters[0].ticks.iter().copied());
    for (settings, records) in scene.peers().iter().zip([bench.armed_ticks(1), bench.armed_ticks(2)]) {
        let ticks = records.len() as u64;
        assert!(ticks >= 1000 * seconds, "only {ticks} ticks were recorded");
        assert!(records.iter().any(|record| record.observed().coordination_force.abs() > 0.1), "they hold one cube");
        let equal = twin::replay_in::<Fixed>(settings, records);
        assert_eq!(equal, Equal { ticks, first_difference: None });
        assert!(twin::replay(settings, records).first_difference.is_some(), "f32 has other bits");
    }
    instructions
}

#[test]
fn two_boards_in_fixed_point_equal_this_pc() {
    println!("a tick in fixed point: {:?}", in_fixed_point(1));
}
