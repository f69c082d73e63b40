//! What passivity costs, against closed forms: how late a sample is, and that a late line is heavy.

use cohold_sim::run::{Outcome, Verdict};
use cohold_studies::campaign::{CHOICES, Cell, costs};

const PACKET_MS: f64 = 8.0;
const TICK_MS: f64 = 1.0;
/// b, N·s/m, and the two copies together, kg.
const IMPEDANCE: f64 = 10.0;
const COPIES_KG: f64 = 0.6;

#[track_caller]
fn close(got: Option<f64>, want: f64, within: f64, what: &str) {
    assert!(got.is_some_and(|got| (got - want).abs() <= within), "{what}: {got:?}, not {want}");
}

/// How much later than the network a peer acts on the other, ms.
fn added_ms(cost: &Cell) -> Option<f64> {
    cost.swing.map(|swing| 1e3 * swing.delay_s)
}

#[test]
fn every_cost_is_what_its_mechanism_must_cost() {
    let mut costs = costs(cohold_guest_laws::laws()).expect("the table");
    // Closed forms are known where the network alone makes the delay; the self-timed line learns one of its own.
    costs.retain(|cost| cost.law != "self-timed");
    assert_eq!(costs.len(), 2 * (CHOICES.len() - 1));
    // The ledger does not pay for what a plain wave line makes: the copies come apart, and what the hands would feel is no figure.
    let (diverged, costs): (Vec<Cell>, Vec<Cell>) = costs.into_iter().partition(|cost| !cost.is_stable());
    let names: Vec<_> = diverged.iter().map(|cost| (cost.law.as_str(), cost.network.as_str())).collect();
    assert_eq!(names, [("wave + ledger", "no loss"), ("wave + ledger", "20 % lost")]);
    assert!(diverged.iter().all(|cost| cost.count(Verdict::Unstable) == 0 && cost.swing.is_none()));

    let find = |choice: &str, network: &str| -> &Cell {
        costs.iter().find(|cost| cost.law == choice && cost.network == network).expect("the row")
    };

    // Held for M ticks: (M − 1)/2 late on average. The mean of M samples: as much again. A wave leaves the tick after.
    let hold = (PACKET_MS - TICK_MS) / 2.0;
    let power = added_ms(find("power", "no loss"));
    close(power, hold, 0.1, "power");
    let mean = 2.0 * hold + TICK_MS;
    for choice in ["passive-mean", "passive-mean + ledger", "passive-mean + ledger + correction"] {
        close(added_ms(find(choice, "no loss")), mean, 0.1, choice);
    }
    let played = "passive-mean + ledger + correction + play-out";
    close(added_ms(find(played, "no loss")), mean + 2.0 * PACKET_MS, 0.1, played);

    // A sample that is lost leaves the one before: p/(1 − p) packet periods older on average.
    let older = 0.2 / 0.8 * PACKET_MS;
    for cost in costs.iter().filter(|cost| cost.network == "20 % lost") {
        let good = added_ms(find(&cost.law, "no loss")).expect("stable");
        close(added_ms(cost), good + older, 0.4, &cost.law);
    }

    // THEORY §4: a line of impedance b and transit time T weighs b·T more than the copies.
    for cost in costs.iter().filter(|cost| cost.law != "power") {
        let transit_s = 1e-3 * (PACKET_MS + added_ms(cost).expect("stable"));
        close(cost.swing.map(|swing| swing.mass_kg), COPIES_KG + IMPEDANCE * transit_s, 0.01, &cost.law);
    }

    // The ledger is what makes a law passive; correction is what brings the copies together again.
    for cost in costs.iter().filter(|cost| cost.law.contains("ledger")) {
        assert!(cost.worst(Outcome::energy_made_mj).is_some_and(|made| made <= 1e-6), "{cost:?}");
    }
    let [drifting, corrected] = ["passive-mean + ledger", "passive-mean + ledger + correction"]
        .map(|choice| find(choice, "20 % lost").true_discrepancy_mm().expect("stable").mean);
    assert!(corrected < 0.5 * drifting, "{corrected} mm, {drifting} mm without correction");
}
