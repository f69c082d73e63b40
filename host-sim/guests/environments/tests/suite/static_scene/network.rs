//! Clients and servers over a bad network: what is felt is what the world is, whatever the network does.

use cohold_core::num::Motion;
use cohold_environments::records::{Object, Shape, Wall};
use cohold_environments::roles::static_scene::Download;
use cohold_environments::world::render::Renderer;
use cohold_environments::world::{OBJECTS, World, load, parse};
use cohold_protocol::ends::Ends;
use cohold_protocol::key::Key;
use cohold_protocol::link::{Config, Link};
use cohold_protocol::parameters::Parameters;
use cohold_protocol::wire::PeerId;

use super::sim::Sim;
use super::world_file::TWO_ROOMS;

/// 30 % loss in runs, jitter, reorder, duplicates and broken bits.
const BAD: &[&str] = &[
    "loss=0.3",
    "loss_burst_packets=2",
    "jitter=gamma",
    "jitter_s=0.01",
    "reorder=0.2",
    "duplicate=0.1",
    "corrupt=0.05",
];

type Hand = [Motion<f64>; 2];

fn rooms() -> World {
    *load(TWO_ROOMS.as_ref()).expect("a good world")
}

/// A world of many balls with a floor at y = 0.
fn many() -> World {
    let balls: String = (0..300)
        .map(|id| {
            format!(
                "[[body]]\nid = {id}\nx_m = {}\ny_m = {}\n",
                0.05 * f64::from(id % 20),
                1.0 + 0.05 * f64::from(id / 20)
            )
        })
        .collect();
    *parse(&format!("{balls}[[wall]]\nid = 1000\nfrom_x_m = -1\nto_x_m = 2\n"), "many").expect("a good world")
}

/// What the world is to a hand, without any network.
struct Oracle(Renderer);

impl Oracle {
    fn new<'a>(objects: impl IntoIterator<Item = &'a Object>) -> Self {
        let mut renderer = Renderer::default();
        renderer.know(objects);
        Self(renderer)
    }
}

/// Up and down through the floor and along it.
fn bounce(tick: u64) -> Hand {
    let time = 1e-3 * tick as f64;
    let wave = |rate: f64, size: f64, phase: f64| Motion {
        position: size * (rate * time + phase).sin(),
        velocity: size * rate * (rate * time + phase).cos(),
    };
    [wave(1.3, 0.4, 0.0), wave(11.0, 0.01, 0.0)]
}

#[test]
fn a_whole_world_over_a_bad_network_feels_as_it_is() {
    let mut sim = Sim::new(BAD);
    sim.serve(1, many(), None);
    sim.visit(1, 1, None);
    let ms = sim.until(20_000, [0.0, 0.5], |sim| sim.visitor(1).is_complete());
    println!("301 objects in {ms} ms of simulated time");
    assert!(sim.visitor(1).download(1).is_some_and(|download| download.objects().eq(many().objects())));
    let mut oracle = Oracle::new(many().objects());
    oracle.0.step([Motion::at(0.0), Motion::at(0.5)]);
    let mut felt = 0;
    for _ in 0..4_000 {
        let hand = bounce(sim.tick());
        let (force, want) = (sim.step(|_| hand)[&1], oracle.0.step(hand));
        assert_eq!(force, want);
        felt += u32::from(force != [0.0; 2]);
    }
    assert!(felt > 1_000);
}

#[test]
fn a_server_that_is_gone_in_the_middle_takes_nothing_with_it() {
    let mut sim = Sim::new(BAD);
    sim.serve(1, many(), None);
    sim.visit(1, 1, None);
    let taken = |sim: &Sim| sim.visitor(1).download(1).map_or(0, Download::<OBJECTS>::objects_taken);
    sim.until(20_000, [0.0, 0.5], |sim| taken(sim) >= 150);
    sim.switch_off(1);
    // What was on its way still comes.
    for _ in 0..200 {
        sim.step(|_| [Motion::at(0.0), Motion::at(0.5)]);
    }
    let before = taken(&sim);
    assert!((150..301).contains(&before));
    // Ten seconds without a server: the hand goes through what is held.
    let held: Vec<Object> = sim.visitor(1).download(1).expect("held").objects().copied().collect();
    assert_eq!(held.len(), before as usize);
    let mut oracle = Oracle::new(&held);
    oracle.0.step([Motion::at(0.0), Motion::at(0.5)]);
    let mut felt = 0;
    for tick in 0..10_000 {
        let [x, y] = bounce(tick);
        let hand = [x, Motion { position: 1.0 + 20.0 * y.position, velocity: 20.0 * y.velocity }];
        let (force, want) = (sim.step(|_| hand)[&1], oracle.0.step(hand));
        assert_eq!(force, want);
        felt += u32::from(force != [0.0; 2]);
    }
    assert!(felt > 100, "{felt}");
    assert_eq!(taken(&sim), before);
    // Another process with the same world: what is missing comes, and nothing twice.
    sim.serve(1, many(), None);
    sim.until(20_000, [0.0, 0.5], |sim| sim.visitor(1).is_complete());
    assert_eq!(taken(&sim), 301);
}

