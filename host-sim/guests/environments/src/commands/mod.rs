//! Commands of the shared environments of the architectures paper.

mod architectures;
mod collaborate;
mod cooperative;
mod hub;
mod squash;
mod world;

use cohold_cli::{Cli, Ui, columns::TableKind};
use cohold_report::Columns;

use crate::cooperative::run;
use crate::studies::architectures as compared;
use crate::world::stroke;
use world::world_keys;

cohold_cli::commands! {
    /// Below `paper`.
    pub(crate) OfThePaper {
        /// The same task in every architecture: coherency, force, stability and bandwidth side by side, to choose by.
        Architectures(architectures::Architectures),
    }
}

cohold_cli::commands! {
    /// Beside the heart's.
    pub(crate) Environments {
        /// Run the architectures paper's shared environments, or a hub for up to 16 peers.
        #[command(subcommand)]
        Shared(Shared),
    }
}

cohold_cli::commands! {
    pub(crate) Shared {
        /// Many users push one object that one dynamics engine moves: limits, bounder, hand-over.
        Cooperative(cooperative::Cooperative),
        /// One at a time edits an object, by a lock or a token ring, over everything that can go wrong.
        Collaborate(collaborate::Collaborate),
        /// Force Feedback Multi-player Squash: 2 to 8 bots play over a network, with the bounders or without.
        Squash(squash::Squash),
        /// Where 2 to 16 live peers hold one object: their wave lines meet in the lossless node, over UDP, sealed.
        Hub(hub::Hub),
        /// A static world: served, visited, summed up, felt.
        #[command(subcommand)]
        World(world::World),
    }
}

/// Adds the shared environments to a command line.
pub fn join(cli: Cli) -> Cli {
    cli.with_commands::<OfThePaper>("paper")
        .with_commands::<Environments>("")
        .with_tables(tables)
        .with_paper(crate::studies::PAPER)
        .with_listing("world-keys", world_keys)
        .with_environments(&crate::play::PLAYABLE)
}

/// Kinds of tables that these commands write.
fn tables(_: &Ui) -> Vec<TableKind> {
    let simulated = "a control period; in a long run one of several";
    vec![
        TableKind::new(
            "architectures",
            "architectures.csv, reproduce-architectures.csv",
            "an architecture at a delay",
            compared::columns(&[]),
        ),
        TableKind::new("shared-cooperative", "cooperative.csv", simulated, Columns::named(run::COLUMNS)),
        TableKind::new("shared-stroke", "shape.csv", "a control period", Columns::named(stroke::COLUMNS)),
    ]
}
