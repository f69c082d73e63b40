//! The whole peer: integrator, decode and control rate together.
//!
//! What a user pays for is a millisecond of control, so a peer that ticks twice as often costs twice as much: this is
//! where a better scheme and a faster one can be weighed against each other. Run in f32, against continuous control
//! ([`super::continuous`]). Unit: m, N; instructions per millisecond of one peer.

use haptic_core::law::wave::Decode;
use haptic_core::object::IntegratorName;
use haptic_core::settings::{Choice, Refused};
use rayon::prelude::*;

use super::counts::Processor;
use super::pair::{self, Apart, apart};
use super::{Comparison, Family, continuous};
use haptic_sim::report::text::significant;

/// Control rates, ticks each millisecond.
pub const RATES: [u32; 4] = [1, 2, 4, 8];

/// One of the choices.
#[derive(Clone, Copy, Debug)]
struct Scheme {
    integrator: IntegratorName,
    decode: Decode,
    ticks_per_ms: u32,
}

impl Scheme {
    fn name(self) -> String {
        format!("{}, {}, {} kHz", self.integrator.name(), self.decode.name(), self.ticks_per_ms)
    }

    /// The case whose ticks are counted: [`super::cost`].
    fn case(self) -> String {
        format!("tick/{}-{}", self.decode.name(), self.integrator.name())
    }
}

/// Every integrator with every decode at every rate.
fn schemes() -> Vec<Scheme> {
    let pairs =
        IntegratorName::ALL.iter().flat_map(|&integrator| Decode::ALL.iter().map(move |&decode| (integrator, decode)));
    pairs
        .flat_map(|(integrator, decode)| RATES.map(|ticks_per_ms| Scheme { integrator, decode, ticks_per_ms }))
        .collect()
}

/// Measures.
pub fn measure(processor: Processor) -> Result<Family, Refused<'static>> {
    let exact = continuous::run(&pair::scene(IntegratorName::Exact, Decode::Implicit, 1), pair::DURATION_S);
    let measured = schemes()
        .into_par_iter()
        .map(|scheme| {
            let scene = pair::scene(scheme.integrator, scheme.decode, scheme.ticks_per_ms);
            let run = pair::run::<f32>(&scene, pair::DURATION_S)?;
            let per_ms = processor.count(&scheme.case(), "f32").map(|count| count * u64::from(scheme.ticks_per_ms));
            Ok((scheme.name(), apart(&run, &exact), per_ms))
        })
        .collect::<Result<Vec<_>, Refused<'static>>>()?;
    let compare = |title: &str, error: &str, unit, pick: fn(&Apart) -> f64| {
        let points = measured.iter().map(|(name, apart, count)| (name.clone(), pick(apart), *count)).collect();
        Comparison::new(title, error, unit, points).in_series()
    };
    let comparisons = vec![
        compare("position of the copies", "RMS error of x_o", "m", |apart| apart.position_rms_m),
        compare("coordination force", "RMS error of F_T", "N", |apart| apart.force_rms_n),
    ];
    let force = &comparisons[1];
    let insight = format!(
        "The paper's scheme (forward Euler, delayed decode) at 1 kHz errs by {} N in force; semi-implicit with implicit \
         decode by {} N for {:+} instructions a millisecond, which the paper's scheme reaches only at 4 kHz ({} N): take the better scheme \
         before the faster tick.",
        significant(force.error_of("forward-euler, delayed, 1 kHz"), 2),
        significant(force.error_of("semi-implicit, implicit, 1 kHz"), 2),
        force.instructions_of("semi-implicit, implicit, 1 kHz") as i64
            - force.instructions_of("forward-euler, delayed, 1 kHz") as i64,
        significant(force.error_of("forward-euler, delayed, 4 kHz"), 2),
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
