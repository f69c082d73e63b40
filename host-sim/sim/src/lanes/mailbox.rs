//! Mailboxes of all lanes: one network for all, or for each lane its own.
//!
//! **Each its own**: packets of all lanes leave at once, and each lane's are lost, late or repeated as its own rule says. What a tick has
//! not brought to a lane that lane goes on with, which is what it does alone if its law only holds packets
//! ([`cohold_core::law::Law::only_holds`]); a silence is counted, and what is held fades, in each lane by itself, with core's own
//! [`Degradation`]. The peer of all lanes hears something in each packet period and is never silent. A lane whose silence lets go of the
//! other peer leaves.

use std::collections::VecDeque;
use std::rc::Rc;

use cohold_core::law::Packet;
use cohold_core::law::degradation::{Degradation, Engagement};
use cohold_core::settings::Refused;

use super::number::{ALL, F64s, LANES, leave};
use crate::network::link::{InFlight, Inbox, Numbered, Route};
use crate::network::rule::Direction;
use crate::pair::{Mailbox, hand_over};
use crate::peers::DynPeer;
use crate::scene::Scene;

/// The packets of all lanes, a kilobyte and more, where they lie: that is what travels.
type Place<const SHARED: usize> = Rc<[Packet<F64s>; SHARED]>;

/// What takes in the packets of all lanes for a peer, and sends its own.
pub(super) struct LaneMailbox<const SHARED: usize> {
    incoming: Incoming<SHARED>,
    /// Where what it has sent lies, the oldest first. Where nobody needs it any more the next one is put.
    places: VecDeque<Place<SHARED>>,
}

/// What takes in the packets of all lanes for a peer.
enum Incoming<const SHARED: usize> {
    /// The same of every lane.
    One(Inbox<Place<SHARED>>),
    /// Of each lane its own.
    Each(Box<Networks<SHARED>>),
}

/// One direction of the networks of all lanes, and the packets that are under way in it.
pub(super) struct Networks<const SHARED: usize> {
    /// One for each scene; lanes without a scene do what the last one does.
    routes: Vec<Route>,
    degradation: Degradation<f64>,
    /// Packet periods of silence after which a peer stops.
    silent_packets: u32,
    max_delay_ns: u64,
    /// What is under way, by its number, and how many copies of it.
    sent: VecDeque<(Numbered<Place<SHARED>>, usize)>,
    /// The numbers of the packets that are due, and the lanes in which.
    in_flight: InFlight<(u64, u32)>,
    newest: [Option<u64>; LANES],
    engagement: [Engagement<f64>; LANES],
    /// Lanes in which a packet has come.
    heard: u32,
    standing: [Packet<F64s>; SHARED],
    /// What the law has been given: what stands, as far as it counts.
    given: [Packet<F64s>; SHARED],
    delivered: u64,
}

/// These lanes of one packet, the others of another.
fn chosen(lanes: u32, yes: &Packet<F64s>, no: &Packet<F64s>) -> Packet<F64s> {
    let number = |yes, no| F64s::chosen(lanes, yes, no);
    let mut packet = *yes;
    packet.motion.position = number(yes.motion.position, no.motion.position);
    packet.motion.velocity = number(yes.motion.velocity, no.motion.velocity);
    packet.wave = number(yes.wave, no.wave);
    packet.energy_j = number(yes.energy_j, no.energy_j);
    packet.wave_integral = number(yes.wave_integral, no.wave_integral);
    packet
}

/// Puts these lanes of packets over what is there.
fn put_over<const SHARED: usize>(lanes: u32, packets: &[Packet<F64s>; SHARED], there: &mut [Packet<F64s>; SHARED]) {
    for (packet, there) in packets.iter().zip(there) {
        *there = if lanes == ALL { *packet } else { chosen(lanes, packet, there) };
    }
}