/// Slides along the ledge, 2 mm deep, from the first room to the second and back, over the ball in the doorway.
fn through_the_door(tick: u64) -> Hand {
    let time = 1e-3 * tick as f64;
    let (rate, size) = (0.5, 0.35);
    // From x = −0.35 at rest.
    let x = Motion { position: -size * (rate * time).cos(), velocity: size * rate * (rate * time).sin() };
    [x, Motion::at(-0.102)]
}

/// How far a visitor looks ahead: nine tenths of a second at its fastest, 0.175 m/s.
const RADIUS_M: f32 = 0.2;

/// Largest step of the force from one tick to the next while both rooms are crossed, how often home changed, and the
/// largest difference to what is felt without a network.
fn crossing(world: &World, servers: &[(u8, Option<u8>)], network: &[&str]) -> (f64, u32, f64) {
    let mut sim = Sim::new(network);
    for (number, region) in servers {
        sim.serve(*number, world.clone(), *region);
    }
    sim.visit(1, 1, Some(RADIUS_M));
    let start = [-0.35, -0.05];
    sim.until(20_000, start, |sim| sim.visitor(1).is_complete());
    let mut oracle = Oracle::new(world.objects());
    oracle.0.step(start.map(Motion::at));
    let (mut last, mut largest, mut differs) = (None::<[f64; 2]>, 0.0_f64, 0.0_f64);
    let distance = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
    for tick in 0..(2_000.0 * std::f64::consts::TAU) as u64 {
        let hand = through_the_door(tick);
        let force = sim.step(|_| hand)[&1];
        largest = largest.max(last.map_or(0.0, |last| distance(force, last)));
        differs = differs.max(distance(force, oracle.0.step(hand)));
        last = Some(force);
    }
    (largest, sim.visitor(1).moves(), differs)
}

#[test]
fn moving_from_server_to_server_makes_no_step_in_the_force() {
    let world = rooms();
    let (one, moves, differs) = crossing(&world, &[(1, None)], &[]);
    assert_eq!((moves, differs), (0, 0.0));
    let both = [(1, Some(0)), (2, Some(1))];
    let (two, moves, differs) = crossing(&world, &both, &[]);
    println!("largest step of the force in 1 ms: one server {one:.4} N, two servers {two:.4} N");
    assert_eq!((two, moves, differs), (one, 2, 0.0));
    let (two, moves, differs) = crossing(&world, &both, BAD);
    assert_eq!((two, moves, differs), (one, 2, 0.0));
    // Without the margin the ball behind the border comes too late to be felt: the test can tell.
    let mut narrow = world;
    narrow.margin_m = 0.0;
    let (_, _, differs) = crossing(&narrow, &both, BAD);
    assert!(differs > 0.5, "{differs} N");
}

#[test]
fn a_new_version_is_felt_after_the_hand_has_left_the_old_one() {
    let mut sim = Sim::new(BAD);
    let floor = |version: u32, y: f32| {
        let wall = Wall { from_x_m: -1.0, from_y_m: y, to_y_m: y, ..Wall::default() };
        Object { id: 1, version, shape: Shape::Wall(wall) }
    };
    let mut world = World::default();
    world.put(floor(1, 0.0)).expect("room");
    sim.serve(1, world.clone(), None);
    sim.visit(1, 1, None);
    sim.until(20_000, [0.0, 0.1], |sim| sim.visitor(1).is_complete());
    let hand = |y: f64| [Motion::at(0.0), Motion::at(y)];
    assert_eq!(sim.step(|_| hand(-0.01))[&1], [0.0, 10.0]);
    // The floor sinks by 5 mm. It comes within a refresh of a second and a few losses, under the hand.
    world.put(floor(2, -0.005)).expect("room");
    sim.host(1).publish(world).expect("a good world");
    for _ in 0..5_000 {
        assert_eq!(sim.step(|_| hand(-0.01))[&1], [0.0, 10.0]);
    }
    assert!(sim.visitor(1).download(1).is_some_and(|download| download.objects().all(|object| object.version == 2)));
    sim.step(|_| hand(0.01));
    let [_, force] = sim.step(|_| hand(-0.01))[&1];
    assert!((force - 5.0).abs() < 1e-3, "{force}");
}

