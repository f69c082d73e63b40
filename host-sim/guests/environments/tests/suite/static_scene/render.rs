//! Local rendering against closed forms: walls, bodies and a strip, and what a download does to what is touched.

use cohold_core::num::Motion;
use cohold_environments::records::{Block, Body, Object, Shape, Strip, Wall};
use cohold_environments::world::render::Renderer;

type Hand = [Motion<f64>; 2];

fn at(x: f64, y: f64) -> Hand {
    [Motion::at(x), Motion::at(y)]
}

fn moving(x: f64, y: f64, u: f64, v: f64) -> Hand {
    [Motion { position: x, velocity: u }, Motion { position: y, velocity: v }]
}

fn object(id: u32, shape: Shape) -> Object {
    Object { id, version: 1, shape }
}

fn wall() -> Object {
    let wall = Wall { from_x_m: 0.0, to_x_m: 1.0, thickness_m: 0.25, damping_n_s_per_m: 4.0, ..Wall::default() };
    object(1, Shape::Wall(wall))
}

fn feel(objects: &[Object]) -> Renderer {
    let mut renderer = Renderer::default();
    renderer.know(objects);
    renderer
}

#[track_caller]
fn close(got: [f64; 2], want: [f64; 2], within: f64) {
    assert!((got[0] - want[0]).abs() <= within && (got[1] - want[1]).abs() <= within, "{got:?} is not {want:?}");
}

#[test]
fn a_wall_pushes_out_of_its_nearest_face() {
    let mut renderer = feel(&[wall()]);
    // K = 1000 N/m, B = 4 N·s/m; the free side of the face is y > 0.
    close(renderer.step(at(0.5, 0.001)), [0.0, 0.0], 0.0);
    close(renderer.step(moving(0.5, -0.01, 7.0, -0.5)), [0.0, 10.0 + 2.0], 1e-9);
    close(renderer.step(at(0.5, -0.24)), [0.0, -10.0], 1e-6);
    close(renderer.step(at(0.02, -0.1)), [-20.0, 0.0], 1e-6);
    close(renderer.step(moving(0.98, -0.1, -0.5, 3.0)), [20.0 + 2.0, 0.0], 1e-6);
    for (x, y) in [(-0.01, -0.1), (1.01, -0.1), (0.5, -0.26), (0.5, 0.0)] {
        close(renderer.step(moving(x, y, 1.0, -1.0)), [0.0, 0.0], 0.0);
    }
}

#[test]
fn a_wall_that_is_turned_pushes_along_its_normal() {
    // From (0, 0) to (-3, -4): along (-0.6, -0.8), free side (0.8, -0.6).
    let turned = Wall { to_x_m: -3.0, to_y_m: -4.0, thickness_m: 1.0, ..Wall::default() };
    let mut renderer = feel(&[object(1, Shape::Wall(turned))]);
    let (x, y) = (-1.5 - 0.8 * 0.02, -2.0 + 0.6 * 0.02);
    close(renderer.step(at(x, y)), [16.0, -12.0], 1e-9);
    close(renderer.step(at(-1.5 + 0.8 * 0.02, -2.0 - 0.6 * 0.02)), [0.0, 0.0], 0.0);
}

#[test]
fn a_body_pushes_away_from_its_centre() {
    let body = Body { x_m: 1.0, y_m: 2.0, radius_m: 0.5, stiffness_n_per_m: 100.0, ..Body::default() };
    let mut renderer = feel(&[object(1, Shape::Body(body))]);
    // At (0.8, −0.6)·0.4 from the centre, moving inwards at 1 m/s; B = 2.
    let hand = moving(1.0 + 0.8 * 0.4, 2.0 - 0.6 * 0.4, -0.8, 0.6);
    close(renderer.step(hand), [0.8 * 12.0, -0.6 * 12.0], 1e-5);
    close(renderer.step(at(1.5001, 2.0)), [0.0, 0.0], 0.0);
    assert!(renderer.step(at(1.0, 2.0)).iter().all(|part| part.is_finite()));
}

/// A dart: a triangle with a corner that points inwards at (0.5, 0.25).
fn dart() -> Object {
    let block = Block { b_x_m: 0.5, b_y_m: 0.25, c_x_m: 1.0, c_y_m: 0.0, d_x_m: 0.5, d_y_m: 1.0, ..Block::default() };
    object(4, Shape::Block(block))
}

