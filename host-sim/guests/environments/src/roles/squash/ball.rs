//! The ball: where it is any time after a hit, in closed form, so that everybody who knows the hit knows the flight; what a hit does;
//! how fast it may be.
//!
//! Plan view. The front wall is at x = length, the side walls at y = 0 and y = width; all three give the ball back without
//! loss. The back, x = 0, is open: there the ball leaves the court. Between hits nothing acts on it, so that its flight is a
//! straight line on a plane tiled with mirrored courts, folded back.
//!
//! m, s, m/s, f32; the same bits on every machine that rounds as IEEE 754 says (the flight takes no function at all).
//!
//! **Bounders** make the game as slow as the network asks for (Buttolo et al. 1997, §3.2.1).
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

use cohold_protocol::bytes::layout;

/// The court, in m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Court {
    /// From the open back to the front wall.
    pub length_m: f32,
    /// Between the side walls.
    pub width_m: f32,
}

layout! {
    /// Position and velocity of a ball in the court.
    pub struct Ball(16 bytes) {
        0 => position: [f32; 2], "Where, m: from the back, from the first side.";
        8 => velocity: [f32; 2], "How fast, m/s.";
    }
}

impl Court {
    /// An international singles court.
    pub const SINGLES: Self = Self { length_m: 9.75, width_m: 6.4 };

    /// The ball `after_s` seconds after it was `ball`. Once it has left it rests where it left; before the beginning it is
    /// where it began. A ball outside of the court is first put to the nearest place inside.
    pub fn flight(&self, ball: &Ball, after_s: f32) -> Ball {
        let [x, y] = self.inside(ball.position);
        let [vx, vy] = ball.velocity;
        let leaves_s = self.leaves_s(ball);
        let gone = after_s >= leaves_s;
        let after_s = if after_s > 0.0 { after_s.min(leaves_s) } else { 0.0 };
        let (x, vx) = fold(x + vx * after_s, vx, self.length_m);
        let (y, vy) = fold(y + vy * after_s, vy, self.width_m);
        if gone {
            Ball { position: self.inside([0.0, y]), velocity: [0.0; 2] }
        } else {
            Ball { position: self.inside([x, y]), velocity: [vx, vy] }
        }
    }

    /// When the ball leaves the court at its back, s; infinite if it never does.
    pub fn leaves_s(&self, ball: &Ball) -> f32 {
        let ([x, _], vx) = (self.inside(ball.position), ball.velocity[0]);
        if vx > 0.0 {
            (2.0 * self.length_m - x) / vx
        } else if vx < 0.0 {
            -x / vx
        } else {
            f32::INFINITY
        }
    }

    /// The place inside that is nearest.
    pub fn inside(&self, [x, y]: [f32; 2]) -> [f32; 2] {
        // `max` and `min` give the number where the other is none.
        [x.max(0.0).min(self.length_m), y.max(0.0).min(self.width_m)]
    }
}

/// A coordinate on the tiled line, folded back between 0 and `wall`; the velocity turns with it.
fn fold(at: f32, velocity: f32, wall: f32) -> (f32, f32) {
    let around = at % (2.0 * wall);
    let around = if around < 0.0 { around + 2.0 * wall } else { around };
    if around > wall { (2.0 * wall - around, -velocity) } else { (around, velocity) }
}

/// A racket at the moment of an elastic impact with a ball (Buttolo et al. 1997, equations 3 and 4).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Racket {
    /// Mass that takes part in the impact, kg.
    pub mass_kg: f32,
    /// Velocity of the racket, m/s.
    pub velocity: [f32; 2],
    /// Normal of the racket's face; its length does not matter.
    pub normal: [f32; 2],
}

/// What an impact does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impact {
    /// The ball's velocity after it, m/s.
    pub velocity: [f32; 2],
    /// Momentum that the racket takes up, N·s: −m·Δv of the ball. As a pulse over a tick of T: force = momentum/T.
    pub recoil_n_s: [f32; 2],
}

impl Racket {
    /// Momentum and kinetic energy are the same before and after; along the face nothing happens. `None` if the two move
    /// apart, or the face looks nowhere.
    pub fn hit(&self, ball_kg: f32, ball: [f32; 2]) -> Option<[f32; 2]> {
        let [nx, ny] = self.normal;
        let square = nx * nx + ny * ny;
        let closing = (self.velocity[0] - ball[0]) * nx + (self.velocity[1] - ball[1]) * ny;
        let push = 2.0 * self.mass_kg / (self.mass_kg + ball_kg) * closing / square;
        // Written so that what is not a number is no hit.
        if !(square > 0.0 && closing > 0.0 && square.is_finite() && push.is_finite()) {
            return None;
        }
        Some([ball[0] + push * nx, ball[1] + push * ny])
    }
}

impl Impact {
    /// The impact that changes a ball's velocity from one to another.
    pub fn between(ball_kg: f32, before: [f32; 2], after: [f32; 2]) -> Self {
        Self {
            velocity: after,
            recoil_n_s: [0, 1].map(|axis: usize| match (before.get(axis), after.get(axis)) {
                (Some(before), Some(after)) => -ball_kg * (after - before),
                _ => 0.0,
            }),
        }
    }

    /// The force that a device renders for one tick, N.
    pub fn pulse_n(&self, tick_s: f32) -> [f32; 2] {
        self.recoil_n_s.map(|momentum| momentum / tick_s)
    }
}

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
            let [first, ..] = &mut self.slots;
            *first = 0;
        }
        self.slot = self.slot.max(slot);
        let [first, ..] = &mut self.slots;
        *first = round_trip_us.max(*first);
    }

    /// The longest, µs; 0 while there is none.
    pub fn longest_us(&self) -> u32 {
        self.slots.iter().copied().max().unwrap_or(0)
    }
}

/// How fast a ball may become, and how much a hit may change it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BallBounds {
    /// Largest speed of the ball, m/s.
    pub speed_m_per_s: f32,
    /// Largest change of the ball's velocity in one hit, m/s.
    pub change_m_per_s: f32,
}

impl BallBounds {
    /// Bounds that allow any speed and any hit.
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
#[path = "../../../tests/inside/squash_ball.rs"]
mod tests;
