//! The whole peer: integrator, decode and control rate together.
//!
//! What a user pays for is a millisecond of control, so a peer that ticks twice as often costs twice as much: this is
//! where a better scheme and a faster one can be weighed against each other. Run in f32, the passive wave against continuous control
//! ([`super::continuous`]), the self-timed line against what it converges to ([`super::line`]). Unit: m, N; instructions per millisecond of one peer.

use cohold_core::settings::{Choice, Refused};
use cohold_core::{law::wave::Decode, object::IntegratorName};
use cohold_report::significant;
use cohold_sim::Scene;
use rayon::prelude::*;

use super::pair::{self, Deviation, deviation};
use super::{Comparison, Family, continuous, counts::Processor, line};

/// Control rates, ticks each millisecond.
const RATES: [u32; 4] = [1, 2, 4, 8];

/// How a peer computes its law: what becomes a series of the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scheme {
    /// The passive wave with this integrator and decode.
    Wave(IntegratorName, Decode),
    /// A self-timed line with this integrator.
    Line(IntegratorName),
}

impl Scheme {
    /// All of them.
    pub(super) fn all() -> impl Iterator<Item = Self> {
        let waves = IntegratorName::ALL.iter().flat_map(|&by| Decode::ALL.iter().map(move |&from| (by, from)));
        // One solve decodes, or it is none; and the line needs one.
        let waves = waves.filter(|(by, from)| !by.solves() || *from == Decode::Implicit);
        let lines = IntegratorName::ALL.iter().filter(|by| by.solves());
        waves.map(|(by, from)| Self::Wave(by, from)).chain(lines.map(|&by| Self::Line(by)))
    }

    /// Its name in reports.
    pub(super) fn name(self) -> String {
        match self {
            Self::Wave(by, from) => format!("{}, {}", by.name(), from.name()),
            Self::Line(by) => format!("self-timed, {}", by.name()),
        }
    }

    /// The scene of `cohold_cases` whose ticks are counted and timed.
    pub(super) fn case(self) -> String {
        match self {
            Self::Wave(by, from) => format!("{}-{}", from.name(), by.name()),
            Self::Line(IntegratorName::Midpoint) => "self-timed".to_owned(),
            Self::Line(by) => format!("self-timed-{}", by.name()),
        }
    }

    fn scene(self, ticks_per_ms: u32) -> Scene {
        match self {
            Self::Wave(by, from) => pair::scene(by, from, ticks_per_ms),
            Self::Line(by) => line::scene(by, ticks_per_ms),
        }
    }
}

/// A scheme at a control rate, and how far it is from its reference.
#[derive(Clone, Copy, Debug)]
pub(super) struct Measured {
    pub(super) scheme: Scheme,
    pub(super) ticks_per_ms: u32,
    pub(super) deviation: Deviation,
}

/// Every scheme at every rate.
pub(super) fn deviations() -> Result<Vec<Measured>, Refused<'static>> {
    let exact = continuous::run(&pair::scene(IntegratorName::Exact, Decode::Implicit, 1), pair::DURATION_S);
    let converged = line::converged()?;
    let each: Vec<_> = Scheme::all().flat_map(|scheme| RATES.map(|ticks_per_ms| (scheme, ticks_per_ms))).collect();
    let run = |(scheme, ticks_per_ms): (Scheme, u32)| {
        let (duration_s, reference) = match scheme {
            Scheme::Wave(..) => (pair::DURATION_S, &exact),
            Scheme::Line(_) => (line::DURATION_S, &converged),
        };
        let run = pair::run::<f32>(&scheme.scene(ticks_per_ms), duration_s)?;
        Ok(Measured { scheme, ticks_per_ms, deviation: deviation(&run, reference) })
    };
    each.into_par_iter().map(run).collect()
}

pub(super) fn measure(processor: Processor) -> Result<Family, Refused<'static>> {
    let measured = deviations()?;
    let of = |lines: bool| -> Vec<_> {
        let chosen = measured.iter().filter(|one| matches!(one.scheme, Scheme::Line(_)) == lines);
        let named = chosen.map(|Measured { scheme, ticks_per_ms, deviation }| {
            let count = processor.count(&format!("tick/{}", scheme.case()), "f32");
            let per_ms = count.map(|count| count * u64::from(*ticks_per_ms));
            (format!("{}, {ticks_per_ms} kHz", scheme.name()), *deviation, per_ms)
        });
        named.collect()
    };
    let (waves, lines) = (of(false), of(true));
    let compare = |measured: &[_], title: &str, error: &str, unit, pick: fn(&Deviation) -> f64| {
        Comparison::of(title, error, unit, measured, pick).in_series()
    };
    let (position, force) = ("RMS error of x_o", "RMS error of F_T");
    let comparisons = vec![
        compare(&waves, "position of the copies", position, "m", |deviation| deviation.position_rms_m),
        compare(&waves, "coordination force", force, "N", |deviation| deviation.force_rms_n),
        compare(&lines, "self-timed line, copies", position, "m", |deviation| deviation.position_rms_m),
        compare(&lines, "self-timed line, pull", force, "N", |deviation| deviation.force_rms_n),
    ];
    let (force, line) = (&comparisons[1], &comparisons[3]);
    let insight = format!(
        "The paper's scheme (forward Euler, delayed decode) at 1 kHz errs by {} N in force; semi-implicit with implicit \
         decode by {} N for {:+} instructions a millisecond, which the paper's scheme reaches only at 4 kHz ({} N); midpoint by \
         {} N for {:+}, and it alone makes no energy when the object is let go of: take the better scheme before the faster tick. A \
         self-timed line errs by {} N, by {} N with backward Euler.",
        significant(force.error_of("forward-euler, delayed, 1 kHz"), 2),
        significant(force.error_of("semi-implicit, implicit, 1 kHz"), 2),
        force.instructions_of("semi-implicit, implicit, 1 kHz") as i64
            - force.instructions_of("forward-euler, delayed, 1 kHz") as i64,
        significant(force.error_of("forward-euler, delayed, 4 kHz"), 2),
        significant(force.error_of("midpoint, implicit, 1 kHz"), 2),
        force.instructions_of("midpoint, implicit, 1 kHz") as i64
            - force.instructions_of("forward-euler, delayed, 1 kHz") as i64,
        significant(line.error_of("self-timed, midpoint, 1 kHz"), 2),
        significant(line.error_of("self-timed, backward-euler, 1 kHz"), 2),
    );
    Ok(Family {
        name: "whole-peer",
        title: "Integrator, decode and control rate",
        motion: format!("{}; f32. {}", pair::MOTION, line::MOTION),
        reference: "continuous control, a matrix exponential in f64; of the self-timed line the same pair at 32 kHz in f64",
        instructions_per: "millisecond of a whole peer",
        comparisons,
        headline: 1,
        insight,
    })
}
