//! The guests of the command line, and the page among them: [`command_line`] lists them.
#![forbid(unsafe_code)]

mod environments;
mod play;
mod published;

pub use cohold_cli::Cli;
pub use cohold_guest_laws::laws;
#[cfg(fuzzing)]
pub use play::page_hears;

/// The command line with every guest; with a law of your own it is `command_line().with_laws(laws().with::<Mine>())`.
pub fn command_line() -> Cli {
    Cli::default()
        .with_groups(&[
            ("Simulate and see", &["play", "cooperate", "scene", "paper"]),
            ("Analyse and compare", &["stability", "study", "accuracy"]),
            ("Connect real peers", &["peer", "meet", "shared", "network", "key"]),
            ("Use devices and boards", &["devices", "board"]),
            ("Read data", &["recording"]),
        ])
        .with_laws(laws())
        .with_proofs(cohold_guest_laws::prove)
        .with_commands::<published::Papers>("paper")
        .with_tables(published::tables)
        .with_commands::<play::PageCommands>("")
        .with_tables(play::tables)
        .with_commands::<environments::OfThePaper>("paper")
        .with_commands::<environments::Environments>("")
        .with_tables(environments::tables)
        .with_paper(cohold_environments::studies::PAPER)
        .with_listing("world-keys", environments::world_keys)
        .with_commands::<cohold_homes::MeetCommands>("")
        .with_commands::<cohold_homes::BoardCommands>("board")
        .with_road::<cohold_homes::MeetingFlags>(&cohold_homes::MEETING, cohold_homes::declare)
        .with_adapters(&cohold_devices::ADAPTERS)
        .with_commands::<cohold_devices::Emulation>("devices")
}
