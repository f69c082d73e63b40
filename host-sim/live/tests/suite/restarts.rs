//! Either peer restarts at any instant, 10,000 times and more: core and protocol together, in virtual time.

use cohold_core::law::degradation::STEP_N;
use cohold_core::safety::Guard;
use cohold_sim::scenes;

mod trial;

use trial::{Report, run};

/// `count` restarts over the network of `overrides`, with what must hold on any.
fn restarts(count: u64, overrides: &[&str]) -> Report {
    let mut scene =
        scenes::load(cohold_sim::Laws::built_in(), "paper-5.2-passive-wave-16ms").expect("a built-in scene");
    for text in overrides {
        scene.apply_override(text).expect("a good override");
    }
    scene.check("the test").expect("a good scene");
    let report = run(&scene, count, 7).expect("they meet");
    assert_eq!((report.restarts, report.failed, report.held_on, report.faults), (count, 0, 0, 0), "{report:?}");
    // Before it meets the new one, the peer that stayed lets its last force fall.
    assert!(report.slowest_ms <= 400.0 + report.let_go_n / STEP_N, "{report:?}");
    // Motors begin at rest, and no step of theirs, nor the first of the coordination, is larger than the slew limit.
    let allowed = Guard::<f64>::build(&scene.peer).limits.step;
    assert_eq!(report.arming_force_n, 0.0);
    assert!(report.largest_step_n <= allowed && report.first_force_n <= allowed, "{report:?}");
    report
}

/// Most that a user of the scene pushes: no first step of a wave's coordination is more.
const PUSH_N: f64 = 1.25;
const EXACT: [&str; 3] =
    ["coordination.comm=passive-mean", "coordination.ledger=true", "coordination.drift_correction=true"];
const BAD: [&str; 4] =
    ["network.loss=0.2", "network.jitter=uniform", "network.jitter_s=0.012", "network.duplicate=0.1"];

#[test]
fn a_clean_network() {
    let report = restarts(10_000, &EXACT);
    // Hello, welcome, first sealed packet, its answer, first flow: five ways of 8 ms and four packet periods of waiting, to the tick.
    let falls_ms = report.let_go_n / STEP_N;
    assert!(report.slowest_ms < 5.0 * 8.0 + 4.0 * 8.0 + 1.0 + falls_ms, "{report:?}");
    assert!(report.first_force_n < PUSH_N, "{report:?}");
}

#[test]
fn a_fifth_lost_the_rest_jittered_and_some_twice() {
    let report = restarts(10_000, &[&EXACT[..], &BAD].concat());
    assert!(report.first_force_n < PUSH_N, "{report:?}");
}

#[test]
fn through_a_play_out_buffer() {
    let report = restarts(2_000, &[&EXACT[..], &BAD, &["network.playout_packets=2"]].concat());
    assert!(report.first_force_n < PUSH_N, "{report:?}");
}

#[test]
fn positions_instead_of_waves() {
    restarts(2_000, &[&["coordination.comm=power", "coordination.stiffness_n_per_m=310"][..], &BAD].concat());
}
