//! The cooperation paper's claims: §4.3 with Figure 4, §5.1 with Figures 6 and 7, §5.2 with Figures 8 and 9.

use haptic_analysis::{Map, figure4};
use haptic_core::names::Decode;
use haptic_report::significant;
use haptic_sim::{Laws, scenes};

use super::claim::{Claim, of, orders};
use super::paper::Experiment;
use super::readings::{crossings, nearest, stable_up_to};
use crate::Error;

/// What the claims are judged from.
pub struct Computed<'a> {
    /// Every experiment of §5.
    pub experiments: &'a [Experiment],
    /// The curves of Figure 4.
    pub curves: &'a [(figure4::Curve, Map)],
}

/// The paper's largest gains in its experiments, and its mean discrepancies at them (§5.1, Fig. 9).
const PRINTED: [(&str, f64, f64); 3] =
    [("power", 310.0, 3.5), ("wave", 1590.0, 0.644), ("passive-wave", 10620.0, 0.099)];

/// How near a number of an experiment is to be: a tenth.
const WITHIN: f64 = 0.1;

/// The contact stiffness at which curves of Figure 4 are compared, N/m.
const CONTACT_N_PER_M: f64 = 500.0;

impl Computed<'_> {
    /// The first crossing of a curve of Figure 4, by delay, N/m.
    fn limits(&self, law: &str) -> Vec<f64> {
        let curves = self.curves.iter().filter(|(curve, _)| curve.comm == law);
        let first = |map: &Map| {
            let far = |x: f64| (x - CONTACT_N_PER_M).abs();
            let column = map.columns.iter().min_by(|a, b| far(a.x).total_cmp(&far(b.x)));
            column.and_then(|column| column.limit.crossings.first().copied()).unwrap_or(f64::NAN)
        };
        curves.map(|(_, map)| first(map)).collect()
    }

    fn experiment(&self, section: &str, law: &str, round_trip_ms: f64) -> Result<&Experiment, Error> {
        let is = |one: &&Experiment| one.section == section && one.law == law && one.round_trip_ms == round_trip_ms;
        self.experiments
            .iter()
            .find(is)
            .ok_or_else(|| format!("no experiment {section} {law} {round_trip_ms} ms").into())
    }
}

fn list(values: &[f64]) -> String {
    values.iter().map(|value| significant(*value, 3)).collect::<Vec<_>>().join(", ")
}

/// All claims of the cooperation paper.
pub fn claims(computed: &Computed<'_>) -> Result<Vec<Claim>, Error> {
    let all = [figure_4(computed)?, gains(computed)?, coherency(computed)?];
    Ok(of("cooperation", all.concat()))
}

