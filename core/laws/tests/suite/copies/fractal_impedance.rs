//! A swing that ends at rest, a way there and back that costs all of its energy, and no energy out of a point that stands.

use cohold_core::law::{Law, Observation, Packet};
use cohold_core::num::{Fixed, Motion, Scalar};
use cohold_core::object::Port;
use cohold_core::settings::Settings;
use cohold_laws::fractal_impedance::FractalImpedance;

use super::draws;
use crate::two_copies::{Copies, PERIOD, SOFT, settings};

const MASS_KG: f64 = 0.3;
const STIFFNESS: f64 = 400.0;

type State = <FractalImpedance<f64> as Law<f64>>::State;

/// One end, its far end at this place, m.
fn end(damping: f64, place: f64) -> (FractalImpedance<f64>, State) {
    let keys = [("coordination.stiffness_n_per_m", STIFFNESS), ("coordination.damping_n_s_per_m", damping)];
    let law = <FractalImpedance<f64> as Law<f64>>::build(&settings("fractal-impedance", &keys)).expect("good settings");
    let mut state = Law::<f64>::start(&law, Motion::REST);
    hear(&law, &mut state, place);
    (law, state)
}

fn hear(law: &FractalImpedance<f64>, state: &mut State, place: f64) {
    law.receive(state, Packet { motion: Motion::at(place), ..Packet::default() });
}

/// A tick in which the copy moves at this mean velocity: the force, N.
fn led(law: &FractalImpedance<f64>, state: &mut State, copy: &mut Motion<f64>, velocity: f64) -> f64 {
    let seen = Observation { local: *copy, ..Observation::default() };
    let force = law.couple(state, &seen, |_: Port<f64>| velocity).force;
    *copy = Motion { position: copy.position + PERIOD * velocity, velocity };
    force
}

/// Let go of at X it comes to the far end after π·√(m/2K), by X/2·(1 + cos √(2K/m)t), and is at rest there.
#[test]
fn what_is_let_go_of_comes_to_rest_where_it_is_drawn() {
    let place = 0.02;
    let (law, mut state) = end(0.0, place);
    let mut copy = Motion::<f64>::REST;
    let swing = (2.0 * STIFFNESS / MASS_KG).sqrt();
    let ticks = (std::f64::consts::PI / swing / PERIOD) as u32;
    for tick in 0..ticks {
        let way = place / 2.0 * (1.0 + (swing * f64::from(tick) * PERIOD).cos());
        assert!(
            (place - copy.position - way).abs() < 0.03 * place,
            "tick {tick}: {} m, {way} m",
            place - copy.position
        );
        let seen = Observation { local: copy, ..Observation::default() };
        let mut mean = 0.0;
        law.couple(&mut state, &seen, |port: Port<f64>| {
            let inertia = 2.0 * MASS_KG / PERIOD;
            mean = (inertia * copy.velocity + port.force) / (inertia + port.impedance);
            mean
        });
        copy = Motion { position: copy.position + PERIOD * mean, velocity: 2.0 * mean - copy.velocity };
    }
    // A spring that is none on the way back would have it pass at √(K/m)·X.
    let free = (STIFFNESS / MASS_KG).sqrt() * place;
    assert!(copy.velocity.abs() < 0.05 * free, "{} m/s, {free} m/s by a spring", copy.velocity);
    assert!((place - copy.position).abs() < 0.01 * place, "{} m from there", place - copy.position);
}

/// Led away from the far end by X and back to it: ½K·X² goes in, and none of it comes out; a part of the way back gives K·x·(X − x).
#[test]
fn a_way_there_and_back_costs_all_that_it_took() {
    let (law, mut state) = end(0.0, 0.0);
    let (mut copy, mut work) = (Motion::<f64>::REST, 0.0);
    let (ticks, speed) = (200, 0.1);
    let most = f64::from(ticks) * speed * PERIOD;
    for _ in 0..ticks {
        work += PERIOD * speed * led(&law, &mut state, &mut copy, speed);
    }
    let stored = 0.5 * STIFFNESS * most * most;
    assert!((work + stored).abs() < 0.02 * stored, "{work} J, {stored} J");
    for tick in 1..=ticks {
        work -= PERIOD * speed * led(&law, &mut state, &mut copy, -speed);
        let way = most - f64::from(tick) * speed * PERIOD;
        let given = STIFFNESS * way * (most - way);
        assert!((work + stored - given).abs() < 0.02 * stored, "{way} m: {work} J, {given} J of {stored} J");
    }
}

