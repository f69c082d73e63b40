//! Mechanisms against inverse kinematics, finite differences and the duality of force and motion.

use cohold_core::device::kinematics::five_bar::MIN_SINE;
use cohold_core::device::kinematics::{AnyKinematics, Pose};
use cohold_core::num::{Fixed, Motion, Scalar};
use cohold_core::settings::{Settings, Value};
use proptest::prelude::*;

use super::{number, settings};

const BASE_M: f64 = 0.06;
const PROXIMAL_M: f64 = 0.1;
const DISTAL_M: f64 = 0.12;

fn named(name: &'static str) -> Settings {
    let axes = if name == "five-bar" { 2.0 } else { 1.0 };
    settings(&[("axis.count", number(axes)), ("kinematics.model", Value::Text(name))])
}

fn build<S: Scalar>(settings: &Settings) -> AnyKinematics<S> {
    AnyKinematics::build(settings).expect("good settings")
}

fn five_bar<S: Scalar>() -> AnyKinematics<S> {
    build(&named("five-bar"))
}

fn with_maths(maths: &'static str) -> Settings {
    let mut settings = named("five-bar");
    settings.set("kinematics.maths", Value::Text(maths)).expect("a word");
    settings
}

/// The pose with joints at rest.
fn at<S: Scalar>(mechanism: &AnyKinematics<S>, [a, b]: [f64; 2]) -> Pose<S> {
    mechanism.forward([Motion::at(S::from_f64(a)), Motion::at(S::from_f64(b))])
}

fn position<S: Scalar>(pose: &Pose<S>) -> [f64; 2] {
    pose.axes.map(|axis| axis.position.to_f64())
}

/// Height of the hand over the base at home: 60° triangle of the proximal link, right triangle of the distal one.
fn home_height() -> f64 {
    PROXIMAL_M * 0.75_f64.sqrt() + (DISTAL_M.powi(2) - (0.5 * (BASE_M + PROXIMAL_M)).powi(2)).sqrt()
}

/// Joint angles that put the hand at `hand`, elbows outward, by the law of cosines; a second method, not the inverse of
/// the first. None out of reach.
fn inverse([x, y]: [f64; 2]) -> Option<[f64; 2]> {
    let arm = |motor_x: f64, outward: f64, home: f64| {
        let (dx, dy) = (x - motor_x, y + home_height());
        let reach = dx.hypot(dy);
        let cosine = (PROXIMAL_M.powi(2) + reach.powi(2) - DISTAL_M.powi(2)) / (2.0 * PROXIMAL_M * reach);
        (cosine.abs() < 1.0).then(|| dy.atan2(dx) + outward * cosine.acos() - home)
    };
    let sixty = 60.0_f64.to_radians();
    Some([arm(-0.5 * BASE_M, 1.0, 2.0 * sixty)?, arm(0.5 * BASE_M, -1.0, sixty)?])
}

fn five_bar_undoes_the_inverse<S: Scalar>(tolerance: f64) {
    let mechanism = five_bar::<S>();
    let mut reached = 0;
    for column in -20..=20 {
        for row in -20..=20 {
            let hand = [f64::from(column) * 0.003, f64::from(row) * 0.003];
            if let Some(joints) = inverse(hand) {
                let found = position(&at(&mechanism, joints));
                for (found, wanted) in found.iter().zip(hand) {
                    assert!((found - wanted).abs() < tolerance, "{}: {found} for {wanted} of {hand:?}", S::NAME);
                }
                reached += 1;
            }
        }
    }
    assert!(reached > 1000, "{reached}");
}

#[test]
fn five_bar_undoes_the_inverse_all_over_the_workspace() {
    five_bar_undoes_the_inverse::<f64>(1e-12);
    five_bar_undoes_the_inverse::<f32>(2e-6);
    five_bar_undoes_the_inverse::<Fixed>(1e-7);
}

#[test]
fn home_is_zero_to_the_last_bit() {
    for maths in ["libm", "micromath"] {
        let settings = with_maths(maths);
        assert_eq!(position(&at(&build::<f32>(&settings), [0.0, 0.0])), [0.0, 0.0]);
        assert_eq!(position(&at(&build::<f64>(&settings), [0.0, 0.0])), [0.0, 0.0]);
        assert_eq!(position(&at(&build::<Fixed>(&settings), [0.0, 0.0])), [0.0, 0.0]);
    }
}

