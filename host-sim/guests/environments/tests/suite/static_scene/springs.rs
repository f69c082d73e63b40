//! A shape of springs and dampers: against the one-dimensional contact, against geometry, against energy.

use cohold_core::contact::continuous::Contact;
use cohold_core::num::{Fixed, Motion, Scalar};
use cohold_core::object::{AnyIntegrator, IntegratorName};
use cohold_core::settings::Settings;
use cohold_environments::world::springs::{Edge, Shape, edges};
use proptest::prelude::*;

const STIFFNESS: f64 = 800.0;

fn contact<S: Scalar>(damping: f64) -> Contact<S> {
    let mut settings = Settings::default();
    settings.contact.one_sided = true;
    (settings.contact.stiffness_n_per_m, settings.contact.damping_n_s_per_m) = (STIFFNESS, damping);
    Contact::build(&settings)
}

fn at(x: f64, y: f64) -> [Motion<f64>; 2] {
    [Motion::at(x), Motion::at(y)]
}

/// 40 mm wide.
const SQUARE: [[f64; 2]; 4] = [[-0.02, -0.02], [0.02, -0.02], [0.02, 0.02], [-0.02, 0.02]];
/// 60 mm wide, with a corner that points inwards at (0, 0).
const ELL: [[f64; 2]; 6] = [[-0.03, -0.03], [0.03, -0.03], [0.03, 0.0], [0.0, 0.0], [0.0, 0.03], [-0.03, 0.03]];

fn polygon<const N: usize>(corners: [[f64; 2]; N]) -> Shape<f64, [Edge<f64>; N]> {
    Shape::Polygon(edges(corners))
}

/// Force on a device at rest at this place.
fn felt<E: AsRef<[Edge<f64>]>>(shape: &Shape<f64, E>, x: f64, y: f64) -> [f64; 2] {
    shape.press(&contact(0.0), at(x, y), at(0.0, 0.0)).force.map(|part| -part)
}

#[track_caller]
fn close(got: [f64; 2], want: [f64; 2]) {
    assert!((got[0] - want[0]).abs() < 1e-9 && (got[1] - want[1]).abs() < 1e-9, "{got:?} is not {want:?}");
}

/// Far from its corners a shape is the one-sided contact of the peer, moving or not.
#[test]
fn a_flat_face_is_the_one_sided_contact() {
    let face = polygon([[0.0, -1.0], [1.0, -1.0], [1.0, 1.0], [0.0, 1.0]]);
    let contact = contact(2.0);
    for step in -50..50 {
        let device = Motion { position: 1e-4 * f64::from(step), velocity: 0.3 };
        let object = Motion { position: 0.0, velocity: -0.1 };
        let pressed = face.press(&contact, [device, Motion::REST], [object, Motion::REST]);
        let depth = device.position.max(0.0);
        let want = if depth > 0.0 { STIFFNESS * depth + 2.0 * 0.4 } else { 0.0 };
        close(pressed.force, [want, 0.0]);
        close([pressed.depth, contact.force(device, object)], [depth, want]);
    }
}

#[test]
fn faces_push_outward_and_a_corner_turns_the_force_and_not_its_size() {
    let square = polygon(SQUARE);
    close(felt(&square, 0.019, 0.0), [0.8, 0.0]);
    close(felt(&square, -0.019, 0.005), [-0.8, 0.0]);
    close(felt(&square, 0.0, 0.018), [0.0, 1.6]);
    close(felt(&square, 0.0171, 0.017), [2.32, 0.0]);
    close(felt(&square, 0.017, 0.0171), [0.0, 2.32]);
    for (x, y) in [(0.021, 0.0), (0.0, -0.03), (0.021, 0.021), (0.019, 0.05), (0.02, 0.0)] {
        close(felt(&square, x, y), [0.0, 0.0]);
    }
    let disc = Shape::Disc { centre: [0.0; 2], radius: 0.02 };
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for shape in [&square, &disc] {
            close(felt(shape, bad, 0.0), [0.0, 0.0]);
            close(felt(shape, 0.0, bad), [0.0, 0.0]);
            let device = [Motion { position: 0.019, velocity: bad }, Motion::REST];
            close(shape.press(&contact(2.0), device, at(0.0, 0.0)).force, [0.0, 0.0]);
        }
    }
}

