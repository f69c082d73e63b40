//! One game from one seed: server and players with clocks of their own, bots, and the scene's network between all of them.
//!
//! Everything moves in control periods of true time. Peer 0 is the server; the network between the peers is a [`Mesh`].

use std::collections::VecDeque;

use haptic_protocol::roles::squash::{
    Court, Message, Notice, PLACE_EVERY_US, PLAYERS, Phase, SERVER, Server, ServerConfig,
};
use haptic_protocol::roles::{Outbox, Role};
use haptic_protocol::wire::{PeerId, SEAL_LEN};

use super::bot::SCALE;
use super::contestant::{Contestant, TICK_S};
use super::referee::Referee;
use super::{Change, Game, Moment, Options};
use haptic_sim::network::link::InFlight;
use haptic_sim::network::mesh::{Clock, Letter, Mesh};
use haptic_sim::rng::Rng;
use haptic_sim::scene::Network;

struct Peer {
    clock: Clock,
    on: bool,
}

struct Seat {
    contestant: Contestant,
    out: Outbox<Message, 64>,
    bytes: u64,
    /// Where the hand was in each tick of the last round trip.
    trail: VecDeque<[f64; 2]>,
}

struct World<'a> {
    options: &'a Options,
    peers: Vec<Peer>,
    server: Server,
    server_out: Outbox<Message, 64>,
    seats: Vec<Seat>,
    mesh: Mesh,
    flying: InFlight<Letter>,
    rng: Rng,
    referee: Referee,
    rallies: u16,
}

fn seat(number: usize, rng: &mut Rng) -> Seat {
    let (life, seed) = (rng.below(1 << 16) as u16, rng.below(u64::MAX));
    let contestant = Contestant::new(PeerId(number as u8), life, seed);
    Seat { contestant, out: Outbox::new(), bytes: 0, trail: VecDeque::new() }
}

impl<'a> World<'a> {
    fn new(options: &'a Options) -> Self {
        let mut rng = Rng::new(options.seed);
        let count = usize::from(options.players) + 1;
        let peers = (0..count)
            .map(|_| {
                // Quartz: 100 ppm.
                let (start_us, ppm) = (rng.below(1 << 40), rng.below(201) as f64 - 100.0);
                Peer { clock: Clock { start_us, rate: 1.0 + ppm * 1e-6 }, on: true }
            })
            .collect();
        let network =
            Network { extra_delay_s: options.network.extra_delay_s + options.round_trip_s / 2.0, ..options.network };
        let mesh = Mesh::new(count, network, PLACE_EVERY_US as f64 / 1e6, &mut rng);
        let config = ServerConfig { players: options.players, rallies: options.rallies, bounder: options.bounder };
        Self {
            options,
            peers,
            server: Server::new(config),
            server_out: Outbox::new(),
            seats: (1..count).map(|number| seat(number, &mut rng)).collect(),
            mesh,
            flying: InFlight::default(),
            rng,
            referee: Referee::new(Court::SINGLES, options.players),
            rallies: 0,
        }
    }

    /// The game is over, and everybody who is there knows.
    fn is_over(&self) -> bool {
        let seats = self.seats.iter().zip(&self.peers[1..]).filter(|(_, peer)| peer.on);
        seats
            .map(|(seat, _)| seat.contestant.player.game())
            .chain([self.server.game()])
            .all(|game| game.phase == Phase::Over)
    }

    fn clock(&self, peer: usize, true_us: u64) -> u64 {
        self.peers[peer].clock.at(true_us)
    }

    /// What a peer has said goes out.
    fn send(&mut self, now_us: u64, from: usize) {
        let said: Vec<_> = match from.checked_sub(1) {
            None => self.server_out.events(|message| message.event(0)).collect(),
            Some(seat) => {
                let Seat { out, bytes, .. } = &mut self.seats[seat];
                out.events(|message| message.event(0))
                    .inspect(|(_, event)| *bytes += (SEAL_LEN + event.emitted_len()) as u64)
                    .collect()
            }
        };
        for (to, event) in said {
            let to = usize::from(to.0);
            if to < self.peers.len() {
                for delay_us in self.mesh.delays_us(from, to, now_us) {
                    self.flying.put(now_us + delay_us, Letter { from, to, event });
                }
            }
        }
    }

    /// What has arrived.
    fn deliver(&mut self, now_us: u64) {
        while let Some((due, Letter { from, to, event })) = self.flying.take(now_us) {
            let Ok((_, message)) = Message::parse(&event) else { continue };
            if !self.peers[to].on {
                continue;
            }
            let (clock, from) = (self.clock(to, due), PeerId(from as u8));
            if to == 0 {
                self.server.receive(clock, from, &message, &mut self.server_out);
                self.judge();
            } else {
                let Seat { contestant, out, .. } = &mut self.seats[to - 1];
                contestant.player.receive(clock, from, &message, out);
                self.notices(due, to);
            }
            self.send(due, to);
        }
    }

    /// What the server has decided since.
    fn judge(&mut self) {
        let last = self.server.game().last;
        if last.rally > self.rallies {
            self.rallies = last.rally;
            self.referee.decided(last);
        }
    }

