//! Bounders: the game is made as slow as the network asks for (Buttolo et al. 1997, §3.2.1).
//!
//! **Adaptive dynamic bounder.** T is the longest round trip between any two. A ball no faster than length/T does not travel
//! more than the court's length in T; a hit ball has more than that to go before it leaves, so that whoever is next knows of
//! the hit while the ball is still in the court. A hit that changes the velocity by no more than 2·length/T moves the ball of
//! the others, who hear of it T/2 later, by no more than the length.
//!
//! **Adaptive user-motion bounder** (proposed there, not built): a damper on the user's hand, proportional to T. A user who
//! pushes with up to F ends at F/b; b = F·T/reach makes that reach/T, so that no hand moves farther than `reach` in T.
//!
//! Both are off while T is 0.

/// Longest round trips by and by: the longest of the last [`Self::SLOTS`] times [`Self::SLOT_US`].
#[derive(Clone, Copy, Debug, Default)]
pub struct RoundTrips {
    slots: [u32; Self::SLOTS],
    slot: u64,
}

impl RoundTrips {
    /// Times that are kept apart.
    pub const SLOTS: usize = 5;
    /// Length of one, µs.
    pub const SLOT_US: u64 = 2_000_000;

    /// A round trip that ended at `now`, µs.
    pub fn add(&mut self, now: u64, round_trip_us: u32) {
        let slot = now / Self::SLOT_US;
        let passed = slot.saturating_sub(self.slot).min(Self::SLOTS as u64);
        for _ in 0..passed {
            self.slots.rotate_right(1);
            if let Some(first) = self.slots.first_mut() {
                *first = 0;
            }
        }
        self.slot = self.slot.max(slot);
        if let Some(first) = self.slots.first_mut() {
            *first = round_trip_us.max(*first);
        }
    }

    /// The longest, µs; 0 while there is none.
    pub fn longest_us(&self) -> u32 {
        self.slots.iter().copied().max().unwrap_or(0)
    }
}

/// How fast a ball may become, and how much a hit may change it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BallBounds {
    /// Most speed, m/s.
    pub speed_m_per_s: f32,
    /// Most change of velocity in one hit, m/s.
    pub change_m_per_s: f32,
}

impl BallBounds {
    /// No bounds.
    pub const NONE: Self = Self { speed_m_per_s: f32::INFINITY, change_m_per_s: f32::INFINITY };

    /// Bounds for a court of this length and a round trip of this long; none for 0.
    pub fn new(length_m: f32, round_trip_us: u32) -> Self {
        if round_trip_us == 0 {
            return Self::NONE;
        }
        let speed_m_per_s = length_m / (round_trip_us as f32 * 1e-6);
        Self { speed_m_per_s, change_m_per_s: 2.0 * speed_m_per_s }
    }

    /// A new velocity within the bounds: first no farther from the old one, then no faster, by shortening. The speed counts
    /// more: where a bound that has just become lower leaves no room for both, the change is the larger one.
    pub fn limit(&self, before: [f32; 2], after: [f32; 2]) -> [f32; 2] {
        let change = shorten([after[0] - before[0], after[1] - before[1]], self.change_m_per_s);
        shorten([before[0] + change[0], before[1] + change[1]], self.speed_m_per_s)
    }
}

/// The damper on a user's hand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionBounder {
    /// Most force of a user, N.
    pub force_n: f32,
    /// How far a hand may move in a round trip, m.
    pub reach_m: f32,
}

impl MotionBounder {
    /// Damping to add to the hand, N·s/m: force = −damping·velocity.
    pub fn damping_n_s_per_m(&self, round_trip_us: u32) -> f32 {
        self.force_n * (round_trip_us as f32 * 1e-6) / self.reach_m
    }
}

