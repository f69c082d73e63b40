//! The guests of the command line, and the page among them: [`command_line`] lists them.
#![forbid(unsafe_code)]

mod environments;
mod play;
mod published;

pub use haptic_cli::Cli;
pub use haptic_guest_laws::laws;
#[cfg(fuzzing)]
pub use play::page_hears;

/// The command line with every guest.
///
/// ```no_run
/// // With a law of your own beside the others, if `Mine` is its family.
/// host_sim::command_line().with_laws(host_sim::laws()).main();
/// ```
pub fn command_line() -> Cli {
    Cli::default()
        .with_laws(laws())
        .with_proofs(haptic_guest_laws::prove)
        .with_commands::<published::Papers>("paper")
        .with_tables(published::tables)
        .with_commands::<play::PageCommands>("")
        .with_tables(play::tables)
        .with_commands::<environments::OfThePaper>("paper")
        .with_commands::<environments::Environments>("")
        .with_tables(environments::tables)
        .with_paper(haptic_environments::studies::PAPER)
        .with_listing("world-keys", environments::world_keys)
        .with_commands::<haptic_homes::MeetCommands>("")
        .with_commands::<haptic_homes::BoardCommands>("board")
        .with_road::<haptic_homes::MeetingFlags>(&haptic_homes::MEETING, haptic_homes::declare)
        .with_adapters(&haptic_devices::ADAPTERS)
        .with_commands::<haptic_devices::Emulation>("devices")
}
