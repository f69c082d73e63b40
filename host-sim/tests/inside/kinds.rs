use cohold_sim::scenes;

use super::*;
use crate::play::environment::{ARMED, Command, OFF, Sample};

/// The environment of a kind in the recommended scene over a network that loses and jitters.
fn open(kind: EnvironmentKind) -> Box<dyn Environment> {
    let mut scene = scenes::load(cohold_guest_laws::laws(), "any-network").expect("a scene");
    for text in ["network.loss=0.1", "network.jitter=\"uniform\"", "network.jitter_s=0.01"] {
        scene.apply_override(text).expect("a key");
    }
    kind.open(&kind.fitting(scene).expect("a scene")).expect("an environment")
}

fn column(kind: EnvironmentKind, sample: &Sample, name: &str) -> f64 {
    f64::from(sample[kind.columns().iter().position(|(known, ..)| *known == name).expect("a column")])
}

/// So many seconds with person 1 where it is wanted and nobody at the other hand; what `each` tick comes to.
fn run(shown: &mut dyn Environment, seconds: f64, wanted: Option<[f64; 3]>, mut each: impl FnMut(&Sample)) {
    for _ in 0..(1000.0 * seconds) as u64 {
        shown.point(0, wanted, 0);
        shown.play(1);
        each(&shown.step().expect("a tick"));
    }
}

/// Names are sent once, and there is room for all of them and for the number of restarts.
#[test]
fn every_kind_fits_a_sample() {
    for kind in EnvironmentKind::ALL {
        let names: Vec<_> = kind.columns().iter().map(|(name, ..)| name).collect();
        assert!(
            names.len() < crate::play::environment::MOST
                && (1..names.len()).all(|at| !names[at..].contains(&names[at - 1])),
            "{names:?}"
        );
        let mut shown = open(*kind);
        run(&mut *shown, 0.5, None, |sample| assert_eq!(sample[crate::play::environment::MOST - 1], 0.0));
        assert_eq!(shown.standing().modes, [ARMED; 2], "{kind:?}");
        shown.command(Command::Stop).expect("it stops");
        run(&mut *shown, 0.1, Some([0.05, 0.0, 0.0]), |_| {});
        assert_eq!(shown.standing().modes, [OFF; 2], "{kind:?}");
        shown.command(Command::Start).expect("it starts");
        let sample = shown.step().expect("a tick");
        assert_eq!(sample[crate::play::environment::MOST - 1], 1.0, "{kind:?}");
    }
}

/// The hand of a person carries what four hold, and all copies follow.
#[test]
fn four_hands_hold_one_object() {
    let mut shown = open(EnvironmentKind::Hub);
    shown.command(Command::Partner(Model::Follows)).expect("a partner");
    let (mut apart, mut last) = (0.0_f64, [0.0; crate::play::environment::MOST]);
    run(&mut *shown, 4.0, Some([0.06, 0.0, 0.0]), |sample| {
        apart = apart.max(column(EnvironmentKind::Hub, sample, "apart"));
        last = *sample;
    });
    let copies = [1, 2, 3, 4].map(|n| column(EnvironmentKind::Hub, &last, &format!("object_{n}")));
    assert!(copies.iter().all(|copy| *copy > 0.01) && apart < 0.02, "{copies:?} {apart}");
}

/// Bots play without people; a person who goes where the ball comes has rallies, too.
#[test]
fn squash_is_played() {
    let kind = EnvironmentKind::Squash;
    let mut shown = open(kind);
    let mut strokes = 0.0_f64;
    for _ in 0..20_000 {
        shown.play(0);
        shown.play(1);
        strokes = strokes.max(column(kind, &shown.step().expect("a tick"), "stroke"));
    }
    assert!(strokes >= 3.0, "{strokes}");
    // Person 1 runs to the ball when it is its turn, and serves by running forward.
    let (mut shown, mut sample, mut hits) = (open(kind), [f32::NAN; crate::play::environment::MOST], 0);
    for tick in 0..900_000 {
        if hits >= 3 {
            break;
        }
        let ball = ["ball_x", "ball_y"].map(|name| column(kind, &sample, name));
        let to = if ball[0].is_finite() { ball } else { [if tick % 2000 < 1000 { 2.0 } else { 6.0 }, 3.2] };
        let [along, across] = to.map(|metres| squash::POINTER * metres);
        shown.point(0, Some([along, across, 0.0]), 0);
        shown.play(1);
        let (before, stroke) = (column(kind, &sample, "next"), column(kind, &sample, "stroke"));
        sample = shown.step().expect("a tick");
        let hit = before == 1.0 && column(kind, &sample, "stroke") > stroke;
        hits += u32::from(hit);
    }
    assert!(hits >= 3, "{hits}");
}

