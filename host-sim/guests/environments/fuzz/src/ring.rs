//! A token ring of three members on a network that the script commands, with clocks as far apart as is allowed and members
//! that crash. Never two owners; a version is published once; what is published is in every later state; and in the end
//! whoever asks is granted in time.

use std::collections::BTreeMap;

use cohold_environments::roles::collaborative::Lease;
use cohold_environments::roles::collaborative::ring::{Config, Message, Notice, Record, Ring, Roster, wait_bound_us};
use cohold_environments::roles::{Outbox, Role};
use cohold_protocol::wire::PeerId;

use super::net::{Clock, Net};
use super::script::Script;

const SEATS: usize = 3;
const LEASE_US: u32 = 100_000;
const TURN_US: u64 = 50_000;

struct World {
    time_us: u64,
    net: Net<Message>,
    out: Outbox<Message, 64>,
    rings: [Ring; SEATS],
    clocks: [Clock; SEATS],
    starts: u64,
    /// What each seat is publishing, under which version.
    proposed: [Option<(u32, [u8; 24])>; SEATS],
    published: BTreeMap<u32, [u8; 24]>,
    values: u64,
    granted: [u32; SEATS],
}

fn config(seat: u8, seed: u64) -> Config {
    let lease = Lease::new(LEASE_US).expect("an allowed lease");
    Config { seat, contacts: Roster::of(0..SEATS as u8), lease, turn_us: TURN_US, seed }
}

impl World {
    fn new() -> Self {
        let drift = i64::from(Lease::MAX_DRIFT_PPM);
        let record = Record::founder(Roster::of(0..SEATS as u8), [0; 24]);
        let clocks: [Clock; SEATS] =
            std::array::from_fn(|seat| Clock { start_us: 1 << (seat * 15), fast_ppm: [drift, -drift, 0][seat] });
        Self {
            time_us: 0,
            net: Net::new(),
            out: Outbox::new(),
            rings: std::array::from_fn(|seat| Ring::new(config(seat as u8, seat as u64), clocks[seat].at(0), record)),
            clocks,
            starts: SEATS as u64,
            proposed: [None; SEATS],
            published: BTreeMap::new(),
            values: 0,
            granted: [0; SEATS],
        }
    }

    fn now(&self, seat: usize) -> u64 {
        self.clocks[seat].at(self.time_us)
    }

    fn poll(&mut self, seat: usize) {
        self.rings[seat].poll(self.now(seat), &mut self.out);
        self.net.post(seat, &mut self.out);
    }

    fn receive(&mut self, (from, to, message): (usize, usize, Message)) {
        self.rings[to].receive(self.now(to), PeerId(from as u8), &message, &mut self.out);
        self.net.post(to, &mut self.out);
        self.look();
    }

    /// A millisecond in which everything arrives and everybody looks at the time.
    fn calm(&mut self) {
        self.time_us += 1_000;
        for message in self.net.take_all() {
            self.receive(message);
        }
        (0..SEATS).for_each(|seat| self.poll(seat));
        self.look();
    }

    /// The user has finished and changed the object.
    fn publish(&mut self, seat: usize) {
        self.values += 1;
        let mut value = [0; 24];
        value[..8].copy_from_slice(&self.values.to_le_bytes());
        if self.rings[seat].publish(self.now(seat), value, &mut self.out).is_ok() {
            self.proposed[seat] = Some((self.rings[seat].state().version, value));
        }
        self.net.post(seat, &mut self.out);
    }

    /// A member loses everything but its record.
    fn crash(&mut self, seat: usize) {
        self.starts += 1;
        self.rings[seat] = Ring::new(config(seat as u8, self.starts), self.now(seat), *self.rings[seat].record());
        self.proposed[seat] = None;
    }

    /// What must always be true.
    fn look(&mut self) {
        let owners = (0..SEATS).filter(|seat| self.rings[*seat].owns(self.now(*seat)));
        assert!(owners.count() <= 1, "two owners at {}", self.time_us);
        for (seat, ring) in self.rings.iter_mut().enumerate() {
            while let Some(notice) = ring.take_notice() {
                match notice {
                    Notice::Granted => self.granted[seat] += 1,
                    Notice::Published(version) => {
                        let (proposed, value) = self.proposed[seat].take().expect("it was publishing");
                        assert_eq!(proposed, version);
                        assert_eq!(self.published.insert(version, value), None, "version {version} is published twice");
                    }
                    Notice::Overdue => {}
                    Notice::Lost => self.proposed[seat] = None,
                }
            }
        }
        let Some((newest, value)) = self.published.last_key_value() else { return };
        for (seat, ring) in
            self.rings.iter().enumerate().filter(|(seat, ring)| ring.owns(self.clocks[*seat].at(self.time_us)))
        {
            let state = ring.state();
            assert!(state.version >= *newest, "seat {seat} edits version {} after {newest}", state.version);
            assert!(state.version > *newest || state.value == *value, "seat {seat} has another value");
        }
    }
}

/// Runs one fuzz input through a token ring of three members.
pub(super) fn run(bytes: &[u8]) {
    let (mut world, mut script) = (World::new(), Script(bytes));
    while script.goes_on() {
        let (call, seat) = (script.byte(), script.below(SEATS));
        match call % 16 {
            0 | 1 => world.time_us += script.time_us(),
            2 | 3 => (0..script.below(64)).for_each(|_| world.calm()),
            4 | 5 => world.poll(seat),
            6..=10 => {
                if let Some(message) = world.net.deliver(&mut script) {
                    world.receive(message);
                }
            }
            11 if call < 128 => world.net.lose(&mut script),
            11 => world.net.cut_or_mend(seat),
            12 => world.rings[seat].ask(),
            13 => world.publish(seat),
            14 => {
                let now = world.now(seat);
                world.rings[seat].give_up(now, &mut world.out);
                world.net.post(seat, &mut world.out);
            }
            _ => world.crash(seat),
        }
        world.look();
    }
    world.net.cut = None;
    // Peace: everything arrives within a millisecond, and who owns the object publishes at once.
    let lease = Lease::new(LEASE_US).expect("an allowed lease");
    let bound = wait_bound_us(lease, SEATS as u64, TURN_US, 1_000);
    let (end, before) = (world.time_us + bound + bound / 10, world.granted);
    while world.granted[0] == before[0] {
        assert!(world.time_us < end, "seat 0 is not granted within {bound} us");
        for seat in 0..SEATS {
            world.publish(seat);
            world.rings[seat].ask();
        }
        world.calm();
    }
}
