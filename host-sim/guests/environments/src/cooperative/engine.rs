//! The dynamics engine: one object, and what every user pushes it with.
//!
//! m_O·ẍ + (b_O + Σβ_i)·ẋ = ΣF_i: the newest force of each user stands until the next comes. The drags β_i that the bounders
//! ask for are taken implicitly, −Σβ·ẋ/(1 + Σβ·T/m_O), so that many users on a light object cannot overdo it.

use cohold_core::{num::Motion, object::AnyIntegrator, settings::Settings};

use super::MOST_USERS;

/// What one user does to the object.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Pushed {
    pub(super) force_n: f64,
    /// Drag for the user's sake.
    pub(super) drag_n_s_per_m: f64,
    /// When the client sent it, µs of its clock; 0: never.
    pub(super) sent_us: u64,
    /// When it came to the engine, µs of the engine's clock.
    pub(super) came_us: u64,
}

/// The object and who pushes it.
#[derive(Clone, Debug)]
pub(super) struct DynamicsEngine {
    integrator: AnyIntegrator<f64>,
    /// T_c/m_O, s/kg.
    gain: f64,
    pub(super) object: Motion<f64>,
    /// The newest of every user.
    pub(super) users: [Pushed; MOST_USERS],
}

impl DynamicsEngine {
    /// The scene's object at rest at the origin.
    pub(super) fn new(settings: &Settings) -> Self {
        let integrator = AnyIntegrator::build(settings).expect("any integrator builds");
        Self {
            integrator,
            gain: settings.timing.control_period_s / settings.object.mass_kg,
            object: Motion::REST,
            users: [Pushed::default(); MOST_USERS],
        }
    }

    /// Goes on from a motion that another engine handed over.
    pub(super) fn take_over(&mut self, object: Motion<f64>) {
        self.object = object;
        self.integrator.rest();
    }

    pub(super) fn step(&mut self) {
        let force: f64 = self.users.iter().map(|user| user.force_n).sum();
        let drag: f64 = self.users.iter().map(|user| user.drag_n_s_per_m).sum();
        let dragged = drag * self.object.velocity / (1.0 + drag * self.gain);
        self.object = self.integrator.step(self.object, force - dragged);
    }
}