/// Near a corner that points inwards the nearest point of the surface is the corner itself.
#[test]
fn an_inward_corner_pushes_towards_itself() {
    let ell = polygon(ELL);
    close(felt(&ell, -0.003, -0.004), [0.6 * STIFFNESS * 0.005, 0.8 * STIFFNESS * 0.005]);
    close(felt(&ell, 0.003, -0.004), [0.0, STIFFNESS * 0.004]);
    close(felt(&ell, 0.003, 0.004), [0.0, 0.0]);
}

/// Two shapes that meet in a corner both push: the forces add.
#[test]
fn two_walls_that_meet_add_their_forces() {
    let floor = polygon([[-1.0, -1.0], [1.0, -1.0], [1.0, 0.0], [-1.0, 0.0]]);
    let wall = polygon([[-1.0, -1.0], [0.0, -1.0], [0.0, 1.0], [-1.0, 1.0]]);
    let [a, b] = [felt(&floor, -0.002, -0.003), felt(&wall, -0.002, -0.003)];
    close([a[0] + b[0], a[1] + b[1]], [STIFFNESS * 0.002, STIFFNESS * 0.003]);
}

/// A regular polygon inside a disc of radius r gives way by r·(1 − cos(π/n)) at most, in the middle of its sides: second
/// order in 1/n. Its normal is off by π/n at most: first order.
#[test]
fn a_disc_of_many_sides_converges_to_the_disc() {
    const RADIUS: f64 = 0.03;
    fn largest<const N: usize>() -> (f64, f64) {
        let turn = |part: f64| std::f64::consts::TAU * part;
        let corner = |at: usize| {
            let (sine, cosine) = turn(at as f64 / N as f64).sin_cos();
            [RADIUS * cosine, RADIUS * sine]
        };
        let disc: Shape<f64, [Edge<f64>; N]> = Shape::Disc { centre: [0.0; 2], radius: RADIUS };
        let many = polygon(std::array::from_fn::<_, N, _>(corner));
        let (mut depth, mut normal) = (0.0_f64, 0.0_f64);
        for step in 0..20_000 {
            let (sine, cosine) = turn(f64::from(step) / 20_000.0).sin_cos();
            let point = [0.9 * RADIUS * cosine, 0.9 * RADIUS * sine];
            let (round, flat) = (disc.depth(point).expect("inside"), many.depth(point).expect("inside"));
            let cross = round.normal[0] * flat.normal[1] - round.normal[1] * flat.normal[0];
            assert!((round.depth - 0.1 * RADIUS).abs() < 1e-15 && (round.normal[0] - cosine).abs() < 1e-12);
            depth = depth.max((round.depth - flat.depth).abs());
            normal = normal.max(cross.abs().asin());
        }
        (depth, normal)
    }
    for ((depth, normal), n) in [largest::<16>(), largest::<32>(), largest::<64>()].into_iter().zip([16.0, 32.0, 64.0])
    {
        let step = std::f64::consts::PI / n;
        assert!((depth / (RADIUS * (1.0 - step.cos())) - 1.0).abs() < 1e-4, "{n}: {depth}");
        assert!((normal / step - 1.0).abs() < 1e-2, "{n}: {normal}");
    }
}

