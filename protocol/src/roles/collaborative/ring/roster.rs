//! Roster: a set of seats, and what a majority of it is.

use crate::bytes::newtype;

/// Seats there can be: the peers numbered 0 to 15.
pub const SEATS: u8 = 16;

/// A set of seats.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Roster(pub(super) u16);

newtype!(Roster);

impl Roster {
    /// Nobody.
    pub const EMPTY: Self = Self(0);

    /// These seats; a number from [`SEATS`] up is none.
    pub fn of(seats: impl IntoIterator<Item = u8>) -> Self {
        seats.into_iter().fold(Self::EMPTY, Self::with)
    }

    /// The set with this seat.
    #[must_use]
    pub fn with(self, seat: u8) -> Self {
        Self(self.0 | Self::bit(seat))
    }

    /// The set without this seat.
    #[must_use]
    pub fn without(self, seat: u8) -> Self {
        Self(self.0 & !Self::bit(seat))
    }

    /// Both sets together.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Whether the seat is one of them.
    pub fn contains(self, seat: u8) -> bool {
        self.0 & Self::bit(seat) != 0
    }

    /// How many they are.
    pub fn len(self) -> u32 {
        self.0.count_ones()
    }

    /// Nobody at all.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// How many of them are more than half: at least 1, so that nobody is no majority of nothing.
    pub fn majority(self) -> u32 {
        self.len() / 2 + 1
    }

    /// The seats, ascending.
    pub fn seats(self) -> impl Iterator<Item = u8> {
        (0..SEATS).filter(move |seat| self.contains(*seat))
    }

    /// The seats in the order of the ring, beginning after `seat` and ending with it.
    pub fn after(self, seat: u8) -> impl Iterator<Item = u8> {
        (1..=SEATS).map(move |step| seat.wrapping_add(step) % SEATS).filter(move |seat| self.contains(*seat))
    }

    fn bit(seat: u8) -> u16 {
        1_u16.checked_shl(u32::from(seat)).unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_two_majorities_meet() {
        for roster in (0..1 << 6).map(Roster) {
            for (one, two) in
                (0..1_u16 << 6).flat_map(|one| (0..1 << 6).map(move |two| (one & roster.0, two & roster.0)))
            {
                let both = [one, two].iter().all(|votes| votes.count_ones() >= roster.majority());
                assert!(!both || one & two != 0);
            }
        }
    }

    #[test]
    fn the_ring_goes_round() {
        let roster = Roster::of([1, 4, 15, 16, 200]);
        assert_eq!(roster.len(), 3);
        assert!(roster.after(4).eq([15, 1, 4]) && roster.after(15).eq([1, 4, 15]) && roster.seats().eq([1, 4, 15]));
        assert!(Roster::EMPTY.after(3).next().is_none() && roster.without(1).with(2).union(Roster::of([9])).len() == 4);
    }
}
