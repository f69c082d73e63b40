//! The architectures paper's claims: §2.3 with Figure 4, §3.2, §3.3 with equation 7; those on systems are in `systems.rs`.

use crate::collaborative::{Scheme, Trial, campaign};
use crate::cooperative::limits;
use cohold_analysis::rendering::Rendering;
use cohold_analysis::rendering::closed::largest_stiffness;
use cohold_analysis::rendering::identify::{DELAY_S, NETWORK, PERIOD_S, STIFFNESS_N_PER_M, identify, wall};
use cohold_analysis::rendering::maps::{at, largest};
use cohold_report::significant;
use cohold_studies::reproduce::{Claim, list, of, span};

use super::architectures::{Architecture, Row};
use super::systems;
use cohold_studies::Error;

/// Devices for which the paper's two statements are tried, kg.
const MASSES_KG: [f64; 3] = [0.02, 0.1, 1.0];

/// Runs of lock and token ring each.
const RUNS: u64 = 200;

/// Between these an object feels rigid, by §2, N/m.
const RIGID_N_PER_M: [f64; 2] = [1e3, 1e4];

/// What is left of a stiffness that drops dramatically: less than this part.
const DRAMATIC: f64 = 0.1;

/// How near a stiffness is to be to the paper's.
const WITHIN: f64 = 0.05;

/// All of them; `rows` are of every architecture at every delay.
pub(super) fn claims(rows: &[Row]) -> Result<Vec<Claim>, Error> {
    let all = [stability_maps()?, collaborative(), cooperative(rows)?, systems::claims(rows)?];
    Ok(of("architectures", all.concat()))
}

fn stability_maps() -> Result<Vec<Claim>, Error> {
    let devices = MASSES_KG.into_iter().map(identify).collect::<Result<Vec<_>, _>>()?;
    let described = devices.iter().map(|device| {
        let (mass, damping, late) = (device.mass_kg, device.damping_n_s_per_m, device.computing_ticks);
        format!("{mass} kg: b = {damping:.2} N·s/m and {late:.2} of a period of computing")
    });
    let own = devices[1];
    let device = wall(own.mass_kg, own.damping_n_s_per_m, own.computing_ticks);
    let periods_s = [1e-3, 2e-3, PERIOD_S, 0.01, 0.02];
    let sampled = periods_s.map(|period_s| largest(&Rendering { period_s, ..device }));
    let sampled = sampled.into_iter().collect::<Result<Vec<_>, _>>()?;
    let delays_s = [1e-3, 2e-3, DELAY_S, 0.01, 0.02, 0.03];
    let delayed = delays_s.map(|delay_s| largest(&at(&device, NETWORK, delay_s, None)));
    let delayed = delayed.into_iter().collect::<Result<Vec<_>, _>>()?;
    // Each lower than the one before, and the last less than a tenth of the first.
    let falls = |values: &[f64]| {
        values.windows(2).all(|pair| pair[1] < pair[0])
            && values.last().zip(values.first()).is_some_and(|(last, first)| last < &(DRAMATIC * first))
    };
    let reached = RIGID_N_PER_M.into_iter().filter(|stiffness| *stiffness <= sampled[0]).count();
    Ok(vec![
        Claim::in_places(
            "§2",
            "A rigid object takes 1000 to 10000 N/m",
            reached,
            RIGID_N_PER_M.len(),
            format!("at 1 kHz without delay a device of 0.1 kg renders up to {} N/m", significant(sampled[0], 3)),
        )
        .because("with the damping that the paper's own 200 Hz and 5 ms imply, and one rate"),
        Claim::not_testable(
            "§2.3",
            "1000 N/m need at least 200 Hz and less than 5 ms",
            format!("both hold at once for {}", described.collect::<Vec<_>>().join("; ")),
            "two statements, and the device's damping and computing time are not given: two values fitted to two numbers prove nothing",
        ),
        Claim::holds(
            "§2.3, Fig. 4",
            "A lower sampling rate lowers the largest stiffness dramatically",
            falls(&sampled),
            format!(
                "{} N/m at 1, 2, 5, 10, 20 ms, for that device of 0.1 kg: always lower, and at last by more than ten times",
                list(&sampled)
            ),
        ),
        Claim::holds(
            "§2.3, Fig. 4",
            "Delay lowers the largest stiffness dramatically",
            falls(&delayed),
            format!(
                "{} N/m at 1, 2, 5, 10, 20, 30 ms, sampled 40 times in a delay: the same rule; b/delay is {} at 5 ms",
                list(&delayed),
                significant(largest_stiffness(&at(&device, NETWORK, DELAY_S, None)), 3)
            ),
        ),
        Claim::not_testable(
            "§2.3, Fig. 4",
            "The measured stability maps",
            "the same maps for any device: cohold stability rendering".to_owned(),
            "mass, damping and computing time of the device are not given",
        ),
    ])
}