/// The lanes of which this is so.
fn lanes_where(of: impl Fn(usize) -> bool) -> u32 {
    (0..LANES).filter(|lane| of(*lane)).fold(0, |lanes, lane| lanes | 1 << lane)
}

impl<const SHARED: usize> Networks<SHARED> {
    /// The networks to peer `index` (0 or 1) of these scenes, which differ in nothing that degradation is built of.
    fn new(scenes: &[&Scene], index: usize) -> Result<Self, Refused<'static>> {
        let direction = if index == 0 { Direction::TwoToOne } else { Direction::OneToTwo };
        let settings = &scenes[0].peers()[index];
        let degradation = Degradation::build(settings)?;
        Ok(Self {
            routes: scenes.iter().map(|scene| Route::of_scene(scene, direction, 0)).collect(),
            silent_packets: settings.timing.packet_periods(settings.safety.peer_lost_s).max(1),
            max_delay_ns: settings.safety.max_delay_ns(),
            sent: VecDeque::new(),
            in_flight: InFlight::default(),
            newest: [None; LANES],
            engagement: [degradation.engaged(); LANES],
            degradation,
            heard: 0,
            standing: [Packet::default(); SHARED],
            given: [Packet::default(); SHARED],
            delivered: 0,
        })
    }

    /// Every copy of the packet gets on its way, in each lane by itself.
    fn send(&mut self, now_ns: u64, packet: &Numbered<Place<SHARED>>) {
        let last = self.routes.len() - 1;
        let mut due: Vec<(u64, u32)> = Vec::new();
        for (lane, route) in self.routes.iter_mut().enumerate() {
            let lanes = if lane == last { ALL << lane & ALL } else { 1 << lane };
            let number = Numbered::new(packet.number, ());
            route.send(now_ns, &number, |due_ns, copy| {
                if copy.delay_ns > self.max_delay_ns {
                    // Whoever has never heard anything lets go at that, and leaves.
                    leave(lanes & !self.heard);
                } else if let Some((_, others)) = due.iter_mut().find(|(other_ns, _)| *other_ns == due_ns) {
                    *others |= lanes;
                } else {
                    due.push((due_ns, lanes));
                }
            });
        }
        if !due.is_empty() {
            self.sent.push_back((packet.clone(), due.len()));
        }
        due.into_iter().for_each(|(due_ns, lanes)| self.in_flight.put(due_ns, (packet.number, lanes)));
    }

    /// Puts what has come by `now_ns` over what stands; gives the lanes in which something has.
    fn take(&mut self, now_ns: u64) -> u32 {
        let mut came = 0;
        while let Some((_, (number, lanes))) = self.in_flight.take(now_ns) {
            let at = self.sent.partition_point(|(sent, _)| sent.number < number);
            let (sent, copies) = &mut self.sent[at];
            let newer = lanes & lanes_where(|lane| self.newest[lane].is_none_or(|newest| number > newest));
            put_over(newer, &sent.what, &mut self.standing);
            (0..LANES).filter(|lane| newer >> lane & 1 == 1).for_each(|lane| self.newest[lane] = Some(number));
            came |= newer;
            *copies -= 1;
            while self.sent.pop_front_if(|(_, copies)| *copies == 0).is_some() {}
        }
        came
    }

    /// The lanes in which what stands is to be given to the law again, after these have heard a packet: a silence is counted if an exchange
    /// of packets is `due`, with these `forces` of the law (N).
    fn count(&mut self, came: u32, due: bool, forces: [F64s; SHARED]) -> u32 {
        for (lane, at) in self.engagement.iter_mut().enumerate() {
            if came >> lane & 1 == 1 {
                self.degradation.hear(at);
            }
            if due {
                self.degradation.pass(at, forces.map(|force| force.lane(lane)));
            }
        }
        let at = &self.engagement;
        leave(lanes_where(|lane| !at[lane].is_engaged() || at[lane].silent() >= self.silent_packets));
        if due { came | lanes_where(|lane| at[lane].is_fading()) } else { came }
    }

    /// What stands of these lanes, as far as it counts, becomes what the law is given.
    fn give<const N: usize>(&mut self, lanes: u32, peer: &dyn DynPeer<F64s, SHARED, N>) {
        let at = &self.engagement;
        let whole = lanes_where(|lane| self.degradation.is_whole(&at[lane]));
        put_over(lanes & whole, &self.standing, &mut self.given);
        if lanes & !whole != 0 {
            let share = F64s::of(|lane| self.degradation.share(&at[lane]));
            put_over(lanes & !whole, &peer.faded(share, &self.standing), &mut self.given);
        }
    }

    /// Lets the peer hear what it is given; in lanes in which nothing has come yet its state stays.
    fn tell<const N: usize>(&self, peer: &mut dyn DynPeer<F64s, SHARED, N>) {
        let mut before = Vec::new();
        if self.heard != ALL {
            peer.visit_state(&mut |number| before.push(*number));
        }
        peer.hear(&self.given);
        if self.heard != ALL {
            let mut before = before.into_iter();
            peer.visit_state(&mut |number| {
                if let Some(before) = before.next() {
                    *number = F64s::chosen(self.heard, *number, before);
                }
            });
        }
    }
}