#[test]
fn a_block_pushes_out_of_its_nearest_side() {
    let mut renderer = feel(&[dart()]);
    // From (0, 0) to (0.5, 0.25): along (2, 1)/√5, out (1, -2)/√5. K = 1000 N/m, B = 2 N·s/m.
    let [x, y] = [1.0, -2.0].map(|part: f64| part / 5.0_f64.sqrt());
    let force = 1000.0 * 0.01 + 2.0 * 0.5;
    close(renderer.step(moving(0.25 - 0.01 * x, 0.125 - 0.01 * y, -0.5 * x, -0.5 * y)), [force * x, force * y], 1e-6);
    // Behind the inward corner it is the corner that is nearest.
    close(renderer.step(at(0.5, 0.27)), [0.0, -20.0], 1e-6);
    for (x, y) in [(0.5, 0.24), (0.25, 0.12), (-0.01, 0.0), (0.5, 1.01), (0.5, 0.0)] {
        close(renderer.step(at(x, y)), [0.0, 0.0], 0.0);
    }
    // What appears around the hand is felt when it has been left.
    let mut renderer = Renderer::default();
    renderer.step(at(0.5, 0.27));
    renderer.know(&[dart()]);
    close(renderer.step(at(0.5, 0.27)), [0.0, 0.0], 0.0);
    renderer.step(at(0.5, 0.24));
    close(renderer.step(at(0.5, 0.27)), [0.0, -20.0], 1e-6);
}

/// A floor and a wall that meet in a corner: each pushes along its own normal, and the forces add.
#[test]
fn in_a_corner_the_forces_add() {
    let floor = Wall { from_x_m: -1.0, to_x_m: 1.0, thickness_m: 0.25, damping_n_s_per_m: 4.0, ..Wall::default() };
    let upright = Wall { from_y_m: 1.0, to_x_m: 0.0, to_y_m: -1.0, thickness_m: 0.25, ..Wall::default() };
    let mut renderer = feel(&[object(1, Shape::Wall(floor)), object(2, Shape::Wall(upright))]);
    // K = 1000 N/m of both, B = 4 N·s/m of the floor and 2 of the wall.
    let force = renderer.step(moving(-0.003, -0.004, -0.1, -0.5));
    close(force, [1000.0 * 0.003 + 2.0 * 0.1, 1000.0 * 0.004 + 4.0 * 0.5], 1e-6);
    assert_eq!(renderer.touched(), 2);
}

fn strip(masses: f32) -> Strip {
    Strip { to_x_m: 1.0, masses, mass_kg: 0.05, spring_n_per_m: 500.0, drag_n_s_per_m: 1.0, ..Strip::default() }
}

/// Presses a strip at mass `at` down to `depth` and gives the force that it settles at.
fn press(strip: Strip, at_mass: f64, depth: f64) -> f64 {
    let mut renderer = feel(&[object(1, Shape::Strip(strip))]);
    let x = at_mass / (f64::from(strip.masses) + 1.0);
    let mut force = [0.0; 2];
    for tick in 0..20_000 {
        let down = depth * (f64::from(tick) / 500.0).min(1.0);
        force = renderer.step(at(x, 0.0001 - down));
    }
    assert!(force[0].abs() < 1e-9);
    force[1]
}

/// A chain with fixed ends under a force at mass j gives way by F/k·j(n + 1 − j)/(n + 1): Green's function of the second
/// difference. The contact spring is in series with it.
#[test]
fn a_strip_gives_way_as_its_greens_function_says() {
    for (masses, j) in [(1.0_f32, 1.0_f64), (9.0, 5.0), (9.0, 2.0), (64.0, 20.0)] {
        let n = f64::from(masses);
        let strip = strip(masses);
        let compliance = j * (n + 1.0 - j) / (n + 1.0) / f64::from(strip.spring_n_per_m) + 1.0 / 1000.0;
        let (got, want) = (press(strip, j, 0.0201), 0.02 / compliance);
        assert!((got / want - 1.0).abs() < 1e-5, "{n} masses at {j}: {got} N, not {want} N");
    }
}

/// Between two masses the load is shared in proportion: with one mass either side, compliance by the same function.
#[test]
fn between_masses_the_load_is_shared() {
    let (n, k, share) = (2.0, 500.0, 0.25);
    let green = |i: f64, j: f64| f64::min(i, j) * (n + 1.0 - f64::max(i, j)) / (n + 1.0) / k;
    let weights = [(1.0, 1.0 - share), (2.0, share)];
    let compliance: f64 =
        weights.iter().flat_map(|(i, a)| weights.iter().map(move |(j, b)| a * b * green(*i, *j))).sum();
    let (got, want) = (press(strip(2.0), 1.0 + share, 0.0201), 0.02 / (compliance + 1e-3));
    assert!((got / want - 1.0).abs() < 1e-5, "{got} N, not {want} N");
}