    fn notices(&mut self, now_us: u64, at: usize) {
        let clock = self.clock(at, now_us);
        let referee = &mut self.referee;
        self.seats[at - 1].contestant.hears(clock, |player, notice| match notice {
            Notice::Begins { .. } => {}
            Notice::Hit { turn, corrected_m: [x, y] } => {
                let corrected = f64::from(x).hypot(f64::from(y));
                referee.report.largest_correction_m = referee.report.largest_correction_m.max(corrected);
                if player.game().active(turn.stroke) == Some(PeerId(at as u8)) {
                    referee.next_knows(now_us as f64 * 1e-6, turn);
                }
            }
            Notice::Ends { verdict, score, seen } => referee.told(at as u8, verdict, score, seen),
        });
    }

    /// A tick of a player's body and role.
    fn play(&mut self, now_us: u64, at: usize) {
        let clock = self.clock(at, now_us);
        let Seat { contestant, out, trail, .. } = &mut self.seats[at - 1];
        if let Some(strike) = contestant.tick(clock, self.options.motion_bounder, out) {
            let ball = contestant.player.ball(clock).unwrap_or_default();
            let [x, y] = strike.impact.pulse_n(TICK_S as f32).map(f64::from);
            let report = &mut self.referee.report;
            report.largest_pulse_n = report.largest_pulse_n.max(SCALE * x.hypot(y));
            if ball.velocity[0] > 0.0 {
                self.referee.hit(now_us as f64 * 1e-6, at as u8, strike.turn, ball, strike.bounded);
            }
        }
        let [x, y] = contestant.bot.position();
        let long = (self.options.round_trip_s / TICK_S).round().max(1.0) as usize;
        trail.push_back([x, y]);
        if trail.len() > long {
            trail.pop_front();
        }
        let away = |[a, b]: [f64; 2]| (a - x).hypot(b - y);
        let travelled = trail.front().copied().map_or(0.0, away);
        self.referee.report.hand_travel_m = self.referee.report.hand_travel_m.max(travelled);
        for (other, seat) in self.seats.iter().enumerate() {
            if other + 1 != at
                && self.peers[other + 1].on
                && let Some(heard) = seat.contestant.player.racket_of(PeerId(at as u8))
            {
                let error = away(heard.position.map(f64::from));
                self.referee.report.hand_error_m = self.referee.report.hand_error_m.max(error);
            }
        }
        self.notices(now_us, at);
        self.send(now_us, at);
    }

    fn change(&mut self, at: usize, change: Change) {
        match change {
            Change::Leaves => self.seats[at - 1].contestant.player.leave(),
            Change::Vanishes => self.peers[at].on = false,
            Change::Comes => {
                self.peers[at].on = true;
                self.seats[at - 1] = seat(at, &mut self.rng);
                self.referee.came_back(at as u8);
            }
        }
    }

    fn moment(&self, now_us: u64) -> Moment {
        let on = |at: &usize| self.peers[*at + 1].on;
        let seats = || self.seats.iter().enumerate();
        let turn = self.seats.iter().map(|seat| seat.contestant.player.turn()).max().unwrap_or_default();
        Moment {
            time_s: now_us as f64 * 1e-6,
            balls: seats().map(|(at, seat)| seat.contestant.player.ball(self.clock(at + 1, now_us))).collect(),
            hands: self.seats.iter().map(|seat| seat.contestant.bot.position()).collect(),
            active: (0..self.seats.len()).filter(on).find(|at| self.seats[*at].contestant.player.is_active()),
            turn: (turn.rally, turn.stroke),
        }
    }
}

/// Plays one game.
pub fn play(options: &Options) -> Game {
    let mut world = World::new(options);
    let ticks = (options.seconds / TICK_S).round() as u64;
    let mut moments = Vec::new();
    let mut present = vec![true; usize::from(options.players)];
    let mut played_s = options.seconds;
    for tick in 1..=ticks {
        let now_us = (tick as f64 * TICK_S * 1e6).round() as u64;
        world.deliver(now_us);
        for (at_s, number, change) in &options.changes {
            if (at_s / TICK_S).round() as u64 == tick {
                world.change(usize::from(*number), *change);
                present[usize::from(*number) - 1] = *change == Change::Comes;
            }
        }
        let clock = world.clock(0, now_us);
        world.server.poll(clock, &mut world.server_out);
        world.judge();
        world.send(now_us, 0);
        for at in 1..world.peers.len() {
            if world.peers[at].on {
                world.play(now_us, at);
            }
        }
        if options.record_every > 0 && tick % options.record_every == 0 {
            moments.push(world.moment(now_us));
        }
        if world.is_over() {
            played_s = tick as f64 * TICK_S;
            break;
        }
    }
    let over = world.is_over();
    // The next rally begins when all know the last: only one result can be on its way.
    world.referee.ends(&present, usize::from(!over));
    let mut report = world.referee.report;
    report.over = over;
    report.round_trip_ms = f64::from(world.server.game().round_trip_us) * 1e-3;
    report.score.truncate(usize::from(options.players));
    let bytes: u64 = world.seats.iter().map(|seat| seat.bytes).sum();
    report.bytes_per_s = bytes as f64 / played_s / f64::from(options.players);
    report.state_hash = hash(&world.seats);
    Game { report, moments }
}

/// FNV-1a of what the players know: equal seeds, equal games.
fn hash(seats: &[Seat]) -> String {
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    for byte in seats.iter().flat_map(|seat| format!("{:?}", seat.contestant.player).into_bytes()) {
        hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    }
    format!("{hash:016x}")
}

const _: () = assert!(PLAYERS == 8 && SERVER.0 == 0);