impl<const SHARED: usize> LaneMailbox<SHARED> {
    /// The mailbox of peer `index` (0 or 1) of these scenes: of the network of all, if it is `one`.
    pub(super) fn new(scenes: &[&Scene], index: usize, one: bool) -> Result<Self, Refused<'static>> {
        let incoming = if one {
            Incoming::One(Inbox::of_end(scenes[0], index, 1))
        } else {
            Incoming::Each(Box::new(Networks::new(scenes, index)?))
        };
        Ok(Self { incoming, places: VecDeque::new() })
    }
}

impl<const SHARED: usize, const N: usize> Mailbox<F64s, SHARED, N> for LaneMailbox<SHARED> {
    type Carried = Place<SHARED>;

    #[inline]
    fn carried(&mut self, packets: [Packet<F64s>; SHARED]) -> Place<SHARED> {
        let free = self.places.iter().position(|place| Rc::strong_count(place) == 1);
        let place = match free.and_then(|at| self.places.remove(at)) {
            Some(mut place) => {
                *Rc::make_mut(&mut place) = packets;
                place
            }
            None => Rc::new(packets),
        };
        self.places.push_back(Rc::clone(&place));
        place
    }

    #[inline]
    fn put(&mut self, now_ns: u64, packet: &Numbered<Place<SHARED>>) {
        match &mut self.incoming {
            Incoming::One(inbox) => inbox.put(now_ns, packet.clone()),
            Incoming::Each(networks) => networks.send(now_ns, packet),
        }
    }

    #[inline]
    fn hand_over(&mut self, now_ns: u64, due: bool, peer: &mut dyn DynPeer<F64s, SHARED, N>) -> bool {
        let networks = match &mut self.incoming {
            Incoming::One(inbox) => return hand_over(inbox, now_ns, due, peer),
            Incoming::Each(networks) => networks,
        };
        let came = networks.take(now_ns);
        if came == 0 && !due {
            return false;
        }
        networks.heard |= came;
        networks.delivered += u64::from(came != 0);
        let again = networks.count(came, due, peer.observed().map(|seen| seen.coordination_force));
        networks.give(again, peer);
        if networks.heard != 0 {
            networks.tell(peer);
        }
        if due {
            peer.listen();
        }
        came != 0
    }

    fn heard(&self) -> Option<&[Packet<F64s>; SHARED]> {
        match &self.incoming {
            Incoming::One(inbox) => inbox.taken().map(Rc::as_ref),
            Incoming::Each(networks) => Some(&networks.standing),
        }
    }

    fn delivered(&self) -> u64 {
        match &self.incoming {
            Incoming::One(inbox) => inbox.delivered,
            Incoming::Each(networks) => networks.delivered,
        }
    }
}
