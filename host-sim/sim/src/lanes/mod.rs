//! Many similar scenes simulated at once (SIMD): the peers of core, the network and the devices compute with
//! [`number::LANES`] numbers in the place of one, a lane for each scene.
//!
//! **Results** are to the bit what each scene gives alone. Scenes of one kind have the same law, network and timing, so that their packets leave
//! together; everything else may differ. Their seeds may, too, where what becomes of packets is not drawn, or the law only holds what it
//! receives ([`cohold_core::law::Law::only_holds`]): then packets are lost and late in each lane by itself (`mailbox`). A scene that is not
//! built as the others of its kind are, or that takes another branch than most (a limit, a fault, a contact let go), leaves, and is run alone
//! from the start: exact, and slow, although its figures and hash are the lanes' until where it left. So lanes pay where scenes differ in
//! gains, masses, users and seeds; not where contact comes and goes.
//!
//! **Left out**: devices with encoders, motors, windings, friction or faults, impulsive contact, and laws that keep `f64` beside their
//! number type (ledger, `self-timed`): these are run alone.
//!
//! **How fast** depends on the vectors of the processor that the program is compiled for: docs/results/speed.md.

mod device;
mod kinds;
mod mailbox;
pub mod number;
mod pairs;
mod run;

pub use self::pairs::Pairs;
pub use self::run::{How, run};
