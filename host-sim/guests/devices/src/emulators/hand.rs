//! A hand that holds the handle of an emulated device, along each of its axes: a spring and a damper to where it wants to be, and the mass of both.
//! It trembles, reaches when told, or does a [`Task`] that somebody has given it.

use std::time::Instant;

/// Stiffness of the hand unless it is told another, N/m.
pub const HAND_N_PER_M: f64 = 300.0;
/// Step of the mechanism, s.
pub const STEP_S: f64 = 50e-6;
/// How often a hand trembles, Hz.
const TREMOR_HZ: f64 = 1.0;
/// How long it takes to reach, s.
const REACH_S: f64 = 1.0;

/// The hand as it is held: kg, N/m, N·s/m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grip {
    /// What moves with the hand, kg.
    pub mass_kg: f64,
    /// The hand's spring, N/m.
    pub stiffness_n_per_m: f64,
    /// The hand's damper, N·s/m.
    pub damping_n_s_per_m: f64,
}

impl Default for Grip {
    fn default() -> Self {
        Self { mass_kg: 0.3, stiffness_n_per_m: HAND_N_PER_M, damping_n_s_per_m: 8.0 }
    }
}

/// What a hand does by itself from when it begins.
pub trait Task: Send {
    /// Force along each of three axes at this time, N: its pushes, and what its spring and damper give toward where it wants to be.
    fn force_n(&self, time_s: f64) -> [f64; 3];

    /// Whether it presses the grip's first button then.
    fn presses(&self, time_s: f64) -> bool;
}

/// A task, and when it begins.
struct Begun {
    task: Box<dyn Task>,
    /// How long the hand rests once somebody has spoken to the device, s.
    rest_s: f64,
    /// When it begins, s; none before that.
    at_s: Option<f64>,
}

/// A hand on a handle that moves along `N` axes.
pub struct Hand<const N: usize> {
    start: Instant,
    grip: Grip,
    /// When the mechanism was last advanced to, s.
    pub now_s: f64,
    /// Where the handle is then, m.
    pub position_m: [f64; N],
    /// How fast it is then, m/s.
    pub velocity_m_per_s: [f64; N],
    /// How far it trembles along each axis until it reaches, m.
    tremor_m: f64,
    /// Where it reaches, m, from where, and since when, s.
    reach: Option<([f64; N], [f64; N], f64)>,
    does: Option<Begun>,
}

impl<const N: usize> Hand<N> {
    /// One that trembles by so much along each axis until it reaches, m.
    pub fn new(tremor_m: f64) -> Self {
        let (start, rest) = (Instant::now(), [0.0; N]);
        let (position_m, velocity_m_per_s) = (rest, rest);
        let grip = Grip::default();
        Self { start, grip, now_s: 0.0, position_m, velocity_m_per_s, tremor_m, reach: None, does: None }
    }

    /// One that holds like this and does this, once so much time, s, has gone since somebody first spoke to the device.
    pub fn of(grip: Grip, rest_s: f64, task: Box<dyn Task>) -> Self {
        Self { grip, does: Some(Begun { task, rest_s, at_s: None }), ..Self::new(0.0) }
    }

    /// Since it began, s.
    pub fn time_s(&self) -> f64 {
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
    pub fn reach(&mut self, to_m: [f64; N]) {
        let from_m = std::array::from_fn(|axis| self.wanted(axis));
        self.reach = Some((to_m, from_m, self.time_s()));
    }

    /// Somebody speaks to the device: a hand that has a task rests for its time, and begins.
    pub(crate) fn wake(&mut self) {
        let now_s = self.time_s();
        if let Some(does) = &mut self.does {
            does.at_s.get_or_insert(now_s + does.rest_s);
        }
    }

    /// The task, and since when it is done, s; none while it is not.
    fn doing(&self) -> Option<(&dyn Task, f64)> {
        let does = self.does.as_ref()?;
        Some((&*does.task, self.now_s - does.at_s?)).filter(|(_, since_s)| *since_s >= 0.0)
    }

    pub(crate) fn presses(&self) -> bool {
        self.doing().is_some_and(|(task, since_s)| task.presses(since_s))
    }

    /// A step under this force of the device, N, by semi-implicit Euler.
    pub fn step(&mut self, device_n: [f64; N]) {
        let doing_n = self.doing().map_or([0.0; 3], |(task, since_s)| task.force_n(since_s));
        self.now_s += STEP_S;
        let Grip { mass_kg, stiffness_n_per_m, damping_n_s_per_m } = self.grip;
        for (axis, device_n) in device_n.into_iter().enumerate() {
            let spring_n = stiffness_n_per_m * (self.wanted(axis) - self.position_m[axis]);
            let force_n = device_n + doing_n[axis] + spring_n - damping_n_s_per_m * self.velocity_m_per_s[axis];
            self.velocity_m_per_s[axis] += STEP_S * force_n / mass_kg;
            self.position_m[axis] += STEP_S * self.velocity_m_per_s[axis];
        }
    }
}