#[test]
fn where_two_servers_differ_the_higher_version_is_felt() {
    let mut sim = Sim::new(&["loss=0.3"]);
    let old = rooms();
    let mut new = old.clone();
    let mut ledge = *new.get(1).expect("the ledge");
    let Shape::Wall(wall) = &mut ledge.shape else { panic!("the ledge is a wall") };
    wall.stiffness_n_per_m = 500.0;
    ledge.version += 1;
    new.put(ledge).expect("room");
    sim.serve(1, old, Some(0));
    sim.serve(2, new, Some(1));
    sim.visit(1, 1, None);
    let press = |sim: &mut Sim, x: f64| {
        for _ in 0..2_000 {
            sim.step(|_| [Motion::at(x), Motion::at(0.0)]);
        }
        sim.step(|_| [Motion::at(x), Motion::at(-0.11)])[&1][1]
    };
    let close = |force: f64, want: f64| assert!((force - want).abs() < 1e-3, "{force} N, not {want} N");
    close(press(&mut sim, -0.3), 10.0);
    // Within the margin of the other room both are known; in that room only the new one; and back.
    close(press(&mut sim, -0.06), 5.0);
    close(press(&mut sim, 0.3), 5.0);
    close(press(&mut sim, -0.06), 5.0);
    close(press(&mut sim, -0.3), 10.0);
    assert_eq!(sim.visitor(1).moves(), 2);
}

#[test]
fn clients_are_aware_of_each_other_by_the_server_of_their_room() {
    let mut sim = Sim::new(&["loss=0.3"]);
    let mut world = rooms();
    sim.serve(1, world.clone(), Some(0));
    world.version = 1;
    sim.serve(2, world, Some(1));
    for line in 1..=4 {
        sim.visit(line, 1, Some(0.1));
    }
    // Three in the first room; the fourth goes to the second after two seconds.
    let place = |line: u32, tick: u64| {
        let go = if line == 4 { 1e-4 * tick.saturating_sub(2_000).min(3_000) as f64 } else { 0.0 };
        [Motion::at(-0.1 + go), Motion::at(0.05 + 0.01 * f64::from(line))]
    };
    let seen = |sim: &Sim, line: u32| {
        sim.visitor(line).others().map(|other| (other.who, other.position[1])).collect::<Vec<_>>()
    };
    for tick in 0..2_000 {
        sim.step(|line| place(line, tick));
    }
    assert_eq!(seen(&sim, 1), [(2, 0.07), (3, 0.08), (4, 0.09)]);
    for tick in 2_000..8_000 {
        sim.step(|line| place(line, tick));
    }
    // A client is seen at the server it is at home at, and nowhere else.
    assert_eq!(sim.visitor(4).home(), 2);
    assert_eq!(seen(&sim, 1), [(2, 0.07), (3, 0.08)]);
    assert_eq!(seen(&sim, 4), []);
}

#[test]
fn clients_are_aware_of_each_other_straight_when_the_server_is_gone() {
    let mut sim = Sim::new(BAD);
    sim.serve(1, many(), None);
    for line in [1, 2] {
        sim.visit(line, 1, Some(0.1));
        let link = Link::new(Config {
            key: Key::new([9; 32]),
            ends: Ends { local: PeerId(line as u8), remote: PeerId(3 - line as u8) },
            packet_period_us: 8_000,
            parameters: Parameters::new(),
            entropy: [line as u8; 32],
        });
        sim.visitor_mut(line).befriend(3 - line, link.expect("a good link"));
    }
    sim.switch_off(1);
    for tick in 0..3_000_u64 {
        // Both move at 0.1 m/s: what is known of the other is at most some packets old.
        sim.step(|line| [Motion { position: 1e-4 * tick as f64, velocity: 0.1 }, Motion::at(f64::from(line))]);
    }
    for line in [1, 2] {
        let other: Vec<_> = sim.visitor(line).others().collect();
        assert_eq!((other.len(), other[0].who, other[0].position[1]), (1, 3 - line, (3 - line) as f32));
        let late_s = (0.3 - f64::from(other[0].position[0])) / 0.1;
        assert!((0.0..0.3).contains(&late_s), "{late_s} s");
        assert_eq!(other[0].velocity, [0.1, 0.0]);
    }
}

#[test]
fn a_client_that_starts_anew_is_the_same_client_to_the_server() {
    let mut sim = Sim::new(&["loss=0.1"]);
    sim.serve(1, rooms(), None);
    for round in 0..3 {
        sim.visit(5, 1, None);
        sim.until(20_000, [0.0, 0.1], |sim| sim.visitor(5).is_complete());
        assert_eq!(sim.host(1).clients(), 1, "round {round}");
    }
}
