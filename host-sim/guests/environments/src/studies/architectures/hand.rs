//! A user where turns are taken: a hand and its copy of the body.
//!
//! Device and arm are one mass on one spring ([`Linear`]). Who waits reaches, open, for the body as it sees it, and grips when
//! it owns the body and has come to rest at it (`GRIP_M`, `GRIP_M_PER_S`), so that how it grips does not depend on when
//! the right comes; who carries reaches its share of the way and releases when it has rested for [`REST_S`].

use std::collections::VecDeque;

use cohold_core::{contact::Contact, num::Motion, object::AnyIntegrator};
use cohold_sim::{plant::Linear, scene::Scene, user::minimum_jerk};

use super::TASK;

/// A hand this close to the body grips it, m: at 1000 N/m with two tenths of a newton.
const GRIP_M: f64 = 2e-4;

/// If it is no faster than this, m/s.
const GRIP_M_PER_S: f64 = 0.02;

/// How long half of the way takes, and the way to the body, s.
const HALF_REACH_S: f64 = 0.5 * TASK.reach_s;

/// How long who carries rests before it lets go, s.
pub const REST_S: f64 = 0.8;

/// What a user has to do with the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum TaskState {
    /// Waits for the body.
    Waits,
    /// Carries it since this time, s.
    Carries(f64),
    Done,
}

/// Where an arm wants its hand: on the way from one place to another.
#[derive(Clone, Copy)]
struct Reach {
    since_s: f64,
    from_m: f64,
    to_m: f64,
}

impl Reach {
    /// Place (m) and speed (m/s) that are wanted.
    fn at(self, time_s: f64) -> (f64, f64) {
        let (travel_m, speed) = minimum_jerk(self.to_m - self.from_m, HALF_REACH_S, time_s - self.since_s);
        (self.from_m + travel_m, speed)
    }

    /// From where it has come by now to another place.
    fn turn(&mut self, time_s: f64, to_m: f64) {
        *self = Self { since_s: time_s, from_m: self.at(time_s).0, to_m };
    }
}

/// A user with its device and its copy.
pub(super) struct Hand {
    plant: Linear,
    stiffness: f64,
    damping: f64,
    device: Motion<f64>,
    reach: Reach,
    pub(super) body: Motion<f64>,
    contact: Contact<f64>,
    integrator: AnyIntegrator<f64>,
    pub(super) doing: TaskState,
    goal: f64,
    /// The official copy as last seen, m: what one has released stands until there is news.
    known: f64,
    /// Force on the body, N; the device feels its reaction late, as far as the scene says.
    pub(super) force: f64,
    /// What the device felt in the tick before, N, and what it holds back, of which the first acts next.
    felt: f64,
    waiting: VecDeque<f64>,
}

impl Hand {
    pub(super) fn new(scene: &Scene, index: usize, goal: f64) -> Self {
        let settings = &scene.peers()[index];
        let (device, period_s) = (&scene.world.device, settings.timing.control_period_s);
        let (stiffness, damping) = (TASK.arm_stiffness_n_per_m[index], TASK.arm_damping_n_s_per_m[index]);
        let mass = device.mass_kg + TASK.arm_mass_kg;
        let (waits, late) = device.delay();
        let integrator = AnyIntegrator::build(settings).expect("any integrator builds");
        Self {
            plant: Linear::new(mass, device.damping_n_s_per_m + damping, stiffness, late, period_s),
            stiffness,
            damping,
            device: Motion::REST,
            reach: Reach { since_s: 0.0, from_m: 0.0, to_m: 0.0 },
            body: Motion::REST,
            contact: Contact::build(settings),
            integrator,
            doing: TaskState::Waits,
            goal,
            known: 0.0,
            force: 0.0,
            felt: 0.0,
            waiting: VecDeque::from(vec![0.0; waits]),
        }
    }

    /// Whether the hand rests at a place, m.
    fn is_at(&self, place: f64) -> bool {
        (self.device.position - place).abs() < GRIP_M && self.device.velocity.abs() < GRIP_M_PER_S
    }

    /// One tick; true when the user lets go.
    pub(super) fn step(&mut self, time_s: f64, owns: bool, official: f64) -> bool {
        let mut lets_go = false;
        match self.doing {
            TaskState::Waits if owns && self.is_at(official) => {
                self.body = Motion::at(official);
                self.doing = TaskState::Carries(time_s);
                self.reach.turn(time_s, self.goal);
            }
            // Whoever has lost the right has to wait again.
            TaskState::Carries(_) if !owns => {
                self.body = Motion::at(official);
                self.doing = TaskState::Waits;
                self.reach.turn(time_s, official);
            }
            TaskState::Carries(since) if time_s - since > HALF_REACH_S + REST_S => {
                self.doing = TaskState::Done;
                self.body.velocity = 0.0;
                lets_go = true;
            }
            _ => {}
        }
        if official != self.known {
            self.known = official;
            if !matches!(self.doing, TaskState::Carries(_)) {
                self.body = Motion::at(official);
                self.reach.turn(time_s, official);
            }
        }
        let (wanted, speed) = self.reach.at(time_s);
        let pull = self.stiffness * wanted + self.damping * speed;
        self.force = 0.0;
        if matches!(self.doing, TaskState::Carries(_)) {
            self.force = self.contact.force(self.device, self.body);
            self.body = self.integrator.step(self.body, self.force);
        }
        self.waiting.push_back(self.force);
        let feels = self.waiting.pop_front().unwrap_or(self.force);
        self.device = self.plant.advance(self.device, pull - self.felt, pull - feels);
        self.felt = feels;
        lets_go
    }
}
