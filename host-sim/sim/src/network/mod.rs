//! Packets on their way between two peers.
//!
//! | module | holds |
//! |---|---|
//! | [`datagrams`] | every datagram of one direction, each when its time has come |
//! | [`rule`] | what becomes of each packet: seeded from the scene, or read from a trace |
//! | [`in_flight`] | what is on its way, each when its time has come |
//! | [`mesh`] | several peers: their clocks, and a line from each to each other |
//! | this | a way of packets: packets in flight, and which one a peer gets |
//!
//! A peer asks once each packet period and gets the newest packet that has arrived; older ones, and second copies, are
//! dropped, as a receiver with sequence numbers does. Corrupted packets do not pass the seal and are dropped too. With
//! network.playout_packets what has arrived goes through the peers' own play-out buffer (`haptic_protocol::playout`).

pub mod datagrams;
pub mod in_flight;
pub mod mesh;
pub mod rule;

use std::collections::VecDeque;

use haptic_protocol::playout::Playout;
use rule::{Direction, Fates};

use crate::scene::Scene;

/// What became of the packets of one direction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Counts {
    /// Handed to the network.
    pub sent: u64,
    /// Taken by the receiver.
    pub delivered: u64,
    /// Never arrived.
    pub lost: u64,
    /// Arrived broken.
    pub corrupt: u64,
    /// Arrived after a newer one was taken, together with one, or twice.
    pub dropped: u64,
}

/// One direction of the network.
#[derive(Clone, Debug)]
pub struct Way<P> {
    delay_packets: u32,
    packet_s: f64,
    ticks_per_packet: u32,
    /// The receiver's buffer, if the scene asks for one.
    playout: Option<Playout<P>>,
    /// Packet periods on the receiver's clock.
    taken: u32,
    impaired: Option<Fates>,
    /// Packets in flight: number, arrival in true packet periods.
    in_flight: VecDeque<(u64, f64, P)>,
    newest: Option<u64>,
    counts: Counts,
}

/// A boundary reached to within this is reached, packet periods: sums of periods round.
const SLACK: f64 = 1e-9;

impl<P: Copy> Way<P> {
    /// The direction's network as the scene describes it.
    pub fn new(scene: &Scene, direction: Direction) -> Self {
        let (network, timing) = (&scene.world.network, &scene.peer.timing);
        Self {
            delay_packets: network.one_way_delay_packets,
            packet_s: timing.control_period_s * f64::from(timing.ticks_per_packet),
            ticks_per_packet: timing.ticks_per_packet,
            playout: (network.playout_packets > 0)
                .then(|| Playout::new(network.playout_packets, timing.ticks_per_packet)),
            taken: 0,
            impaired: Fates::new(scene, direction),
            in_flight: VecDeque::new(),
            newest: None,
            counts: Counts::default(),
        }
    }

    /// Takes a packet that the sender sends at `now`, in packet periods.
    pub fn send(&mut self, now: f64, packet: P) {
        let number = self.counts.sent;
        self.counts.sent += 1;
        let due = now + f64::from(self.delay_packets);
        let Some(fates) = &mut self.impaired else {
            self.in_flight.push_back((number, due, packet));
            return;
        };
        let copies = fates.next(number, now * self.packet_s);
        self.counts.lost += u64::from(copies.is_empty());
        for copy in copies {
            if copy.corrupt {
                self.counts.corrupt += 1;
            } else {
                self.in_flight.push_back((number, due + copy.delay_s / self.packet_s, packet));
            }
        }
    }

    /// The newest packet that has arrived by `now`, in packet periods, and was not overtaken.
    pub fn take(&mut self, now: f64) -> Option<P> {
        if self.playout.is_some() {
            return self.take_played(now);
        }
        let mut taken: Option<(u64, P)> = None;
        let (newest, counts) = (&mut self.newest, &mut self.counts);
        self.in_flight.retain(|&(number, arrival, packet)| {
            if arrival > now + SLACK {
                return true;
            }
            if newest.is_none_or(|newest| number > newest) {
                *newest = Some(number);
                counts.delivered += 1;
                // One that arrived in the same period and was older is overtaken after all.
                if taken.replace((number, packet)).is_some() {
                    counts.delivered -= 1;
                    counts.dropped += 1;
                }
            } else {
                counts.dropped += 1;
            }
            false
        });
        taken.map(|(_, packet)| packet)
    }