fn collaborative() -> Vec<Claim> {
    let of = |scheme, name: &str| {
        let verdict = campaign(&Trial { scheme, users: 4, seed: 1, mistake: None }, RUNS, &|| {});
        let claim = format!("With {name} one user at a time edits, and no edit is lost");
        let (owners, lost, stuck) = (verdict.two_owners, verdict.lost_update, verdict.no_progress);
        let found = format!(
            "{} runs of 4 users with loss, reorder and crashes: {owners} with two owners, {lost} with a lost update, {stuck} stuck; {} edits",
            verdict.runs, verdict.published
        );
        Claim::holds("§3.2", &claim, owners + lost + stuck == 0 && verdict.published > 0, found)
    };
    vec![of(Scheme::Lock, "a central server"), of(Scheme::Ring, "a token ring")]
}

fn cooperative(rows: &[Row]) -> Result<Vec<Claim>, Error> {
    let mut claims = Vec::new();
    let table = limits::table()?;
    for round_trip_ms in [5.0, 10.0, 30.0] {
        let here: Vec<_> = table.iter().filter(|one| one.round_trip_ms == round_trip_ms).collect();
        let [low, high] = span(here.iter().map(|one| one.simulated_n_per_m));
        let found = format!(
            "{} to {} N/m, contact at the server and at the clients",
            significant(low, 3),
            significant(high, 3)
        );
        let wanted = format!("{found}; at least {STIFFNESS_N_PER_M} ± {:.0} %", 100.0 * WITHIN);
        claims.push(if round_trip_ms == 30.0 {
            Claim::not_testable(
                "§3.3, eq. 7",
                "30 ms are enough for soft objects",
                found,
                "the paper says of no stiffness that it is soft",
            )
        } else {
            let claim =
                format!("{round_trip_ms} ms are short enough for stiff objects ({STIFFNESS_N_PER_M} N/m and more)");
            let needs = STIFFNESS_N_PER_M * 1e-3 * round_trip_ms;
            Claim::holds("§3.3, eq. 7", &claim, low >= (1.0 - WITHIN) * STIFFNESS_N_PER_M, wanted)
                .because(format!(
                    "with the damping that the paper's own 200 Hz and 5 ms imply; by b/delay {needs} N·s/m are needed"
                ))
                .circular("the damping was found from the paper's own 200 Hz and 5 ms")
        });
    }
    claims.push(Claim::not_testable(
        "§3.3, Fig. 10",
        "The cooperative system worked for latencies below 30 ms",
        "see equation 7".to_owned(),
        "of its devices and objects nothing is given",
    ));
    let of = |architecture: Architecture| rows.iter().filter(move |row| row.architecture == architecture);
    let stable = |architecture| (of(architecture).filter(|row| row.stable).count(), of(architecture).count());
    let [bounded, unbounded] = [Architecture::CooperativeServer, Architecture::CooperativeServerUnbounded].map(stable);
    let left: Vec<String> = of(Architecture::CooperativeServer)
        .map(|row| {
            format!("{} N/m at {} ms", significant(row.contact_n_per_m[0].min(row.contact_n_per_m[1]), 3), row.delay_ms)
        })
        .collect();
    claims.push(
        Claim::holds(
            "§3.3",
            "An adaptive dynamic bounder keeps the simulation stable by lowering the stiffness with the round trip",
            bounded.0 == bounded.1 && unbounded.0 < unbounded.1,
            format!(
                "{} of {} delays stable with it, {} without, 0 to 200 ms one way",
                bounded.0, bounded.1, unbounded.0
            ),
        )
        .but(format!(
            "the stiffness that it leaves is {}; packets of 8 ms lower it without any delay, and a packet in the middle of a period waits for the next",
            left.join(", ")
        )),
    );
    let longest = of(Architecture::CooperativeClient).max_by(|a, b| a.delay_ms.total_cmp(&b.delay_ms));
    let stiffness = longest.map_or([f64::NAN; 2], |row| row.contact_n_per_m);
    let delay_ms = longest.map_or(f64::NAN, |row| row.delay_ms);
    claims.push(Claim::holds(
        "§3.3",
        "With the dynamics engine at a client, its own loop holds no transmission; the others' do",
        stiffness[0] > stiffness[1],
        format!(
            "at {delay_ms} ms the bounder leaves it {} N/m, the other {} N/m",
            significant(stiffness[0], 3),
            significant(stiffness[1], 3)
        ),
    ));
    Ok(claims)
}