fn figure_4(computed: &Computed<'_>) -> Result<Vec<Claim>, Error> {
    let [power, wave, passive] = ["power", "wave", "passive-wave"].map(|law| computed.limits(law));
    let ratios = |over: &[f64], under: &[f64]| over.iter().zip(under).map(|(a, b)| a / b).collect::<Vec<_>>();
    let over_power = ratios(&wave, &power);
    let over_wave = ratios(&passive, &wave);
    let an_order = |ratios: &[f64]| ratios.iter().all(|ratio| orders(*ratio) == 1.0);
    let at = "K_LC 500 N/m, n_t 0, 1, 2, 3";
    let spread = |limits: &[f64]| {
        let [low, high] = [f64::min, f64::max].map(|of| limits.iter().copied().reduce(of).unwrap_or(f64::NAN));
        high / low - 1.0
    };
    let mut claims = vec![
        Claim::holds(
            "§4.3, Fig. 4",
            "Waves raise the largest coordination stiffness by an order of magnitude over power-domain communications",
            an_order(&over_power[1..]),
            format!("{} times, {at}", list(&over_power)),
        )
        .but("with a delay; without one they need none of it, and gain less".to_owned()),
        Claim::holds(
            "§4.3, Fig. 4",
            "Passive waves raise it by another order of magnitude",
            an_order(&over_wave),
            format!("{} times, {at}", list(&over_wave)),
        )
        .unless(|| {
            let [(_, wave, _), (_, passive, _)] = [PRINTED[1], PRINTED[2]];
            Ok(format!(
                "half of one on a logarithmic scale, in these parameters; the gains of the paper's experiments are {} apart",
                significant(passive / wave, 3)
            ))
        })?,
    ];
    for (name, limits) in [("traditional", &wave), ("passive", &passive)] {
        let claim = format!("The largest stiffness of {name} waves is unaffected by the delay");
        let found = format!("{} N/m, {at}: within {:.0} %", list(limits), 100.0 * spread(limits));
        claims.push(Claim::holds("§4.3, Fig. 4", &claim, spread(limits) <= WITHIN, found).unless(|| {
            // The decode is what limits it: solved in one step, with the copy's forces in the same tick, there is no limit to be moved.
            let mut free = 0;
            for delay in figure4::DELAYS {
                let mut scene = figure4::scene("wave", delay);
                scene.peer.contact.stiffness_n_per_m = CONTACT_N_PER_M;
                scene.peer.coordination.decode = Decode::Implicit;
                scene.peer.object.force_delay_ticks = 0.0;
                let found = crossings(&scene, 2e5)?;
                free += usize::from(found.stable_at_start && found.crossings.is_empty());
            }
            let of = figure4::DELAYS.len();
            Ok(format!("decoded in one step with x_d, and the copy's forces in their own tick, {free} of {of} delays have no limit up to 200000 N/m"))
        })?);
    }
    Ok(claims)
}

fn gains(computed: &Computed<'_>) -> Result<Vec<Claim>, Error> {
    let mut claims = Vec::new();
    for (law, gain, _) in PRINTED {
        let scene = scenes::load(Laws::built_in(), &format!("paper-5.1-{law}-16ms"))?;
        let found = crossings(&scene, 12_000.0)?;
        // The boundary that the gain would be at: the nearest one behind which it is unstable.
        let ends = found.crossings.iter().enumerate().filter(|(at, _)| found.stable_at_start == (at % 2 == 0));
        let near = ends.map(|(_, crossing)| *crossing).min_by(|a, b| (a - gain).abs().total_cmp(&(b - gain).abs()));
        let numbers = (gain, near.unwrap_or(f64::NAN), "N/m");
        let largest = format!("The largest gain of {law} communications is {gain} N/m (16 ms)");
        claims.push(Claim::number("§5.1, Fig. 6", &largest, numbers, 0.05).unless(|| {
            let side = if numbers.1 > gain { "inside" } else { "outside" };
            Ok(match nearest(&scene, gain)? {
                Some((reading, first)) if (first / gain - 1.0).abs() < 0.99 * (numbers.1 / gain - 1.0).abs() => {
                    format!("the reading left open that comes nearest has {} N/m: {reading}", significant(first, 4))
                }
                _ => format!(
                    "the gain lies {side} the stable region, and no reading left open has a boundary nearer to it"
                ),
            })
        })?);
        let up_to = format!("With {law} communications every gain up to {gain} N/m is stable (16 ms)");
        let below: Vec<f64> = found.crossings.iter().copied().filter(|crossing| *crossing < gain).collect();
        let words = if below.is_empty() {
            "no boundary below it".to_owned()
        } else {
            format!("it changes at {} N/m", list(&below))
        };
        claims.push(Claim::holds("§5.1", &up_to, found.stable_at_start && below.is_empty(), words).unless(|| {
            let readings = stable_up_to(&scene, gain)?;
            let which = readings.join("; ");
            Ok(match readings.len() {
                0 => "a pocket in this reading and in every other one that the paper leaves open".to_owned(),
                count => format!(
                    "a pocket that depends on what the paper leaves open: none in {count} other readings ({which})"
                ),
            })
        })?);
        let stable = computed.experiment("5.1", law, 16.0)?.outcome.is_stable();
        let holds = format!("At {gain} N/m {law} communications are stable with 16 ms round trip");
        claims.push(Claim::holds("Fig. 6", &holds, stable, "a run of 20 s, and its eigenvalues".to_owned()));
    }
    for (law, wanted) in [("power", false), ("wave", true), ("passive-wave", true)] {
        let outcome = &computed.experiment("5.1", law, 32.0)?.outcome;
        let word = if wanted { "stays stable" } else { "is not robust" };
        let claim = format!("At the same gain with 32 ms round trip {law} {word}");
        let found = outcome.reason.map_or_else(|| "stable".to_owned(), |reason| reason.to_string());
        claims.push(Claim::holds("§5.1, Fig. 7", &claim, outcome.is_stable() == wanted, found));
    }
    Ok(claims)
}