/// What is not known is not felt; what is known holds a hand that leans on it, as its spring and the hand's share the way.
#[test]
fn a_static_world_is_felt() {
    let kind = EnvironmentKind::World;
    let mut shown = open(kind);
    let mut last = [0.0; crate::play::environment::MOST];
    run(&mut *shown, 2.0, None, |_| {});
    run(&mut *shown, 3.0, Some([-0.015, -0.075, 0.0]), |sample| last = *sample);
    let [at, force, felt] = ["device_1_y", "force_1_y", "felt_1"].map(|name| column(kind, &last, name));
    // The hand's 200 N/m against the wall's, whose face is at -0.06 m.
    let wall = 1000.0;
    let depth = 200.0 * (0.075 - 0.06) / (200.0 + wall);
    assert_eq!(felt, 7.0);
    assert!((at + 0.06 + depth).abs() < 1e-4 && (force - wall * depth).abs() < 0.1, "{at} {force} {depth}");
    // The other one is seen where it is.
    let seen = ["seen_1_x", "device_2_x"].map(|name| column(kind, &last, name));
    assert!((seen[0] - seen[1]).abs() < 1e-3, "{seen:?}");
}

/// A person gets the object, carries it and leaves it where it lets go, for all to see; never do two have it.
#[test]
fn turns_are_taken() {
    for kind in [EnvironmentKind::Lock, EnvironmentKind::Ring] {
        let mut shown = open(kind);
        let states = |sample: &Sample| [1, 2, 3].map(|n| column(kind, sample, &format!("state_{n}")));
        let (mut sample, mut got) = ([0.0; crate::play::environment::MOST], 0);
        for tick in 0..40_000 {
            let object = ["object_1_x", "object_1_y"].map(|name| column(kind, &sample, name));
            // Takes it, carries it to the left, lets go for two seconds.
            let mine = states(&sample)[0] == 2.0;
            let [along, across] = if mine { [-0.07, 0.0] } else { object };
            shown.point(0, (tick % 8000 < 6000).then_some([along, across, 0.0]), 0);
            shown.play(1);
            sample = shown.step().expect("a tick");
            let now = states(&sample);
            assert!(now.iter().filter(|state| **state == 2.0).count() <= 1, "{kind:?} {now:?}");
            got += u32::from(!mine && now[0] == 2.0);
        }
        let versions = [1, 2, 3].map(|n| column(kind, &sample, &format!("version_{n}")));
        assert!(got >= 2 && versions.iter().all(|version| *version >= 2.0), "{kind:?} {got} {versions:?}");
    }
}

/// A scene is shown along as many axes as it says, and a kind that says otherwise sets them.
#[test]
fn the_scene_says_along_how_many_axes() {
    let scene = |axes: u32| {
        let scene = scenes::load(cohold_guest_laws::laws(), "any-network").expect("a scene");
        let kind = [EnvironmentKind::Pair, EnvironmentKind::Plane, EnvironmentKind::Space][axes as usize - 1];
        (kind, kind.fitting(scene).expect("it fits"))
    };
    for axes in 1..=3 {
        let (kind, scene) = scene(axes);
        assert_eq!((scene.peer.axis.shared, EnvironmentKind::Pair.in_scene(&scene)), (axes, kind));
        assert_eq!(EnvironmentKind::Ring.in_scene(&scene), EnvironmentKind::Ring);
        // Of four hands along several axes nobody has said how they are drawn: refused by name, and shown along one.
        assert_eq!(EnvironmentKind::Hub.open(&scene).is_ok(), axes == 1);
        assert!(EnvironmentKind::Hub.fitting(scene).is_ok_and(|scene| scene.peer.axis.shared == 1));
    }
}
