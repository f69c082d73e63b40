//! Amplifiers in current mode take half of the period for no current, and a line that is low for all of it backwards. What stands at their
//! inputs is looked at every 20 µs while they are armed and disarmed, and a microsecond after each break: they are enabled only where
//! the timer drives, and from no current on. That the gate is needed shows where the enable line alone is looked at; a gate that is not
//! what it should be is noticed before amplifiers that it enables are asked for anything.

use std::sync::Arc;

use board_bench::bench::Bench;
use board_bench::image::Firmware;
use board_bench::node::Inputs;
use board_bench::part::Gate;

use board_bench::wire::Line;
use cohold_sim::scene::Scene;

use crate::{breaks, three_axes};

/// Full scale that a hand which holds still may be given in the first 10 ms, as a share.
const SMALL: f64 = 0.1;

fn armed(three: bool) -> Bench {
    let (firmware, scene) = image(three);
    breaks::armed(&firmware, &scene)
}

fn image(three: bool) -> (Arc<Firmware>, Scene) {
    if three {
        (Arc::new(Firmware::with("three-axes")), three_axes::scene())
    } else {
        (Arc::new(Firmware::release()), breaks::scene(&[]))
    }
}

/// A board alone that is checked and armed behind such a gate; the largest share that its amplifiers were commanded while enabled, and what it
/// says then.
pub(crate) fn armed_behind(gate: Gate, three: bool) -> (f64, [String; 2]) {
    let (firmware, scene) = image(three);
    let mut bench = Bench::start(&firmware, 1, Line::default());
    bench.set_up(&scene).expect("the board takes it");
    bench.check(1).expect("it passes with a gate that works");
    bench.input(1).gate = Some(gate);
    bench.run_for_ms(2);
    bench.send(1, "arm");
    let ([most, _], _) = look(&mut bench, 20);
    let said = ["status", "arm"].map(|line| bench.ask(1, line));
    bench.finish();
    (most, said)
}

#[test]
fn are_asked_for_nothing_behind_a_gate_that_does_not_work() {
    for (gate, three) in [
        (Gate::EnableAlone, false),
        (Gate::EnableAlone, true),
        (Gate::TimerAlone, false),
        (Gate::TimerAlone, true),
        (Gate::NeverOpens, false),
    ] {
        let (most, [status, arm]) = armed_behind(gate, three);
        assert!(status.contains(" faulted fault 31 ") && arm == "error faulted, fault 31", "{gate:?}: {status}; {arm}");
        assert_eq!(most, 0.0, "{gate:?}, three {three}");
    }
    // Whatever it is wired to, it is not armed: no software takes back what is always enabled.
    let (_, [status, _]) = armed_behind(Gate::AlwaysOpen, false);
    assert!(status.contains(" faulted fault 31 "), "{status}");
}

/// It worked when the amplifiers were enabled, and does not when it is needed.
#[test]
fn a_gate_that_fails_later_is_noticed_by_the_first_break() {
    for press in [true, false] {
        let mut bench = armed(false);
        let inputs = bench.input(1);
        inputs.gate = Some(Gate::EnableAlone);
        (inputs.press, inputs.bridge_fails) = (press.then_some(true), (!press).then_some(true));
        bench.run_for_ms(1);
        let inputs = bench.input(1);
        (inputs.press, inputs.bridge_fails) = (Some(false), Some(false));
        bench.run_for_ms(3);
        let status = bench.ask(1, "status");
        assert!(status.contains(" faulted fault 31 "), "press {press}: {status}");
        bench.finish();
    }
}

/// From the end of the enable line on: so long do commands stand at no current, µs.
fn stands_us(bench: &mut Bench, three: bool) -> u32 {
    let (mut enabled, mut stood_us) = (false, 0);
    for _ in 0..1000 {
        bench.run_for_us(20);
        let bridges = bench.stopped[0].bridges;
        if bridges.enable || !enabled {
            assert_eq!(stood_us, 0, "three {three}: enabled again");
            enabled |= bridges.enable;
            continue;
        }
        if !bridges.outputs {
            break;
        }
        stood_us += 20;
        let legs = if three { 3 } else { 1 };
        let middle = bridges.compare[..legs].iter().all(|compare| *compare == bridges.top / 2);
        assert!(middle, "three {three}: {:?}", bridges.compare);
    }
    assert!(!bench.stopped[0].bridges.outputs, "three {three}: off in the end");
    stood_us
}

/// Amplifiers need some time to let go: whatever the program disables them for, their inputs stand at no current for a tick longer.
#[test]
fn inputs_stand_at_no_current_after_the_program_disabled_them() {
    for three in [false, true] {
        let mut bench = armed(three);
        bench.send(1, "disarm");
        let stood_us = stands_us(&mut bench, three);
        assert!((900..=1100).contains(&stood_us), "three {three}: {stood_us} us");
        // Without a gate, where the enable line itself is what they get.
        bench.input(1).gate = Some(Gate::EnableAlone);
        bench.run_for_ms(2);
        bench.send(1, "arm");
        let stood_us = stands_us(&mut bench, three);
        assert!((900..=2100).contains(&stood_us), "three {three}, no gate: {stood_us} us");
        bench.finish();
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