fn coherency(computed: &Computed<'_>) -> Result<Vec<Claim>, Error> {
    let of = |law| computed.experiment("5.2", law, 16.0).map(|one| &one.outcome);
    let outcomes = [of("power")?, of("wave")?, of("passive-wave")?];
    let [decoded, all_true] = [
        outcomes.map(|outcome| outcome.metric(|o| o.whole.decoded_discrepancy_mm).unwrap_or(f64::NAN)),
        outcomes.map(|outcome| outcome.metric(|o| o.whole.true_discrepancy_mm).unwrap_or(f64::NAN)),
    ];
    let mut claims = Vec::new();
    for ((law, _, papers), computed) in PRINTED.into_iter().zip(decoded) {
        let claim = format!("The mean position discrepancy of {law} communications is {papers} mm");
        claims.push(
            Claim::number("§5.2, Fig. 9", &claim, (papers, computed, "mm"), WITHIN)
                .but("read as the distance to the remote copy as it is decoded at the same peer".to_owned()),
        );
    }
    let fewer = |of: [f64; 3], at: usize| of[0] / of[at];
    for (at, (name, wanted)) in [(1, ("Waves", 1.0)), (2, ("Passive waves", 2.0))] {
        let word = if wanted == 1.0 { "one order" } else { "two orders" };
        for (which, values) in [("decoded", decoded), ("true", all_true)] {
            let claim = format!("{name} decrease the position discrepancy by {word} of magnitude ({which})");
            let found = format!("{} times", significant(fewer(values, at), 3));
            let holds = orders(fewer(values, at)) == wanted;
            claims.push(Claim::holds("§5.2, Fig. 9", &claim, holds, found).unless(|| {
                Ok(format!(
                    "the copies themselves, at one instant, are {} times nearer: a wave line is a spring and adds its own way; the remote copy as decoded at the same peer is {} times nearer",
                    significant(fewer(all_true, at), 3),
                    significant(fewer(decoded, at), 3)
                ))
            })?);
        }
    }
    let sd = outcomes.map(|outcome| outcome.whole.coordination_force_n.sd);
    let mean = outcomes.map(|outcome| outcome.whole.coordination_force_n.mean.abs());
    let peak = outcomes.map(|outcome| outcome.whole.peak_coordination_force_n);
    let lowest = |of: [f64; 3]| of[2] <= of[0].min(of[1]);
    let numbers = |of: [f64; 3]| list(&of);
    claims.push(
        Claim::holds(
            "§5.2, Fig. 8",
            "Passive waves apply lower coordination forces",
            lowest(peak),
            format!("largest |F_T| {} N for power, wave, passive wave; mean {} N", numbers(peak), numbers(mean)),
        )
        .unless(|| {
            Ok("over the whole run, its start included; the means, which the users' pushes set, are alike".to_owned())
        })?,
    );
    claims.push(
        Claim::holds(
            "§5.2, Fig. 8",
            "Passive waves apply smoother coordination forces",
            lowest(sd),
            format!("standard deviation {} N for power, wave, passive wave", numbers(sd)),
        )
        .unless(|| Ok("by the standard deviation over the last half of the run".to_owned()))?,
    );
    Ok(claims)
}
