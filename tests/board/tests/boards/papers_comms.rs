//! The cooperation paper's three communications at 16 ms round trip, 20 s, on two boards: cohold's figures, no tick
//! missed, no packet lost, and nothing that the emulator did not model but what was reviewed.

use std::sync::Arc;

use board_bench::image::Firmware;
use board_bench::reviewed;
use board_bench::trial::{self, Trial};

use crate::breaks;

const SECONDS: f64 = 20.0;

fn close(what: &str, board: f64, cohold: f64) {
    assert!((board - cohold).abs() <= 0.01 * cohold.abs(), "{what}: {board} on the boards, {cohold} in cohold");
}

fn check(name: &str) {
    let scene = breaks::built_in(name, &[]);
    let trial = trial::run(&Arc::new(Firmware::release()), &scene, SECONDS).expect("the boards run it");
    let Trial { boards, cohold, .. } = &trial;
    println!(
        "{name}: true {:.4} mm, decoded {:.4} mm, {} of {} ticks equal, instructions {:?}, {:.1} s",
        boards.whole.true_discrepancy_mm,
        boards.whole.decoded_discrepancy_mm,
        trial.equal.ticks,
        boards.ticks,
        trial.instructions,
        trial.wall_s
    );
    close("true discrepancy", boards.whole.true_discrepancy_mm, cohold.whole.true_discrepancy_mm);
    close("decoded discrepancy", boards.whole.decoded_discrepancy_mm, cohold.whole.decoded_discrepancy_mm);
    close("coordination force", boards.whole.coordination_force_n.mean, cohold.whole.coordination_force_n.mean);
    assert_eq!(boards.fault, None);
    assert_eq!(boards.ticks, (1000.0 * SECONDS) as u64);
    assert_eq!(trial.equal.ticks, boards.ticks, "first difference: {:?}", trial.equal.first_difference);
    assert_eq!(trial.replayed.map(|equal| equal.first_difference), [None; 2]);
    assert_eq!(trial.ticks_missed, 0);
    assert_eq!((trial.packets_sent, trial.packets_received), (boards.ticks / 4, boards.ticks / 4));
    assert_eq!((trial.packets_dropped, trial.wire_lost), (0, 0));
    for report in &trial.reports {
        assert_eq!(report.resets, Vec::<String>::new());
        let [_, overflowed, unlinked] = report.frames;
        // At power-on a board asks for the other's address before the other's link is up.
        assert!(overflowed == 0 && unlinked <= 2, "lost for want of buffers: {overflowed}, of a link: {unlinked}");
        reviewed::check(report);
    }
}

#[test]
fn power_domain() {
    check("paper-5.2-power-16ms");
}

#[test]
fn wave() {
    check("paper-5.2-wave-16ms");
}

#[test]
fn passive_wave() {
    check("paper-5.2-passive-wave-16ms");
}
