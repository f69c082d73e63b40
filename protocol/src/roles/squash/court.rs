//! Court: where the ball is, any time after a hit, in closed form, so that everybody who knows the hit knows the flight.
//!
//! Plan view. The front wall is at x = length, the side walls at y = 0 and y = width; all three give the ball back without
//! loss. The back, x = 0, is open: there the ball leaves the court. Between hits nothing acts on it, so that its flight is a
//! straight line on a plane tiled with mirrored courts, folded back.
//!
//! m, s, m/s, f32; the same bits on every machine that rounds as IEEE 754 says (no square root, no other function).

use crate::bytes::layout;

/// The court, in m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Court {
    /// From the open back to the front wall.
    pub length_m: f32,
    /// Between the side walls.
    pub width_m: f32,
}

impl Court {
    /// An international singles court.
    pub const SINGLES: Self = Self { length_m: 9.75, width_m: 6.4 };
}

layout! {
    /// A ball.
    #[derive(Clone, Copy, Debug, Default, PartialEq)]
    pub struct Ball(16 bytes) {
        /// Where, m: from the back, from the first side.
        0 => position: [f32; 2],
        /// How fast, m/s.
        8 => velocity: [f32; 2],
    }
}

impl Court {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_flight_is_what_small_steps_make() {
        let court = Court::SINGLES;
        for (vx, vy) in [(20.0, 3.0), (30.0, -25.0), (8.0, 40.0), (-4.0, 11.0)] {
            let start = Ball { position: [4.0, 2.0], velocity: [vx, vy] };
            // Second method: step by step in f64, turning at the walls.
            let ([mut x, mut y], [mut u, mut w]) = ([4.0_f64, 2.0], [f64::from(vx), f64::from(vy)]);
            let step = 1e-5;
            for n in 1..200_000 {
                x += u * step;
                y += w * step;
                if x < 0.0 {
                    let left = f64::from(court.leaves_s(&start));
                    assert!((left - f64::from(n) * step).abs() < 2e-5, "{left}");
                    break;
                }
                for (at, speed, wall) in [(&mut x, &mut u, court.length_m), (&mut y, &mut w, court.width_m)] {
                    let wall = f64::from(wall);
                    if *at > wall || (*at < 0.0 && wall < 7.0) {
                        *at = if *at > wall { 2.0 * wall - *at } else { -*at };
                        *speed = -*speed;
                    }
                }
                if n % 997 == 0 {
                    let ball = court.flight(&start, (f64::from(n) * step) as f32);
                    let error = (f64::from(ball.position[0]) - x).abs() + (f64::from(ball.position[1]) - y).abs();
                    assert!(error < 1e-4, "{error}");
                }
            }
        }
    }

    #[test]
    fn the_ball_is_always_inside() {
        let court = Court::SINGLES;
        let numbers = [f32::NAN, f32::INFINITY, -1e30, -3.0, -0.0, 1e-30, 5.0, 1e30];
        for x in numbers {
            for v in numbers {
                for t in numbers {
                    let Ball { position: [x, y], .. } = court.flight(&Ball { position: [x, v], velocity: [v, x] }, t);
                    assert!((0.0..=9.75).contains(&x) && (0.0..=6.4).contains(&y), "{x} {y}");
                }
            }
        }
    }
}
