//! Motions of the shared object that have closed forms: let go on a contact, pushed against damping.
//!
//! What they are compared with, and why these: [the integrators](../../integrators/index.html). Unit: m, m/s, N, s.

use alloc::vec::Vec;

use cohold_core::contact::Contact;
use cohold_core::law::wave::Decode;
use cohold_core::num::{Motion, Scalar};
use cohold_core::object::{AnyIntegrator, IntegratorName};
use cohold_core::settings::Settings;

/// Length of every motion, s.
pub const DURATION_S: f64 = 0.5;
/// Where the object is let go, m.
pub const RELEASE_M: f64 = 0.005;
/// What it is pushed with, N.
pub const PUSH_N: f64 = 1.0;

/// A motion with a closed form.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Test {
    /// Let go on a damped contact.
    Contact,
    /// Let go on a contact without damping.
    Undamped,
    /// Pushed by a constant force, against damping.
    Push,
}

/// The settings of the object in a test, at a control period of `period_s` (s).
pub fn settings(test: Test, integrator: IntegratorName, period_s: f64) -> Settings {
    let mut settings = Settings::default();
    settings.timing.control_period_s = period_s;
    settings.object.integrator = integrator;
    settings.object.force_delay_ticks = 0.0;
    settings.coordination.decode = Decode::Implicit;
    match test {
        Test::Contact => {}
        Test::Undamped => settings.contact.damping_n_s_per_m = 0.0,
        Test::Push => settings.object.damping_n_s_per_m = 1.0,
    }
    settings
}

/// The test as core computes it in `S`, one motion each tick.
pub fn run<S: Scalar>(test: Test, settings: &Settings) -> Vec<Motion<S>> {
    let mut integrator = AnyIntegrator::<S>::build(settings).expect(crate::GOOD);
    let contact = Contact::<S>::build(settings);
    let mut object = match test {
        Test::Push => Motion::REST,
        _ => Motion::at(S::from_f64(RELEASE_M)),
    };
    let ticks = libm::round(DURATION_S / settings.timing.control_period_s) as usize;
    let push = S::from_f64(PUSH_N);
    let step = |_| {
        let before = object;
        object = match (&mut integrator, test) {
            (integrator, Test::Push) => integrator.step(object, push),
            // Contact and object in one solve, as a peer does it.
            (AnyIntegrator::Midpoint(midpoint, carries) | AnyIntegrator::BackwardEuler(midpoint, carries), _) => {
                let half = midpoint.half_change(object.velocity, contact.port(Motion::REST, object).port);
                midpoint.advance(carries, object, half)
            }
            (integrator, _) => integrator.step(object, contact.force(Motion::REST, object)),
        };
        before
    };
    (0..ticks).map(step).collect()
}
