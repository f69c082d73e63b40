//! Hubs of three and of eight people, audited as pairs are: every port, at every tick, over random hostile networks (THEORY §5, §8, §11).
//!
//! Each line has two ends. At either no more comes out than has gone in at the other; what goes back into all lines at the hub is no more
//! than came out of them there, and what the hub's ends begin with; what a peer's end does to its copy, ∫F_T·v, is no more than came out of
//! the line less what went into it, and what it begins with. All in joules, aligned in time: a peer's force and the copy's mean velocity of one
//! tick are booked beside what the line had done by the end of that tick.

use cohold_core::safety::Mode;
use cohold_environments::cooperative::waves::Waves;
use cohold_sim::rng::Rng;

use super::trial::built_in;

/// Equal chances by ratio.
fn spread(random: &mut Rng, low: f64, high: f64) -> f64 {
    low * (high / low).powf(random.unit())
}

/// A network that nobody would want, and hands that push against each other, and together, in front of an arm or without one.
fn hostile(random: &mut Rng, seed: u64) -> Vec<String> {
    let jitter = ["gamma", "uniform", "pareto"][random.below(3) as usize];
    let mut keys = vec![
        format!("network.one_way_delay_packets={}", random.below(10)),
        format!("network.loss={}", 0.6 * random.unit()),
        format!("network.loss_burst_packets={}", spread(random, 1.0, 60.0)),
        format!("network.jitter={jitter}"),
        format!("network.jitter_s={}", spread(random, 1e-4, 0.02)),
        format!("network.duplicate={}", 0.3 * random.unit()),
        format!("network.reorder={}", 0.3 * random.unit()),
        "network.reorder_depth_packets=8".to_owned(),
        format!("network.asymmetry_s={}", 0.01 * random.unit()),
        format!("network.seed={seed}"),
        format!("user.1.push_n={}", 2.0 * random.unit()),
        format!("user.2.push_n={}", 2.0 * random.unit() - 1.0),
        format!("user.2.sine_n={}", 2.0 * random.unit()),
        "user.2.sine_rad_per_s=11".to_owned(),
    ];
    if random.below(2) == 0 {
        keys.push("user.1.arm_stiffness_n_per_m=200".to_owned());
        keys.push("user.1.arm_damping_n_s_per_m=5".to_owned());
    }
    keys
}

/// What an audit of one end of a line knows from the tick before: force, velocity, and what had come out of the line less what went in.
type Before = Option<(f64, f64, f64)>;

/// Runs a hub and checks every port at every tick; `borrowed_j` is what an end may give before it has taken anything. Whether everybody was still
/// armed in the end.
fn audit(name: &str, keys: &[String], users: usize, borrowed_j: f64) -> bool {
    let scene = built_in(name, keys);
    let period_s = scene.peer.timing.control_period_s;
    let mut hub = Waves::new(&scene, users).expect("peers around a node");
    let (mut done_j, mut before) = (vec![0.0; users], vec![Before::None; users]);
    for tick in 0..2_500 {
        hub.step();
        let (mut back_j, mut taken_j) = (0.0, 0.0);
        for (line, (side, port)) in hub.sides().zip(&hub.junction().ports).enumerate() {
            let (ledger, at_hub) = (&side.peer.ledger()[0], port.energy());
            let (received_j, sent_j) = (ledger.received_j(), ledger.sent_j());
            for (out_j, in_j) in [(received_j, at_hub.sent_j), (at_hub.taken_j, sent_j)] {
                let most_j = in_j * (1.0 + 1e-12) + 1e-9;
                assert!(out_j <= most_j, "{name}, {users}, line {line}, tick {tick}: {out_j} J of {in_j} J, {keys:?}");
            }
            let seen = side.peer.observed()[0];
            if let Some((velocity, force, into_j)) = before[line] {
                done_j[line] += period_s * force * 0.5 * (velocity + seen.object.velocity);
                let made_j = done_j[line] - into_j;
                assert!(made_j <= borrowed_j + 1e-9, "{name}, {users}, line {line}, tick {tick}: {made_j} J, {keys:?}");
            }
            before[line] = Some((seen.object.velocity, seen.coordination_force, received_j - sent_j));
            (back_j, taken_j) = (back_j + at_hub.sent_j, taken_j + at_hub.taken_j);
        }
        let most_j = taken_j * (1.0 + 1e-12) + users as f64 * borrowed_j + 1e-9;
        assert!(back_j <= most_j, "{name}, {users}, tick {tick}: {back_j} J back, of {taken_j} J, {keys:?}");
    }
    hub.sides().all(|side| side.peer.mode() == Mode::Armed)
}

/// Lines with a time of their own, which carry on, some of them short of tank, some of them light; and means of waves that are paid for.
#[test]
fn hubs_of_three_and_of_eight_make_no_energy_at_any_port() {
    let mut random = Rng::new(9);
    for users in [3, 8] {
        let (mut runs, mut armed) = (0, 0);
        for seed in 0..12 {
            let network = hostile(&mut random, seed);
            let capital_j = [0.0, 0.005, 0.02][seed as usize % 3];
            let own = [
                format!("coordination.carry_energy_j={capital_j}"),
                format!("coordination.most_line_mass_kg={}", [4.0, 0.5, 0.0, 0.1][seed as usize % 4]),
                format!("coordination.credit_ticks={}", [0, 25][seed as usize % 2]),
            ];
            armed += u32::from(audit("any-network", &[&network[..], &own].concat(), users, capital_j));
            armed += u32::from(audit("hub", &network, users, 0.0));
            runs += 2;
        }
        println!("{users} users: {armed} of {runs} runs to the end");
        assert!(4 * armed > 3 * runs, "runs that go on are most of them: {armed} of {runs}");
    }
}
