use cohold_core::safety::Mode;
use cohold_live::playable::{Held, MOST_COLUMNS, Play};
use cohold_sim::scenes;

use super::*;

/// An environment, and the names of its numbers.
struct Shown {
    play: Box<dyn Play>,
    columns: &'static [Column],
}

impl Shown {
    /// In the recommended scene over a network that loses and jitters.
    fn open(name: &str) -> Self {
        let mut scene = scenes::load(cohold_sim::Laws::built_in(), "any-network").expect("a scene");
        for text in ["network.loss=0.1", "network.jitter=\"uniform\"", "network.jitter_s=0.01"] {
            scene.apply_override(text).expect("a key");
        }
        let of = PLAYABLE.iter().find(|of| of.name == name).expect("a name");
        Self { play: (of.open)(&scene).expect("an environment"), columns: of.columns }
    }

    /// A tick with the first hand like this. What is seen after it.
    fn tick(&mut self, held: Held) -> Vec<f64> {
        self.play.hold(0, held);
        self.play.step();
        self.numbers()
    }

    fn numbers(&self) -> Vec<f64> {
        let mut numbers = Vec::new();
        self.play.numbers(&mut |number| numbers.push(number));
        assert_eq!(numbers.len(), self.columns.len());
        numbers
    }

    fn column(&self, numbers: &[f64], name: &str) -> f64 {
        numbers[self.columns.iter().position(|(known, ..)| *known == name).expect("a column")]
    }
}

/// Names are sent once, and there is room for all of them.
#[test]
fn every_environment_fits_a_sample() {
    for of in &PLAYABLE {
        let names: Vec<_> = of.columns.iter().map(|(name, ..)| name).collect();
        let twice = (1..names.len()).any(|at| names[at..].contains(&names[at - 1]));
        assert!(names.len() <= MOST_COLUMNS && !twice, "{names:?}");
        let mut shown = Shown::open(of.name);
        for _ in 0..500 {
            shown.tick(Held::Free);
        }
        assert_eq!(shown.play.modes(), [Mode::Armed; 2], "{}", of.name);
    }
}

/// The hand of a person carries what four hold, and all copies follow.
#[test]
fn four_hands_hold_one_object() {
    let mut shown = Shown::open("hub");
    let (mut apart, mut last) = (0.0_f64, Vec::new());
    for hand in 1..4 {
        shown.play.hold(hand, Held::Free);
    }
    for _ in 0..4_000 {
        last = shown.tick(Held::At([0.06, 0.0]));
        apart = apart.max(shown.column(&last, "apart"));
    }
    let copies = [1, 2, 3, 4].map(|n| shown.column(&last, &format!("object_{n}")));
    assert!(copies.iter().all(|copy| *copy > 0.01) && apart < 0.02, "{copies:?} {apart}");
}

/// Of hands along several axes nobody has said how a hub's are drawn: refused by name.
#[test]
fn a_hub_is_of_one_axis() {
    let [of, ..] = &PLAYABLE;
    let mut scene = scenes::load(cohold_sim::Laws::built_in(), "any-network").expect("a scene");
    assert!((of.open)(&scene).is_ok());
    (scene.peer.axis.count, scene.peer.axis.shared) = (2, 2);
    let why = (of.open)(&scene).err().expect("one axis").to_string();
    assert!(why.contains("axis") && of.axes == Some(1), "{why}");
}

/// Bots play without people. A person who goes where the ball comes has rallies, too.
#[test]
fn squash_is_played() {
    let mut shown = Shown::open("squash");
    let mut strokes = 0.0_f64;
    for _ in 0..20_000 {
        let seen = shown.tick(Held::ByNobody);
        strokes = strokes.max(shown.column(&seen, "stroke"));
    }
    assert!(strokes >= 3.0, "{strokes}");
    // Person 1 runs to the ball when it is its turn, and serves by running forward.
    let (mut shown, mut hits) = (Shown::open("squash"), 0);
    let mut seen = shown.numbers();
    for tick in 0..900_000 {
        if hits >= 3 {
            break;
        }
        let ball = ["ball_x", "ball_y"].map(|name| shown.column(&seen, name));
        let to = if ball[0].is_finite() { ball } else { [if tick % 2000 < 1000 { 2.0 } else { 6.0 }, 3.2] };
        let (before, stroke) = (shown.column(&seen, "next"), shown.column(&seen, "stroke"));
        seen = shown.tick(Held::At(to.map(|metres| squash::POINTER * metres)));
        hits += u32::from(before == 1.0 && shown.column(&seen, "stroke") > stroke);
        if shown.play.is_over() {
            shown = Shown::open("squash");
        }
    }
    assert!(hits >= 3, "{hits}");
}

/// What is not known is not felt. What is known holds a hand that leans on it, as its spring and the hand's share the way.
#[test]
fn a_static_world_is_felt() {
    let mut shown = Shown::open("world");
    for _ in 0..2_000 {
        shown.tick(Held::Free);
    }
    let last = (0..3_000).map(|_| shown.tick(Held::At([-0.015, -0.075]))).last().expect("ticks");
    let [at, force, felt] = ["device_1_y", "force_1_y", "felt_1"].map(|name| shown.column(&last, name));
    // The hand's 200 N/m against the wall's, whose face is at -0.06 m.
    let wall = 1000.0;
    let depth = 200.0 * (0.075 - 0.06) / (200.0 + wall);
    assert_eq!(felt, 7.0);
    assert!((at + 0.06 + depth).abs() < 1e-4 && (force - wall * depth).abs() < 0.1, "{at} {force} {depth}");
    // The other one is seen where it is.
    let seen = ["seen_1_x", "device_2_x"].map(|name| shown.column(&last, name));
    assert!((seen[0] - seen[1]).abs() < 1e-3, "{seen:?}");
}

/// A person gets the object, carries it and leaves it where it lets go, for all to see. Never do two have it.
#[test]
fn turns_are_taken() {
    for name in ["lock", "ring"] {
        let mut shown = Shown::open(name);
        let (mut seen, mut got) = (shown.numbers(), 0);
        for tick in 0..40_000 {
            let object = ["object_1_x", "object_1_y"].map(|name| shown.column(&seen, name));
            // Takes it, carries it to the left, lets go for two seconds.
            let mine = shown.column(&seen, "state_1") == 2.0;
            let wanted = if mine { [-0.07, 0.0] } else { object };
            seen = shown.tick(if tick % 8000 < 6000 { Held::At(wanted) } else { Held::Free });
            let now = [1, 2, 3].map(|n| shown.column(&seen, &format!("state_{n}")));
            assert!(now.iter().filter(|state| **state == 2.0).count() <= 1, "{name} {now:?}");
            got += u32::from(!mine && now[0] == 2.0);
        }
        let versions = [1, 2, 3].map(|n| shown.column(&seen, &format!("version_{n}")));
        assert!(got >= 2 && versions.iter().all(|version| *version >= 2.0), "{name} {got} {versions:?}");
    }
}
