//! Stroke: an elastic impact between racket and ball (Buttolo et al. 1997, equations 3 and 4).

/// A racket at the moment of impact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Racket {
    /// Mass that takes part in the impact, kg.
    pub mass_kg: f32,
    /// Velocity, m/s.
    pub velocity: [f32; 2],
    /// Where its face looks; its length does not matter.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn momentum_and_energy_stay() {
        for n in 0..10_000 {
            let wave = |k: f64| (f64::from(n) * k).sin() as f32;
            let racket = Racket {
                mass_kg: 0.2 + 0.1 * wave(0.9),
                velocity: [30.0 * wave(1.3), 9.0 * wave(2.1)],
                normal: [wave(0.4), wave(1.7)],
            };
            let (ball_kg, before) = (0.024, [40.0 * wave(3.1), 30.0 * wave(0.2)]);
            let Some(after) = racket.hit(ball_kg, before) else { continue };
            let impact = Impact::between(ball_kg, before, after);
            let [ball, mass] = [ball_kg, racket.mass_kg].map(f64::from);
            let square = |v: [f64; 2]| v[0] * v[0] + v[1] * v[1];
            let moved = [0, 1].map(|axis| f64::from(racket.velocity[axis]) + f64::from(impact.recoil_n_s[axis]) / mass);
            let energy =
                |ball_v: [f32; 2], racket_v: [f64; 2]| ball * square(ball_v.map(f64::from)) + mass * square(racket_v);
            let (first, last) = (energy(before, racket.velocity.map(f64::from)), energy(after, moved));
            assert!((last - first).abs() < 2e-5 * first, "{first} {last}");
            assert_eq!(impact.pulse_n(0.5), impact.recoil_n_s.map(|momentum| 2.0 * momentum));
        }
    }

    #[test]
    fn what_moves_apart_or_looks_nowhere_does_not_hit() {
        let racket = Racket { mass_kg: 1.0, velocity: [1.0, 0.0], normal: [1.0, 0.0] };
        assert_eq!(racket.hit(1.0, [2.0, 0.0]), None);
        assert_eq!(racket.hit(1.0, [0.0, 3.0]), Some([1.0, 3.0]));
        assert_eq!(Racket { normal: [0.0; 2], ..racket }.hit(1.0, [0.0; 2]), None);
        assert_eq!(Racket { velocity: [f32::NAN, 0.0], ..racket }.hit(1.0, [0.0; 2]), None);
    }
}
