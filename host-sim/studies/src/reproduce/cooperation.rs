//! The cooperation paper's claims: §4.3 with Figure 4, what §1 to §3 say of filters, §5.1 with Figures 6 and 7, §5.2 with Figures 8 and 9.

use cohold_analysis::{Hands, Map, figure4, judge};
use cohold_core::law::decimate::{Newest, OnePole};
use cohold_core::names::Decode;
use cohold_report::significant;
use cohold_sim::run::{Options, Outcome, run};

use super::claim::{Claim, of};
use super::paper::{Experiment, PRINTED, Printed, run_at, scene};
use super::readings::{DAMPINGS_N_S_PER_M, MASSES_KG, TO_N_PER_M, boundary, crossings, nearest, over_devices};
use super::{channel, list, span};
use crate::Error;

/// What the claims are judged from.
pub struct Computed<'a> {
    /// Every experiment of §5.
    pub experiments: &'a [Experiment],
    /// The curves of Figure 4.
    pub curves: &'a [(figure4::Curve, Map)],
}

/// How near a number of an experiment is to be: a tenth.
const WITHIN: f64 = 0.1;

/// And a largest gain: a twentieth.
const NUMBER_WITHIN: f64 = 0.05;

/// Tones that are sent over the wave line, Hz: below and above what packets can carry, multiples of their rate among them.
const TONES_HZ: [f64; 9] = [1.0, 10.0, 31.0, 60.0, 62.0, 125.0, 200.0, 250.0, 499.0];

/// When the paper's Figure 8 shows forces, s: of a run that lasts as long.
const FIGURE_8_S: [f64; 2] = [50.0, 58.0];

/// The contact stiffness at which curves of Figure 4 are compared, N/m.
const CONTACT_N_PER_M: f64 = 500.0;

impl Computed<'_> {
    /// The first crossings of a law's curves of Figure 4 at every K_LC, by delay, N/m; NaN where a curve has none there.
    fn limits(&self, law: &str) -> Vec<(f64, Vec<f64>)> {
        let curves: Vec<_> = self.curves.iter().filter(|(curve, _)| curve.comm == law).map(|(_, map)| map).collect();
        let first = |map: &Map, at: usize| {
            let limit = &map.columns[at].limit;
            limit.crossings.first().copied().filter(|_| limit.stable_at_start).unwrap_or(f64::NAN)
        };
        let columns = curves.first().map_or(0, |map| map.columns.len());
        (0..columns).map(|at| (curves[0].columns[at].x, curves.iter().map(|map| first(map, at)).collect())).collect()
    }

    fn experiment(&self, section: &str, law: &str, round_trip_ms: f64) -> Result<&Experiment, Error> {
        let is = |one: &&Experiment| one.section == section && one.law == law && one.round_trip_ms == round_trip_ms;
        self.experiments
            .iter()
            .find(is)
            .ok_or_else(|| format!("no experiment {section} {law} {round_trip_ms} ms").into())
    }
}

/// All claims of the cooperation paper.
pub fn claims(computed: &Computed<'_>) -> Result<Vec<Claim>, Error> {
    let all = [model()?, figure_4(computed)?, filters(computed)?, gains(computed)?, coherency(computed)?];
    Ok(of("cooperation", all.concat()))
}

/// What is sent (§3), and what the criterion of stability says (§4).
fn model() -> Result<Vec<Claim>, Error> {
    let mut rest = Vec::new();
    for Printed { law, .. } in PRINTED {
        let judged = judge(&scene("5.1", law)?)?;
        let both = judged.modes.iter().find(|mode| mode.mode == Hands::Both && !mode.at_walls);
        rest.push(both.map_or(0, |both| both.verdict.rest_modes));
    }
    let literal = rest.iter().filter(|rest| **rest == 0).count();
    let found = format!(
        "with the laws and gains of §5.1 at 16 ms {rest:?} eigenvalues are 1: {literal} of {} are stable by it",
        rest.len()
    );
    Ok(vec![
        Claim::not_testable(
            "§3",
            "Power-domain communications exchange velocity data",
            "here a packet has position and velocity, and a copy is pulled to where the other was".to_owned(),
            "not said of what the position is made at the other end; from velocities alone copies would be apart for good after a loss, of which the paper has none",
        ),
        Claim::in_places("§4, eq. 25", "Stable is what has all eigenvalues inside the unit circle", literal, rest.len(), found)
            .because("taken literally it calls all of the paper's own experiments unstable: nothing holds the pair where it is, and waves do not say where either copy is; here what stands still so is left out, and all else has to be inside"),
    ])
}

