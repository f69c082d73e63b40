//! The scene `any-network` where packets are lost in bursts (THEORY §11): what a hand feels, how far it gets and how near the copies are,
//! where an end carries on and where it stands like a wall.

use std::sync::Arc;

use cohold_sim::network::rule::{Arrival, NetworkTrace};
use cohold_sim::pair::Pair;
use cohold_sim::{Laws, Scene, scenes};
use rayon::prelude::*;

use super::capital_j;

/// Loss, and the mean length of a burst, ms: packets go each millisecond.
const SHORT: [(&str, &str); 3] = [("0.05", "40"), ("0.2", "40"), ("0.5", "40")];
const LONG: [(&str, &str); 3] = [("0.05", "100"), ("0.2", "100"), ("0.5", "100")];

/// The networks that the bench tests on and whose losses are no plain bursts (docs/results/laws.md), and others that are hostile.
const OTHERS: [&[&str]; 10] = [
    &[],
    &["network.jitter=pareto", "network.jitter_s=0.004"],
    &["network.one_way_delay_packets=20"],
    &["network.delay_step_s=0.012", "network.delay_step_at_s=3"],
    &["network.like=5g-campus", "network.one_way_delay_packets=4"],
    &["network.like=starlink", "network.one_way_delay_packets=15"],
    &["network.like=home-wifi", "network.one_way_delay_packets=0", "network.extra_delay_s=0.0008"],
    &["network.jitter=gamma", "network.jitter_s=0.01", "network.loss=0.2"],
    &[
        "network.reorder=0.3",
        "network.reorder_depth_packets=16",
        "network.duplicate=0.2",
        "network.clock_drift_ppm=200",
    ],
    &["network.one_way_delay_packets=90", "network.jitter=pareto", "network.jitter_s=0.004", "network.loss=0.1"],
];

/// Against each other, those of the cooperation paper's §5.2.
const AGAINST: &[&str] = &["user.1.push_n=1", "user.2.push_n=1", "user.2.sine_n=0.25", "user.2.sine_rad_per_s=3"];
/// Both the same way, 1 N from rest.
const TOGETHER: &[&str] = &["user.1.push_n=1", "user.2.push_n=-1"];
/// One hand over 200 mm at 0.7 Hz, by an arm that does not give way; the other one only goes along.
const LED: &[&str] = &[
    "user.1.arm_stiffness_n_per_m=400",
    "user.1.arm_damping_n_s_per_m=5",
    "user.1.tremor_m=0.1",
    "user.1.tremor_hz=0.7",
];
const STANDS: &[&str] = &["coordination.carry_damping_n_s_per_m=0"];
/// What a wall would push a hand with: the device's own limits cut it at 40 N.
const UNBOUND: &[&str] = &[
    "safety.max_force_n=200",
    "safety.max_slew_n_per_s=1000000",
    "safety.max_rms_force_n=200",
    "safety.max_rms_power_w=1000",
    "safety.max_hand_power_w=1000",
    "motor.full_scale_a=50",
];

const SEEDS: u64 = 20;

fn scene(settings: &[&[&str]], network: Option<(&str, &str)>, seed: u64) -> Scene {
    let mut scene = scenes::load(Laws::built_in(), "any-network").expect("built in");
    scene.users = Default::default();
    let network = network.map(|(loss, burst)| [("loss", loss), ("loss_burst_packets", burst)]);
    let network = network.into_iter().flatten().map(|(key, value)| format!("network.{key}={value}"));
    let seed = format!("network.seed={seed}");
    let own = settings.iter().copied().flatten().map(|setting| (*setting).to_owned());
    for setting in own.chain(network).chain([seed]) {
        scene.apply_override(&setting).expect("a good override");
    }
    scene.check("test").expect("a good scene");
    scene
}

/// What runs of a scene came to; means but where it says most.
#[derive(Clone, Copy, Debug, Default)]
struct Got {
    /// Mean |x_o1 − x_o2| after the first half, mm, of runs that went on; its sum, and of how many ticks.
    true_mm: f64,
    sum_mm: f64,
    compared: usize,
    /// Where both copies are in the end, m.
    way_m: f64,
    /// The most that either hand felt, N, its largest change in a tick, and the most F_T.
    most_hand_n: f64,
    most_jump_n: f64,
    most_force_n: f64,
    stopped: u32,
}

