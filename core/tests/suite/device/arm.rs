//! The arm in space against inverse kinematics by the law of cosines, finite differences and the duality of force and motion.

use cohold_core::device::kinematics::AnySpatial;
use cohold_core::device::kinematics::arm::MIN_SHARE;
use cohold_core::num::{Fixed, Motion, Scalar};
use cohold_core::settings::{Settings, Value};
use proptest::prelude::*;

use super::{number, settings};

const UPPER_M: f64 = 0.14;
const FORE_M: f64 = 0.11;

fn named(name: &'static str) -> Settings {
    settings(&[
        ("axis.count", number(3.0)),
        ("kinematics.model", Value::Text(name)),
        ("kinematics.proximal_m", number(UPPER_M)),
        ("kinematics.distal_m", number(FORE_M)),
    ])
}

fn arm<S: Scalar>() -> AnySpatial<S> {
    AnySpatial::build(&named("arm")).expect("good settings")
}

fn position<S: Scalar>(mechanism: &AnySpatial<S>, joints: [f64; 3]) -> [f64; 3] {
    mechanism.forward(joints.map(|joint| Motion::at(S::from_f64(joint)))).axes.map(|axis| axis.position.to_f64())
}

/// Joint angles that put the hand there, elbow up: the base turns to it, and the links are two sides of a triangle. None out of reach.
fn inverse([x, y, z]: [f64; 3]) -> Option<[f64; 3]> {
    let (out, up) = (x.hypot(z + UPPER_M), y - FORE_M);
    let far = out.hypot(up);
    let cosine = (UPPER_M.powi(2) + far.powi(2) - FORE_M.powi(2)) / (2.0 * UPPER_M * far);
    (cosine.abs() < 1.0).then(|| {
        let upper = up.atan2(out) + cosine.acos();
        let [fore_out, fore_up] = [out - UPPER_M * upper.cos(), up - UPPER_M * upper.sin()];
        [x.atan2(z + UPPER_M), upper, fore_out.atan2(-fore_up)]
    })
}

fn undoes_the_inverse<S: Scalar>(tolerance: f64) {
    let mechanism = arm::<S>();
    let mut reached = 0;
    for at in 0..17_i32.pow(3) {
        let hand = [at % 17, at / 17 % 17, at / 289].map(|step| f64::from(step - 8) * 0.012);
        let Some(joints) = inverse(hand) else { continue };
        let found = position(&mechanism, joints);
        for (found, wanted) in found.into_iter().zip(hand) {
            assert!((found - wanted).abs() < tolerance, "{}: {found} for {wanted} of {hand:?}", S::NAME);
        }
        reached += 1;
    }
    assert!(reached > 3000, "{reached}");
}

#[test]
fn the_arm_undoes_the_inverse_all_over_the_workspace() {
    undoes_the_inverse::<f64>(1e-14);
    undoes_the_inverse::<f32>(1e-7);
    undoes_the_inverse::<Fixed>(1e-9);
}

#[test]
fn at_home_each_joint_moves_an_axis_of_its_own() {
    let pose = arm::<f32>().forward([Motion::REST; 3]);
    assert_eq!(pose.axes, [Motion::REST; 3]);
    let [upper, fore] = [UPPER_M as f32, FORE_M as f32];
    assert_eq!(pose.jacobian, [[upper, 0.0, 0.0], [0.0, upper, 0.0], [0.0, 0.0, fore]]);
}

#[test]
fn a_pose_in_line_or_over_the_base_is_singular_and_its_motors_are_off() {
    let mechanism = arm::<f64>();
    let singular = |joints: [f64; 3]| {
        let pose = mechanism.forward(joints.map(|position| Motion { position, velocity: 1.0 }));
        assert_eq!(pose.is_singular(), pose.joint_forces([40.0; 3]) == [0.0; 3], "{joints:?}");
        assert!(pose.axes.iter().all(|axis| axis.is_finite() && (axis.velocity == 0.0 || !pose.is_singular())));
        pose.is_singular()
    };
    let limit = MIN_SHARE.acos();
    assert!(singular([0.3, limit + 0.001, 0.0]) && !singular([0.3, limit - 0.001, 0.0]));
    assert!(singular([0.3, 0.0, limit + 0.001]) && !singular([0.3, 0.0, limit - 0.001]));
    // The upper link level, the fore link drawn in until the hand is over the base, long before the links are in line.
    let over = |share: f64| -((1.0 - share) * UPPER_M / 0.2).asin();
    let long = settings(&[
        ("axis.count", number(3.0)),
        ("kinematics.model", Value::Text("arm")),
        ("kinematics.proximal_m", number(UPPER_M)),
        ("kinematics.distal_m", number(0.2)),
    ]);
    let long = AnySpatial::<f64>::build(&long).expect("good settings");
    let is_singular = |fore: f64| long.forward([0.3, 0.0, fore].map(Motion::at)).is_singular();
    assert!(is_singular(over(0.9 * MIN_SHARE)) && !is_singular(over(1.1 * MIN_SHARE)));
    // What is no number pushes nothing.
    assert!([f64::NAN, f64::INFINITY].into_iter().all(|bad| {
        (0..3).all(|joint| {
            let mut joints = [0.1; 3];
            joints[joint] = bad;
            let pose = mechanism.forward(joints.map(Motion::at));
            pose.axes.iter().any(|axis| !axis.is_finite())
        })
    }));
}