    /// The same through the play-out buffer, in ticks: the sender's at which a packet was sent, the receiver's at which it
    /// came. A receiver asks once each packet period of its own clock.
    fn take_played(&mut self, now: f64) -> Option<P> {
        let (playout, counts, ticks) = (self.playout.as_mut()?, &mut self.counts, self.ticks_per_packet);
        let local = self.taken.wrapping_mul(ticks);
        self.taken = self.taken.wrapping_add(1);
        self.in_flight.retain(|&(number, arrival, packet)| {
            if arrival > now + SLACK {
                return true;
            }
            let ago = ((now - arrival).max(0.0) * f64::from(ticks)).ceil() as u32;
            let kept = playout.put(local.wrapping_sub(ago), (number as u32).wrapping_mul(ticks), packet);
            counts.dropped += u64::from(!kept);
            false
        });
        let before = playout.waiting();
        let played = playout.take(local);
        let gone = (before - playout.waiting()) as u64;
        counts.delivered += u64::from(played.is_some());
        counts.dropped += gone - u64::from(played.is_some());
        played
    }

    /// What became of the packets so far.
    pub fn counts(&self) -> Counts {
        self.counts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn way(overrides: &[&str]) -> Way<u64> {
        let overrides: Vec<String> = overrides.iter().map(|text| (*text).to_owned()).collect();
        Way::new(&Scene::load(None, &overrides).expect("a good scene"), Direction::OneToTwo)
    }

    /// One packet period in which both ends are on time.
    fn period(way: &mut Way<u64>, number: u64) -> Option<u64> {
        way.send(number as f64, number);
        way.take(number as f64)
    }

    #[test]
    fn without_impairment_every_packet_arrives_after_the_delay() {
        for delay in [0_u64, 1, 5] {
            let mut way = way(&[&format!("network.one_way_delay_packets={delay}")]);
            for number in 0..50_u64 {
                assert_eq!(period(&mut way, number), number.checked_sub(delay));
            }
        }
    }

    #[test]
    fn losses_come_as_often_and_in_runs_as_long_as_the_scene_says() {
        for (loss, burst) in [(0.2, 1.0), (0.1, 5.0), (0.5, 20.0)] {
            let mut way = way(&[
                "network.one_way_delay_packets=0",
                &format!("network.loss={loss}"),
                &format!("network.loss_burst_packets={burst}"),
            ]);
            let got: Vec<bool> = (0..200_000).map(|number| period(&mut way, number).is_some()).collect();
            let lost = got.iter().filter(|got| !**got).count() as f64;
            let runs = got.windows(2).filter(|pair| pair[0] && !pair[1]).count() as f64;
            assert!((lost / 200_000.0 - loss).abs() < 0.02, "{lost} lost at {loss}");
            // Independent losses come in runs of 1/(1 − p).
            let expected = if burst == 1.0 { 1.0 / (1.0 - loss) } else { burst };
            assert!((lost / runs / expected - 1.0).abs() < 0.1, "runs of {} for {expected}", lost / runs);
        }
    }

    #[test]
    fn whatever_happens_on_the_way_numbers_only_grow() {
        let mut way = way(&[
            "network.jitter=gamma",
            "network.jitter_s=0.012",
            "network.reorder=0.3",
            "network.reorder_depth_packets=16",
            "network.duplicate=0.2",
            "network.corrupt=0.1",
            "network.loss=0.1",
        ]);
        let mut last = None;
        for sent in 0..20_000 {
            if let Some(number) = period(&mut way, sent) {
                assert!(last.is_none_or(|last| number > last), "{number} after {last:?}");
                last = Some(number);
            }
        }
        let counts = way.counts();
        assert!(
            counts.dropped > 1000 && counts.corrupt > 1000 && counts.lost > 1000 && counts.delivered > 5000,
            "{counts:?}"
        );
    }

    #[test]
    fn play_out_makes_the_delay_constant() {
        let mut way = way(&["network.jitter=uniform", "network.jitter_s=0.012", "network.playout_packets=2"]);
        // Once the fastest has been seen.
        for number in 0..5000_u64 {
            let played = period(&mut way, number);
            assert!(number < 200 || played == number.checked_sub(3), "{played:?} in period {number}");
        }
        // Uniform to 12 ms is never later than two packets of 8 ms.
        let counts = way.counts();
        assert!(counts.delivered > 4_980 && counts.dropped < 10 && counts.lost == 0, "{counts:?}");
    }

    /// Without impairment the fastest is known from the start, and every packet waits exactly as long as it was told to.
    #[test]
    fn play_out_on_a_good_network_is_more_delay_and_nothing_else() {
        let mut way = way(&["network.one_way_delay_packets=2", "network.playout_packets=4"]);
        for number in 0..500_u64 {
            assert_eq!(period(&mut way, number), number.checked_sub(6));
        }
    }
}
