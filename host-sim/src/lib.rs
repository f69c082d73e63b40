//! The `cohold` command: the heart's command line, and the list of guests who join it.
#![forbid(unsafe_code)]

pub use cohold_cli::Cli;

/// The command line with every guest. With a law of your own it is `command_line().with_laws(|laws| laws.with::<Mine>())`.
pub fn command_line() -> Cli {
    let cli = Cli::default().built_from(option_env!("COHOLD_COMMIT"));
    // To leave a guest out, delete its line here and in `Cargo.toml`.
    let cli = cohold_papers::join(cli);
    let cli = cohold_page::join(cli);
    let cli = cohold_environments::join(cli);
    let cli = cohold_homes::join(cli);
    let cli = cohold_devices::join(cli);
    cli.with_groups(&[
        ("Simulate and see", &["play", "cooperate", "scene", "paper"]),
        ("Analyse and compare", &["stability", "study", "accuracy"]),
        ("Connect real peers", &["peer", "meet", "shared", "network", "key"]),
        ("Use devices and boards", &["devices", "board"]),
        ("Read data", &["recording"]),
    ])
}
