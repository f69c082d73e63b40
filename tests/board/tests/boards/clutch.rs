//! A leader and a follower that are unlike, on two boards, the leader's scaled: a clutch that is opened and closed by order, to the bits of
//! cohold and without a jump of what the hand feels.

use std::sync::Arc;

use board_bench::bench::for_boards;
use board_bench::image::Firmware;
use board_bench::trial;
use board_bench::twin::{Equal, closed_loop_ordered};
use cohold_core::safety::{Command, Mode};
use cohold_sim::scenes;

use crate::breaks;

/// Steps of a duty, and of the encoder in the world's force, N: what a tick may change beside.
const STEPS_N: f32 = 0.01;

#[test]
fn opened_and_closed_by_order_it_changes_the_force_by_no_more_than_its_share() {
    let keys = ["network.jitter=none", "network.loss=0", "network.one_way_delay_packets=8"].map(str::to_owned);
    let scene = scenes::find(cohold_sim::Laws::built_in(), Some("leader-follower".as_ref()), &keys).expect("a scene");
    let scene = for_boards(&scene);
    let [leader, follower] = scene.peers();
    assert!((leader.scale.force, follower.scale.force) == (5.0, 1.0), "one of them is scaled");
    let line = trial::line(&scene).expect("a wire can do it");
    let mut bench = breaks::just_armed(&Arc::new(Firmware::release()), 2, line, &scene);
    bench.run_for_ms(700);
    assert!(bench.ask(1, "clutch").starts_with("ok"));
    bench.run_for_ms(600);
    assert!(bench.ask(1, "release").starts_with("ok"));
    bench.run_for_ms(700);
    let boards = [bench.since_armed(1), bench.since_armed(2)];
    for board in boards {
        assert!(board.records.iter().all(|record| record.mode() == Mode::Armed), "it stayed armed");
        assert!(board.records.windows(2).all(|two| two[1].tick() == two[0].tick() + 1), "telemetry lost ticks");
    }

    // Each order explains the first tick that is otherwise, and with both all ticks are the same.
    let mut orders = Vec::new();
    for order in [Command::Clutch, Command::Release] {
        let Equal { ticks, first_difference } = closed_loop_ordered(&scene, boards, &orders);
        orders.push((
            0,
            first_difference.unwrap_or_else(|| panic!("{order:?} changed nothing in {ticks} ticks")),
            order,
        ));
    }
    let equal = closed_loop_ordered(&scene, boards, &orders);
    println!("orders {orders:?}: {equal:?}");
    assert_eq!(equal.first_difference, None);
    let [opened, closed] = [orders[0].1, orders[1].1].map(|tick| tick as usize);
    assert!((600..700).contains(&(closed - opened)), "open for {} ms", closed - opened);

    // What the hand feels is the motor's force: a duty, which while nothing is open goes by the contact's force.
    let records = boards[0].records;
    // The comparison counts from the first of them to be armed.
    let before = boards[1].standing.saturating_sub(boards[0].standing);
    let (opened, closed) = (opened - before, closed - before);
    let duty = |at: usize| f32::from(records[at].duties()[0].0);
    let contact = |at: usize| records[at].observed().contact_force;
    let largest = (0..opened).max_by(|one, two| contact(*one).abs().total_cmp(&contact(*two).abs())).expect("ticks");
    let duty_per_n = duty(largest) / contact(largest);
    assert!(contact(largest).abs() > 0.5 && duty_per_n.abs() > 1.0, "{} N", contact(largest));
    let felt = |at: usize| duty(at) / duty_per_n;
    let a_tick = (scene.peer.timing.control_period_s / leader.safety.clutch_s) as f32;
    let ticks = (leader.safety.clutch_s / scene.peer.timing.control_period_s).ceil() as usize;
    for at in 1..records.len() {
        let (by_world, by_clutch) =
            ((contact(at) - contact(at - 1)).abs(), contact(at).abs().max(contact(at - 1).abs()) * a_tick);
        let jump = (felt(at) - felt(at - 1)).abs();
        assert!(jump <= by_world + by_clutch + STEPS_N, "{jump} N at {at}, opened {opened}, closed {closed}");
    }
    // Open, the hand feels nothing of the world; closed again, all of it.
    assert!((opened + ticks + 1..closed).all(|at| duty(at) == 0.0), "open, the motor rests");
    let last = records.len() - 1;
    assert!(
        felt(last).abs() > 0.0 && (felt(last) - contact(last)).abs() <= STEPS_N,
        "{} of {}",
        felt(last),
        contact(last)
    );
}
