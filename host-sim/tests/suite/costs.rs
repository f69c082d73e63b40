//! What passivity costs, against closed forms: how late a sample is, and that a late line is heavy.

use host_sim::studies::costs::{CHOICES, Cost, costs};

const PACKET_MS: f64 = 8.0;
const TICK_MS: f64 = 1.0;
/// b, N·s/m, and the two copies together, kg.
const IMPEDANCE: f64 = 10.0;
const COPIES_KG: f64 = 0.6;

#[track_caller]
fn close(got: Option<f64>, want: f64, within: f64, what: &str) {
    assert!(got.is_some_and(|got| (got - want).abs() <= within), "{what}: {got:?}, not {want}");
}

#[test]
fn every_cost_is_what_its_mechanism_must_cost() {
    let mut costs = costs(haptic_sim::Laws::built_in()).expect("the table");
    // Closed forms are known for the choices that are named there, not for a law that is only in core's list.
    costs.retain(|cost| CHOICES.iter().any(|(name, _)| *name == cost.choice));
    assert_eq!(costs.len(), 2 * CHOICES.len());
    let find = |choice: &str, network: &str| -> &Cost {
        costs.iter().find(|cost| cost.choice == choice && cost.network == network).expect("the row")
    };
    assert!(costs.iter().all(|cost| cost.stable), "{costs:?}");

    // Held for M ticks: (M − 1)/2 late on average. The mean of M samples: as much again. A wave leaves the tick after.
    let hold = (PACKET_MS - TICK_MS) / 2.0;
    let power = find("power", "no loss").added_delay_ms;
    close(power, hold, 0.1, "power");
    let mean = 2.0 * hold + TICK_MS;
    for choice in ["passive-mean", "passive-mean + ledger", "passive-mean + ledger + correction"] {
        close(find(choice, "no loss").added_delay_ms, mean, 0.1, choice);
    }
    let played = "passive-mean + ledger + correction + play-out";
    close(find(played, "no loss").added_delay_ms, mean + 2.0 * PACKET_MS, 0.1, played);

    // A sample that is lost leaves the one before: p/(1 − p) packet periods older on average.
    let older = 0.2 / 0.8 * PACKET_MS;
    for cost in costs.iter().filter(|cost| cost.network == "20 % lost") {
        let good = find(&cost.choice, "no loss").added_delay_ms.expect("stable");
        close(cost.added_delay_ms, good + older, 0.4, &cost.choice);
    }

    // THEORY §4: a line of impedance b and transit time T weighs b·T more than the copies.
    for cost in costs.iter().filter(|cost| cost.choice != "power") {
        let transit_s = 1e-3 * (PACKET_MS + cost.added_delay_ms.expect("stable"));
        close(cost.apparent_mass_kg, COPIES_KG + IMPEDANCE * transit_s, 0.01, &cost.choice);
    }

    // The ledger is what makes a comm passive; correction is what brings the copies together again.
    for cost in costs.iter().filter(|cost| cost.choice.contains("ledger")) {
        assert!(cost.energy_out_over_in <= 1.0 + 1e-9, "{cost:?}");
    }
    let [drifting, corrected] = ["passive-mean + ledger", "passive-mean + ledger + correction"]
        .map(|choice| find(choice, "20 % lost").true_discrepancy_mm);
    assert!(corrected < 0.5 * drifting, "{corrected} mm, {drifting} mm without correction");
}
