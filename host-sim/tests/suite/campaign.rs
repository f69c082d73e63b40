//! The fault campaign: what passive communications promise on any network, and a reviewed snapshot of the whole table.

use host_sim::studies::campaign::{COMMS, Cell, campaign};

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/campaign.txt");

fn line(cell: &Cell) -> String {
    let Cell { comm, network, outcome, .. } = cell;
    let fault = outcome.fault.map_or_else(|| "-".to_owned(), |(peer, fault)| format!("peer {peer}: {fault:?}"));
    format!(
        "{comm} | {network} | {} | {:.4} | {:.2} | {:.2} | {fault}",
        outcome.bounded,
        outcome.energy_out_over_in(),
        outcome.peak_coordination_force_n,
        outcome.true_discrepancy_mm
    )
}

#[test]
fn passive_comms_hold_on_every_network_and_the_table_is_as_reviewed() {
    let cells = campaign(haptic_sim::Laws::built_in()).expect("the campaign runs");
    for cell in cells.iter().filter(|cell| cell.passive()) {
        assert!(cell.outcome.bounded, "{} diverges: {}", cell.comm, cell.network);
        assert!(cell.outcome.energy_out_over_in() <= 1.0 + 1e-9, "{} over {} makes energy", cell.comm, cell.network);
        // The silence ladder and the slew of the forces: no blow, whatever the network does.
        assert!(
            cell.outcome.largest_jump_n < 10.0,
            "{} over {} jerks by {} N",
            cell.comm,
            cell.network,
            cell.outcome.largest_jump_n
        );
    }
    // The campaign would prove nothing if it broke nothing.
    let broken = cells.iter().filter(|cell| cell.comm == "power" && !cell.outcome.bounded).count();
    assert!(broken >= 10, "only {broken} networks break the power-domain coupling");
    let held_energy =
        cells.iter().filter(|cell| cell.comm == "wave" && cell.outcome.energy_out_over_in() > 1.001).count();
    assert!(held_energy >= 5, "only {held_energy} networks make the plain wave line generate energy");

    // The table is of the comms that are named there; a law that is only in core's list has rows after them.
    let named = cells.iter().filter(|cell| COMMS.iter().any(|(name, ..)| *name == cell.comm));
    let table = "comm | network | stable | energy out/in | peak N | true mm | fault\n".to_owned()
        + &named.map(line).collect::<Vec<_>>().join("\n")
        + "\n";
    if std::env::var_os("BLESS").is_some() {
        std::fs::write(FILE, &table).expect("write the snapshot");
    }
    assert_eq!(
        table,
        std::fs::read_to_string(FILE).expect("the snapshot"),
        "run with BLESS=1 and review the difference"
    );
}
