//! The leader and the follower of the built-in scenes: no fault, no energy made, and contact at the wall that comes to rest.

use cohold_sim::pair::Pair;
use cohold_sim::peers::Laws;
use cohold_sim::run::{Options, Outcome, run};
use cohold_sim::scene::Scene;
use cohold_sim::scenes;

use super::capital_j;

const SCENES: [&str; 2] = ["leader-follower", "leader-follower-wall"];
/// 120 ± 40 ms each way with 1 % loss, as the scenes have it; and a round trip of 160 ms without.
const NETWORKS: [&[&str]; 2] = [&[], &["network.jitter=none", "network.loss=0"]];

fn scene(name: &str, keys: &[&str], seed: u32) -> Scene {
    let seed = format!("network.seed={seed}");
    let keys: Vec<String> = keys.iter().copied().chain([&*seed]).map(str::to_owned).collect();
    scenes::find(Laws::built_in(), Some(name.as_ref()), &keys).unwrap()
}

fn passive_and_bounded(scene: &Scene, duration_s: f64) -> Outcome {
    let outcome = run::<f64>(scene, Options { duration_s, record_every: 0 }, &|_| ()).unwrap();
    let made_mj = outcome.peer_energy_made_mj().unwrap();
    assert!(outcome.bounded && outcome.fault.is_none(), "{:?}", outcome.reason);
    // No more than its law begins with.
    assert!(made_mj <= 1e3 * capital_j(scene) + 1e-6, "a peer made energy: {made_mj} mJ");
    assert!(outcome.energy_made_mj() <= 1e-6, "the line made energy: {} mJ", outcome.energy_made_mj());
    outcome
}

#[test]
fn no_seed_of_either_network_faults_or_makes_energy() {
    for (name, network) in SCENES.iter().flat_map(|name| NETWORKS.map(|network| (name, network))) {
        for seed in 1..=20 {
            passive_and_bounded(&scene(name, network, seed), 10.0);
        }
    }
}

#[test]
fn ten_simulated_minutes_with_a_clutch_that_opens_every_ten_seconds() {
    let clutch = ["user.1.clutch_at_s=5", "user.1.clutch_for_s=2", "user.1.clutch_every_s=10"];
    for (name, network) in SCENES.iter().flat_map(|name| NETWORKS.map(|network| (name, network))) {
        passive_and_bounded(&scene(name, &[network, &clutch].concat(), 1), 600.0);
    }
}

/// Pressed on, the wall pushes back with what the leader's hand gives, five times as much, and neither bounces nor hums.
#[test]
fn contact_at_the_wall_comes_to_rest() {
    for network in NETWORKS {
        let mut pair = Pair::<f64>::new(&scene("leader-follower-wall", network, 1)).unwrap();
        let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
        for tick in 0..30_000 {
            pair.step();
            if tick >= 25_000 {
                let push = pair.sides()[1].plant.wall_n();
                (least, most) = (least.min(push), most.max(push));
            }
        }
        let felt = pair.sides()[0].peer.observed()[0].contact_force;
        assert!(pair.fault().is_none() && least > 1.0 && most - least < 0.02 * most, "{least} to {most} N");
        // At rest every force of the chain is the same: what the leader's hand feels is a fifth of the wall's.
        assert!((felt - 0.5 * (least + most)).abs() < 0.02 * most, "{felt} N, wall {least} to {most} N");
    }
}