/// The column that is printed.
fn at_usual(columns: &[(f64, Vec<f64>)]) -> &[f64] {
    let far = |x: f64| (x - CONTACT_N_PER_M).abs();
    columns.iter().min_by(|a, b| far(a.0).total_cmp(&far(b.0))).map_or(&[], |(_, limits)| limits)
}

fn figure_4(computed: &Computed<'_>) -> Result<Vec<Claim>, Error> {
    let [power, wave, passive] = ["power", "wave", "passive-wave"].map(|law| computed.limits(law));
    let at = format!("at K_LC {CONTACT_N_PER_M} N/m, n_t 0, 1, 2, 3");
    // At every K_LC and delay at which both curves end.
    let an_order = |place, claim: &str, over: &[(f64, Vec<f64>)], under: &[(f64, Vec<f64>)], why: &str| {
        let count = |delay: usize| {
            let ratios = over.iter().zip(under).map(|(over, under)| over.1[delay] / under.1[delay]);
            let ratios: Vec<f64> = ratios.filter(|ratio| ratio.is_finite()).collect();
            [ratios.iter().filter(|ratio| **ratio >= 10.0).count(), ratios.len()]
        };
        let counts: Vec<[usize; 2]> = (0..figure4::DELAYS.len()).map(count).collect();
        let [holding, of] = [0, 1].map(|which| counts.iter().map(|count| count[which]).sum::<usize>());
        let words: Vec<String> = counts.iter().map(|[holding, of]| format!("{holding} of {of}")).collect();
        let usual: Vec<f64> = at_usual(over).iter().zip(at_usual(under)).map(|(over, under)| over / under).collect();
        let found =
            format!("{} times {at}; ten times or more in {} places of Figure 4", list(&usual), words.join(", "));
        Claim::in_places(place, claim, holding, of, found).because(why)
    };
    let [wave_gain, passive_gain] = [PRINTED[1], PRINTED[2]].map(|printed| printed.gain_n_per_m);
    let mut claims = vec![
        an_order(
            "§4.3, Fig. 4",
            "Waves raise the largest coordination stiffness by an order of magnitude over power-domain communications",
            &wave,
            &power,
            "the longer the delay, the more: without one they gain little",
        ),
        an_order(
            "abstract",
            "Passive waves allow gains an order of magnitude larger than power-domain communications",
            &passive,
            &power,
            "the longer the delay, the more: without one they gain less",
        ),
        an_order(
            "§4.3, Fig. 4",
            "Passive waves raise it by another order of magnitude over traditional waves (also in the abstract)",
            &passive,
            &wave,
            &format!("the gains of the paper's own experiments are {} apart", significant(passive_gain / wave_gain, 3)),
        ),
    ];
    for (name, law, columns) in [("traditional", "wave", &wave), ("passive", "passive-wave", &passive)] {
        let claim = format!("The largest stiffness of {name} waves is unaffected by the delay");
        let spread = |limits: &[f64]| {
            let [low, high] = span(limits.iter().copied());
            high / low - 1.0
        };
        let ends: Vec<_> = columns.iter().filter(|(_, limits)| limits.iter().all(|limit| limit.is_finite())).collect();
        let alike = ends.iter().filter(|(_, limits)| spread(limits) <= WITHIN).count();
        let usual = at_usual(columns);
        let found = format!(
            "{} N/m {at}: within {:.0} %; within {:.0} % at {alike} of {} K_LC of Figure 4 at which all four end",
            list(usual),
            100.0 * spread(usual),
            100.0 * WITHIN,
            ends.len()
        );
        let worst = ends.iter().max_by(|a, b| spread(&a.1).total_cmp(&spread(&b.1)));
        let worst = worst.map_or_else(String::new, |(x, limits)| {
            format!("most of all at K_LC {} N/m: {} N/m", significant(*x, 3), list(limits))
        });
        claims.push(Claim::in_places("§4.3, Fig. 4", &claim, alike, ends.len(), found).unless(|| {
            // The decode is what limits it: solved in one step, with the copy's forces in the same tick, there is no limit to be moved.
            let mut free = 0;
            for delay in figure4::DELAYS {
                let mut scene = figure4::scene(law, delay);
                scene.peer.contact.stiffness_n_per_m = CONTACT_N_PER_M;
                scene.peer.coordination.decode = Decode::Implicit;
                scene.peer.object.force_delay_ticks = 0.0;
                let found = crossings(&scene, 2e5)?;
                free += usize::from(found.stable_at_start && found.crossings.is_empty());
            }
            let of = figure4::DELAYS.len();
            Ok(format!("{worst}; decoded in one step with x_d, and the copy's forces in their own tick, {free} of {of} delays have no limit up to 200000 N/m at K_LC {CONTACT_N_PER_M} N/m"))
        })?);
    }
    Ok(claims)
}

