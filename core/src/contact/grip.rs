//! What a spring does whose force is limited: its far end slips, so that it never holds more than it pushes with.
//!
//! A device pushes the object by a spring and a damper, F = K·y + B·ẏ with y = δ − e, where δ is how far the device is past the surface and e
//! the **slip**, 0 until a limit acts. The limits ([`crate::safety`]) allow an interval of forces around zero. Where the F that comes of the
//! tick's one solve lies outside, the force is the nearer end F̂ of that interval, for the object as for the device, the tick is solved again
//! with that constant, and the slip takes what is missing, in a row with spring and damper:
//!
//! > Δe = T_c·(F − F̂)/z,   z = K·T_c/2 + B   (THEORY §7)
//!
//! **Passive**: ½K·y² + the work on the object changes by T_c·B·ẏ·(ẋ_h − ẏ) − F̂·Δe, which is what it does without limits, less F̂·Δe. And
//! F̂·Δe ≥ 0, since the interval has zero in it: F̂ has the sign of F − F̂. A force that had to fall slowly would need the other sign.
//!
//! **Going back.** A slip would stay for good. What it took, Σ F̂·Δe, pays for its way back to 0, at [`BACK_M_PER_S`] and never beyond a
//! spring energy of ½K·y² + what is saved. So a spring that was cut by the largest force gives back what it took, like one that is soft from
//! there on, and one that was cut by the slew limit a part of it. Where the two can part, a device that goes out takes the slip along at
//! once and for nothing: e lies between 0 and δ, and y is 0 on that way.
//!
//! Units: m, N, J. State: zeros while no limit acts, and nothing else is computed then. No branch is on its numbers: a proof would have to
//! follow both ways of each.

use crate::num::Scalar;

/// How fast a slip goes back while it presses, m/s.
pub const BACK_M_PER_S: f64 = 0.05;

/// The slip of one spring.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Grip<S> {
    /// e, m.
    slip: S,
    /// What it may still give back, J.
    saved_j: S,
    /// It gave way, and whoever holds it has not made it firm since.
    loose: bool,
}

impl<S: Scalar> Grip<S> {
    /// Whether nothing has slipped since it was made.
    #[inline]
    pub fn is_firm(&self) -> bool {
        !self.loose
    }

    /// It is not firm from now on, although nothing has slipped.
    pub fn loosen(&mut self) {
        self.loose = true;
    }

    /// The slip e, m.
    #[inline]
    pub fn slip_m(&self) -> S {
        self.slip
    }

    /// Gives way to a force F of which the limits let `given` (N) through, by a spring and damper of this z, N·s/m; `missing` is F less `given`, N.
    #[inline]
    pub fn slide(&mut self, missing: S, given: S, impedance: S, period_s: S) {
        let slid = (period_s * missing).ratio(impedance);
        self.slip = self.slip + slid;
        self.saved_j = (self.saved_j + given * slid).max(S::ZERO);
        self.loose = true;
    }

    /// The device is so far past the surface (m): what it does not press into any more has not slipped.
    #[inline]
    pub fn part(&mut self, past: S) {
        self.slip = self.slip.max(past.min(S::ZERO)).min(past.max(S::ZERO));
    }

    /// A tick of the way back of a spring (N/m) whose device is so far past the surface, m.
    #[inline]
    pub fn recover(&mut self, past: S, stiffness: S, period_s: S) {
        let slip = self.slip;
        let depth = past - slip;
        let back = slip.limit(S::from_f64(BACK_M_PER_S) * period_s);
        // No rounding is beyond what presses already; a spring that stores nothing pays nothing, and stays.
        let paid_for = (depth * depth + (self.saved_j + self.saved_j).ratio(stiffness)).sqrt().max(depth.abs());
        let wanted = depth + back;
        let pressed = wanted.limit(paid_for);
        // Exactly 0 in the end.
        self.slip = (slip - back) + (wanted - pressed);
        let half_sum = S::from_f64(0.5) * (pressed + depth);
        let left_j = self.saved_j - stiffness * (pressed - depth) * half_sum;
        // More than the whole way could cost is not kept.
        let slipped = self.slip.abs();
        self.saved_j = left_j.max(S::ZERO).min(stiffness * slipped * (depth.abs() + slipped));
    }
}
