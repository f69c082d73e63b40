//! Adaptive dynamic bounder: contact stiffness and damping follow the measured round trip (architectures paper §3.3).
//!
//! In a cooperative environment the object answers a push one round trip θ late. Until it does, a contact of stiffness K has
//! built up K·θ·ẋ too much force, which acts as negative damping: contact is stable up to about K = b/θ, with b the damping
//! present (THEORY §6, row 2.3). The object itself may be undamped, so the bounder adds damping to it at its dynamics engine,
//! where that acts without delay: for every user β = b, the damping of the device, or what K needs if that is less. Then
//!
//! > β = min(b, K·θ/m),   K' = min(K, m·β/θ),   B' = B·K'/K,   m = 0.8
//!
//! Up to θ = m·b/K the scene keeps its stiffness and only gains drag; beyond, stiffness falls with 1/θ. A β above b makes light
//! objects unstable again: their drag is then stiffer than the hand behind the spring. Found by eigenvalues, no proof:
//! `host-sim/guests/environments/tests/suite/cooperative.rs` looks at 1 to 16 users, devices of 0.05 to 0.5 kg and 0.2 to 5 N·s/m, objects of 0.05 to
//! 2 kg and round trips to 200 ms, and simulates round trips to 400 ms.
//!
//! **Following**: stiffness falls within [`FALL_S`] and rises within [`RISE_S`], from the stiffness for [`LONGEST_S`]
//! while nothing is measured. A spring that stiffens while compressed generates energy, so the force of a compressed
//! one rises by no more than [`GENTLE_N_PER_S`]. Units: s, N/m, N·s/m. A θ of NaN counts as [`LONGEST_S`].

use cohold_core::num::Scalar;

/// Share m of the stability limit b/θ that the bounder uses.
pub const MARGIN: f64 = 0.8;
/// Time constant of falling stiffness, s.
pub const FALL_S: f64 = 0.1;
/// Time constant of rising stiffness, s.
pub const RISE_S: f64 = 0.5;
/// How fast stiffening may raise the force of a pressed contact, N/s.
pub const GENTLE_N_PER_S: f64 = 5.0;
/// Round trip that is assumed before one is measured, s.
pub const LONGEST_S: f64 = 0.5;

/// Bounds on a contact for the measured round trip.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bound<S> {
    /// Largest contact stiffness K', N/m.
    pub stiffness: S,
    /// Largest contact damping B', N·s/m.
    pub damping: S,
    /// Damping β that the dynamics engine adds to the object for this user, N·s/m.
    pub drag: S,
}

/// Bounds contact stiffness and damping of one user by the measured round trip.
#[derive(Clone, Copy, Debug)]
pub struct Bounder<S> {
    stiffness: S,
    /// Ratio of damping to stiffness B/K, s.
    damping_s: S,
    device_damping: S,
    margin: S,
    /// T_c, s: the force is held that long.
    period: S,
    longest: S,
    fall: S,
    rise: S,
    /// What stiffening may add to the force in a tick, N.
    gentle: S,
}

impl<S: Scalar> Bounder<S> {
    /// For a contact of K (N/m) and B (N·s/m), a device with damping b (N·s/m) and the control period (s).
    pub fn new(stiffness: f64, damping: f64, device_damping: f64, period_s: f64) -> Self {
        let ratio = if stiffness > 0.0 { damping / stiffness } else { 0.0 };
        Self {
            stiffness: S::from_f64(stiffness),
            damping_s: S::from_f64(ratio),
            device_damping: S::from_f64(device_damping),
            margin: S::from_f64(MARGIN),
            period: S::from_f64(period_s),
            longest: S::from_f64(LONGEST_S),
            fall: S::from_f64(-libm::expm1(-period_s / FALL_S)),
            rise: S::from_f64(-libm::expm1(-period_s / RISE_S)),
            gentle: S::from_f64(GENTLE_N_PER_S * period_s),
        }
    }

    /// The bound for a constant round trip of `round_trip` seconds.
    pub fn bound(&self, round_trip: S) -> Bound<S> {
        let known = round_trip >= S::ZERO && round_trip < self.longest;
        let late = self.period + if known { round_trip } else { self.longest };
        let enough = (self.stiffness * late).ratio(self.margin);
        let drag = enough.min(self.device_damping);
        let stiffness = (self.margin * drag).ratio(late).min(self.stiffness);
        Bound { stiffness, damping: self.damping_s * stiffness, drag }
    }

    /// Advances the last tick's bound `now` by one tick and returns it, for the measured round trip (s; `None` while
    /// nothing is measured) and the depth `pressed` to which the contact is compressed (m).
    pub fn follow(&self, now: &mut Bound<S>, measured: Option<S>, pressed: S) -> Bound<S> {
        let target = self.bound(measured.unwrap_or(self.longest));
        if *now == Bound::default() {
            *now = target;
        }
        let toward = |now: S, target: S, pace: S| now + pace * (target - now);
        now.stiffness = if target.stiffness < now.stiffness {
            toward(now.stiffness, target.stiffness, self.fall)
        } else {
            let risen = toward(now.stiffness, target.stiffness, self.rise);
            let added = (risen - now.stiffness) * pressed.abs();
            if added > self.gentle { now.stiffness + self.gentle.ratio(pressed.abs()) } else { risen }
        };
        now.damping = self.damping_s * now.stiffness;
        // More drag soon, less as slowly as stiffness rises.
        now.drag = toward(now.drag, target.drag, if target.drag > now.drag { self.fall } else { self.rise });
        *now
    }
}