/// What the anti-aliasing filters are for (§1, §2), what delay does without waves (§3), and where Figure 4 ends at its right.
fn filters(computed: &Computed<'_>) -> Result<Vec<Claim>, Error> {
    let settings = scene("5.1", "passive-wave")?.peer;
    let worst = channel::worst::<OnePole<f64>>(&settings, channel::pole(&settings));
    let tones: Vec<f64> = TONES_HZ.iter().map(|hz| channel::tone::<OnePole<f64>>(&settings, *hz)).collect();
    let [loudest, bare] = [tones.iter().copied().fold(0.0, f64::max), channel::worst::<Newest>(&settings, 0.0)];
    let mut claims = vec![
        // A guarantee: one wave is enough against it.
        Claim::holds(
            "§1, §2",
            "The anti-aliasing filters guarantee that the multirate wave line is passive",
            loudest.max(worst) <= 1.0,
            format!(
                "of each of {} tones up to 500 Hz at most {loudest:.3} of its energy comes out, of the worst wave {worst:.2} times as much as went in; {bare:.0} times without a filter",
                tones.len()
            ),
        )
        .because("tone by tone it is; a filter of one pole lets some of what is above its cutoff through, where it adds up with what is below; the mean of a packet period, passive-mean, gives back no more than went in whatever the wave"),
    ];
    let [power, wave, filtered] = ["power", "wave", "passive-wave"].map(|law| computed.limits(law));
    // At every K_LC and delay at which both end.
    let pairs = wave.iter().zip(&filtered).flat_map(|(wave, filtered)| wave.1.iter().zip(&filtered.1));
    let ratios: Vec<f64> = pairs.map(|(wave, filtered)| filtered / wave).filter(|ratio| ratio.is_finite()).collect();
    let farther = ratios.iter().filter(|ratio| **ratio > 1.0).count();
    let least = ratios.iter().copied().fold(f64::INFINITY, f64::min);
    claims.push(
        Claim::in_places(
            "§1, Fig. 4",
            "The anti-aliasing filters extend the stable region",
            farther,
            ratios.len(),
            format!("the first boundary is farther in {farther} of {} places of Figure 4 at which both end, {} times at least", ratios.len(), significant(least, 3)),
        )
        .because("where the contact is about to be unstable by itself, both end early"),
    );
    let ends: Vec<_> = power.iter().filter(|(_, limits)| limits.iter().all(|limit| limit.is_finite())).collect();
    let falling = ends.iter().filter(|(_, limits)| limits.windows(2).all(|pair| pair[1] < pair[0])).count();
    claims.push(
        Claim::in_places(
            "§3, Fig. 4",
            "Delay lowers the largest gain of power-domain communications",
            falling,
            ends.len(),
            format!("{} N/m at K_LC {CONTACT_N_PER_M} N/m, n_t 0, 1, 2, 3; each lower than the one before at {falling} of {} K_LC", list(at_usual(&power)), ends.len()),
        )
        .because("not where the contact, and no coordination, is what is unstable"),
    );
    let right: Vec<String> = ["power", "wave", "passive-wave"]
        .iter()
        .map(|law| {
            let most = computed
                .limits(law)
                .iter()
                .filter(|(_, limits)| limits.iter().any(|limit| limit.is_finite() && *limit > 0.0))
                .map(|(x, _)| *x)
                .fold(0.0, f64::max);
            format!("{law} {most:.0}")
        })
        .collect();
    claims.push(Claim::not_testable(
        "§4.3, Fig. 4",
        "The largest stiffness of the contact, where the regions end at the right",
        format!("some gain is stable up to K_LC of {} N/m", right.join(", ")),
        "the figure is a picture, of which the text gives the ends of the axes only",
    ));
    // §3: a lower gain lessens the coherency.
    let mut discrepancies = Vec::new();
    for share in [1.0, 0.5, 0.25] {
        let outcome = run_at("power", share)?;
        discrepancies.push(outcome.metric(|o| o.whole.true_discrepancy_mm).unwrap_or(f64::NAN));
    }
    claims.push(Claim::holds(
        "§3",
        "A lower coordination gain lessens the coherency of the copies",
        discrepancies.windows(2).all(|pair| pair[1] > pair[0]),
        format!(
            "true discrepancy of power in §5.2 with its gain, half and a quarter of it: {} mm",
            list(&discrepancies)
        ),
    ));
    Ok(claims)
}

