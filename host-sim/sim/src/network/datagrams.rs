//! Datagrams on their way in one direction: what is taken in, late, twice, broken or not at all.
//!
//! Unlike a [`super::Way`], which hands out the newest packet once each packet period, this delivers every datagram when its
//! time has come, in the order of arrival: greetings and acknowledgements count as much as flow.

use serde::Serialize;

use super::in_flight::InFlight;
use super::rule::{Arrival, Direction, Fates};
use crate::scene::Scene;

/// What became of the datagrams of one direction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Relayed {
    /// Datagrams taken in.
    pub taken: u64,
    /// Datagrams that came out, copies included.
    pub sent: u64,
    /// Datagrams lost.
    pub lost: u64,
    /// Datagrams broken on purpose.
    pub corrupt: u64,
}

/// One direction of the network.
#[derive(Debug)]
pub struct Datagrams {
    constant_s: f64,
    fates: Option<Fates>,
    in_flight: InFlight<Vec<u8>>,
    counts: Relayed,
}

impl Datagrams {
    /// The direction's network as the scene describes it.
    pub fn new(scene: &Scene, direction: Direction) -> Self {
        let timing = &scene.peer.timing;
        let packet_s = timing.control_period_s * f64::from(timing.ticks_per_packet);
        Self {
            constant_s: packet_s * f64::from(scene.world.network.one_way_delay_packets),
            fates: Fates::new(scene, direction),
            in_flight: InFlight::default(),
            counts: Relayed::default(),
        }
    }

    /// Takes a datagram that is sent at `now_us`.
    pub fn send(&mut self, now_us: u64, bytes: &[u8]) {
        let now_s = now_us as f64 * 1e-6;
        let copies = match &mut self.fates {
            None => vec![Arrival { delay_s: 0.0, corrupt: false }],
            Some(fates) => fates.next(self.counts.taken, now_s),
        };
        self.counts.taken += 1;
        self.counts.lost += u64::from(copies.is_empty());
        for copy in copies {
            let mut datagram = bytes.to_vec();
            let middle = datagram.len() / 2;
            if let Some(byte) = datagram.get_mut(middle).filter(|_| copy.corrupt) {
                *byte ^= 0x10;
                self.counts.corrupt += 1;
            }
            let due_us = now_us + (1e6 * (self.constant_s + copy.delay_s)).round() as u64;
            self.in_flight.send(due_us, datagram);
        }
    }

    /// The next datagram that has arrived by `now_us`.
    pub fn take(&mut self, now_us: u64) -> Option<Vec<u8>> {
        let (_, datagram) = self.in_flight.take(now_us)?;
        self.counts.sent += 1;
        Some(datagram)
    }

    /// What became of the datagrams so far.
    pub fn counts(&self) -> Relayed {
        self.counts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(overrides: &[&str]) -> Datagrams {
        let overrides: Vec<String> = overrides.iter().map(|text| (*text).to_owned()).collect();
        Datagrams::new(&Scene::load(None, &overrides).expect("a good scene"), Direction::OneToTwo)
    }

    #[test]
    fn every_datagram_comes_out_after_the_delay_in_the_order_it_went_in() {
        let mut line = line(&["network.one_way_delay_packets=2"]);
        for n in 0..5_u8 {
            line.send(1_000 * u64::from(n), &[n]);
            line.send(1_000 * u64::from(n), &[n, n]);
        }
        assert_eq!(line.take(15_999), None);
        assert_eq!([line.take(16_000), line.take(16_000), line.take(16_000)], [Some(vec![0]), Some(vec![0, 0]), None]);
        assert_eq!(std::iter::from_fn(|| line.take(20_000)).count(), 8);
        assert_eq!(line.counts(), Relayed { taken: 10, sent: 10, ..Relayed::default() });
    }

    #[test]
    fn what_is_lost_never_comes_and_what_is_broken_differs_in_one_bit() {
        let mut line = line(&["network.loss=0.3", "network.corrupt=0.2"]);
        for n in 0..10_000 {
            line.send(n, &[0; 60]);
        }
        let came: Vec<Vec<u8>> = std::iter::from_fn(|| line.take(u64::MAX)).collect();
        let counts = line.counts();
        let flipped = |bytes: &Vec<u8>| bytes.iter().map(|byte| byte.count_ones()).sum::<u32>();
        assert!(came.iter().all(|bytes| bytes.len() == 60 && flipped(bytes) <= 1));
        assert_eq!(came.iter().filter(|bytes| flipped(bytes) == 1).count() as u64, counts.corrupt);
        assert_eq!((counts.taken, counts.sent, came.len() as u64), (10_000, 10_000 - counts.lost, counts.sent));
        assert!(counts.lost.abs_diff(3_000) < 200 && counts.corrupt.abs_diff(1_400) < 200, "{counts:?}");
    }
}
