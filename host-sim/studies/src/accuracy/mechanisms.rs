//! Kinematics: which sine and which number type, over the workspace of the five-bar and of the capstan.
//!
//! The reference for the five-bar knows only that the distal links are rigid: |P − E_a| = |P − E_b| = l₂, solved by
//! Newton's method in double-double, and its Jacobian is a central difference of that, good to 20 digits. The capstan's is
//! the ratio r/N in double-double. Joints are whole 32nds of a radian, exact in every number type, so that only the
//! kinematics errs: the five-bar within half a radian of home (in steps of 1/32 rad), the capstan within 5 rad.
//!
//! Unit: m for the hand, m/rad for the Jacobian; largest errors. micromath exists for f32 only; the capstan needs no sine.

use cohold_core::device::kinematics::five_bar::HOME_RAD;
use cohold_core::device::kinematics::{AnyKinematics, KinematicsName, Maths, Pose};
use cohold_core::num::{Fixed, Motion, Scalar};
use cohold_core::settings::{Choice, Refused, Settings};
use cohold_report::significant;
use cohold_sim::double_double::DoubleDouble;

use super::{Comparison, Family, counts::Processor, largest};

pub use cohold_cases::workspace::{case, joints, settings};

/// Hand (m) and Jacobian (m/rad) of a pose.
pub type Truth = ([DoubleDouble; 2], [[DoubleDouble; 2]; 2]);

/// Where the five-bar's hand is, from the middle of its base.
fn hand(settings: &Settings, joints: [DoubleDouble; 2]) -> [DoubleDouble; 2] {
    let number = DoubleDouble::from_f64;
    let kinematics = &settings.kinematics;
    let half = number(0.5);
    let elbow = |home: f64, joint: DoubleDouble, side: f64| {
        let (sine, cosine) = (number(home) + joint).sin_cos();
        let proximal = number(kinematics.proximal_m);
        [number(side * kinematics.base_m) * half + proximal * cosine, proximal * sine]
    };
    let [a, b] = joints;
    let elbows = [elbow(std::f64::consts::PI - HOME_RAD, a, -1.0), elbow(HOME_RAD, b, 1.0)];
    let square = number(kinematics.distal_m) * number(kinematics.distal_m);
    // From above the elbows down to where both links reach: Newton's method doubles its digits with each step.
    let [left, right] = elbows;
    let mut at = [(left[0] + right[0]) * half, (left[1] + right[1]) * half + number(kinematics.distal_m)];
    for _ in 0..10 {
        let [from_a, from_b] = elbows.map(|elbow| [at[0] - elbow[0], at[1] - elbow[1]]);
        let [miss_a, miss_b] = [from_a, from_b].map(|link| (square - link[0] * link[0] - link[1] * link[1]) * half);
        let determinant = from_a[0] * from_b[1] - from_a[1] * from_b[0];
        at[0] = at[0] + (miss_a * from_b[1] - miss_b * from_a[1]).ratio(determinant);
        at[1] = at[1] + (miss_b * from_a[0] - miss_a * from_b[0]).ratio(determinant);
    }
    at
}

/// Hand and Jacobian at these joints, from home.
pub fn truth(settings: &Settings, joints: [f64; 2]) -> Truth {
    let number = DoubleDouble::from_f64;
    let kinematics = &settings.kinematics;
    if settings.kinematics.model != KinematicsName::FiveBar {
        let ratio = number(kinematics.paddle_radius_m).ratio(number(kinematics.capstan_ratio));
        let none = DoubleDouble::ZERO;
        return ([ratio * number(joints[0]), none], [[ratio, none], [none, none]]);
    }
    let at = |offset: [f64; 2]| hand(settings, [0, 1].map(|i| number(joints[i]) + number(offset[i])));
    let home = hand(settings, [DoubleDouble::ZERO; 2]);
    let here = at([0.0, 0.0]);
    // A billionth of a radian: curvature is lost at 1e-18, digits at 1e-21.
    let step = 1e-9;
    let slope = |up: [DoubleDouble; 2], down: [DoubleDouble; 2]| {
        [0, 1].map(|axis| (up[axis] - down[axis]).ratio(number(2.0 * step)))
    };
    let [of_a, of_b] = [slope(at([step, 0.0]), at([-step, 0.0])), slope(at([0.0, step]), at([0.0, -step]))];
    ([0, 1].map(|axis| here[axis] - home[axis]), [[of_a[0], of_b[0]], [of_a[1], of_b[1]]])
}

