//! Cooperative: all users push the same object at the same time, one dynamics engine moves it (Buttolo et al. 1997, §3.3).
//!
//! Every client renders its own contact against the last motion of the object that it was told ([`State`]) and says with
//! what force it pushes ([`Push`]); whoever has the dynamics engine adds the forces up, moves the object and tells everybody.
//! That is the server, or for a while the client whose manipulation needs its quality: there the loop has no network in it.
//!
//! **The engine moves without a jump**: the motion travels with the right to change it ([`Message::Lend`],
//! [`Message::Return`]), and every transfer has a higher version, which also numbers what the engine tells. Between the one
//! who let go and the one who takes over the object stands, for one delay; nobody moves it twice.
//!
//! **Never two engines**, whatever the network does and whoever vanishes. Who lends lets go first, and takes back only what
//! is returned or after [`Lease::giver_us`]; who holds lets go after [`Lease::holder_us`], which is an eighth shorter and
//! counts from *before* the request that was answered. So it ends first, by any delay, with clocks whose rates differ by
//! less than 6 % (Gray & Cheriton, SOSP 1989). **Progress**: one who vanishes with the engine costs [`Lease::giver_us`], one
//! whom nothing reaches in time at most twice that and the longest delay; then the server goes on from the last motion that it was told. A lease must be
//! longer than the round trip, or nobody can hold it.
//!
//! Messages are of at most 48 bytes and may be lost, doubled, late and out of order: what must arrive is said again until it
//! is answered. Of the carrier is asked what a sealed session gives: who it is from, and nothing from an earlier
//! incarnation of either end. Time is µs on the own clock, which never goes backwards.

mod client;
mod message;
mod server;

pub use client::{Client, Told};
pub use message::{Body, Malformed, Message, Push, State};
pub use server::{Heard, Server};

use core::fmt;

/// How long a right lasts that nobody renews.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lease(u32);

/// A lease that is too short to renew or too long to wait for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OutOfRange(pub u32);

impl fmt::Display for OutOfRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "a lease of {} us is not allowed: it must be from {} to {} us",
            self.0,
            Lease::LEAST_US,
            Lease::MOST_US
        )
    }
}

impl core::error::Error for OutOfRange {}

impl Lease {
    /// Shortest, µs: some packets must fit into it.
    pub const LEAST_US: u32 = 10_000;
    /// Longest, µs.
    pub const MOST_US: u32 = 60_000_000;

    /// A lease of `us` µs.
    ///
    /// # Errors
    /// Outside [`Lease::LEAST_US`] to [`Lease::MOST_US`].
    pub fn new(us: u32) -> Result<Self, OutOfRange> {
        if (Self::LEAST_US..=Self::MOST_US).contains(&us) { Ok(Self(us)) } else { Err(OutOfRange(us)) }
    }

    /// How long who lent the engine waits, µs.
    pub fn giver_us(self) -> u64 {
        u64::from(self.0)
    }

    /// How long who holds it may move the object, µs.
    pub fn holder_us(self) -> u64 {
        u64::from(self.0 - self.0 / 8)
    }

    /// How often it is renewed, and anything unanswered said again, µs.
    pub fn retry_us(self) -> u64 {
        u64::from(self.0 / 8)
    }
}
