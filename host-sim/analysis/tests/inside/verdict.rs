//! Objects shared along several axes: the spectrum of all axes at once against that of each alone, where it is known what they fall apart into.

use cohold_core::device::kinematics::{AnyKinematics, AnySpatial};
use cohold_core::num::Motion;
use cohold_sim::Laws;
use cohold_sim::scene::Scene;
use nalgebra::{DMatrix, SymmetricEigen};

use super::{Analyser, Direction, Polar};
use crate::modes::{Hands, judge};

/// Eigenvalues below this are those of lines and filters, whose repeated zeros rounding spreads.
const SMALL: f64 = 0.1;

fn scene(axes: u32, keys: &[&str]) -> Scene {
    let mut scene = Scene::new(Laws::built_in());
    let shared = [format!("axis.count={axes}"), format!("axis.shared={axes}")];
    let own = ["object.force_delay_ticks=0", "coordination.decode=implicit"];
    for key in own.iter().chain(keys).copied().chain(shared.iter().map(String::as_str)) {
        scene.apply_override(key).unwrap_or_else(|error| panic!("{key}: {error}"));
    }
    scene.check("test").unwrap_or_else(|error| panic!("{error}"));
    scene
}

/// Sizes and angles of the eigenvalues of every part of a mode, the largest first.
fn parts(scene: &Scene, hands: Hands) -> Vec<Polar> {
    let mut analyser = Analyser::default();
    analyser.modes(scene, Some(hands)).expect("a good scene");
    analyser.parts
}

fn sorted(mut polar: Polar) -> Polar {
    polar.retain(|[size, _]| *size > SMALL);
    polar.sort_unstable_by(|a, b| b[0].total_cmp(&a[0]).then(b[1].total_cmp(&a[1])));
    polar
}

/// How far the eigenvalues of all axes are from those of the axes, each of which is a scene of one.
fn difference(all: &Scene, each: &[Scene]) -> f64 {
    let mut most = 0.0_f64;
    for hands in [Hands::Both, Hands::One, Hands::None] {
        let (together, alone) = (parts(all, hands), each.iter().map(|one| parts(one, hands)).collect::<Vec<_>>());
        for (at, together) in together.into_iter().enumerate() {
            let expected = sorted(alone.iter().flat_map(|parts| parts[at].clone()).collect());
            let together = sorted(together);
            assert_eq!(together.len(), expected.len(), "{hands:?}, part {at}");
            assert!(expected.len() > 2 * each.len() || hands == Hands::None, "{hands:?}: little to compare");
            // Each with the nearest of those that are left: equal sizes may come in any order.
            let mut left: Vec<[f64; 2]> =
                expected.iter().map(|[size, angle]| [size * angle.cos(), size * angle.sin()]).collect();
            for [size, angle] in together {
                let distance = |to: &[f64; 2]| (to[0] - size * angle.cos()).hypot(to[1] - size * angle.sin());
                let nearest = (0..left.len()).min_by(|a, b| distance(&left[*a]).total_cmp(&distance(&left[*b])));
                most = most.max(distance(&left.swap_remove(nearest.expect("as many"))));
            }
        }
    }
    most
}

const LAWS: [&[&str]; 5] = [
    &["coordination.comm=power", "coordination.stiffness_n_per_m=250"],
    &["coordination.comm=wave", "coordination.stiffness_n_per_m=900"],
    &["coordination.comm=passive-wave", "coordination.stiffness_n_per_m=2500"],
    &["coordination.comm=passive-mean", "coordination.stiffness_n_per_m=2500"],
    // Longer than any network here, so that it settles.
    &[
        "coordination.comm=self-timed",
        "object.integrator=midpoint",
        "coordination.stiffness_n_per_m=2500",
        "coordination.credit_ticks=40",
    ],
];

const ENDS: [&[&str]; 3] = [
    &[],
    &["user.1.arm_stiffness_n_per_m=150", "user.1.arm_damping_n_s_per_m=3", "network.asymmetry_s=0.008"],
    &["peer.2.device.mass_kg=0.25", "peer.2.scale.force=1.5"],
];

#[test]
fn axes_that_nothing_couples_have_the_spectrum_of_one_axis_each() {
    for axes in [2, 3] {
        for law in LAWS {
            for ends in ENDS {
                // A symmetric device: what weighs at its joints weighs alike every way.
                let keys = [law, ends].concat();
                let all = scene(axes, &[&keys[..], &["device.joint_inertia=0.05"]].concat());
                let mut one = scene(1, &keys);
                one.world.device.mass_kg += 0.05;
                if ends == ENDS[2] {
                    one.apply_override("peer.2.device.mass_kg=0.3").expect("a good key");
                }
                let difference = difference(&all, &vec![one; axes as usize]);
                assert!(difference < 1e-9, "{axes} {law:?} {ends:?}: {difference:e}");
                let direction = judge(&all).expect("a good scene").worst.direction;
                assert_eq!(direction, Some(Direction::Any), "{axes} {law:?} {ends:?}");
            }
        }
    }
}

/// Mass matrix of a mechanism at home, kg: m·1 + i·J⁻ᵀJ⁻¹, from core's Jacobian and nalgebra.
fn mass(scene: &Scene) -> DMatrix<f64> {
    let (peer, device) = (&scene.peer, &scene.world.device);
    let axes = peer.axis.shared as usize;
    let jacobian = if axes == 2 {
        let pose = AnyKinematics::<f64>::build(peer).expect("a mechanism").forward([Motion::REST; 2]);
        DMatrix::from_fn(2, 2, |row, column| pose.jacobian[row][column])
    } else {
        let pose = AnySpatial::<f64>::build(peer).expect("a mechanism").forward([Motion::REST; 3]);
        DMatrix::from_fn(3, 3, |row, column| pose.jacobian[row][column])
    };
    let inverse = jacobian.try_inverse().expect("a pose that is not singular");
    DMatrix::identity(axes, axes) * device.mass_kg + inverse.transpose() * inverse * device.joint_inertia
}

/// Peers push alike every way, so that all that couples the axes is the mass: the principal masses have an axis each.
#[test]
fn a_mechanism_whose_mass_couples_the_axes_has_the_spectra_of_its_principal_masses() {
    let mechanisms: [(u32, &[&str]); 2] = [
        (
            2,
            &[
                "kinematics.model=five-bar",
                "kinematics.left_home_rad=2.9",
                "kinematics.right_home_rad=1.3",
                "kinematics.distal_m=0.16",
            ],
        ),
        (3, &["kinematics.model=arm"]),
    ];
    for (axes, mechanism) in mechanisms {
        for law in LAWS {
            let all = scene(axes, &[law, mechanism, &["device.joint_inertia=0.002"]].concat());
            let eigen = SymmetricEigen::new(mass(&all));
            let masses: Vec<f64> = eigen.eigenvalues.iter().copied().collect();
            let spread = eigen.eigenvalues.max() / eigen.eigenvalues.min();
            assert!(spread > 1.2, "{mechanism:?}: hardly coupled, {masses:?}");
            let of_mass = |mass_kg: &f64| {
                let mut one = scene(1, law);
                one.world.device.mass_kg = *mass_kg;
                one
            };
            let difference = difference(&all, &masses.iter().map(of_mass).collect::<Vec<_>>());
            assert!(difference < 1e-9, "{mechanism:?} {law:?}: {difference:e} with {masses:?}");
        }
    }
}