/// ½·K·x² is a potential: a walk through the faces and corners of a shape and back costs nothing, in the limit of small
/// steps. Were both springs of a corner to push, it would not be so: the second is found stretched already.
#[test]
fn a_walk_around_a_closed_path_costs_nothing() {
    // Through the right face of the square 3 mm below its corner, out of the top 2 mm beside it, and around the corner back.
    let path = [[0.025, 0.017], [0.018, 0.017], [0.018, 0.025], [0.025, 0.025], [0.025, 0.017]];
    let work = |force: &dyn Fn(f64, f64) -> [f64; 2], steps: u32| -> f64 {
        let leg = |pair: &[[f64; 2]]| -> f64 {
            let way = [pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]];
            let middle = |step: u32| (f64::from(step) + 0.5) / f64::from(steps);
            let dot = |force: [f64; 2]| force[0] * way[0] + force[1] * way[1];
            let at = |part: f64| dot(force(pair[0][0] + part * way[0], pair[0][1] + part * way[1]));
            (0..steps).map(|step| at(middle(step))).sum::<f64>() / f64::from(steps)
        };
        path.windows(2).map(leg).sum()
    };
    for shape in [SQUARE, [[-0.02, -0.01], [0.021, -0.02], [0.02, 0.02], [-0.02, 0.024]]].map(polygon) {
        let one = work(&|x, y| felt(&shape, x, y), 20_000);
        // What is stored on the way is up to 3.6 mJ.
        assert!(one.abs() < 1e-6, "{one} J");
    }
    // Both springs: the top one is found stretched by 3 mm, the right one is left behind stretched by 2 mm.
    let both =
        |x: f64, y: f64| if x < 0.02 && y < 0.02 { [0.02 - x, 0.02 - y].map(|d| STIFFNESS * d) } else { [0.0; 2] };
    let made = work(&both, 20_000);
    let known = 0.5 * STIFFNESS * (0.003_f64.powi(2) - 0.002_f64.powi(2));
    assert!((made / known - 1.0).abs() < 1e-2, "{made} J, not {known} J");
}

/// Without damping, device, object and spring keep their energy; with it, they lose what the damper took and no more.
#[test]
fn energy_of_a_blow_on_a_corner() {
    let mut settings = Settings::default();
    settings.object.force_delay_ticks = 0.0;
    settings.object.integrator = IntegratorName::SemiImplicit;
    settings.timing.control_period_s = 1e-5;
    let body = |mass: f64| {
        let mut settings = settings;
        settings.object.mass_kg = mass;
        [AnyIntegrator::build(&settings).expect("good settings"); 2]
    };
    let square = polygon(SQUARE);
    for damping in [0.0, 0.5] {
        let contact = contact(damping);
        let mut device = [Motion { position: 0.0202, velocity: -0.3 }, Motion { position: 0.0180, velocity: 0.2 }];
        let mut object = [Motion::REST; 2];
        let (mut device_law, mut object_law) = (body(0.1), body(0.3));
        let kinetic = |device: [Motion<f64>; 2], object: [Motion<f64>; 2]| {
            let squares = |axes: [Motion<f64>; 2]| axes.iter().map(|axis| axis.velocity * axis.velocity).sum::<f64>();
            0.5 * (0.1 * squares(device) + 0.3 * squares(object))
        };
        let start = kinetic(device, object);
        let (mut taken, mut stored) = (0.0, 0.0);
        let mut felt = [false; 2];
        for _ in 0..20_000 {
            let pressed = square.press(&contact, device, object);
            stored = 0.5 * STIFFNESS * pressed.depth * pressed.depth;
            taken += damping * pressed.rate * pressed.rate * 1e-5;
            for axis in 0..2 {
                felt[axis] |= pressed.force[axis] != 0.0;
                device[axis] = device_law[axis].step(device[axis], -pressed.force[axis]);
                object[axis] = object_law[axis].step(object[axis], pressed.force[axis]);
            }
        }
        let end = kinetic(device, object) + stored;
        assert!(felt[0], "the corner was missed");
        assert!((end + taken - start).abs() < 2e-3 * start, "{end} + {taken} of {start} with damping {damping}");
        assert!(damping == 0.0 || taken > 0.01 * start);
    }
}

