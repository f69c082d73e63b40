//! A spring that is far too stiff for the tick (K_T = 10⁷ N/m) in runs over a network with jitter: under the midpoint rule its force goes up and down
//! from tick to tick, under backward Euler it does not.

use cohold_sim::pair::Pair;
use cohold_sim::{Laws, Scene, scenes};

/// The scene `any-network` with such a spring, whose line stands where nothing comes (THEORY §8), both users pushing the same way: an object that moves
/// meets a wall again and again.
fn scene(integrator: &str, seed: u64) -> Scene {
    let mut scene = scenes::load(Laws::built_in(), "any-network").expect("built in");
    for setting in [
        "coordination.stiffness_n_per_m=1e7",
        "coordination.carry_damping_n_s_per_m=0",
        "user.1.push_n=1",
        "user.2.push_n=-1",
        "network.jitter=gamma",
        "network.jitter_s=0.01",
        &format!("object.integrator={integrator}"),
        &format!("network.seed={seed}"),
    ] {
        scene.apply_override(setting).expect("a good override");
    }
    scene.check("test").expect("a good scene");
    scene
}

/// What 3 s of a scene came to.
#[derive(Clone, Copy, Debug, Default)]
struct Got {
    /// Largest amplitude with which F_T went up and down in 4 and in 12 changes in a row, N.
    short_n: f64,
    long_n: f64,
    /// Largest F_T, N.
    peak_n: f64,
}

/// Half of the least of these changes, if each has another sign than the one before it.
fn alternates(changes: &[f64]) -> f64 {
    let up_and_down = changes.windows(2).all(|two| two[0] * two[1] < 0.0);
    if up_and_down { changes.iter().fold(f64::MAX, |least, change| least.min(0.5 * change.abs())) } else { 0.0 }
}

fn run(scene: &Scene) -> Got {
    let mut pair = Pair::<f64>::new(scene).expect("a good scene");
    let mut forces = [const { Vec::new() }; 2];
    for _ in 0..3_000 {
        pair.step();
        assert!(pair.fault().is_none(), "{:?}", pair.fault());
        for (forces, side) in forces.iter_mut().zip(pair.sides()) {
            forces.push(side.peer.observed()[0].coordination_force);
        }
    }
    let mut got = Got::default();
    for forces in forces {
        let changes: Vec<f64> = forces.windows(2).map(|two| two[1] - two[0]).collect();
        let most = |length| changes.windows(length).map(alternates).fold(0.0, f64::max);
        (got.short_n, got.long_n) = (most(4).max(got.short_n), most(12).max(got.long_n));
        got.peak_n = forces.iter().fold(got.peak_n, |peak, force| peak.max(force.abs()));
    }
    got
}

/// An audit found 9.7 N under the midpoint rule, of a line that stood as it did then.
#[test]
fn a_stiff_spring_alternates_midway_and_not_at_the_end_of_the_tick() {
    for seed in 1..=3 {
        let [midpoint, backward] = ["midpoint", "backward-euler"].map(|integrator| run(&scene(integrator, seed)));
        println!("seed {seed}: {midpoint:?}, {backward:?}");
        assert!(midpoint.short_n > 9.7 && midpoint.long_n > 1.0, "{midpoint:?}");
        // What is left in the short is the network's own: ticks that have a sample, and such that have none.
        assert!(backward.short_n < 0.5 * midpoint.short_n && backward.long_n < 0.05, "{backward:?}, {midpoint:?}");
        assert!(backward.peak_n < 0.7 * midpoint.peak_n, "{backward:?}, {midpoint:?}");
    }
}