#[test]
fn mechanisms_of_another_number_of_axes_are_refused() {
    let refused = |changes: &[(&str, Value<'static>)]| settings(changes).check().unwrap_err().to_string();
    let model = |name| ("kinematics.model", Value::Text(name));
    assert_eq!(settings(&[("axis.count", number(3.0)), model("arm")]).check(), Ok(()));
    assert_eq!(settings(&[("axis.count", number(3.0))]).check(), Ok(()));
    assert_eq!(
        refused(&[("axis.count", number(3.0)), model("five-bar")]),
        "kinematics.model = \"five-bar\" is not allowed: it must be \"direct\" or \"arm\" where axis.count is 3"
    );
    assert_eq!(
        refused(&[model("arm")]),
        "kinematics.model = \"arm\" is not allowed: it must be \"direct\", \"capstan\" or \"five-bar\" where axis.count is 1 or 2"
    );
}

proptest! {
    #[test]
    fn the_jacobian_is_the_derivative(hand in prop::array::uniform3(-0.04..0.04_f64)) {
        let joints = inverse(hand).unwrap();
        let mechanism = arm::<f64>();
        let pose = mechanism.forward(joints.map(Motion::at));
        prop_assert!(!pose.is_singular());
        for joint in 0..3 {
            let moved = |by: f64| {
                let mut moved = joints;
                moved[joint] += by;
                position(&mechanism, moved)
            };
            let (after, before) = (moved(1e-6), moved(-1e-6));
            for axis in 0..3 {
                let derivative = (after[axis] - before[axis]) / 2e-6;
                prop_assert!((pose.jacobian[axis][joint] - derivative).abs() < 1e-9, "{axis} {joint}: {derivative}");
            }
        }
    }

    #[test]
    fn power_at_the_joints_is_power_at_the_axes(
        name in prop::sample::select(vec!["direct", "arm"]),
        positions in prop::array::uniform3(-7.0..7.0_f64),
        velocities in prop::array::uniform3(-10.0..10.0_f64),
        forces in prop::array::uniform3(-40.0..40.0_f64),
    ) {
        let mechanism = AnySpatial::<f64>::build(&named(name)).expect("good settings");
        let joints = [0, 1, 2].map(|joint: usize| Motion { position: positions[joint], velocity: velocities[joint] });
        let pose = mechanism.forward(joints);
        let torques = pose.joint_forces(forces);
        let power = |forces: [f64; 3], speeds: [f64; 3]| forces.iter().zip(speeds).map(|(f, v)| f * v).sum::<f64>();
        let (at_joints, at_axes) = (power(torques, velocities), power(forces, pose.axes.map(|axis| axis.velocity)));
        prop_assert!((at_joints - at_axes).abs() <= 1e-12 * (100.0 + at_joints.abs()), "{at_joints} {at_axes}");
    }

    #[test]
    fn any_bits_may_come_in(bits in prop::array::uniform6(any::<u32>()), whole in prop::array::uniform6(any::<i64>())) {
        let [a, b, c, d, e, f] = bits.map(f32::from_bits);
        let joints = [(a, b), (c, d), (e, f)].map(|(position, velocity)| Motion { position, velocity });
        arm::<f32>().forward(joints);
        let [a, b, c, d, e, f] = whole.map(Fixed::from_bits);
        let joints = [(a, b), (c, d), (e, f)].map(|(position, velocity)| Motion { position, velocity });
        arm::<Fixed>().forward(joints);
    }
}