/// The same force in every number type, to what it can hold.
fn agrees<S: Scalar>(tolerance: f64) {
    let (known, shape) = (polygon(ELL), Shape::Polygon(edges::<S, 6>(ELL)));
    for step in 0..4000 {
        // No point is equally near to two sides.
        let (x, y) = (1e-3 * f64::from(step % 63) - 0.031_31, 1e-3 * f64::from(step / 63) - 0.031_17);
        let hand = [(x, 0.2), (y, -0.1)].map(|(position, velocity)| Motion { position, velocity });
        let typed =
            hand.map(|axis| Motion { position: S::from_f64(axis.position), velocity: S::from_f64(axis.velocity) });
        let want = known.press(&contact(2.0), hand, [Motion::REST; 2]);
        let got = shape.press(&contact(2.0), typed, [Motion::REST; 2]);
        for (got, want) in got.force.into_iter().zip(want.force) {
            assert!((got.to_f64() - want).abs() < tolerance, "{} at {x}, {y}: {} {want}", S::NAME, got.to_f64());
        }
    }
}

#[test]
fn every_number_type_feels_the_same() {
    agrees::<f32>(1e-4);
    agrees::<Fixed>(1e-3);
}

proptest! {
    /// Any bits may come in: no panic, and no force on who is nowhere.
    #[test]
    fn any_bits_may_come_in(bits in prop::array::uniform4(any::<u32>()), far: bool) {
        let [x, y, u, v] = bits.map(|bits| if far { f32::from_bits(bits) } else { bits as f32 * 1e-11 - 0.02 });
        let hand = [(x, u), (y, v)].map(|(position, velocity)| Motion { position, velocity });
        let felt = Shape::Polygon(edges::<f32, 6>(ELL)).press(&contact(2.0), hand, [Motion::REST; 2]);
        prop_assert!((x.is_finite() && y.is_finite()) || felt == Default::default());
        let hand = hand.map(|axis| Motion {
            position: Fixed::from_f64(f64::from(axis.position)),
            velocity: Fixed::from_f64(f64::from(axis.velocity)),
        });
        let felt = Shape::Polygon(edges::<Fixed, 6>(ELL)).press(&contact(2.0), hand, [Motion::REST; 2]);
        prop_assert!(felt.depth.to_f64() < 0.03);
    }

    /// Against a walk along the outline in small steps, and a count of turns around the point.
    #[test]
    fn depth_is_the_distance_to_the_outline(
        radii in prop::array::uniform7(0.01..0.03_f64),
        x in -0.03..0.03_f64,
        y in -0.03..0.03_f64,
        backwards: bool,
    ) {
        let mut corners: [[f64; 2]; 7] = std::array::from_fn(|at| {
            let (sine, cosine) = (std::f64::consts::TAU * at as f64 / 7.0).sin_cos();
            [radii[at] * cosine, radii[at] * sine]
        });
        if backwards {
            corners.reverse();
        }
        let (mut nearest, mut turned) = (f64::INFINITY, 0.0);
        for at in 0..7 {
            let ([ax, ay], [bx, by]) = (corners[at], corners[(at + 1) % 7]);
            for step in 0..2000 {
                let part = f64::from(step) / 2000.0;
                nearest = nearest.min((ax + part * (bx - ax) - x).hypot(ay + part * (by - ay) - y));
            }
            let (from, to) = ((ay - y).atan2(ax - x), (by - y).atan2(bx - x));
            turned += (to - from + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU) - std::f64::consts::PI;
        }
        prop_assume!(nearest > 1e-4);
        match polygon(corners).depth([x, y]) {
            None => prop_assert!(turned.abs() < 1.0, "{turned}"),
            Some(found) => {
                prop_assert!(turned.abs() > 6.0, "{turned}");
                prop_assert!((found.depth - nearest).abs() < 2e-5, "{} {nearest}", found.depth);
                // Along the normal by the depth lies the surface.
                let [u, v] = [x + 1.0001 * found.depth * found.normal[0], y + 1.0001 * found.depth * found.normal[1]];
                let beyond = polygon(corners).depth([u, v]).map_or(0.0, |found| found.depth);
                prop_assert!(beyond < 1e-5, "{beyond}");
            }
        }
    }
}
