//! `host-sim shared`: the shared environments of the architectures paper.

mod collaborate;
mod cooperative;
mod squash;
mod world;

super::commands! {
    Shared {
        /// Many users push one object that one dynamics engine moves: limits, bounder, hand-over.
        Cooperative(cooperative::Cooperative),
        /// One at a time edits an object, by a lock or a token ring, over everything that can go wrong.
        Collaborate(collaborate::Collaborate),
        /// Force Feedback Multi-player Squash: 2 to 8 bots play over a network, with the bounders or without.
        Squash(squash::Squash),
        /// A static world: served, visited, summed up, felt.
        #[command(subcommand)]
        World(world::World),
    }
}
