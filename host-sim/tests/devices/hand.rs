//! A hand that holds the handle of an emulated device, along each of its axes: a spring and a damper to where it wants to be, and the mass of both.

use std::time::Instant;

/// What moves with the hand, kg, and the hand: N/m, N·s/m.
pub(crate) const MASS_KG: f64 = 0.3;
pub(crate) const HAND_N_PER_M: f64 = 300.0;
pub(crate) const HAND_N_S_PER_M: f64 = 8.0;
/// Step of the mechanism, s.
pub(crate) const STEP_S: f64 = 50e-6;
/// How often a hand trembles, Hz.
const TREMOR_HZ: f64 = 1.0;
/// How long it takes to reach, s.
const REACH_S: f64 = 1.0;

pub(crate) struct Hand<const N: usize> {
    start: Instant,
    pub(crate) now_s: f64,
    pub(crate) position_m: [f64; N],
    pub(crate) velocity_m_per_s: [f64; N],
    /// How far it trembles along each axis until it reaches, m.
    tremor_m: f64,
    /// Where it reaches, m, from where, and since when, s.
    reach: Option<([f64; N], [f64; N], f64)>,
}

impl<const N: usize> Hand<N> {
    pub(crate) fn new(tremor_m: f64) -> Self {
        let (start, rest) = (Instant::now(), [0.0; N]);
        Self { start, now_s: 0.0, position_m: rest, velocity_m_per_s: rest, tremor_m, reach: None }
    }

    /// Since it began, s.
    pub(crate) fn time_s(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    /// Where it wants to be along an axis, m; a hand that reaches trembles no more.
    fn wanted(&self, axis: usize) -> f64 {
        let Some((to_m, from_m, since_s)) = self.reach else {
            return self.tremor_m * (std::f64::consts::TAU * TREMOR_HZ * self.now_s).sin();
        };
        let share = ((self.now_s - since_s) / REACH_S).clamp(0.0, 1.0);
        // Of least jerk.
        let gone = share.powi(3) * (10.0 - 15.0 * share + 6.0 * share * share);
        gone * to_m[axis] + (1.0 - gone) * from_m[axis]
    }

    /// It begins to reach there from where it wants to be.
    pub(crate) fn reach(&mut self, to_m: [f64; N]) {
        let from_m = std::array::from_fn(|axis| self.wanted(axis));
        self.reach = Some((to_m, from_m, self.time_s()));
    }

    /// A step under this force of the device, N, by semi-implicit Euler.
    pub(crate) fn step(&mut self, device_n: [f64; N]) {
        self.now_s += STEP_S;
        for (axis, device_n) in device_n.into_iter().enumerate() {
            let spring_n = HAND_N_PER_M * (self.wanted(axis) - self.position_m[axis]);
            let force_n = device_n + spring_n - HAND_N_S_PER_M * self.velocity_m_per_s[axis];
            self.velocity_m_per_s[axis] += STEP_S * force_n / MASS_KG;
            self.position_m[axis] += STEP_S * self.velocity_m_per_s[axis];
        }
    }
}