#[test]
fn the_capstan_is_a_gear() {
    let mechanism = build::<f64>(&named("capstan"));
    let pose = mechanism.forward([Motion { position: 10.0, velocity: -5.0 }, Motion { position: 9.0, velocity: 9.0 }]);
    // One paddle radian is ten motor radians; 0.08 m away.
    assert_eq!(pose.axes, [Motion { position: 0.08, velocity: -0.04 }, Motion::REST]);
    let [torque, none] = pose.joint_forces([2.0, 5.0]);
    assert!((torque - 2.0 * 0.08 / 10.0).abs() < 1e-15 && none == 0.0);
}

#[test]
fn direct_joints_are_the_axes() {
    let joints = [Motion { position: 0.1, velocity: 0.2 }, Motion { position: -0.3, velocity: 0.4 }];
    let pose = build::<f64>(&named("direct")).forward(joints);
    assert_eq!(pose.axes, joints);
    assert_eq!(pose.joint_forces([3.0, -4.0]), [3.0, -4.0]);
}

#[test]
fn micromath_is_as_far_off_as_stated() {
    let (fast, exact) = (build::<f32>(&with_maths("micromath")), five_bar::<f64>());
    let (mut off_m, mut off_jacobian) = (0.0_f64, 0.0_f64);
    for column in -10..=10 {
        for row in -10..=10 {
            let Some(joints) = inverse([f64::from(column) * 0.003, f64::from(row) * 0.003]) else { continue };
            let (fast, exact) = (at(&fast, joints), at(&exact, joints));
            for (fast, exact) in position(&fast).iter().zip(position(&exact)) {
                off_m = off_m.max((fast - exact).abs());
            }
            for (fast, exact) in fast.jacobian.as_flattened().iter().zip(exact.jacobian.as_flattened()) {
                off_jacobian = off_jacobian.max((f64::from(*fast) - exact).abs() / PROXIMAL_M);
            }
        }
    }
    assert!(off_m < 0.001 * (PROXIMAL_M + DISTAL_M) && off_jacobian < 0.005, "{off_m} {off_jacobian}");
    assert!(off_m > 1e-5, "the fast maths are not in use");
}

#[test]
fn a_pose_joins_its_singular_neighbours_without_a_step() {
    let mechanism = five_bar::<f64>();
    let step = 1e-4;
    // Both elbows outward until the distal links are in line, and far beyond; both inward until they cross.
    let mut before = position(&at(&mechanism, [0.0, 0.0]));
    let (mut regular, mut singular) = (0, 0);
    for tick in 1..15000 {
        let pose = at(&mechanism, [step * f64::from(tick), -step * f64::from(tick)]);
        let now = position(&pose);
        assert!((now[0] - before[0]).hypot(now[1] - before[1]) < step * PROXIMAL_M / MIN_SINE, "{tick}");
        before = now;
        if pose.jacobian == [[0.0; 2]; 2] {
            singular += 1;
            assert_eq!(pose.joint_forces([40.0, 40.0]), [0.0, 0.0]);
        } else {
            regular += 1;
        }
    }
    assert!(regular > 100 && singular > 100, "{regular} {singular}");
}

#[test]
fn a_joint_that_is_not_a_number_is_seen_and_pushes_nothing() {
    for bad in [f64::NAN, f64::INFINITY] {
        let pose = at(&five_bar::<f64>(), [bad, 0.1]);
        assert!(pose.axes.iter().all(|axis| !axis.is_finite()));
        assert_eq!(pose.joint_forces([1.0, 1.0]), [0.0, 0.0]);
    }
}