/// Hands that throw and hold, a far end that stands, or that moves and whose work is counted: V never grows by more than was done.
#[test]
fn a_point_that_stands_gives_nothing() {
    for seed in 0..40_u64 {
        let mut random = draws(seed);
        let (law, mut state) = end(if seed % 2 == 0 { 0.0 } else { 5.0 }, 0.01);
        let (mut copy, mut given, mut taken) = (Motion::<f64>::REST, 0.0_f64, 0.0_f64);
        let stored = 0.5 * STIFFNESS * 0.01 * 0.01;
        for _ in 0..5000 {
            let hand = Port { force: 10.0 * random(), impedance: 2.0 };
            let seen = Observation { local: copy, ..Observation::default() };
            let mut mean = 0.0;
            let coupled = law.couple(&mut state, &seen, |port: Port<f64>| {
                let (inertia, all) = (2.0 * MASS_KG / PERIOD, port + hand);
                mean = (inertia * copy.velocity + all.force) / (inertia + all.impedance);
                mean
            });
            copy = Motion { position: copy.position + PERIOD * mean, velocity: 2.0 * mean - copy.velocity };
            given += PERIOD * coupled.force * mean;
            taken = taken.min(given);
            assert!(given <= stored + 1e-12, "seed {seed}: {given} J of {stored} J");
        }
        assert!(taken < -0.001, "seed {seed}: the hand did nothing, {taken} J");
    }
}

fn scene(law: &'static str, stiffness: f64, damping: f64) -> Settings {
    let keys = [
        ("coordination.stiffness_n_per_m", stiffness),
        ("coordination.damping_n_s_per_m", damping),
        ("contact.stiffness_n_per_m", SOFT),
        ("contact.damping_n_s_per_m", 0.0),
    ];
    settings(law, &keys)
}

/// How far apart copies are on average in the last quarter of 20 s under these pushes, N.
fn apart(copies: &mut Copies<f64>, force: f64) -> f64 {
    (0..20_000).fold(0.0, |apart, tick| {
        let [one, two] = copies.pushed([force, -force]).map(|seen| seen.object.position);
        if tick >= 15_000 { apart + (one - two) / 5000.0 } else { apart }
    })
}

/// Two hands that push F against each other stand F/K_T apart, whatever the delay, and the copies come together when they let go.
#[test]
fn copies_stand_apart_by_the_spring_and_come_together() {
    for (delay, damping) in [(0, 0.0), (20, 4.0)] {
        let mut copies = Copies::<f64>::new(&scene("fractal-impedance", STIFFNESS, damping), delay);
        let pushed = apart(&mut copies, 1.0);
        assert!((pushed * STIFFNESS - 1.0).abs() < 0.02, "{delay} ticks: {} mm", 1e3 * pushed);
        let left = apart(&mut copies, 0.0);
        assert!(left.abs() < 1e-5, "{delay} ticks: {} mm in the end", 1e3 * left);
    }
}

/// At 310 N/m the swing of a kick dies away at 8 ms each way without a damper, at 20 with 4 N·s/m and at 50 with 8, where that of the same spring that is one both ways
/// grows; without a damper it grows at 50 ms as well.
#[test]
fn braking_on_the_way_back_pays_for_some_delay() {
    // The fastest that the copies go against each other in the last of five half seconds, over the first.
    let swing = |law, delay, damping| {
        let mut copies = Copies::<f64>::new(&scene(law, 310.0, damping), delay);
        (0..10).for_each(|_| _ = copies.pushed([1e-6, -1e-6]));
        let mut most = || {
            (0..500).fold(0.0_f64, |most, _| {
                let [one, two] = copies.pushed([0.0; 2]).map(|seen| seen.object.velocity);
                most.max((one - two).abs())
            })
        };
        let seconds = [0; 5].map(|_| most());
        seconds[4] / seconds[0]
    };
    for (delay, damping) in [(8, 0.0), (20, 4.0), (50, 8.0)] {
        let [brakes, spring] = ["fractal-impedance", "p-plus-d"].map(|law| swing(law, delay, damping));
        assert!(brakes < 0.01 && spring > 3.0, "{delay} ticks: {brakes}, {spring} by a spring");
    }
    let far = swing("fractal-impedance", 50, 0.0);
    assert!(far > 10.0, "{far}");
}

/// Hands that push alike against each other: what one copy does the other mirrors, bit for bit.
fn mirrors<S: Scalar>() {
    let mut copies = Copies::<S>::new(&scene("fractal-impedance", 310.0, 4.0), 8);
    let mut moved = 0.0_f64;
    for tick in 0..5000 {
        let push = 1.0 + 0.5 * (3e-3 * f64::from(tick)).sin();
        let [one, two] = copies.pushed([push, -push]).map(|seen| (seen.object.position, seen.coordination_force));
        assert!(one.0 == -two.0 && one.1 == -two.1, "tick {tick}: {one:?}, {two:?}");
        moved = moved.max(one.0.to_f64());
    }
    assert!(moved > 1e-3, "{moved} m");
}

#[test]
fn mirrored_hands_give_mirrored_bits() {
    mirrors::<f32>();
    mirrors::<f64>();
    mirrors::<Fixed>();
}
