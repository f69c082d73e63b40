//! The whole peer: integrator, decode and control rate together.
//!
//! What a user pays for is a millisecond of control, so a peer that ticks twice as often costs twice as much: this is
//! where a better scheme and a faster one can be weighed against each other. Run in f32, against continuous control
//! ([`super::continuous`]). Unit: m, N; instructions per millisecond of one peer.

use haptic_core::settings::{Choice, Refused};
use haptic_core::{law::wave::Decode, object::IntegratorName};
use haptic_report::significant;
use rayon::prelude::*;

use super::pair::{self, Deviation, deviation};
use super::{Comparison, Family, continuous, counts::Processor};

/// Control rates, ticks each millisecond.
const RATES: [u32; 4] = [1, 2, 4, 8];

pub(super) fn measure(processor: Processor) -> Result<Family, Refused<'static>> {
    let exact = continuous::run(&pair::scene(IntegratorName::Exact, Decode::Implicit, 1), pair::DURATION_S);
    let schemes: Vec<_> = IntegratorName::ALL
        .iter()
        .flat_map(|&integrator| Decode::ALL.iter().map(move |&decode| (integrator, decode)))
        // One solve decodes, or it is none.
        .filter(|scheme| !(scheme.0.solves() && scheme.1 == Decode::Delayed))
        .flat_map(|(integrator, decode)| RATES.map(|ticks_per_ms| (integrator, decode, ticks_per_ms)))
        .collect();
    let measured = schemes
        .into_par_iter()
        .map(|(integrator, decode, ticks_per_ms)| {
            let run = pair::run::<f32>(&pair::scene(integrator, decode, ticks_per_ms), pair::DURATION_S)?;
            let (by, from) = (integrator.name(), decode.name());
            // The case whose ticks are counted: [`super::counts`].
            let count = processor.count(&format!("tick/{from}-{by}"), "f32");
            let per_ms = count.map(|count| count * u64::from(ticks_per_ms));
            Ok((format!("{by}, {from}, {ticks_per_ms} kHz"), deviation(&run, &exact), per_ms))
        })
        .collect::<Result<Vec<_>, Refused<'static>>>()?;
    let compare = |title: &str, error: &str, unit, pick: fn(&Deviation) -> f64| {
        Comparison::of(title, error, unit, &measured, pick).in_series()
    };
    let comparisons = vec![
        compare("position of the copies", "RMS error of x_o", "m", |deviation| deviation.position_rms_m),
        compare("coordination force", "RMS error of F_T", "N", |deviation| deviation.force_rms_n),
    ];
    let force = &comparisons[1];
    let insight = format!(
        "The paper's scheme (forward Euler, delayed decode) at 1 kHz errs by {} N in force; semi-implicit with implicit \
         decode by {} N for {:+} instructions a millisecond, which the paper's scheme reaches only at 4 kHz ({} N); midpoint by \
         {} N for {:+}, and it alone makes no energy when the object is let go of: take the better scheme before the faster tick.",
        significant(force.error_of("forward-euler, delayed, 1 kHz"), 2),
        significant(force.error_of("semi-implicit, implicit, 1 kHz"), 2),
        force.instructions_of("semi-implicit, implicit, 1 kHz") as i64
            - force.instructions_of("forward-euler, delayed, 1 kHz") as i64,
        significant(force.error_of("forward-euler, delayed, 4 kHz"), 2),
        significant(force.error_of("midpoint, implicit, 1 kHz"), 2),
        force.instructions_of("midpoint, implicit, 1 kHz") as i64
            - force.instructions_of("forward-euler, delayed, 1 kHz") as i64,
    );
    Ok(Family {
        name: "whole-peer",
        title: "Integrator, decode and control rate",
        motion: format!("{}; f32", pair::MOTION),
        reference: "continuous control: matrix exponential in f64",
        instructions_per: "millisecond of a whole peer",
        comparisons,
        headline: 1,
        insight,
    })
}
