//! Planar five-bar linkage: two motors on a base, a proximal and a distal link each, one hand.
//!
//! ```text
//!                 P  hand                     y (axis 1, away from the base)
//!               ╱   ╲    distal links l₂      ↑
//!             ╱       ╲                       o→ x (axis 0, along the base), origin at the hand's home
//!     elbow E_a       E_b elbow
//!            ╲         ╱  proximal links l₁
//!             A───────B   motors, base apart
//! ```
//!
//! Design: both elbows outward, the hand on the far side of the line between the elbows (circle intersection). Joint a
//! is the left motor, b the right one, both counter-clockwise. At home (joints zero, where the encoders are first read) the proximal
//! links stand at `kinematics.left_home_rad` and `right_home_rad` from x, leaning outward: 120° and 60°, unless a lab says otherwise.
//!
//! Jacobian: the distal links are rigid, so with pᵢ = P − Eᵢ and tᵢ the direction in which elbow i turns, pᵢ·Ṗ =
//! l₁·(pᵢ·tᵢ)·q̇ᵢ; Cramer's rule solves the pair, with the determinant p_a × p_b = d·h (elbow distance times height).
//!
//! Units: joints rad, axes m, Jacobian m/rad.
//!
//! Limits: where the distal links are nearly in line, nearly parallel, or too short to meet (h or d/2 under
//! [`MIN_SINE`]·l₂, h² = l₂² − d²/4) the pose is singular: the Jacobian is zero, and with it the velocities and the
//! motor torques; the hand is taken to be no less than that height beyond the elbows' middle, which is finite and joins
//! the regular poses without a step. A non-finite joint gives a non-finite position and a zero Jacobian. With
//! `kinematics.maths = "micromath"` the hand is off by up to 1 mm per m of link in the middle of the workspace, and J
//! is the derivative only to 0.5 % of l₁.

use crate::device::kinematics::{Kinematics, Maths, Pose};
use crate::num::{Motion, Scalar};
use crate::settings::{Allowed, Refused, Settings};
use crate::{device::AXES, model::Model};

/// Angle between base and proximal links at home, rad: 60°.
pub const HOME_RAD: f64 = core::f64::consts::FRAC_PI_3;
/// Smallest sine (and cosine) of the angle between a distal link and the elbows' line; under it a pose is singular.
pub const MIN_SINE: f64 = 0.05;
/// Smallest sine of the angle between proximal and distal link that plausibility limits reckon with.
pub(crate) const MIN_ELBOW_SINE: f64 = 0.25;
/// Cosine of the distal links' angle at home, least and most that a geometry may have.
const HOME_COSINE: (f64, f64) = (0.2, 0.95);

/// Lengths of the linkage, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FiveBar<S> {
    maths: Maths,
    half_base: S,
    half_proximal: S,
    distal_squared: S,
    /// Least height of the hand over the elbows' line, and least half distance of the elbows, of a regular pose.
    margin: S,
    home_rad: [S; AXES],
    /// The hand at home, from the middle of the base.
    home: [S; AXES],
}

configured!([S: Scalar] FiveBar<S> { maths, half_base, half_proximal, distal_squared, margin, home_rad, home });

impl<S: Scalar> Model<S> for FiveBar<S> {
    type State = ();

    fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
        settings.within("axis.count", Allowed::Whole { min: 2, max: 2 })?;
        let [left, right] = [settings.kinematics.left_home_rad, settings.kinematics.right_home_rad];
        // The distal links meet at home with room to move. Half the elbows' distance there, along the base and across.
        let half_proximal = 0.5 * settings.kinematics.proximal_m;
        let along = 0.5 * settings.kinematics.base_m + half_proximal * (libm::cos(right) - libm::cos(left));
        let half_distance = libm::hypot(along, half_proximal * (libm::sin(right) - libm::sin(left)));
        let (least, most) = HOME_COSINE;
        let allowed = Allowed::Number { min: half_distance / most, max: half_distance / least };
        settings.within("kinematics.distal_m", allowed)?;

        let kinematics = &settings.kinematics;
        let mut five_bar = Self {
            maths: kinematics.maths,
            half_base: S::from_f64(0.5 * kinematics.base_m),
            half_proximal: S::from_f64(0.5 * kinematics.proximal_m),
            distal_squared: S::from_f64(kinematics.distal_m * kinematics.distal_m),
            margin: S::from_f64(MIN_SINE * kinematics.distal_m),
            home_rad: [S::from_f64(left), S::from_f64(right)],
            home: [S::ZERO; AXES],
        };
        // With the tick's own arithmetic, so that home is zero to the last bit.
        let [x, y] = five_bar.forward([Motion::REST; AXES]).axes;
        five_bar.home = [x.position, y.position];
        Ok(five_bar)
    }
}

impl<S: Scalar> Kinematics<S> for FiveBar<S> {
    fn forward(&self, joints: [Motion<S>; AXES]) -> Pose<S> {
        let ([a, b], [home_a, home_b], [home_x, home_y]) = (joints, self.home_rad, self.home);
        let (sin_a, cos_a) = self.maths.sin_cos(home_a + a.position);
        let (sin_b, cos_b) = self.maths.sin_cos(home_b + b.position);

        // Half of the way from elbow a to elbow b, and the middle between them, from the middle of the base.
        let (half_x, half_y) =
            (self.half_base + self.half_proximal * (cos_b - cos_a), self.half_proximal * (sin_b - sin_a));
        let (middle_x, middle_y) = (self.half_proximal * (cos_a + cos_b), self.half_proximal * (sin_a + sin_b));
        let half_squared = half_x * half_x + half_y * half_y;
        let half_distance = half_squared.sqrt();
        let height = (self.distal_squared - half_squared).sqrt();
        let regular = height > self.margin && half_distance > self.margin;
        let height = height.max(self.margin);

        // From the middle to the hand: a quarter turn left of the way from a to b; with the elbows together, away.
        let (up_x, up_y) = if half_distance > S::ZERO {
            let stretch = height.ratio(half_distance);
            (-(half_y * stretch), half_x * stretch)
        } else {
            (S::ZERO, height)
        };
        let position = [middle_x + up_x - home_x, middle_y + up_y - home_y];
        if !regular {
            return Pose::moving(position, [[S::ZERO; AXES]; AXES], joints);
        }
        // p_a and p_b, then l₁·(pᵢ·tᵢ)/(d·h).
        let (a_x, a_y, b_x, b_y) = (up_x + half_x, up_y + half_y, up_x - half_x, up_y - half_y);
        let scale = self.half_proximal.ratio(half_distance * height);
        let (turn_a, turn_b) = ((a_y * cos_a - a_x * sin_a) * scale, (b_y * cos_b - b_x * sin_b) * scale);
        Pose::moving(position, [[b_y * turn_a, -(a_y * turn_b)], [-(b_x * turn_a), a_x * turn_b]], joints)
    }
}
