//! Devices that hold a force back for whole ticks, as one behind a bus or a network does: the stiffest contact of the recommended scene.

use cohold_analysis::{Effort, Range, limit};
use cohold_sim::scenes;

use super::winding;

/// The recommended scene, whose line has a time of its own: its stiffest contact by the analyser and by runs, to 2.5 %.
#[test]
fn the_limit_of_a_contact_falls_with_the_delay_as_runs_say() {
    let mut before = f64::INFINITY;
    for delay in [1.0, 2.0, 4.5, 20.0] {
        // What limits take of a contact is passive, and would settle.
        let keys = ["safety.max_force_n=200", "safety.max_slew_n_per_s=1000000"].map(str::to_owned);
        let mut scene =
            scenes::find(cohold_guest_laws::laws(), Some(std::path::Path::new("any-network")), &keys).expect("a scene");
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