/// Adds what a run comes to; |x_o1 − x_o2| at each tick after the first half, m.
fn run(scene: &Scene, ticks: u32, got: &mut Got) -> Vec<f64> {
    let mut pair = Pair::<f32>::new(scene).expect("a good scene");
    let (mut apart_m, mut way_m, mut felt_n) = (Vec::new(), 0.0, [0.0; 2]);
    for tick in 0..ticks {
        pair.step();
        if pair.fault().is_some() {
            got.stopped += 1;
            break;
        }
        let seen = pair.sides().map(|side| side.peer.observed()[0].map(f64::from));
        if tick >= ticks / 2 {
            apart_m.push((seen[0].object.position - seen[1].object.position).abs());
        }
        way_m = 0.5 * (seen[0].object.position + seen[1].object.position);
        for (seen, felt_n) in seen.into_iter().zip(&mut felt_n) {
            got.most_hand_n = got.most_hand_n.max(seen.contact_force.abs());
            got.most_jump_n = got.most_jump_n.max((seen.contact_force - *felt_n).abs());
            *felt_n = seen.contact_force;
            got.most_force_n = got.most_force_n.max(seen.coordination_force.abs());
        }
    }
    got.sum_mm += 1e3 * apart_m.iter().sum::<f64>();
    got.compared += apart_m.len();
    got.true_mm = got.sum_mm / got.compared.max(1) as f64;
    got.way_m += way_m / SEEDS as f64;
    apart_m
}

fn over(settings: &[&[&str]], network: Option<(&str, &str)>, ticks: u32) -> Got {
    let mut got = Got::default();
    for seed in 1..=SEEDS {
        run(&scene(settings, network, seed), ticks, &mut got);
    }
    got
}

/// A hand that is led feels at most half of what a line that stands lets it feel, is stopped nowhere, and in bursts of 40 ms the copies are hardly
/// farther apart. A standing line stops some of these runs, and the easiest of each: so distances are compared over the ticks in
/// which both lines run, seed by seed; what each comes to by itself is printed beside it.
#[test]
fn a_hand_that_is_led_meets_no_wall() {
    const FAR: f64 = f64::MAX;
    for (network, farther) in SHORT.into_iter().chain(LONG).zip([1.0, 1.1, 1.3, 1.8, FAR, FAR]) {
        let (mut carries, mut stands) = (Got::default(), Got::default());
        let mut both_m = [0.0; 2];
        for seed in 1..=SEEDS {
            let carried = run(&scene(&[LED], Some(network), seed), 8_000, &mut carries);
            let stood = run(&scene(&[LED, STANDS, UNBOUND], Some(network), seed), 8_000, &mut stands);
            for (carried, stood) in carried.iter().zip(&stood) {
                both_m = [both_m[0] + carried, both_m[1] + stood];
            }
        }
        let share = both_m[0] / both_m[1];
        println!("{network:?}: {share:.2} times as far in the same ticks; {carries:?}, a wall {stands:?}");
        assert_eq!(carries.stopped, 0, "{network:?}");
        assert!(carries.most_hand_n <= 0.5 * stands.most_hand_n, "{network:?}: {carries:?}, a wall {stands:?}");
        assert!(share <= farther, "{network:?}: {share}, {carries:?}, a wall {stands:?}");
        // Nor by themselves, where it is stated.
        assert!(carries.true_mm <= farther.max(1.8) * stands.true_mm, "{network:?}: {carries:?}, a wall {stands:?}");
    }
}

/// Wherever else packets come late or not at all, nobody who is led is stopped.
#[test]
fn a_hand_that_is_led_is_stopped_nowhere() {
    for network in OTHERS {
        let mut got = Got::default();
        for seed in 1..=SEEDS {
            run(&scene(&[LED, network], None, seed), 20_000, &mut got);
        }
        println!("{network:?}: {got:?}");
        assert!(got.stopped == 0 && got.most_hand_n < 40.0, "{network:?}: {got:?}");
    }
}

