//! Devices that hold a force back for whole ticks, as one behind a bus or a network does: random scenes that are let run, and the stiffest
//! contact of the recommended scene.

use haptic_analysis::{Analyser, Effort, Range, limit};
use haptic_sim::{Laws, scenes};
use rayon::prelude::*;

use super::kinds::held_back;
use super::{envelope, winding};

/// What is called stable settles, and what is not grows.
#[test]
fn runs_show_what_the_verdict_says_of_devices_that_hold_forces_back() {
    let found: Vec<bool> = (2_000_000..2_000_600_u64)
        .into_par_iter()
        .map_init(Analyser::default, |analyser, seed| {
            let linear = held_back(seed).linear();
            (seed, analyser.verdict(&linear).expect("a good scene"), linear)
        })
        .filter(|(_, verdict, _)| verdict.not_judged_because.is_none() && (verdict.spectral_radius - 1.0).abs() > 1e-3)
        .map(|(seed, verdict, linear)| {
            let settles = envelope::settles(&linear, &verdict, seed);
            assert_eq!(settles, Some(verdict.stable), "scene {seed}: {verdict:?}\n{linear:?}");
            verdict.stable
        })
        .collect();
    let stable = found.iter().filter(|stable| **stable).count();
    println!("{stable} of {} are stable", found.len());
    assert!(stable > 60 && found.len() - stable > 60, "{stable} of {} are stable", found.len());
}

/// The recommended scene, whose line has a time of its own: its stiffest contact by the analyser and by runs, to 2.5 %.
#[test]
fn the_limit_of_a_contact_falls_with_the_delay_as_runs_say() {
    let mut before = f64::INFINITY;
    for delay in [1.0, 2.0, 4.5, 20.0] {
        // What limits take of a contact is passive, and would settle.
        let keys = ["safety.max_force_n=200", "safety.max_slew_n_per_s=1000000"].map(str::to_owned);
        let mut scene =
            scenes::find(Laws::built_in(), Some(std::path::Path::new("any-network")), &keys).expect("a scene");
        scene.set_number("device.force_delay_ticks", delay).expect("it is allowed");
        let range = Range { key: "contact.stiffness_n_per_m".to_owned(), from: 10.0, to: 9000.0 };
        let found = limit(&scene, range, Effort { steps: 100, ..Effort::default() }).expect("a good scene");
        assert!(found.stable_at_start);
        let analysed = found.crossings[0];
        let (below, above) = (winding::settles(&scene, 0.975 * analysed), winding::settles(&scene, 1.025 * analysed));
        println!("{delay} ticks: {analysed:.0} N/m");
        assert!(below && !above && analysed < before, "{delay} ticks, {analysed} N/m: {below} below, {above} above");
        before = analysed;
    }
}
