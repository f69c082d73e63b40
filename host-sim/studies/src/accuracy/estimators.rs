//! Velocity estimators: a hand's reach with tremor, read through an encoder, against its true velocity.
//!
//! The motion is that of `scenes/person-reach.toml`: a minimum-jerk reach of 50 mm in one second with a tremor of 0.1 mm at
//! 9 Hz, which goes on for another second. The encoder rounds it down to whole counts, 20 000 to 2²⁴ of them to the metre;
//! core's own encoder turns counts into positions and core's estimators those into velocities, in f32.
//!
//! `measured` needs a sensor that has a velocity. An encoder has none, so it reads zero, and its error is the velocity
//! itself: what any estimator must beat. `filtered` is shown at its default cutoff and at the best of `CUTOFFS_HZ` for the
//! resolution, which costs the same.
//!
//! Unit: m/s, root of the mean square over 2 s.

use cohold_core::device::velocity::{AnyVelocity, VelocityName};
use cohold_core::num::{Motion, Scalar};
use cohold_core::settings::{Choice, Refused, Settings};
use cohold_report::significant;

use super::{Comparison, Family, counts::Processor, rms};

pub use cohold_cases::reach::{RESOLUTIONS, case, readings, settings};

/// Cutoffs tried for the best one, Hz: whole steps of a tenth of a decade.
const CUTOFFS_HZ: [f64; 18] =
    [8.0, 10.0, 12.5, 16.0, 20.0, 25.0, 31.5, 40.0, 50.0, 63.0, 80.0, 100.0, 125.0, 160.0, 200.0, 250.0, 315.0, 400.0];
/// RMS error of the velocity, m/s.
pub fn error<S: Scalar>(settings: &Settings) -> f64 {
    let readings = readings::<S>(settings);
    let mut estimator = AnyVelocity::<S>::build(settings).expect("good settings");
    let start = readings.first().map_or(0.0, |(_, velocity)| *velocity);
    estimator.start(Motion::new(S::ZERO, S::from_f64(start)));
    rms(readings.iter().map(|(reading, velocity)| estimator.step(*reading).to_f64() - velocity))
}

/// The cutoff of `CUTOFFS_HZ` with the least error, Hz, and that error, m/s.
fn best_cutoff(counts_per_m: f64) -> (f64, f64) {
    let tried = CUTOFFS_HZ.map(|cutoff| {
        let mut settings = settings(VelocityName::Filtered, counts_per_m);
        settings.axis.velocity_cutoff_hz = cutoff;
        (cutoff, error::<f32>(&settings))
    });
    tried.into_iter().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((f64::NAN, f64::NAN))
}

pub(super) fn measure(processor: Processor) -> Result<Family, Refused<'static>> {
    let mut comparisons = Vec::new();
    let mut advice = Vec::new();
    for resolution in RESOLUTIONS {
        let mut measured = Vec::new();
        for &velocity in VelocityName::ALL {
            let count = processor.count(&case(velocity, resolution), "f32");
            measured.push((velocity.name().to_owned(), error::<f32>(&settings(velocity, resolution)), count));
            if velocity == VelocityName::Filtered {
                let (cutoff, error) = best_cutoff(resolution);
                measured.push((format!("filtered, {cutoff:.0} Hz"), error, count));
                advice.push((resolution, cutoff));
            }
        }
        let title = format!("{} counts/m ({} µm)", resolution, significant(1e6 / resolution, 2));
        comparisons.push(Comparison::new(title, "RMS velocity error", "m/s", measured));
    }
    let [coarse, _, usual, fine] = &comparisons[..] else { unreachable!("one comparison for each resolution") };
    let number = |comparison: &Comparison, name| significant(comparison.error_of(name), 2);
    let cutoffs: Vec<String> =
        advice.iter().map(|(resolution, cutoff)| format!("{cutoff} Hz at {resolution}")).collect();
    let insight = format!(
        "At 50 µm a count the plain difference errs by {} m/s, filtered (100 Hz) by {}, adaptive by {}; at 5 µm by {}, {} and \
         {}; at 24 bit/m the difference wins with {}. Set the filter to the encoder ({} counts/m) before paying \
         {} instructions for adaptive windows instead of {}.",
        number(coarse, "difference"),
        number(coarse, "filtered"),
        number(coarse, "adaptive"),
        number(usual, "difference"),
        number(usual, "filtered"),
        number(usual, "adaptive"),
        number(fine, "difference"),
        cutoffs.join(", "),
        usual.instructions_of("adaptive"),
        usual.instructions_of("filtered"),
    );
    Ok(Family {
        name: "velocity",
        title: "Velocity from an encoder",
        motion:
            "Minimum-jerk reach of 50 mm in 1 s with a tremor of 0.1 mm at 9 Hz, which goes on for 1 s more; 1 kHz, f32; measured reads 0, an encoder has no velocity"
                .to_owned(),
        reference: "the true velocity of the motion",
        instructions_per: "call of step()",
        comparisons,
        headline: 2,
        insight,
    })
}