/// What carrying on does not do: over a LAN of 1 ms of which one direction alone is dead for a while, a hand that is led leaves the other copy behind, for the
/// one end hears nothing and the other hears of an end that stands. It feels no wall and no jolt, nobody stops, and the copies meet again. Twenty instants at which
/// the direction dies, each way.
#[test]
fn one_dead_direction_parts_the_copies_and_they_meet_again() {
    for (dead_ms, most_mm, most_n) in [(200, 40.0, 12.0), (1_000, 300.0, 16.0), (2_500, 300.0, 16.0)] {
        let (mut got, mut last_mm, mut far_mm) = (Got::default(), 0.0_f64, 0.0_f64);
        for at in 0..2 * SEEDS {
            let mut lan = scene(&[LED, &["network.one_way_delay_packets=1"]], None, 1);
            let from = 11_000 + 71 * (at / 2) as usize;
            let packet = |dies: bool, nth| {
                let lost = dies && (from..from + dead_ms).contains(&nth);
                if lost { Vec::new() } else { vec![Arrival { delay_ns: 0, corrupt: false }] }
            };
            let way = |dies| (0..20_000).map(|nth| packet(dies, nth)).collect();
            lan.network_trace = Some(Arc::new(NetworkTrace::of_packets([way(at % 2 == 0), way(at % 2 == 1)])));
            let apart_m = run(&lan, 20_000, &mut got);
            far_mm = apart_m.iter().fold(far_mm, |far_mm, apart_m| far_mm.max(1e3 * apart_m));
            last_mm =
                apart_m[apart_m.len() - 500..].iter().fold(last_mm, |last_mm, apart_m| last_mm.max(1e3 * apart_m));
        }
        println!("{dead_ms} ms: at most {far_mm:.0} mm, in the end {last_mm:.2} mm; {got:?}");
        assert!(got.stopped == 0 && far_mm < most_mm && got.most_hand_n < most_n && last_mm < 3.0, "{got:?}");
    }
}

/// Pushed the same way, the object goes where it would, without a jolt.
#[test]
fn a_common_push_goes_on_through_bursts() {
    let free = over(&[TOGETHER], None, 1_000);
    for (network, least, most_n) in [(SHORT[0], 0.85, 2.5), (SHORT[1], 0.65, 3.0), (LONG[2], 0.4, 4.0)] {
        let [carries, stands] =
            [&[TOGETHER][..], &[TOGETHER, STANDS]].map(|settings| over(settings, Some(network), 1_000));
        let way = carries.way_m / free.way_m;
        println!("{network:?}: way {way}, {carries:?}, a wall {}, {stands:?}", stands.way_m / free.way_m);
        assert!(
            way >= least && carries.way_m > 1.15 * stands.way_m,
            "{network:?}: {way}, {carries:?}, a wall {stands:?}"
        );
        assert!(carries.most_force_n <= most_n && carries.stopped == 0, "{network:?}: {carries:?}");
    }
}

/// Pushed against each other the copies are as near as a wall holds them, or nearly.
#[test]
fn a_push_against_each_other_holds() {
    for (network, most_mm) in
        [(SHORT[0], 0.6), (SHORT[1], 0.7), (SHORT[2], 0.7), (LONG[0], 0.6), (LONG[1], 0.8), (LONG[2], 1.0)]
    {
        let got = over(&[AGAINST], Some(network), 10_000);
        println!("{network:?}: {got:?}");
        assert!(got.true_mm <= most_mm && got.stopped == 0, "{network:?}: {got:?}");
    }
}

/// An end that had to stand is behind in motion, and makes up for it if it may: the copies come nearer, whatever the hands do, and nobody feels more (THEORY
/// §15). Where paths of different delay are taken for that, it does no harm.
#[test]
fn who_is_behind_makes_up_for_it() {
    const COMMON: &[&str] =
        &["user.1.sine_n=2", "user.1.sine_rad_per_s=3", "user.2.sine_n=-2", "user.2.sine_rad_per_s=3"];
    const ASYMMETRY: &[&str] = &["network.asymmetry_s=0.04"];
    for (users, network, other, share) in [
        (LED, Some(SHORT[0]), OTHERS[0], 0.6),
        (LED, Some(SHORT[1]), OTHERS[0], 0.95),
        (COMMON, Some(SHORT[0]), OTHERS[0], 0.35),
        (COMMON, Some(SHORT[1]), OTHERS[0], 0.7),
        (AGAINST, Some(SHORT[0]), OTHERS[0], 0.5),
        (AGAINST, Some(SHORT[1]), OTHERS[0], 0.85),
        (COMMON, None, OTHERS[1], 0.8),
        (LED, None, ASYMMETRY, 1.0),
        (COMMON, None, ASYMMETRY, 1.0),
    ] {
        let [without, with] = ["coordination.even_s=0", "coordination.even_s=0.02"]
            .map(|key| over(&[users, other, &[key]], network, 10_000));
        println!("{users:?}, {network:?}, {other:?}: {without:?}, made up for {with:?}");
        assert!(with.true_mm < share * without.true_mm && with.stopped == 0, "{with:?}, not made up for {without:?}");
        assert!(with.most_hand_n < 1.05 * without.most_hand_n + 0.1, "{with:?}, not made up for {without:?}");
        assert!(with.most_jump_n < 1.3 * without.most_jump_n + 0.05, "{with:?}, not made up for {without:?}");
    }
}

