//! Networks that are like some that were measured: generators fitted to public figures (`network.like`).
//!
//! What is constant each way the scene says (`network.one_way_delay_packets`, `network.extra_delay_s`); here is what varies, a function of time and of the
//! seed and not of who sends how often. Nothing overtakes: a packet arrives with or after all that was sent before it.
//!
//! | name | figure | fitted | assumed, for the source does not say |
//! |---|---|---|---|
//! | `5g-campus` | 95 % of the packets of a standalone campus network come after 4 to 10 ms (Rischke et al., *5G Campus Networks: A First Measurement Study*, IEEE Access 9, 2021); 4 ms are the scene's | one slot in sixteen is sent again: 0.8 of its packets, 5 % of all, are later | a packet waits for the end of its slot of 5 ms; what fails comes a slot later, all of the slot; nothing is lost; both ways alike |
//! | `starlink` | another satellite every 15 s, spikes of 30 to 50 ms more there and back at each; 6.7 ms between successive round trips on average; 1 to 2 % lost whatever the load (Huston, *A transport protocol's view of Starlink*, APNIC 2024); 15 ms are the scene's | exponential, mean 3.8 ms: two ways differ by 6.7 ms from one second to the next; 15 to 25 ms more each way in a spike; 1.5 % lost | redrawn every 20 ms; spikes last 200 ms; at each change all is lost for 100 ms, and 0.84 % of the others; a satellite has 0 to 5 ms of its own |
//! | `home-wifi` | round trips of 4.04 ms in the median, 95 % below 8 ms; 0.127 % lost; in 10 minutes 18 times above 100 ms and 12 of these above 200 ms, when all stands and then comes at once (Huitema, *The weird case of the wifi latency spikes*, 2023); 0.8 ms are the scene's | exponential, mean 1.22 ms; 18 stands in 10 minutes, of 100 to 400 ms; 0.034 % lost each way beside the first 20 ms of each | redrawn every 5 ms; both ways stand together |
//!
//! A run begins in the middle of a satellite: the first change is after 7.5 s.

use super::rule::{Direction, Fate, Rule, nanoseconds, seconds};
use crate::rng::Rng;
use crate::scene::Network;

crate::choices! {
    /// What a network is like.
    Like {
        "none" => None, "None that was measured: it does what the other keys of its table say.";
        "5g-campus" => Campus5g, "A standalone 5G network of a campus.";
        "starlink" => Starlink, "A line over Starlink's satellites.";
        "home-wifi" => HomeWifi, "Two computers on the Wi-Fi of a house.";
    }
}

/// From one satellite to the next, and when the first change is, s.
const SATELLITE_S: [f64; 2] = [15.0, 7.5];
/// How long all is lost at a change of satellites, and how long the spike after it lasts, s.
const GAP_S: f64 = 0.1;
const SPIKE_S: f64 = 0.2;
/// Chance that a slot of 5G is sent again.
const AGAIN: f64 = 1.0 / 16.0;
/// From one stand of the Wi-Fi to the next on average, and how long one lasts, s.
const STAND_EVERY_S: f64 = 600.0 / 18.0;
const STAND_S: [f64; 2] = [0.1, 0.4];
/// What is lost at the beginning of a stand, s.
const STAND_LOST_S: f64 = 0.02;
/// An exponential is cut at so many of its means: once in 10⁷ draws.
const CUT: f64 = 16.0;

/// One direction of such a network.
#[derive(Clone, Debug)]
pub struct FittedRule {
    like: Like,
    seed: u32,
    direction: Direction,
    constant_s: f64,
    /// Of single losses.
    rng: Rng,
    /// The slot that the last packet was sent in.
    slot: u64,
    /// When all of the slots before it have arrived, s.
    released_s: f64,
    /// The next stand of the Wi-Fi, or the one that is: from when to when, s.
    stand_s: [f64; 2],
    stands: Rng,
}

impl FittedRule {
    /// As this network says; each direction has its own streams, and what happens to both at once has one.
    pub fn new(network: Network, direction: Direction) -> Self {
        let (seed, way) = (network.seed, direction as u64);
        let asymmetry_s = if direction == Direction::TwoToOne { network.asymmetry_s } else { 0.0 };
        let mut rule = Self {
            like: network.like,
            seed,
            direction,
            constant_s: network.extra_delay_s + asymmetry_s,
            rng: stream(seed, 2 + way, 0),
            slot: 0,
            released_s: 0.0,
            stand_s: [0.0; 2],
            stands: stream(seed, 4, 0),
        };
        rule.next_stand();
        rule
    }