proptest! {
    #[test]
    fn the_jacobian_is_the_derivative(x in -0.03..0.03_f64, y in -0.05..0.03_f64) {
        let joints = inverse([x, y]).unwrap();
        let mechanism = five_bar::<f64>();
        let pose = at(&mechanism, joints);
        for joint in 0..2 {
            let moved = |by: f64| {
                let mut moved = joints;
                moved[joint] += by;
                position(&at(&mechanism, moved))
            };
            let (after, before) = (moved(1e-6), moved(-1e-6));
            for axis in 0..2 {
                let derivative = (after[axis] - before[axis]) / 2e-6;
                prop_assert!((pose.jacobian[axis][joint] - derivative).abs() < 1e-7, "{axis} {joint}: {derivative}");
            }
        }
    }

    #[test]
    fn the_mirror_image_is_a_mirror_image(a in -0.5..0.5_f64, b in -0.5..0.5_f64) {
        let mechanism = five_bar::<f64>();
        let [x, y] = position(&at(&mechanism, [a, b]));
        let [mirrored_x, mirrored_y] = position(&at(&mechanism, [-b, -a]));
        prop_assert!((x + mirrored_x).abs() < 1e-12 && (y - mirrored_y).abs() < 1e-12);
    }

    #[test]
    fn power_at_the_joints_is_power_at_the_axes(
        name in prop::sample::select(vec!["direct", "capstan", "five-bar"]),
        positions in prop::array::uniform2(-7.0..7.0_f64),
        velocities in prop::array::uniform2(-10.0..10.0_f64),
        forces in prop::array::uniform2(-40.0..40.0_f64),
    ) {
        let joints = [0, 1].map(|joint| Motion { position: positions[joint], velocity: velocities[joint] });
        let pose = build::<f64>(&named(name)).forward(joints);
        let torques = pose.joint_forces(forces);
        let at_joints = torques[0] * velocities[0] + torques[1] * velocities[1];
        let at_axes = forces[0] * pose.axes[0].velocity + forces[1] * pose.axes[1].velocity;
        prop_assert!((at_joints - at_axes).abs() <= 1e-12 * (1.0 + at_joints.abs() + forces[0].hypot(forces[1])));
    }

    #[test]
    fn any_geometry_that_passes_and_any_pose_is_finite(
        base in 0.0..1.0_f64,
        proximal in 0.01..1.0_f64,
        distal in 0.01..1.0_f64,
        angles in prop::array::uniform2(-1e4..1e4_f32),
        forces in prop::array::uniform2(-40.0..40.0_f32),
        maths in prop::sample::select(vec!["libm", "micromath"]),
    ) {
        let settings = settings(&[
            ("axis.count", number(2.0)),
            ("kinematics.model", Value::Text("five-bar")),
            ("kinematics.maths", Value::Text(maths)),
            ("kinematics.base_m", number(base)),
            ("kinematics.proximal_m", number(proximal)),
            ("kinematics.distal_m", number(distal)),
        ]);
        let Ok(mechanism) = AnyKinematics::<f32>::build(&settings) else { return Ok(()) };
        let pose = mechanism.forward(angles.map(Motion::at));
        prop_assert!(pose.axes.iter().all(|axis| axis.is_finite()), "{pose:?}");
        // One of sine and cosine is at least 0.7, the other at least MIN_SINE: no gain of the Jacobian above this.
        let most = proximal as f32 / (2.0 * 0.7 * MIN_SINE as f32) * 1.1;
        prop_assert!(pose.jacobian.as_flattened().iter().all(|gain| gain.abs() <= most), "{pose:?} {most}");
        prop_assert!(pose.joint_forces(forces).iter().all(|torque| torque.is_finite()));
    }

    #[test]
    fn any_bits_may_come_in(bits in prop::array::uniform4(any::<u32>()), whole in prop::array::uniform4(any::<i64>())) {
        let [a, b, c, d] = bits.map(f32::from_bits);
        let [e, f, g, h] = whole.map(Fixed::from_bits);
        for name in ["direct", "capstan", "five-bar"] {
            let mechanism = build::<f32>(&named(name));
            mechanism.forward([Motion { position: a, velocity: b }, Motion { position: c, velocity: d }]);
            let mechanism = build::<Fixed>(&named(name));
            mechanism.forward([Motion { position: e, velocity: f }, Motion { position: g, velocity: h }]);
        }
    }
}

/// A lab whose links stand otherwise where its joints are zero: the same mechanism, counted from there.
#[test]
fn a_home_of_ones_own_is_the_same_mechanism_counted_from_there() {
    use core::f64::consts::{FRAC_PI_3, PI};
    let [left, right] = [2.3, 0.9];
    let mut settings = named("five-bar");
    (settings.kinematics.left_home_rad, settings.kinematics.right_home_rad) = (left, right);
    let (own, usual) = (build::<f64>(&settings), five_bar::<f64>());
    let place = |mechanism: &AnyKinematics<f64>, joints: [f64; 2]| mechanism.forward(joints.map(Motion::at));
    let shifted = |[a, b]: [f64; 2]| place(&usual, [a + left - (PI - FRAC_PI_3), b + right - FRAC_PI_3]);
    assert_eq!(place(&own, [0.0; 2]).axes.map(|axis| axis.position), [0.0; 2]);
    for joints in [[0.1, -0.2], [-0.3, 0.05], [0.2, 0.3]] {
        let (found, expected, home) = (place(&own, joints), shifted(joints), shifted([0.0; 2]));
        for axis in 0..2 {
            let moved = expected.axes[axis].position - home.axes[axis].position;
            assert!((found.axes[axis].position - moved).abs() < 1e-14, "{joints:?}");
            for joint in 0..2 {
                assert!((found.jacobian[axis][joint] - expected.jacobian[axis][joint]).abs() < 1e-13);
            }
        }
    }
    // Links that do not meet there are refused.
    settings.kinematics.left_home_rad = PI;
    settings.kinematics.right_home_rad = 0.0;
    assert!(settings.check().is_err());
}
