//! A shape of springs and dampers: against the one-dimensional contact, against geometry, against energy.

use haptic_core::list::Model;
use haptic_core::motion::Motion;
use haptic_core::object::Integrator;
use haptic_core::object::semi_implicit::SemiImplicit;
use haptic_core::render::contact::Contact;
use haptic_core::render::shape::{Patch, press};
use haptic_core::settings::Settings;

fn at(x: f64, y: f64) -> [Motion<f64>; 2] {
    [Motion::at(x), Motion::at(y)]
}

/// A square of 40 mm, a patch on each side.
fn square(stiffness: f64, damping: f64) -> [Patch<f64>; 4] {
    [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]].map(|normal: [f64; 2]| Patch {
        point: normal.map(|n| 0.02 * n),
        normal,
        reach: 0.02,
        thickness: 0.005,
        stiffness,
        damping,
    })
}

/// On one side a shape is the one-sided contact of the peer, moving or not.
#[test]
fn one_patch_is_the_one_sided_contact() {
    let mut settings = Settings::default();
    settings.contact.one_sided = true;
    let contact = Contact::<f64>::build(&settings);
    let patch =
        Patch { point: [0.0; 2], normal: [-1.0, 0.0], reach: 1.0, thickness: 1.0, stiffness: 1000.0, damping: 2.0 };
    for step in -50..50 {
        let device = Motion { position: 1e-4 * f64::from(step), velocity: 0.3 };
        let object = Motion { position: 0.0, velocity: -0.1 };
        let felt = press(&[patch], [device, Motion::REST], [object, Motion::REST]).force;
        assert!((felt[0] - contact.force(device, object)).abs() < 1e-12 && felt[1] == 0.0, "{felt:?}");
    }
}

#[test]
fn sides_push_outward_corners_push_twice_and_the_middle_is_far_from_every_side() {
    let square = square(500.0, 0.0);
    let object = at(0.1, -0.2);
    let force = |x: f64, y: f64| press(&square, at(0.1 + x, -0.2 + y), object);
    let close = |got: [f64; 2], want: [f64; 2]| (got[0] - want[0]).abs() < 1e-9 && (got[1] - want[1]).abs() < 1e-9;
    // 1 mm in from the right: the object is pushed left, the device right.
    assert!(close(force(0.019, 0.0).force, [-0.5, 0.0]));
    assert!(close(force(-0.019, 0.005).force, [0.5, 0.0]));
    assert!(close(force(0.0, 0.018).force, [0.0, -1.0]));
    let corner = force(0.019, 0.018);
    assert_eq!(corner.patches, 2);
    assert!(close(corner.force, [-0.5, -1.0]));
    for outside in [(0.021, 0.0), (0.0, -0.03), (0.021, 0.021), (0.019, 0.05)] {
        assert_eq!(force(outside.0, outside.1).patches, 0, "{outside:?}");
    }
    assert_eq!(press(&square, at(f64::NAN, 0.0), object).patches, 0);
}

/// Without damping, device, object and springs keep their energy; with it, they lose what the dampers took and no more.
#[test]
fn energy_of_a_push_on_two_sides() {
    let mut settings = Settings::default();
    settings.object.force_delay_ticks = 0.0;
    settings.timing.control_period_s = 1e-5;
    let body = |mass: f64| {
        let mut settings = settings;
        settings.object.mass_kg = mass;
        SemiImplicit::<f64>::build(&settings)
    };
    let (device_law, object_law) = (body(0.1), body(0.3));
    for damping in [0.0, 0.5] {
        let square = square(800.0, damping);
        let mut device = [Motion { position: 0.0202, velocity: -0.3 }, Motion { position: 0.0202, velocity: -0.2 }];
        let mut object = [Motion::REST; 2];
        let mut states = [[SemiImplicit::<f64>::initial(&object_law); 2]; 2];
        let kinetic = |device: [Motion<f64>; 2], object: [Motion<f64>; 2]| {
            let squares = |axes: [Motion<f64>; 2]| axes.iter().map(|axis| axis.velocity * axis.velocity).sum::<f64>();
            0.5 * (0.1 * squares(device) + 0.3 * squares(object))
        };
        let start = kinetic(device, object);
        let (mut taken, mut touched) = (0.0, 0);
        let mut stored = 0.0;
        for _ in 0..20_000 {
            let pressed = press(&square, device, object);
            touched = touched.max(pressed.patches);
            stored = pressed.stored_j;
            for axis in 0..2 {
                let force = pressed.force[axis];
                device[axis] = device_law.step(&mut states[0][axis], device[axis], -force);
                object[axis] = object_law.step(&mut states[1][axis], object[axis], force);
                let gone = object[axis].velocity - device[axis].velocity;
                if damping > 0.0 && force != 0.0 {
                    // The damper's share of the force is damping·rate on this axis, whose normal is the axis itself.
                    taken += damping * gone * gone * 1e-5;
                }
            }
        }
        assert_eq!(touched, 2);
        let end = kinetic(device, object) + stored;
        assert!((end + taken - start).abs() < 2e-3 * start, "{end} + {taken} of {start} with damping {damping}");
        assert!(damping == 0.0 || taken > 0.05 * start);
    }
}