fn gains(computed: &Computed<'_>) -> Result<Vec<Claim>, Error> {
    let mut claims = Vec::new();
    for Printed { law, gain_n_per_m: gain, .. } in PRINTED {
        let scene = scene("5.1", law)?;
        let found = crossings(&scene, TO_N_PER_M)?;
        let own = boundary(&found, gain);
        let numbers = (gain, own, "N/m");
        let largest = format!("The largest gain of {law} communications is {gain} N/m (16 ms)");
        let ([least, most], [mass_kg, damping], there) = over_devices(&scene, gain)?;
        let device = format!(
            "of the device the paper gives neither mass nor damping: with {} to {} kg and {} to {} N·s/m the boundary is at {} to {} N/m, nearest with {mass_kg} kg and {damping} N·s/m: {}",
            MASSES_KG[0],
            MASSES_KG[MASSES_KG.len() - 1],
            DAMPINGS_N_S_PER_M[0],
            DAMPINGS_N_S_PER_M[DAMPINGS_N_S_PER_M.len() - 1],
            significant(least, 3),
            significant(most, 3),
            significant(there, 4)
        );
        let claim = Claim::number("§5.1, Fig. 6", &largest, numbers, NUMBER_WITHIN).unless(|| {
            let side = if own > gain { "inside" } else { "outside" };
            let read = match nearest(&scene, gain)? {
                Some((reading, first)) if (first / gain - 1.0).abs() < 0.99 * (own / gain - 1.0).abs() => {
                    format!("of copy and lateness the reading that comes nearest has {} N/m: {reading}", significant(first, 4))
                }
                _ => format!("the gain lies {side} the stable region, and no reading of copy and lateness has a boundary nearer to it"),
            };
            Ok(format!("{read}; {device}"))
        })?;
        let below: Vec<f64> = found.crossings.iter().copied().filter(|crossing| *crossing < 0.99 * own).collect();
        let claim = if below.is_empty() {
            claim
        } else {
            claim.but(format!(
                "this model is not stable at every lower gain: it changes at {} N/m, of which the paper says nothing",
                list(&below)
            ))
        };
        let near = |boundary: f64| (boundary / gain - 1.0).abs() <= NUMBER_WITHIN;
        claims.push(match [near(least) && near(most), near(there)] {
            [true, _] => claim,
            [false, true] => {
                claim.assumed(device.clone()).reached("one of these devices has the paper's gain to 5 %".to_owned())
            }
            [false, false] => claim.assumed(device),
        });
        let stable = computed.experiment("5.1", law, 16.0)?.outcome.is_stable();
        let holds = format!("At {gain} N/m {law} communications are stable with 16 ms round trip");
        claims.push(Claim::holds("§5.1, Fig. 6", &holds, stable, "a run of 20 s, and its eigenvalues".to_owned()));
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
    let [decoded, all_true] = discrepancies_mm(outcomes);
    let mut claims = Vec::new();
    for ((Printed { law, discrepancy_mm: papers, .. }, decoded), copies) in
        PRINTED.into_iter().zip(decoded).zip(all_true)
    {
        let claim = format!("The mean position discrepancy of {law} communications is {papers} mm");
        claims.push(Claim::number("§5.2, Fig. 9", &claim, (papers, decoded, "mm"), WITHIN).but(format!(
            "read as the distance to the remote copy as it is decoded at the same peer, which is F_T/K_T whatever lies between; the copies themselves, at one instant, are {} mm apart",
            significant(copies, 3)
        )));
    }
    let fewer = |of: [f64; 3], at: usize| of[0] / of[at];
    for (at, (name, wanted)) in [(1, ("Waves", 1.0)), (2, ("Passive waves", 2.0))] {
        let word = if wanted == 1.0 { "one order" } else { "two orders" };
        for (which, values) in [("decoded", decoded), ("true", all_true)] {
            let claim = format!("{name} decrease the position discrepancy by {word} of magnitude ({which})");
            let found = format!("{} times", significant(fewer(values, at), 3));
            let holds = fewer(values, at) >= 10.0_f64.powf(wanted);
            let printed = significant(fewer(PRINTED.map(|printed| printed.discrepancy_mm), at), 3);
            claims.push(
                Claim::holds("§5.2, Fig. 9", &claim, holds, found).because(match which {
                    "true" => {
                        "between the copies themselves, at one instant: a wave line is a spring and adds its own way"
                            .to_owned()
                    }
                    _ => format!("nor do the means that the paper prints: they are {printed} times apart"),
                }),
            );
        }
    }
    let sd = outcomes.map(|outcome| outcome.whole.coordination_force_n.sd);
    let mean = outcomes.map(|outcome| outcome.whole.coordination_force_n.mean.abs());
    let peak = outcomes.map(|outcome| outcome.whole.peak_coordination_force_n);
    let lowest = |of: [f64; 3]| of[2] <= of[0].min(of[1]);
    let numbers = |of: [f64; 3]| list(&of);
    let [from, to] = FIGURE_8_S;
    let late = [largest_late("power")?, largest_late("wave")?, largest_late("passive-wave")?];
    let holding = [late, peak].into_iter().filter(|of| lowest(*of)).count();
    claims.push(
        Claim::in_places(
            "§5.2, Fig. 8",
            "Passive waves apply lower coordination forces",
            holding,
            2,
            format!(
                "largest |F_T| {} N for power, wave, passive wave from {from} to {to} s, as Figure 8 shows it; {} N with the start of the run; mean {} N",
                numbers(late),
                numbers(peak),
                numbers(mean)
            ),
        )
        .because("not while the object is met, when the stiffer coupling pulls harder; the means, which the users' pushes set, are alike"),
    );
    let mut all = vec![sd];
    for share in [0.95, 0.9] {
        let deviation = |law| Ok::<_, Error>(run_at(law, share)?.whole.coordination_force_n.sd);
        all.push([deviation("power")?, deviation("wave")?, deviation("passive-wave")?]);
    }
    let smooth = all.iter().filter(|sd| lowest(**sd)).count();
    let words: Vec<String> = all.iter().map(|sd| numbers(*sd)).collect();
    claims.push(
        Claim::in_places(
            "§5.2, Fig. 8",
            "Passive waves apply smoother coordination forces",
            smooth,
            all.len(),
            format!(
                "standard deviation over the last half of the run {} N for power, wave, passive wave; with 0.95 of each gain {}; with 0.9 of it {}",
                words[0], words[1], words[2]
            ),
        )
        .but(format!(
            "much of the waves' deviation is their force that rings near the boundary: of {} N at their gain {} N are left at 0.9 of it",
            significant(sd[1], 3),
            significant(all[2][1], 3)
        )),
    );
    // Robust: within a tenth with twice the delay, in the paper's reading and between the copies themselves.
    let [near, far] = [16.0, 32.0].map(|round_trip_ms| computed.experiment("5.1", "passive-wave", round_trip_ms));
    let outcomes = [&near?.outcome, &far?.outcome];
    let [decoded, copies] = discrepancies_mm(outcomes);
    let robust = [decoded, copies].iter().filter(|[near, far]| (far / near - 1.0).abs() <= WITHIN).count();
    claims.push(
        Claim::in_places(
            "abstract",
            "With passive waves the coherency is robust to the delay",
            robust,
            2,
            format!(
                "mean discrepancy in §5.1 with 16 and 32 ms round trip: decoded {} mm, true {} mm; robust is within {:.0} %",
                list(&decoded),
                list(&copies),
                100.0 * WITHIN
            ),
        )
        .because("a wave line is a spring that is softer the longer it is"),
    );
    Ok(claims)
}

/// Mean discrepancies of these runs, decoded and true, mm.
fn discrepancies_mm<const N: usize>(outcomes: [&Outcome; N]) -> [[f64; N]; 2] {
    let of = |figure: fn(&Outcome) -> f64| outcomes.map(|outcome| outcome.metric(figure).unwrap_or(f64::NAN));
    [of(|outcome| outcome.whole.decoded_discrepancy_mm), of(|outcome| outcome.whole.true_discrepancy_mm)]
}

/// The largest coordination force at peer 2 in the window that Figure 8 shows, N.
fn largest_late(law: &str) -> Result<f64, Error> {
    let scene = scene("5.2", law)?;
    let [from, to] = FIGURE_8_S;
    let outcome = run::<f64>(&scene, Options { duration_s: to, record_every: 1 }, &|_| {})?;
    let table = &outcome.axes[0].table;
    let column = |name: &str| table.column(name).ok_or_else(|| format!("a run has no column {name}"));
    let late = column("time_s")?.iter().zip(column("coordination_2_n")?).filter(|(time_s, _)| **time_s >= from);
    Ok(late.map(|(_, force)| force.abs()).fold(0.0, f64::max))
}
