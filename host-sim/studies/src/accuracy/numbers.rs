//! Number types: the same peer in f32, f64 and I32F32.
//!
//! Two errors, because they answer two questions. The *whole* error, against continuous control ([`super::continuous`]),
//! is what a user gets; most of it is the control period's. The *rounding* alone, against the same peer in double-double
//! ([`DoubleDouble`]), is what the number type adds. The device is simulated in f64 for all of them, which is most
//! of what f64 itself shows. Unit: m, N.
//!
//! A board computes in f32 and keeps long sums in f64: what that mix is worth, a self-timed line says ([`super::sums`]).

use cohold_core::num::{Fixed, Scalar};
use cohold_core::{law::wave::Decode, object::IntegratorName, settings::Refused};
use cohold_report::significant;
use cohold_sim::double_double::DoubleDouble;

use super::pair::{self, Deviation, deviation};
use super::{Comparison, Family, continuous, counts::Processor, sums};

/// The case whose ticks are counted: [`super::counts`].
const CASE: &str = "tick/implicit-semi-implicit";
const LINE: &str = "tick/self-timed";

pub(super) fn measure(processor: Processor) -> Result<Family, Refused<'static>> {
    let scene = pair::scene(IntegratorName::SemiImplicit, Decode::Implicit, 1);
    let exact = continuous::run(&scene, pair::DURATION_S);
    let precise = pair::run::<DoubleDouble>(&scene, pair::DURATION_S)?;
    let runs = [
        (<f32 as Scalar>::NAME, pair::run::<f32>(&scene, pair::DURATION_S)?),
        (<f64 as Scalar>::NAME, pair::run::<f64>(&scene, pair::DURATION_S)?),
        (Fixed::NAME, pair::run::<Fixed>(&scene, pair::DURATION_S)?),
    ];
    let measured: Vec<_> = runs
        .iter()
        .map(|(name, run)| {
            ((*name).to_owned(), [deviation(run, &exact), deviation(run, &precise)], processor.count(CASE, name))
        })
        .collect();
    let compare = |title: &str, error: &str, unit, pick: fn(&[Deviation; 2]) -> f64| {
        Comparison::of(title, error, unit, &measured, pick)
    };
    let line: Vec<_> = sums::errors()?
        .into_iter()
        .map(|(mix, scalar, errors)| (mix.to_owned(), errors, processor.count(LINE, scalar)))
        .collect();
    let of_line =
        |title: &str, error: &str, which: usize| Comparison::of(title, error, "m", &line, |errors| errors[which]);
    let comparisons = vec![
        compare("rounding, position", "largest error of x_o", "m", |[_, rounding]| rounding.position_largest_m),
        compare("rounding, force", "largest error of F_T", "N", |[_, rounding]| rounding.force_largest_n),
        compare("whole error, position", "RMS error of x_o", "m", |[whole, _]| whole.position_rms_m),
        compare("whole error, force", "RMS error of F_T", "N", |[whole, _]| whole.force_rms_n),
        of_line("self-timed line, distance of the copies", "largest error of x_o1 - x_o2", 0),
        of_line("self-timed line, both copies", "largest error of their mean position", 1),
    ];
    let [rounding, _, whole, _, apart, _] = &comparisons[..] else { unreachable!("six comparisons were just made") };
    let insight = format!(
        "f32 rounds the shared object's position by {} m where the 1 ms control period alone costs {} m, {:.0} times as much: \
         the number type cannot be felt, so take the one the processor computes fastest (f64 takes {:.2} times the \
         instructions of f32 here, I32F32 {:.1} times; cycles are for the hardware to tell). Long sums are another matter: within a minute a \
         self-timed line in f32 has its copies {} m from where they belong to each other with its sums in f64, as it flies, and {} m with its sums in f32.",
        significant(rounding.error_of("f32"), 2),
        significant(whole.error_of("f32"), 2),
        whole.error_of("f32") / rounding.error_of("f32"),
        whole.instructions_of("f64") as f64 / whole.instructions_of("f32") as f64,
        whole.instructions_of("i32f32") as f64 / whole.instructions_of("f32") as f64,
        significant(apart.error_of(sums::MIX), 2),
        significant(apart.error_of(sums::SINGLE), 2),
    );
    Ok(Family {
        name: "number-type",
        title: "Number type of the whole peer",
        motion: format!(
            "{}; semi-implicit object, implicit decode. Self-timed line: any-network, both push 1 N and one 0.25 sin 3t N; 60 s",
            pair::MOTION
        ),
        reference: "the same peer in double-double (rounding) and continuous control, a matrix exponential in f64 (whole error)",
        instructions_per: "tick of a whole peer",
        comparisons,
        headline: 2,
        insight,
    })
}
