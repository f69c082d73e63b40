//! Whether the links of a mechanism reach where a scene sends the hand, and if not, how far they do.
//!
//! The way there is followed from home in small steps, joint angles by Newton's method on the peer's own forward kinematics: a place counts as
//! reached if the mechanism can be assembled there, and moved every way. Units: m.

use cohold_core::device::kinematics::KinematicsName;
use cohold_core::num::Motion;
use cohold_core::settings::Settings;

use super::joints::Joints;
use crate::scene::PlantSettings;

/// Steps of a way.
const STEPS: u32 = 400;
/// How near Newton's method has to come, m.
const NEAR_M: f64 = 1e-9;

/// A way that leads beyond what links reach.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Beyond {
    /// The share of the way that they reach.
    pub(crate) share: f64,
    /// What is in the way at its end, as the end of a sentence.
    pub(crate) why: String,
}

/// What keeps a device's hand from going this way from home (m along each axis); none where nothing does, or there are no links.
pub(crate) fn beyond(settings: &Settings, plant: &PlantSettings, way_m: [f64; 3]) -> Option<Beyond> {
    let share = match settings.kinematics.model {
        KinematicsName::FiveBar => reached::<2>(settings, plant, [way_m[0], way_m[1]]),
        KinematicsName::Arm => reached::<3>(settings, plant, way_m),
        KinematicsName::Direct | KinematicsName::Capstan => 1.0,
    };
    (share < 1.0).then(|| Beyond { share, why: stretched(settings, way_m) })
}

fn reached<const N: usize>(settings: &Settings, plant: &PlantSettings, way_m: [f64; N]) -> f64 {
    let (joints, mut turned) = (Joints::new(settings, plant), [0.0; N]);
    for step in 1..=STEPS {
        let share = f64::from(step) / f64::from(STEPS);
        turned = joints.inverse_from(turned, way_m.map(|part| Motion::at(share * part)));
        let (hand, pose) = joints.at(turned);
        let off_m = hand.iter().zip(way_m).map(|(at, part)| (at - share * part).abs()).fold(0.0, f64::max);
        if pose.is_singular() || off_m.is_nan() || off_m >= NEAR_M {
            return f64::from(step - 1) / f64::from(STEPS);
        }
    }
    1.0
}

/// Which links would have to be longer.
fn stretched(settings: &Settings, [x, y, z]: [f64; 3]) -> String {
    let kinematics = &settings.kinematics;
    let long_m = kinematics.proximal_m + kinematics.distal_m;
    let said = |which: &str, needed_m: f64| {
        format!("the {which} would have to span {:.1} mm and is {:.1} mm long, stretched", 1e3 * needed_m, 1e3 * long_m)
    };
    if kinematics.model == KinematicsName::Arm {
        // From the shoulder, which is one link behind the hand at home and the other above it.
        let needed_m = x.hypot(y - kinematics.distal_m).hypot(z + kinematics.proximal_m);
        return if needed_m > long_m { said("arm", needed_m) } else { "the arm is nearly stretched or folded".into() };
    }
    let elbow = |side: f64, angle: f64| {
        let (sine, cosine) = angle.sin_cos();
        [side * 0.5 * kinematics.base_m + kinematics.proximal_m * cosine, kinematics.proximal_m * sine]
    };
    let [left, right] = [elbow(-1.0, kinematics.left_home_rad), elbow(1.0, kinematics.right_home_rad)];
    let half = [0.5 * (right[0] - left[0]), 0.5 * (right[1] - left[1])];
    let half_m = half[0].hypot(half[1]);
    let stretch = (kinematics.distal_m.powi(2) - half_m * half_m).max(0.0).sqrt() / half_m;
    let hand = [0.5 * (left[0] + right[0]) - half[1] * stretch + x, 0.5 * (left[1] + right[1]) + half[0] * stretch + y];
    let legs = [("left leg", -0.5), ("right leg", 0.5)]
        .map(|(which, side)| (which, (hand[0] - side * kinematics.base_m).hypot(hand[1])));
    let (which, needed_m) = legs.into_iter().fold(("", 0.0), |most, leg| if leg.1 > most.1 { leg } else { most });
    if needed_m > long_m { said(which, needed_m) } else { "two links are nearly in line".into() }
}
