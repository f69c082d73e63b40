//! Discretisation of ẋ = A·x + b·F for a force that is held.

use super::rows;
use crate::exponential::exponential;

/// A mass, damper and spring over one tick, with a force that may act late.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Held {
    /// Position and velocity after, for position and velocity before.
    pub motion: [[f64; 2]; 2],
    /// Position and velocity after, for the force of the tick before, per N.
    pub before: [f64; 2],
    /// Position and velocity after, for the force of this tick, per N.
    pub now: [f64; 2],
}

impl Held {
    /// Exact: the old force for `late` of the period, then the new one. Mass kg, damping N·s/m, stiffness N/m, period s.
    pub(crate) fn exact(mass: f64, damping: f64, stiffness: f64, late: f64, period: f64) -> Self {
        let over = |time: f64| {
            exponential(&rows([
                [0.0, time, 0.0],
                [-stiffness / mass * time, -damping / mass * time, time / mass],
                [0.0, 0.0, 0.0],
            ]))
        };
        let (first, second) = (over(late * period), over((1.0 - late) * period));
        let both = &second * &first;
        let carried = |i: usize| second[(i, 0)] * first[(0, 2)] + second[(i, 1)] * first[(1, 2)];
        Self {
            motion: [[both[(0, 0)], both[(0, 1)]], [both[(1, 0)], both[(1, 1)]]],
            before: [carried(0), carried(1)],
            now: [second[(0, 2)], second[(1, 2)]],
        }
    }

    /// Forward Euler: v⁺ = v + (T/m)·(F − b·v), x⁺ = x + T·v, with F = late·F_before + (1 − late)·F_now.
    pub(crate) fn forward_euler(mass: f64, damping: f64, late: f64, period: f64) -> Self {
        let gain = period / mass;
        Self {
            motion: [[1.0, period], [0.0, 1.0 - gain * damping]],
            before: [0.0, gain * late],
            now: [0.0, gain * (1.0 - late)],
        }
    }

    /// Semi-implicit Euler: the same velocity, and x⁺ = x + T·v⁺.
    pub(crate) fn semi_implicit(mass: f64, damping: f64, late: f64, period: f64) -> Self {
        let mut held = Self::forward_euler(mass, damping, late, period);
        held.motion[0][1] = period * held.motion[1][1];
        held.before[0] = period * held.before[1];
        held.now[0] = period * held.now[1];
        held
    }
}

#[test]
fn late_and_prompt_forces_add_up_to_a_held_one() {
    let (whole, split) = (Held::exact(0.2, 3.0, 80.0, 0.0, 1e-3), Held::exact(0.2, 3.0, 80.0, 0.37, 1e-3));
    for i in 0..2 {
        assert!((split.before[i] + split.now[i] - whole.now[i]).abs() < 1e-17);
        assert_eq!(whole.before[i], 0.0);
    }
}