/// The vector in the same direction, no longer than `most`; finite whatever its parts are, NaN aside.
fn shorten(vector: [f32; 2], most: f32) -> [f32; 2] {
    // The square of what is longer may be no number.
    let [x, y] = vector.map(|part| part.clamp(-LONGEST, LONGEST));
    let square = x * x + y * y;
    if square <= most * most {
        return [x, y];
    }
    // Shorter by a millionth, for what the root rounds.
    let scale = most / root(square) * (1.0 - 1e-6);
    [x * scale, y * scale]
}

/// No part of a vector counts as longer.
const LONGEST: f32 = 1e18;

/// Square root of a positive number to 2 ulp: Newton's from a guess that halves the exponent. Neither core nor this crate's
/// dependencies have one.
fn root(square: f32) -> f32 {
    let mut root = f32::from_bits((square.to_bits() >> 1) + 0x1fc0_0000);
    for _ in 0..4 {
        root = 0.5 * (root + square / root);
    }
    root
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_root_is_within_2_ulp() {
        for n in 0..200_000_u32 {
            let number = f32::from_bits(0x0080_0000 + n * 10_000);
            let exact = f64::from(number).sqrt();
            assert!(((f64::from(root(number)) - exact) / exact).abs() < 2.4e-7, "{number}");
        }
    }

    #[test]
    fn a_limited_velocity_is_within_both_bounds() {
        let bounds = BallBounds::new(9.75, 400_000);
        assert!((bounds.speed_m_per_s - 24.375).abs() < 1e-4);
        for n in 0..10_000 {
            let turn = |k: f64| ((f64::from(n) * k).sin() * 24.0 / 1.5) as f32;
            let (before, wish) = ([turn(1.1), turn(0.7)], [turn(0.3) * 5.0, turn(1.9) * 5.0]);
            let [x, y] = bounds.limit(before, wish).map(f64::from);
            let (dx, dy) = (x - f64::from(before[0]), y - f64::from(before[1]));
            assert!(x.hypot(y) <= 24.375 && dx.hypot(dy) <= 48.75 + 1e-3);
        }
        assert_eq!(BallBounds::new(9.75, 0).limit([1.0, 2.0], [500.0, 3.0]), [500.0, 3.0]);
        assert_eq!(bounds.limit([-10.0, 0.0], [10.0, 5.0]), [10.0, 5.0]);
        for huge in [1e30, -1e30, f32::MAX, f32::INFINITY] {
            let [x, y] = bounds.limit([1.0, -huge], [huge, 2.0]).map(f64::from);
            assert!(x.hypot(y) <= 24.375 && x.hypot(y) > 24.374, "{x} {y}");
        }
    }

    #[test]
    fn a_hand_moves_no_farther_than_its_reach_in_a_round_trip() {
        let bounder = MotionBounder { force_n: 60.0, reach_m: 2.0 };
        for (round_trip_us, mass_kg) in [(10_000, 0.1), (100_000, 1.0), (400_000, 3.0)] {
            let damping = f64::from(bounder.damping_n_s_per_m(round_trip_us));
            // Pushed for 20 s as hard as it goes: x = F/b·(t − τ·(1 − e^(−t/τ))), τ = m/b; the last round trip counts.
            let (force, tau) = (60.0, mass_kg / damping);
            let place = |t: f64| force / damping * (t - tau * (1.0 - (-t / tau).exp()));
            let moved = place(20.0) - place(20.0 - f64::from(round_trip_us) * 1e-6);
            assert!(moved <= 2.0 * (1.0 + 1e-6) && moved > 1.9, "{moved}");
        }
        assert_eq!(bounder.damping_n_s_per_m(0), 0.0);
    }

    #[test]
    fn the_longest_round_trip_is_forgotten_after_10_seconds() {
        let mut trips = RoundTrips::default();
        assert_eq!(trips.longest_us(), 0);
        trips.add(0, 300_000);
        for second in 1..20 {
            trips.add(second * 1_000_000, 50_000);
            assert_eq!(trips.longest_us(), if second < 10 { 300_000 } else { 50_000 }, "{second}");
        }
        trips.add(0, 70_000);
        trips.add(u64::MAX, 20_000);
        assert_eq!(trips.longest_us(), 20_000);
    }
}
