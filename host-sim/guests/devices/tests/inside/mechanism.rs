//! The mechanisms of motors, against virtual work and closed forms.

use cohold_sim::Laws;
use cohold_sim::scene::Scene;

use super::*;

fn mechanism(settings: &[&str], motors: usize) -> Result<Mechanism, Error> {
    let settings: Vec<String> = settings.iter().map(|setting| (*setting).to_owned()).collect();
    let scene = Scene::load(Laws::built_in(), None, &settings).expect("a scene");
    Mechanism::build(&scene.peers()[0], motors)
}

const ARM: [&str; 3] = ["axis.count=3", "axis.shared=3", "kinematics.model=\"arm\""];
const FIVE_BAR: [&str; 2] = ["axis.count=2", "kinematics.model=\"five-bar\""];
const CAPSTAN: [&str; 2] = ["axis.count=1", "kinematics.model=\"capstan\""];

/// The power at the motors is the power at the hand, whatever the pose.
#[test]
fn torques_do_the_work_of_the_force() {
    for (settings, motors) in [(&ARM[..], 3), (&FIVE_BAR, 2), (&CAPSTAN, 1)] {
        let mechanism = mechanism(settings, motors).expect("it can be assembled");
        for angle_rad in [[0.0; 3], [0.1, -0.2, 0.15], [-0.2, 0.1, 0.05]] {
            let speeds = std::array::from_fn(|joint| if joint < motors { 0.7 - 0.5 * joint as f64 } else { 0.0 });
            let pose = mechanism.pose(angle_rad, speeds);
            let force_n = std::array::from_fn(|axis| if axis < motors { 1.5 - axis as f64 } else { 0.0 });
            let torques = pose.torques(force_n, 100.0);
            let power =
                |of: [f64; AXES], with: [f64; AXES]| of.iter().zip(with).map(|(one, other)| one * other).sum::<f64>();
            let (joints_w, hand_w) = (power(torques, speeds), power(force_n, pose.velocity_m_per_s));
            assert!((joints_w - hand_w).abs() < 1e-12, "{settings:?}: {joints_w} W and {hand_w} W");
            assert!(!pose.is_singular(), "{settings:?}");
        }
    }
}

/// A paddle of 80 mm behind a capstan of 10: 8 mm a radian, so 4 N·m give 500 N; more is not asked for, in no other direction.
#[test]
fn no_motor_is_asked_for_more_than_it_may_give() {
    let capstan = mechanism(&CAPSTAN, 1).expect("it can be assembled");
    let pose = capstan.pose([0.5, 0.0, 0.0], [2.0, 0.0, 0.0]);
    assert!((pose.position_m[0] - 4e-3).abs() < 1e-15 && (pose.velocity_m_per_s[0] - 16e-3).abs() < 1e-15, "{pose:?}");
    assert!(
        (pose.weakest_n(4.0) - 500.0).abs() < 1e-9 && (pose.torques([900.0, 0.0, 0.0], 4.0)[0] - 4.0).abs() < 1e-12
    );
    let five_bar = mechanism(&FIVE_BAR, 2).expect("it can be assembled").pose([0.1, 0.2, 0.0], [0.0; AXES]);
    let [free, held] = [10.0, 0.05].map(|most_nm| five_bar.torques([3.0, 1.0, 0.0], most_nm));
    assert!(held.iter().all(|torque| torque.abs() <= 0.05), "{held:?}");
    assert!((free[0] * held[1] - free[1] * held[0]).abs() < 1e-12, "another direction: {free:?}, {held:?}");
}

#[test]
fn what_does_not_fit_is_refused_by_name() {
    for (settings, motors, words) in [
        (&ARM[..], 2, "2 motors are named, and this scene's mechanism (kinematics.model) has 3"),
        (&[], 1, "kinematics.model is \"direct\""),
    ] {
        let why = mechanism(settings, motors).err().expect("refused").to_string();
        assert!(why.contains(words), "{why}");
    }
}
