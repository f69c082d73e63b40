//! The lease is explored, not only tested: the board's [`Holder`](super::Holder) and operators' [`Giver`](super::Giver)s themselves, and
//! everything that a network, persons and restarts can do to them, breadth first. After each action every state is held against the
//! promises S1 to S5 ([`world`]). Mistakes that are planted are found, those of wire version 3 among them; what is printed then is a
//! shortest sequence of actions.
//!
//! Bounds and counts of states are printed. Larger bounds, an hour of processor time:
//! `cargo test --release -p haptic-protocol --lib lease -- --ignored --nocapture`.

mod world;

use std::collections::hash_map::Entry;
use std::collections::{HashMap, VecDeque};
use std::hash::{BuildHasherDefault, Hasher};
use std::time::Instant;

use super::{Motors, Number, Told, Want, Word};
use world::{Action, Planted, State, World};

/// One operator, and one datagram under way each way.
const ONE: World = World {
    planted: Planted::Nothing,
    lease: 2,
    shown: 1,
    silence: 0,
    operators: 1,
    to_board: 1,
    to_operator: 1,
    alone: true,
    switch: false,
    restarts: false,
    live_every: 0,
};

/// The shortest lease by which motors stay on from one exchange to the next, so that what a person may count on is tried, too.
const LONGER: World = World { lease: 3, live_every: 16, ..ONE };

/// A hash that is a hash already.
#[derive(Default)]
struct Same(u64);

impl Hasher for Same {
    fn finish(&self) -> u64 {
        self.0
    }
    fn write(&mut self, _: &[u8]) {}
    fn write_u64(&mut self, number: u64) {
        self.0 = number;
    }
}

/// The state before each state, by fingerprint.
type Known = HashMap<u64, u64, BuildHasherDefault<Same>>;

/// How a state came about.
fn path(world: &World, known: &Known, mut at: u64) -> Vec<Action> {
    let mut marks = vec![at];
    while let Some(before) = known.get(&at).filter(|before| **before != at) {
        marks.push(*before);
        at = *before;
    }
    let mut state = world.start();
    let to = |state: &State, mark| {
        let next = world.actions(state).into_iter().filter_map(|action| Some((action, world.next(state, action)?)));
        next.into_iter().find(|(_, next)| next.mark() == mark).expect("a way that was gone before")
    };
    let step = |mark| {
        let (action, next) = to(&state, mark);
        state = next;
        action
    };
    marks.into_iter().rev().skip(1).map(step).collect()
}

/// Explores states, and no more than this: whether those were all, or the promise that is broken and how.
fn explore(name: &str, world: &World, most: usize) -> Result<bool, (&'static str, Vec<Action>)> {
    let (begun, start) = (Instant::now(), world.start());
    let (mut known, mut depth, mut kinds) = (Known::default(), 0, [false; 3]);
    known.insert(start.mark(), start.mark());
    let mut level = VecDeque::from([start]);
    while !level.is_empty() && known.len() < most {
        for _ in 0..level.len() {
            let Some(state) = level.pop_front() else { break };
            let at = state.mark();
            for action in world.actions(&state) {
                let Some(next) = world.next(&state, action) else { continue };
                let mark = next.mark();
                let Entry::Vacant(place) = known.entry(mark) else { continue };
                place.insert(at);
                if let Some(broken) = world.broken(&next, mark) {
                    return Err((broken, path(world, &known, mark)));
                }
                kinds.iter_mut().zip(world.kinds(&next)).for_each(|(kind, there)| *kind |= there);
                level.push_back(next);
            }
        }
        depth += 1;
    }
    let (states, whole, seconds) = (known.len(), level.is_empty(), begun.elapsed().as_secs_f64());
    let all = if whole { "all of them" } else { "not all" };
    println!("{name}: {states} states, {all}, {depth} actions deep, {seconds:.1} s: {world:?}");
    assert_eq!(kinds, [true, world.alone, true], "{name}: there is nothing to see");
    Ok(whole)
}

fn holds(name: &str, world: &World) {
    match explore(name, world, usize::MAX) {
        Ok(whole) => assert!(whole),
        Err((broken, actions)) => panic!("{name}: {broken}, in {} actions: {actions:?}", actions.len()),
    }
}

#[test]
fn nothing_that_one_operator_and_the_network_can_do_breaks_a_promise() {
    holds("one operator", &LONGER);
}

#[test]
fn nothing_that_a_switch_faults_and_restarts_add_breaks_a_promise() {
    holds("one operator, switch and restarts", &World { switch: true, restarts: true, ..ONE });
}

/// Not to its end: the first states of two operators.
#[test]
fn nothing_that_two_operators_do_first_breaks_a_promise() {
    let two = World { operators: 2, live_every: 256, ..LONGER };
    explore("two operators", &two, 300_000).unwrap_or_else(|broken| panic!("{broken:?}"));
}

#[test]
#[ignore = "takes an hour: see the top of this file"]
fn nothing_breaks_a_promise_within_larger_bounds() {
    holds("one operator, every state tried", &World { live_every: 1, ..LONGER });
    holds("one operator, switch and restarts", &World { switch: true, restarts: true, ..LONGER });
    holds("one operator, reordering", &World { to_board: 2, live_every: 256, ..LONGER });
    holds("two operators", &World { operators: 2, ..ONE });
}

#[test]
fn what_is_planted_is_found() {
    for (planted, broken) in [
        (Planted::OldStop, "S1"),
        (Planted::LeaseOver, "S1"),
        (Planted::GateByRow, "S3"),
        (Planted::ShownWithoutAge, "S2: shown as off"),
        (Planted::YesOfAnyAge, "S4"),
        (Planted::UsedAgain, "S4"),
    ] {
        let world = World { planted, ..ONE };
        let found = explore("planted", &world, 2_000_000).expect_err("it is found");
        println!("{planted:?}: {}, in {} actions: {:?}", found.0, found.1.len(), found.1);
        assert!(found.0.starts_with(broken), "{planted:?}: {found:?}");
    }
}

#[test]
fn words_are_bytes_and_what_is_unknown_is_the_safe_one() {
    for byte in 0..=255 {
        let (word, told) = (Word::of_byte(byte), Told::of_byte(byte));
        assert_eq!((word.number, told.heard), (Number(byte >> 2), Number(byte >> 2)));
        assert!(byte & 3 == 3 || (word.byte(), told.byte()) == (byte, byte));
    }
    assert_eq!((Word::of_byte(3).want, Told::of_byte(3).motors), (Want::Stop, Motors::Leased));
    assert_eq!(Number(super::LAST).next(), Number(1));
}
