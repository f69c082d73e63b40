//! Lock: a central server says who may edit an object and keeps the only official copy (Buttolo et al. 1997, §3.2, scheme 1).
//!
//! ```text
//! client   Idle ──ask──► Asking ──grant──► Owner ──release──► Releasing ──answer──► Idle
//!                          ▲ withdraw        │ lease ran out (the hand keeps its local copy; it is not copied)
//! ```
//!
//! | rule | because |
//! |---|---|
//! | first come first served, one grant at a time, each with a higher **fence** number | a release counts only under the newest fence: what comes late cannot overwrite |
//! | an owner asks again all the time; its [`Lease`] runs from the sending of an ask that was answered, the server's from its reception | a vanished owner's lock expires, after it has stopped |
//! | the version of a state is the fence it was made under | a state is newer if its number is higher, and nobody needs to agree on more |
//! | the server answers every release, twice if it comes twice | the client knows whether its work is in the official copy |
//! | after a restart the server gives nothing out for one lease | somebody may still hold what it has forgotten |
//! | who follows says which version it has; who has an older one is notified | a lost publication is repaired at the next call |
//!
//! One [`Server`] and one [`Client`] per object and peer: the message names the object. [`Lease::retry_us`] sets all repetition.
//!
//! **Progress**: while the server and a client hear each other, a client that asks is granted within [`wait_bound_us`].
//! **Limits**: fences are 32 bits (6 years at 20 grants a second), then the server grants no more; so are a client's asks (6
//! years of asking under a lease of 300 ms, 82 days under the shortest), then it must start anew; a server serves as many
//! clients as its type says, further ones are not heard until others have been silent for a lease.

mod client;
mod message;
mod server;

pub use client::{Client, Notice, Phase};
pub use message::{Copy, Message};
pub use server::{Record, Server};

use super::Lease;

/// How long a client that asks may have to wait for its grant, µs, if nobody loses a message from now on: a vanished owner's
/// lease, or the server's own after a restart, then every other client once, each for `edit_us` at the most and four
/// messages of `delay_us`, said again where the answer is late.
pub fn wait_bound_us(lease: Lease, clients: u64, edit_us: u64, delay_us: u64) -> u64 {
    let turn = edit_us.saturating_add(delay_us.saturating_mul(4)).saturating_add(lease.retry_us().saturating_mul(2));
    // Twice the lease: a client that vanished while it waited may be granted first, and let it run out once more.
    lease.giver_us().saturating_mul(2).saturating_add(turn.saturating_mul(clients))
}