/// Largest errors of hand (m) and Jacobian (m/rad) over the workspace, in `S`.
pub fn errors<S: Scalar>(settings: &Settings, truths: &[([f64; 2], Truth)]) -> (f64, f64) {
    let kinematics = AnyKinematics::<S>::build(settings).expect("good settings");
    let errors = truths.iter().map(|(joints, (hand, jacobian))| {
        let pose: Pose<S> = kinematics.forward(joints.map(|joint| Motion::at(S::from_f64(joint))));
        // The difference is taken in twice the digits: f64 has an error, too.
        let miss = |got: S, want: DoubleDouble| (DoubleDouble::from_f64(got.to_f64()) - want).to_f64();
        let entry = |row: usize, column: usize| miss(pose.jacobian[row][column], jacobian[row][column]);
        let [x, y] = [0, 1].map(|axis: usize| miss(pose.axes[axis].position, hand[axis]));
        (x.hypot(y), largest([entry(0, 0), entry(0, 1), entry(1, 0), entry(1, 1)]))
    });
    let (hands, jacobians): (Vec<f64>, Vec<f64>) = errors.unzip();
    (largest(hands), largest(jacobians))
}

/// Measures every choice, with the instructions of this processor.
///
/// # Errors
/// The first key that is out of range or impossible beside the others.
pub fn measure(processor: Processor) -> Result<Family, Refused<'static>> {
    let mut comparisons = Vec::new();
    for model in [KinematicsName::FiveBar, KinematicsName::Capstan] {
        let libm = settings(model, Maths::Libm);
        let truths: Vec<_> = joints(model).into_iter().map(|joints| (joints, truth(&libm, joints))).collect();
        let exact = case(model, Maths::Libm);
        let named = |name: &str| {
            if model == KinematicsName::FiveBar { format!("{name}, libm") } else { name.to_owned() }
        };
        let mut measured = vec![
            (named("f32"), errors::<f32>(&libm, &truths), processor.count(&exact, "f32")),
            (named("f64"), errors::<f64>(&libm, &truths), processor.count(&exact, "f64")),
            (named("i32f32"), errors::<Fixed>(&libm, &truths), processor.count(&exact, "i32f32")),
        ];
        if model == KinematicsName::FiveBar {
            let fast = settings(model, Maths::Micromath);
            let count = processor.count(&case(model, Maths::Micromath), "f32");
            measured.insert(0, ("f32, micromath".to_owned(), errors::<f32>(&fast, &truths), count));
        }
        let title = model.name();
        comparisons.push(Comparison::of(title, "largest error of the hand", "m", &measured, |errors| errors.0));
        comparisons.push(Comparison::of(title, "largest error of J", "m/rad", &measured, |errors| errors.1));
    }
    let hand = &comparisons[0];
    let defaults = Settings::default();
    let count_m = std::f64::consts::TAU / defaults.encoder.counts_per_rev * defaults.kinematics.proximal_m;
    let insight = format!(
        "micromath puts the five-bar's hand off by up to {} m, {:.1} encoder counts at the end of a proximal link, in {} \
         instructions; libm takes {} in f32 and errs by {} m: use it, and f64 buys nothing that a device of 8192 counts \
         could show.",
        significant(hand.error_of("f32, micromath"), 2),
        hand.error_of("f32, micromath") / count_m,
        hand.instructions_of("f32, micromath"),
        hand.instructions_of("f32, libm"),
        significant(hand.error_of("f32, libm"), 2),
    );
    Ok(Family {
        name: "kinematics",
        title: "Kinematics: sine and number type",
        motion: "Every pose of the workspace: five-bar joints within 0.5 rad of home in steps of 1/32 rad (1089 poses), capstan \
                 motor within 5 rad (81 poses); default lengths"
            .to_owned(),
        reference: "loop closure by Newton's method in double-double, Jacobian by its central difference",
        instructions_per: "call of forward()",
        comparisons,
        headline: 0,
        insight,
    })
}
