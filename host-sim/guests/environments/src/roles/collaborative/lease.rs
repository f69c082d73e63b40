//! Who wants to edit, and for how long one may: a right that runs out by itself, at its holder before at its giver.

use cohold_protocol::notices::Notices;

/// A lease may not be that long.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a lease of {us} us is not allowed: it must be from {} to {} us", Lease::SHORTEST_US, Lease::LONGEST_US)]
pub struct OutOfRange {
    /// What was asked for, µs.
    pub us: u32,
}

/// A right that runs out by itself when it is not renewed.
///
/// It runs from the *sending* of the request at who holds it and from the *reception* at who gave it, and 1/8 shorter at the
/// holder. So the holder's right ends first, by any delay and with any two clocks that differ by no more than
/// [`Lease::MAX_DRIFT_PPM`]: 7/8·(1 + ρ) ≤ 1 − ρ for ρ ≤ 1/15 (Gray & Cheriton, SOSP 1989).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lease {
    us: u32,
}

impl Lease {
    /// How much faster one clock may run than true time, and how much slower another, ppm.
    pub const MAX_DRIFT_PPM: u32 = 66_000;
    /// Shortest lease, µs: some packets must fit into it.
    pub const SHORTEST_US: u32 = 10_000;
    /// Longest lease, µs: one minute.
    pub const LONGEST_US: u32 = 60_000_000;

    /// A lease of `us` µs, from [`Lease::SHORTEST_US`] to [`Lease::LONGEST_US`].
    ///
    /// # Errors
    /// A length outside that range.
    pub fn new(us: u32) -> Result<Self, OutOfRange> {
        if (Self::SHORTEST_US..=Self::LONGEST_US).contains(&us) { Ok(Self { us }) } else { Err(OutOfRange { us }) }
    }

    /// How long who gave it must wait, µs.
    pub fn giver_us(self) -> u64 {
        u64::from(self.us)
    }

    /// How long who holds it may act, µs.
    pub fn holder_us(self) -> u64 {
        u64::from(self.us - self.us / 8)
    }

    /// How often it is renewed, and anything unanswered said again, µs: 6 times, so that 4 losses in a row do no harm.
    pub fn retry_us(self) -> u64 {
        u64::from(self.us / 6)
    }
}

/// Requests whose time of sending is remembered; an answer to an older one would leave no time.
const REMEMBERED: usize = 8;

/// The numbered requests that a lease is counted from.
#[derive(Clone, Debug, Default)]
pub(super) struct Requests {
    newest: u32,
    sent: Notices<(u32, u64), REMEMBERED>,
}

impl Requests {
    /// Number of the request that is sent now: 1, 2, 3 …
    pub(super) fn send(&mut self, now: u64) -> u32 {
        self.newest = self.newest.saturating_add(1);
        self.sent.put((self.newest, now));
        self.newest
    }

    /// When a request was sent, if that is not too long ago.
    pub(super) fn sent_us(&self, number: u32) -> Option<u64> {
        self.sent.iter().find(|(sent, _)| *sent == number).map(|(_, at_us)| *at_us)
    }

    pub(super) fn newest(&self) -> u32 {
        self.newest
    }
}

/// What a user at some distance wants: one who comes near an object wants to edit it, one who moves away has finished (Buttolo et
/// al. 1997, §3.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wish {
    /// It wants to edit, and asks for it.
    Edit,
    /// Whatever it was before.
    AsBefore,
    /// It wants nothing, and gives back what it holds.
    Leave,
}

/// Two distances, so that a hand that trembles at one of them does not ask and give back all the time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Approach {
    /// Closer than this, the user wants to edit, m.
    pub near_m: f32,
    /// Farther than this, the user has finished, m; not less than `near_m`.
    pub far_m: f32,
}

impl Approach {
    /// What the user wants at this distance from the object, m. Not a number: whatever it was before.
    pub fn wish(&self, distance_m: f32) -> Wish {
        if distance_m < self.near_m {
            Wish::Edit
        } else if distance_m > self.far_m {
            Wish::Leave
        } else {
            Wish::AsBefore
        }
    }
}
