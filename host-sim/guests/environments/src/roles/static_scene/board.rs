//! Board: the positions of all clients, sent to each other client in turns.
//!
//! Each answer carries the next [`Presence::MOST`] of the others; so with up to five clients everybody is notified about all
//! others with every packet, and with n of them every ⌈(n − 1)/4⌉ packets. The cost of an answer does not grow with the
//! number of clients. Someone who has not been heard for a while is not reported any more.

use heapless::Vec;

use cohold_protocol::wire::{Presence, Sighting};

#[derive(Clone, Copy, Debug)]
struct Place {
    sighting: Sighting,
    heard_us: u64,
    /// Whom to tell this one about next.
    cursor: usize,
}

/// The positions of all clients, as they last reported them.
#[derive(Clone, Debug)]
pub struct Board<const CLIENTS: usize> {
    places: Vec<Place, CLIENTS>,
    silence_us: u64,
}

impl<const CLIENTS: usize> Board<CLIENTS> {
    /// Nobody yet; who is silent for `silence_us` is forgotten when somebody new needs the room, and not reported any
    /// more.
    pub fn new(silence_us: u64) -> Self {
        Self { places: Vec::new(), silence_us }
    }

    /// How many have been heard lately.
    pub fn present(&self, now: u64) -> usize {
        self.places.iter().filter(|place| now.saturating_sub(place.heard_us) < self.silence_us).count()
    }

    /// Takes in where client `who` says it is, and answers with others. `seat` is where the client was last time, if the
    /// caller remembers; the seat to remember comes back. `None`: nothing was said, or there is no room.
    pub fn hear(&mut self, now: u64, who: u32, said: &Presence, seat: Option<usize>) -> Option<(Presence, usize)> {
        let own = Sighting { who, ..*said.seen().first()? };
        let sits = |places: &[Place], at: usize| places.get(at).is_some_and(|place| place.sighting.who == who);
        let seat = seat.filter(|at| sits(&self.places, *at)).or_else(|| self.seat(now, who))?;
        let place = self.places.get_mut(seat)?;
        place.sighting = own;
        place.heard_us = now;
        let cursor = place.cursor;
        let count = self.places.len();
        let (mut sightings, mut passed) = (Vec::<Sighting, { Presence::MOST }>::new(), 0);
        // At most a few times as many looks as there are answers, whoever is silent.
        for step in 0..count.min(8 * Presence::MOST) {
            if sightings.is_full() {
                break;
            }
            passed = step + 1;
            let at = cursor.wrapping_add(step) % count.max(1);
            if let Some(other) = self.places.get(at)
                && at != seat
                && now.saturating_sub(other.heard_us) < self.silence_us
            {
                let _ = sightings.push(other.sighting);
            }
        }
        if let Some(place) = self.places.get_mut(seat) {
            place.cursor = cursor.wrapping_add(passed) % count.max(1);
        }
        Some((Presence::new(said.tick, sightings), seat))
    }

    /// A seat for `who`: its own, a new one, or that of somebody who is silent.
    fn seat(&mut self, now: u64, who: u32) -> Option<usize> {
        if let Some(at) = self.places.iter().position(|place| place.sighting.who == who) {
            return Some(at);
        }
        let new = Place { sighting: Sighting { who, ..Sighting::default() }, heard_us: now, cursor: 0 };
        if self.places.push(new).is_ok() {
            return self.places.len().checked_sub(1);
        }
        let silence_us = self.silence_us;
        let silent = |place: &Place| now.saturating_sub(place.heard_us) >= silence_us;
        let at = self.places.iter().position(silent)?;
        if let Some(place) = self.places.get_mut(at) {
            *place = new;
        }
        Some(at)
    }
}