/// Two hands that push against each other hardly part ends whose tanks begin with nothing: an empty one is a wall. One that was a damper let the
/// copies go 6 to 8 mm apart, and stopped two runs of eight.
#[test]
fn an_empty_tank_parts_nobody() {
    let got = over(&[AGAINST, &["coordination.carry_energy_j=0"]], Some(LONG[2]), 60_000);
    println!("{got:?}");
    assert!(got.true_mm < 3.5 && got.stopped == 0, "{got:?}");
}

/// Over every network: what is lost is made good for as long as one looks, and at no tick has an end done more to its copy, ∫F_T·v, than came out of the line
/// less what went into it, and E₀. Ten minutes of each; an hour: `MINUTES=60 cargo test --release -p cohold-sim --test suite nothing_drifts`.
#[test]
fn nothing_drifts_and_nothing_is_made() {
    let minutes = std::env::var("MINUTES").map_or(10, |text| text.parse().expect("whole minutes"));
    let bursts = SHORT.into_iter().chain(LONG).map(|network| scene(&[AGAINST], Some(network), 1));
    let scenes: Vec<Scene> = bursts.chain(OTHERS.map(|network| scene(&[AGAINST, network], None, 1))).collect();
    scenes.par_iter().for_each(|scene| {
        let of = |tautness: &str| {
            let mut scene = scene.clone();
            scene.apply_override(&format!("coordination.tautness={tautness}")).expect("a good override");
            drift(&scene, minutes)
        };
        let ([first, last, least_j], [taut_first, taut_last, taut_least_j]) = (of("0"), of("0.9"));
        println!(
            "{first:.3} mm at first, {last:.3} mm in the end, least balance {least_j:.3e} J; taut {taut_first:.3} mm, \
             {taut_last:.3} mm, {taut_least_j:.3e} J: {:?}",
            scene.world.network
        );
        assert!(last < 1.2 * first + 0.05, "{first} mm, then {last} mm: {:?}", scene.world.network);
        // What losses take from the tank a taut line does not have, so that its copies come to stand like those of one that is not.
        assert!(taut_first.max(taut_last) < last + 0.05, "{taut_last} mm, not {last} mm: {:?}", scene.world.network);
        let least_j = least_j.min(taut_least_j);
        assert!(least_j >= -capital_j(scene) - 1e-9, "{least_j} J: {:?}", scene.world.network);
    });
}

/// Mean distance of the copies in the first and the last fifth but for the first minute, mm; and the least balance of either end at any tick, J.
fn drift(scene: &Scene, minutes: usize) -> [f64; 3] {
    let mut pair = Pair::<f64>::new(scene).expect("a good scene");
    let (mut sums_m, mut least_j) = (vec![0.0; minutes], 0.0_f64);
    let (mut done_j, mut before) = ([0.0; 2], [None; 2]);
    for (minute, sum_m) in sums_m.iter_mut().enumerate() {
        for _ in 0..60_000 {
            pair.step();
            let sides = pair.sides();
            let [one, other] = sides.map(|side| side.peer.observed()[0].object.position);
            *sum_m += (one - other).abs();
            for (at, side) in sides.into_iter().enumerate() {
                let (seen, ledger) = (side.peer.observed()[0], &side.peer.ledger()[0]);
                if let Some((velocity, force, into_j)) = before[at] {
                    done_j[at] += 1e-3 * force * 0.5 * (velocity + seen.object.velocity);
                    least_j = least_j.min(into_j - done_j[at]);
                }
                before[at] =
                    Some((seen.object.velocity, seen.coordination_force, ledger.received_j() - ledger.sent_j()));
            }
        }
        assert!(pair.fault().is_none(), "minute {minute}: {:?}, {:?}", pair.fault(), scene.world.network);
    }
    let fifth = (minutes / 5).max(1);
    let mean = |sums: &[f64]| 1e3 * sums.iter().sum::<f64>() / (60_000 * sums.len()) as f64;
    [mean(&sums_m[1..=fifth]), mean(&sums_m[minutes - fifth..]), least_j]
}
