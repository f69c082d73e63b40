use std::sync::atomic::{AtomicUsize, Ordering};

use cohold_live::playable::{Held, MOST_COLUMNS, PERIOD_S, Play, route};
use cohold_sim::network::link::Route;
use cohold_sim::scenes;

use super::*;
use crate::environment::{ARMED, Command, MOST, OFF, Sample};

/// Three hands at one network, each where it is held; none has a device but the third.
struct Guest {
    held: [Held; 3],
    route: Route,
    ticks: u32,
}

/// How often one was opened.
static OPENED: AtomicUsize = AtomicUsize::new(0);

static GUESTS: [Playable; 1] = [Playable {
    name: "guest",
    axes: Some(1),
    columns: &[("hand_1", "m", ""), ("hand_2", "", ""), ("hand_3", "m", ""), ("ticks", "", "")],
    more: || json!({ "size": 3 }),
    open: |scene| {
        OPENED.fetch_add(1, Ordering::Relaxed);
        Ok(Box::new(Guest { held: [Held::Free; 3], route: route(scene, 0, 1), ticks: 0 }))
    },
}];

impl Play for Guest {
    fn hold(&mut self, hand: usize, held: Held) {
        self.held[hand] = held;
    }

    fn device(&self, hand: usize) -> Option<f64> {
        (hand == 2).then_some(0.01)
    }

    fn step(&mut self) {
        self.ticks += 1;
    }

    fn numbers(&self, number: &mut dyn FnMut(f64)) {
        for held in self.held {
            number(match held {
                Held::ByNobody => -1.0,
                Held::Free => f64::NAN,
                Held::At([along, _]) => along,
            });
        }
        number(self.ticks.into());
    }

    fn seats(&self) -> usize {
        2
    }

    fn route(&mut self, _: usize, _: usize) -> &mut Route {
        &mut self.route
    }

    fn is_over(&self) -> bool {
        self.ticks == 2_000
    }
}

const KINDS: Kinds = Kinds(&GUESTS);

/// The environment of a kind in the recommended scene over a network that loses and jitters.
fn open(kind: EnvironmentKind) -> Box<dyn Environment> {
    let mut scene = scenes::load(cohold_sim::Laws::built_in(), "any-network").expect("a scene");
    for text in ["network.loss=0.1", "network.jitter=\"uniform\"", "network.jitter_s=0.01"] {
        scene.apply_override(text).expect("a key");
    }
    kind.open(&kind.fitting(scene).expect("a scene")).expect("an environment")
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
    assert_eq!(MOST, MOST_COLUMNS + 1);
    for kind in KINDS.all() {
        let names: Vec<_> = kind.columns().iter().map(|(name, ..)| name).collect();
        let twice = (1..names.len()).any(|at| names[at..].contains(&names[at - 1]));
        assert!(names.len() < MOST && !twice, "{names:?}");
        let mut shown = open(kind);
        run(&mut *shown, 0.5, None, |sample| assert_eq!(sample[MOST - 1], 0.0));
        assert_eq!(shown.standing().modes, [ARMED; 2], "{kind:?}");
        shown.command(Command::Stop).expect("it stops");
        run(&mut *shown, 0.1, Some([0.05, 0.0, 0.0]), |_| {});
        assert_eq!(shown.standing().modes, [OFF; 2], "{kind:?}");
        shown.command(Command::Start).expect("it starts");
        let sample = shown.step().expect("a tick");
        assert_eq!(sample[MOST - 1], 1.0, "{kind:?}");
    }
}

/// A guest's environment is chosen by its name, holds the hands that people and partners hold, and begins anew when it is over.
#[test]
fn a_guests_environment_is_shown() {
    let kind = KINDS.named("guest").expect("a guest");
    assert_eq!((usize::from(kind.number()), KINDS.names().last()), (KINDS.all().count() - 1, Some(&"guest")));
    assert_eq!(KINDS.hello().last().map(|hello| hello["more"]["size"].clone()), Some(json!(3)));
    assert!(Kinds::default().named("guest").is_none());
    let mut shown = open(kind);
    let opened = OPENED.load(Ordering::Relaxed);
    let mut third = [f32::INFINITY, f32::NEG_INFINITY];
    run(&mut *shown, 1.9, Some([0.02, 0.0, 0.0]), |[one, two, three, ..]| {
        assert_eq!([*one, *two], [0.02, -1.0]);
        third = [third[0].min(*three), third[1].max(*three)];
    });
    // The hand that nobody can take carries on from where its device is.
    assert!((third[0] - 0.01).abs() < 1e-6 && third[1] > 0.04, "{third:?}");
    run(&mut *shown, 0.2, None, |_| {});
    assert!(OPENED.load(Ordering::Relaxed) > opened);
    let sample = shown.step().expect("a tick");
    assert_eq!((sample[3], sample[MOST - 1]), (101.0, 1.0));
    assert!(PERIOD_S == 0.001 && sample[0].is_nan());
}

/// A scene is shown along as many axes as it says, and a kind that says otherwise sets them.
#[test]
fn the_scene_says_along_how_many_axes() {
    let scene = |axes: u32| {
        let scene = scenes::load(cohold_sim::Laws::built_in(), "any-network").expect("a scene");
        let kind = [EnvironmentKind::Pair, EnvironmentKind::Plane, EnvironmentKind::Space][axes as usize - 1];
        (kind, kind.fitting(scene).expect("it fits"))
    };
    let guest = KINDS.named("guest").expect("a guest");
    for axes in 1..=3 {
        let (kind, scene) = scene(axes);
        assert_eq!((scene.peer.axis.shared, EnvironmentKind::Pair.in_scene(&scene)), (axes, kind));
        assert_eq!(guest.in_scene(&scene), guest);
        assert!(guest.fitting(scene).is_ok_and(|scene| scene.peer.axis.shared == 1));
    }
}