/// The lowest mode of a chain: ω = 2·√(k/m)·sin(π/2(n + 1)), seen as the sway of the force after a pluck.
#[test]
fn a_strip_swings_at_its_own_frequency() {
    let strip = Strip { drag_n_s_per_m: 0.0, stiffness_n_per_m: 1.0, ..strip(1.0) };
    let mut renderer = feel(&[object(1, Shape::Strip(strip))]);
    // A light touch deep enough to be in contact throughout: the force is K·(u − d), its period that of u.
    renderer.step(at(0.5, 0.001));
    let force: Vec<f64> = (0..20_000).map(|_| renderer.step(at(0.5, -0.1))[1]).collect();
    let mean = force.iter().sum::<f64>() / force.len() as f64;
    let ups: Vec<usize> = (1..force.len()).filter(|at| force[at - 1] < mean && force[*at] >= mean).collect();
    let period = (ups[ups.len() - 1] - ups[0]) as f64 / (ups.len() - 1) as f64 * 1e-3;
    // One mass between two springs of 500 N/m, and the contact's 1 N/m.
    let want = std::f64::consts::TAU * (0.05_f64 / 1001.0).sqrt();
    assert!((period / want - 1.0).abs() < 2e-3, "{period} s, not {want} s");
}

/// The bound that world files are held to is where the chain really turns unstable.
#[test]
fn the_stiffest_strip_that_is_allowed_stays_bounded() {
    let grows = |spring: f32| {
        let strip = Strip { spring_n_per_m: spring, mass_kg: 0.01, drag_n_s_per_m: 0.0, ..strip(63.0) };
        let strip = Strip { stiffness_n_per_m: 1.0, ..strip };
        let mut renderer = feel(&[object(1, Shape::Strip(strip))]);
        renderer.step(at(0.3, 0.001));
        let largest = (0..5_000).map(|_| renderer.step(at(0.3, -0.01))[1].abs()).fold(0.0, f64::max);
        // What is felt is bounded by the way to the ends, here 0.3 m: the hand is safe even so.
        assert!(largest <= 0.3);
        largest > 0.1
    };
    // 4·k·T²/m = 4 at k = 10⁴ N/m.
    assert!(!grows(9_900.0) && grows(10_100.0));
}

#[test]
fn a_strip_is_felt_from_its_free_side_only_and_fades_at_its_ends() {
    let mut renderer = feel(&[object(1, Shape::Strip(strip(9.0)))]);
    renderer.step(at(-0.5, -0.5));
    for y in [-0.5, -0.1, -0.01, -0.001] {
        close(renderer.step(at(0.5, y)), [0.0, 0.0], 0.0);
    }
    renderer.step(at(0.5, 0.01));
    // Sliding off the end at a depth: no step larger than the slide's own. K = 1000 N/m, 0.1 mm a tick.
    let (mut last, mut largest) = (renderer.step(at(0.5, -0.01))[1], 0.0_f64);
    for tick in 0..6_000 {
        let force = renderer.step(at(0.5 + 1e-4 * f64::from(tick), -0.01))[1];
        if tick > 0 {
            largest = largest.max((force - last).abs());
        }
        last = force;
    }
    assert!(last == 0.0 && largest < 1.0, "{largest} N");
}

#[test]
fn what_is_touched_does_not_change_under_the_hand() {
    let mut renderer = feel(&[wall()]);
    let deep = at(0.5, -0.01);
    close(renderer.step(deep), [0.0, 10.0], 1e-9);
    // A softer version, then nothing at all: not while it is touched.
    let Shape::Wall(mut softer) = wall().shape else { unreachable!() };
    softer.stiffness_n_per_m = 500.0;
    let softer = Object { version: 2, ..object(1, Shape::Wall(softer)) };
    renderer.know(&[softer]);
    close(renderer.step(deep), [0.0, 10.0], 1e-9);
    renderer.step(at(0.5, 0.01));
    close(renderer.step(deep), [0.0, 5.0], 1e-9);
    renderer.know(&[]);
    close(renderer.step(deep), [0.0, 5.0], 1e-9);
    assert_eq!(renderer.touched(), 1);
    renderer.step(at(0.5, 0.01));
    close(renderer.step(deep), [0.0, 0.0], 0.0);
    // A wall that appears around the hand is felt once the hand has left it.
    renderer.know(&[wall()]);
    close(renderer.step(deep), [0.0, 0.0], 0.0);
    renderer.step(at(0.5, 0.01));
    close(renderer.step(deep), [0.0, 10.0], 1e-9);
    // The same thing told again changes nothing, and something else told beside it neither.
    renderer.know(&[wall(), object(2, Shape::Body(Body { x_m: 5.0, ..Body::default() }))]);
    close(renderer.step(deep), [0.0, 10.0], 1e-9);
    assert_eq!(renderer.count(), 2);
}
