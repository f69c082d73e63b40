//! The force at the hand: known forces, and what the motors of a run are seen to press with.

use std::path::Path;

use cohold_sim::pair::Pair;
use cohold_sim::peers::Builds;
use cohold_sim::run::{Accounts, Figures, Options, run};
use cohold_sim::{Laws, Plant, Scene, scenes};

const OPTIONS: Options = Options { duration_s: 2.0, record_every: 0 };

fn scene(set: &[&str]) -> Scene {
    let set: Vec<String> = set.iter().map(|text| (*text).to_owned()).collect();
    scenes::find(Laws::built_in(), Some(Path::new("any-network")), &set).expect("a scene")
}

fn hands(figures: &Figures) -> [f64; 2] {
    [figures.peak_hand_force_n, figures.largest_hand_change_n]
}

/// 3 and 4 N at right angles are 5 N; from there to -3 and -4 N the change is 10 N, along the axes 6 and 8.
#[test]
fn along_several_axes_forces_and_changes_are_vectors() {
    let mut account = Accounts::<2>::new(&scene(&["axis.count=2", "axis.shared=2"]), 3, OPTIONS);
    for (first, second) in [([0.0, 0.0], [1.0, 0.0]), ([3.0, 4.0], [1.0, 1.0]), ([-3.0, -4.0], [f64::NAN, 1.0])] {
        account.pressed(0, first);
        account.pressed(1, second);
        account.period();
    }
    let outcome = account.outcome();
    assert_eq!(hands(&outcome.whole), [5.0, 10.0]);
    assert_eq!([hands(&outcome.axes[0].figures), hands(&outcome.axes[1].figures)], [[3.0, 6.0], [4.0, 8.0]]);
}

/// Of a board's record nobody knows: no number, and not 0.
#[test]
fn who_was_never_told_has_none() {
    let mut account = Accounts::<1>::new(&scene(&[]), 1, OPTIONS);
    account.period();
    assert!(hands(&account.outcome().whole).iter().all(|figure| figure.is_nan()));
}

/// Largest force and change of both motors, read off one by one.
fn seen<const SHARED: usize>(scene: &Scene) -> [f64; 2]
where
    f64: Builds<SHARED, 2>,
{
    let mut pair = Pair::<f64, Plant, SHARED>::build(scene).expect("a scene");
    let (mut last, mut largest) = ([[0.0_f64; SHARED]; 2], [0.0_f64; 2]);
    for _ in 0..OPTIONS.ticks(scene) {
        pair.step_watched(&mut |tick| {
            let before = &mut last[tick.number - 1];
            let square = |of: &dyn Fn(usize) -> f64| (0..SHARED).map(|axis| of(axis).powi(2)).sum::<f64>().sqrt();
            let now = |axis: usize| tick.actuators.forces[axis];
            largest[0] = largest[0].max(square(&now));
            largest[1] = largest[1].max(square(&|axis| now(axis) - before[axis]));
            before.iter_mut().enumerate().for_each(|(axis, force)| *force = now(axis));
        });
    }
    largest
}

/// Hands that push and beat through a network that loses: what the run says is what is seen, on clocks that drift, too.
#[test]
fn a_run_says_what_its_motors_pressed_with() {
    let pushes =
        ["user.1.push_n=1", "user.2.sine_n=2", "user.1.pulse_n=4", "network.loss=0.3", "user.2.side_push_n=0.5"];
    let near = |one: [f64; 2], other: [f64; 2]| {
        assert!(
            one.iter().zip(other).all(|(one, other)| (one - other).abs() < 1e-12 * other && other > 0.5),
            "{one:?} {other:?}"
        );
    };
    for more in ["network.clock_drift_ppm=0", "network.clock_drift_ppm=900"] {
        let one = scene(&[&pushes[..], &[more]].concat());
        near(hands(&run::<f64>(&one, OPTIONS, &|_| ()).expect("a run").whole), seen::<1>(&one));
        let two = scene(&[&pushes[..], &[more, "axis.count=2", "axis.shared=2"]].concat());
        near(hands(&run::<f64>(&two, OPTIONS, &|_| ()).expect("a run").whole), seen::<2>(&two));
    }
}