    fn slot_s(&self) -> f64 {
        if self.like == Like::Starlink { 0.02 } else { 0.005 }
    }

    fn next_stand(&mut self) {
        let begin_s = self.stand_s[1] - STAND_EVERY_S * libm::log(1.0 - self.stands.unit());
        let [least_s, most_s] = STAND_S;
        self.stand_s = [begin_s, begin_s + least_s + (most_s - least_s) * self.stands.unit()];
    }

    /// When the packets of this slot arrive that are sent at `sent_s`, but for those before them.
    fn due_s(&self, slot: u64, sent_s: f64) -> f64 {
        let mut random = stream(self.seed, self.direction as u64, slot);
        let mut exponential = |mean_s: f64| mean_s * (-libm::log(1.0 - random.unit())).min(CUT);
        match self.like {
            Like::None => sent_s,
            Like::Campus5g => {
                let slots = if random.chance(AGAIN) { 2 } else { 1 };
                (slot + slots) as f64 * self.slot_s()
            }
            Like::Starlink => {
                let late_s = exponential(0.0038);
                let (satellite, since_s) = satellite(sent_s);
                let mut of_satellite = stream(self.seed, 5 + self.direction as u64, satellite);
                let own_s = 0.005 * of_satellite.unit();
                let spike_s = 0.015 + 0.01 * of_satellite.unit();
                let spikes = satellite > 0 && since_s < GAP_S + SPIKE_S;
                sent_s + late_s + own_s + if spikes { spike_s } else { 0.0 }
            }
            Like::HomeWifi => sent_s + exponential(0.00122),
        }
    }

    fn is_lost(&mut self, sent_s: f64) -> bool {
        let single = match self.like {
            Like::Starlink => 0.0084,
            Like::HomeWifi => 0.000_335,
            Like::None | Like::Campus5g => 0.0,
        };
        let single = single > 0.0 && self.rng.chance(single);
        let all = match self.like {
            Like::Starlink => matches!(satellite(sent_s), (1.., since_s) if since_s < GAP_S),
            Like::HomeWifi => sent_s >= self.stand_s[0] && sent_s < self.stand_s[0] + STAND_LOST_S,
            Like::None | Like::Campus5g => false,
        };
        single || all
    }
}

/// Random numbers of this seed for one purpose and slot.
fn stream(seed: u32, purpose: u64, slot: u64) -> Rng {
    Rng::new(u64::from(seed) << 32 ^ purpose << 29 ^ slot)
}

/// Number of the satellite at this time, 0 the one that a run begins with, and for how long it has been, s.
fn satellite(time_s: f64) -> (u64, f64) {
    let [each_s, first_s] = SATELLITE_S;
    // No packet of the end of a spike is one by a rounding.
    let since_s = time_s + 1e-9 + each_s - first_s;
    ((since_s / each_s) as u64, since_s % each_s)
}

impl Rule for FittedRule {
    fn decide(&mut self, _: u64, sent_ns: u64) -> Fate {
        let sent_s = seconds(sent_ns);
        let now = (sent_s / self.slot_s() + 1e-9) as u64;
        while self.slot < now {
            // What was sent at its very end, before a spike is over by rounding ([`satellite`]).
            let end_s = (self.slot + 1) as f64 * self.slot_s() - 4e-9;
            self.released_s = self.released_s.max(self.due_s(self.slot, end_s));
            self.slot += 1;
        }
        while self.like == Like::HomeWifi && sent_s >= self.stand_s[1] {
            self.released_s = self.released_s.max(self.stand_s[1]);
            self.next_stand();
        }
        if self.is_lost(sent_s) {
            return Fate::Drop;
        }
        let mut due_s = self.due_s(now, sent_s).max(self.released_s);
        if self.like == Like::HomeWifi && sent_s >= self.stand_s[0] {
            due_s = due_s.max(self.stand_s[1]);
        }
        Fate::late(nanoseconds(self.constant_s + (due_s - sent_s).max(0.0)))
    }
}
