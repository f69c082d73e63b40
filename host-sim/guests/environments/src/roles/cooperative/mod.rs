//! Cooperative: all users push the same object at the same time, one dynamics engine moves it (Buttolo et al. 1997, §3.3).
//!
//! Every client renders its own contact against the last motion of the object that was announced to it ([`cohold_protocol::wire::Moved`]) and says with
//! what force it pushes ([`cohold_protocol::wire::Push`]); whoever has the dynamics engine adds the forces up, moves the object and tells everybody.
//! That is the server, or for a while the client whose manipulation needs its quality: there the loop has no network in it.
//!
//! **The engine moves without a jump**: the motion travels with the right to change it ([`Message::Lend`],
//! [`Message::Return`]), and every transfer has a higher version, which also numbers what the engine tells. Between the one
//! who let go and the one who takes over the object stands, for one delay; nobody moves it twice.
//!
//! **Never two engines**, whatever the network does and whoever vanishes. Who lends lets go first, and takes back only what
//! is returned or after [`Lease::giver_us`]; who holds lets go after [`Lease::holder_us`], which is an eighth shorter and
//! counts from *before* the request that was answered. So it ends first, by any delay, with clocks whose rates differ by
//! less than [`Lease::MAX_DRIFT_PPM`]. **Progress**: one who vanishes with the engine costs [`Lease::giver_us`], one
//! whom nothing reaches in time at most twice that and the longest delay; then the server goes on from the last motion that it
//! was told. A lease must be longer than the round trip, or nobody can hold it. **Limit**: a server keeps no record of what it has
//! lent; one that starts anew may do so only [`Lease::giver_us`] after the one before it ended.
//!
//! Hand-over messages are events ([`Message`]), pushes and motions are kinds of their own; all of them
//! may be lost, doubled, late and out of order: what must arrive is said again until it is answered. Of the carrier is asked
//! what a sealed session gives: who it is from, and nothing from an earlier incarnation of either end. Time is µs on the own
//! clock, which never goes backwards.

pub use super::collaborative::{Lease, OutOfRange};

mod client;
mod message;
mod server;

pub use client::{Client, Notice};
pub use message::{Body, Message};
pub use server::Server;
