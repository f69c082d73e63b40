//! Amplifiers in current mode take half of the period for no current, and a line that is low for all of it backwards. What stands at their
//! inputs is looked at every 20 µs while they are armed and disarmed, and a microsecond after each break: they are enabled only where
//! the timer drives, and from no current on. That the gate is needed shows where the enable line alone is looked at.

use std::sync::Arc;

use board_bench::bench::Bench;
use board_bench::image::Firmware;
use board_bench::node::Inputs;

use crate::{breaks, three_axes};

/// Full scale that a hand which holds still may be given in the first 10 ms, as a share.
const SMALL: f64 = 0.1;

fn armed(three: bool) -> Bench {
    if three {
        breaks::armed(&Arc::new(Firmware::three_axes()), &three_axes::scene())
    } else {
        breaks::armed(&Arc::new(Firmware::release()), &breaks::scene(&[]))
    }
}

/// So many ms, looked at every 20 µs: the largest share that amplifiers were commanded while enabled, with the gate and without one, and the
/// first that was.
fn look(bench: &mut Bench, ms: u64) -> ([f64; 2], Option<f64>) {
    let (mut most, mut first) = ([0.0_f64; 2], None);
    for _ in 0..50 * ms {
        bench.run_for_us(20);
        let bridges = bench.stopped[0].bridges;
        let seen = [bridges.currents(), bridges.currents_without_gate()];
        let largest = seen.map(|shares| shares.map(|shares| shares.into_iter().map(f64::abs).fold(0.0, f64::max)));
        for (most, largest) in most.iter_mut().zip(largest) {
            *most = most.max(largest.unwrap_or(0.0));
        }
        first = first.or(largest[0]);
    }
    (most, first)
}

#[test]
fn are_enabled_at_no_current_and_never_while_the_outputs_are_off() {
    type Cause = fn(&mut Inputs);
    let causes: [(&str, Cause, Cause); 3] = [
        ("stop", |inputs| inputs.press = Some(true), |inputs| inputs.press = Some(false)),
        ("fault", |inputs| inputs.bridge_fails = Some(true), |inputs| inputs.bridge_fails = Some(false)),
        ("supply", |inputs| inputs.supply_dips = true, |_| {}),
    ];
    for three in [false, true] {
        let mut bench = armed(three);
        assert!(bench.stopped[0].bridges.currents().is_some(), "three {three}: they are enabled");
        bench.send(1, "disarm");
        let ([_, without], _) = look(&mut bench, 10);
        assert!(bench.stopped[0].bridges.currents().is_none() && without < SMALL, "three {three}: off, at {without}");
        bench.send(1, "arm");
        let ([most, without], first) = look(&mut bench, 10);
        assert!(first.is_some_and(|share| share < SMALL), "three {three}: enabled at {first:?}");
        assert!(most < SMALL && without < SMALL, "three {three}: {most} in the first 10 ms, {without} without a gate");
        bench.finish();
        for (what, breaks, mends) in causes {
            let mut bench = armed(three);
            breaks(bench.input(1));
            bench.run_for_us(1);
            let bridges = bench.stopped[0].bridges;
            assert_eq!(bridges.currents(), None, "{what}, three {three}: not enabled a microsecond later");
            assert_eq!(bridges.currents_without_gate(), Some([-1.0; 3]), "{what}, three {three}: what the gate is for");
            mends(bench.input(1));
            let ([most, _], _) = look(&mut bench, 5);
            assert_eq!(most, 0.0, "{what}, three {three}: enabled again by itself");
            bench.finish();
        }
    }
}
