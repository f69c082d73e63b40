//! The fault campaign: what passive communications promise on any network, and a reviewed snapshot of the whole table.

use cohold_sim::run::{Outcome, Verdict};
use cohold_studies::campaign::{COMMS, Cell, campaign, columns};

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/campaign.txt");

#[test]
fn passive_comms_hold_on_every_network_and_the_table_is_as_reviewed() {
    let cells = campaign(cohold_guest_laws::laws()).expect("the campaign runs");
    for cell in cells.iter().filter(|cell| cell.passive) {
        let name = format!("{} over {}", cell.law, cell.network);
        let largest = |of: fn(&Outcome) -> f64| cell.outcomes.iter().map(of).fold(0.0, f64::max);
        // A packet a tick is more than this line carries: packets wait until they are older than safety.max_delay_s.
        if name == "self-timed over bandwidth 110 kbit/s" {
            assert!(cell.reason().is_some_and(|reason| reason.contains("PeerDelayed")), "{:?}", cell.reason());
            continue;
        }
        assert!(cell.outcomes.iter().all(|outcome| outcome.bounded), "{name} diverges: {:?}", cell.reason());
        let made_mj = largest(Outcome::energy_made_mj);
        assert!(made_mj <= 1e-6, "the line of {name} makes energy: {made_mj} mJ");
        // The degradation by silence and the slew of the forces: no blow, whatever the network does.
        let jump_n = largest(|outcome| outcome.whole.largest_jump_n);
        assert!(jump_n < 10.0, "{name} jerks by {jump_n} N");
    }
    // The campaign would prove nothing if it broke nothing.
    let count = |law: &str, of: &dyn Fn(&&Cell) -> bool| cells.iter().filter(|cell| cell.law == law).filter(of).count();
    let broken = count("power", &|cell| cell.count(Verdict::Unstable) > 0);
    assert!(broken >= 15, "only {broken} networks break the power-domain coupling");
    let held_energy = count("wave", &|cell| cell.outcomes.iter().any(|outcome| outcome.energy_made_mj() > 0.1));
    assert!(held_energy >= 5, "only {held_energy} networks make the plain wave line generate energy");
    // Neither does stable in a run mean stable when somebody lets go: waves at 16 ms are not, once nobody holds either device.
    let let_go = |cell: &&Cell| cell.network == "none" && cell.is_stable() && cell.unstable_modes == "none";
    assert_eq!((count("wave", &let_go), count("self-timed", &let_go)), (1, 0));
    // Nor does passive mean together: bursts take the copies apart, in every seed.
    for bursts in ["bursts of 40 ms, 20 %", "bursts of 100 ms, 5 %", "bursts of 100 ms, 50 %"] {
        let apart = |cell: &&Cell| cell.network == bursts && cell.count(Verdict::Apart) == cell.outcomes.len();
        assert_eq!(count("passive-mean + ledger + correction", &apart), 1, "{bursts}");
    }

    // The table is of the laws that are named there; a law that is only in core's list has rows after them.
    let named: Vec<Cell> = cells.into_iter().filter(|cell| COMMS.iter().any(|(name, ..)| *name == cell.law)).collect();
    let table = columns(&named).to_string();
    if std::env::var_os("BLESS").is_some() {
        std::fs::write(FILE, &table).expect("write the snapshot");
    }
    assert_eq!(
        table,
        std::fs::read_to_string(FILE).expect("the snapshot"),
        "run with BLESS=1 and review the difference"
    );
}
