//! Integrators of the shared object, each against the closed form of a motion.
//!
//! - *contact*: the object, 0.3 kg, let go 5 mm off its rest on a contact of 1000 N/m and 2 N·s/m with a device that
//!   stands still: m·ẍ + B·ẋ + K·x = 0, a damped oscillation of 9 Hz. The force is what the peer computes: sampled each
//!   tick, then held. That hold is in no closed form, and an integrator that is exact for held forces cannot mend it. The
//!   midpoint rule holds nothing, nor does backward Euler: contact and object are one solve.
//! - *energy*: the same without damping, where nothing may be gained or lost.
//! - *push*: the object with 1 N·s/m of damping under 1 N from rest: m·ẍ + b·ẋ = F. The force is constant, so only the
//!   integrator errs.
//!
//! Half a second at T_c = 1 ms without force delay, in f32. Unit: m, m/s; energy as a fraction of what there was.

use cohold_cases::contact::{PUSH_N, RELEASE_M};
use cohold_core::num::{Motion, Scalar};
use cohold_core::object::IntegratorName;
use cohold_core::settings::{Choice, Refused, Settings};
use cohold_report::significant;

use super::{Comparison, Family, counts::Processor, largest, rms};

pub use cohold_cases::contact::{Test, run, settings};

/// Position (m) and velocity (m/s) at `time_s`, in closed form.
pub fn closed_form(test: Test, settings: &Settings, time_s: f64) -> Motion<f64> {
    let (contact, object) = (&settings.contact, &settings.object);
    if test == Test::Push {
        let (damping, rate) = (object.damping_n_s_per_m, object.damping_n_s_per_m / object.mass_kg);
        let reached = -(-rate * time_s).exp_m1();
        let velocity = PUSH_N / damping * reached;
        return Motion::new(PUSH_N / damping * (time_s - reached / rate), velocity);
    }
    // x = x₀·e^(−σt)·(cos ωt + σ/ω·sin ωt), ẋ = −x₀·e^(−σt)·ω₀²/ω·sin ωt.
    let decay = 0.5 * contact.damping_n_s_per_m / object.mass_kg;
    let square = contact.stiffness_n_per_m / object.mass_kg;
    let angular = (square - decay * decay).sqrt();
    let (sine, cosine) = (angular * time_s).sin_cos();
    let left = RELEASE_M * (-decay * time_s).exp();
    Motion::new(left * (cosine + decay / angular * sine), -left * square / angular * sine)
}

/// RMS errors of position (m) and velocity (m/s) against the closed form.
pub fn errors<S: Scalar>(test: Test, integrator: IntegratorName, period_s: f64) -> (f64, f64) {
    let settings = settings(test, integrator, period_s);
    let run = run::<S>(test, &settings);
    let (positions, velocities): (Vec<f64>, Vec<f64>) = run
        .iter()
        .enumerate()
        .map(|(tick, got)| {
            let want = closed_form(test, &settings, tick as f64 * period_s);
            (got.position.to_f64() - want.position, got.velocity.to_f64() - want.velocity)
        })
        .unzip();
    (rms(positions), rms(velocities))
}

/// Largest change of ½·m·ẋ² + ½·K·x² without damping, as a fraction of what there was.
pub fn energy_error<S: Scalar>(integrator: IntegratorName, period_s: f64) -> f64 {
    let settings = settings(Test::Undamped, integrator, period_s);
    let energy = |motion: &Motion<S>| {
        let (x, v) = (motion.position.to_f64(), motion.velocity.to_f64());
        settings.object.mass_kg * v * v + settings.contact.stiffness_n_per_m * x * x
    };
    let run = run::<S>(Test::Undamped, &settings);
    let start = run.first().map_or(f64::NAN, energy);
    largest(run.iter().map(|motion| energy(motion) / start - 1.0))
}

pub(super) fn measure(processor: Processor) -> Result<Family, Refused<'static>> {
    let compare = |title: &str, error: &str, unit, measure: &dyn Fn(IntegratorName) -> f64| {
        let points = IntegratorName::ALL.iter().map(|&integrator| {
            let count = processor.count(&format!("integrator/{}", integrator.name()), "f32");
            (integrator.name().to_owned(), measure(integrator), count)
        });
        Comparison::new(title, error, unit, points.collect())
    };
    let (position, velocity) = ("RMS position error", "RMS velocity error");
    let comparisons = vec![
        compare("contact", position, "m", &|name| errors::<f32>(Test::Contact, name, 1e-3).0),
        compare("contact", velocity, "m/s", &|name| errors::<f32>(Test::Contact, name, 1e-3).1),
        compare("contact without damping", "largest energy error", "1", &|name| energy_error::<f32>(name, 1e-3)),
        compare("push against damping", position, "m", &|name| errors::<f32>(Test::Push, name, 1e-3).0),
    ];
    let (energy, push) = (&comparisons[2], &comparisons[3]);
    let percent = |name| format!("{:.0} %", 100.0 * energy.error_of(name));
    let insight = format!(
        "A sampled contact decides, not the formula: in half a second without damping forward Euler changes the energy by {}, \
         the exact integrator still by {}, semi-implicit only wobbles by {}; exact pays where forces are smooth and the \
         object is damped ({} m against {} m). The midpoint rule solves contact and object at once and changes it by {}: take it \
         wherever the object may be let go of. Backward Euler, which solves so for forces as the tick ends, takes {} of it here: it is for \
         springs that are too stiff for the tick.",
        percent("forward-euler"),
        percent("exact"),
        percent("semi-implicit"),
        significant(push.error_of("exact"), 2),
        significant(push.error_of("semi-implicit"), 2),
        significant(energy.error_of("midpoint"), 1),
        percent("backward-euler"),
    );
    Ok(Family {
        name: "integrator",
        title: "Integrator of the shared object",
        motion: "0.3 kg let go 5 mm off rest on a contact of 1000 N/m, 2 N·s/m (and 0); pushed by 1 N against \
                 1 N·s/m; 0.5 s at 1 kHz, no force delay, f32"
            .to_owned(),
        reference: "closed forms of a damped oscillation and of a damped mass under a constant force",
        instructions_per: "call of step()",
        comparisons,
        headline: 0,
        insight,
    })
}
