//! One game from one seed: server and players with clocks of their own, bots, and the scene's network between all of them.
//!
//! Everything moves in control periods of true time. Seat 0 is the server.

use std::collections::VecDeque;

use cohold_protocol::wire::PeerId;
use cohold_sim::engine::{Actor, Clock, Engine, EngineView, Out, Seat};
use cohold_sim::network::rule::{Direction, SeededRule};
use cohold_sim::{network::link::Route, rng::Rng, scene::Network};

use super::bot::{Contestant, Participant, SCALE, TICK_S};
use super::game::{Change, Game, Moment, Options};
use super::referee::Referee;
use crate::roles::squash::{
    Court, Message, Notice, PLACE_EVERY_US, PLAYERS, Phase, Player, SERVER, Server, ServerConfig, Strike,
};
use crate::roles::{Carried as _, Role as _};
use crate::{Crossing, carried::sealed_len, said};

/// Who sits at the engine, and what the referee has not seen of it yet.
struct SimulatedPeer {
    participant: Participant,
    damped: bool,
    bytes: u64,
    strike: Option<Strike>,
    /// What was announced to it, and whether that makes it the next to hit.
    notices: Vec<(Notice, bool)>,
    /// Where the hand was in each tick of the last round trip.
    trail: VecDeque<[f64; 2]>,
}

impl SimulatedPeer {
    fn new(participant: Participant, damped: bool) -> Self {
        Self { participant, damped, bytes: 0, strike: None, notices: Vec::new(), trail: VecDeque::new() }
    }

    /// Player `number`, in another life than any before.
    fn player(number: usize, damped: bool, rng: &mut Rng) -> Self {
        let (life, seed) = (rng.below(1 << 16) as u16, rng.below(u64::MAX));
        Self::new(Participant::Player(Box::new(Contestant::new(PeerId(number as u8), life, seed))), damped)
    }

    /// What was announced to it since, for the bot and for the referee.
    fn take_notices(&mut self, now_us: u64) {
        let Self { participant: Participant::Player(contestant), notices, .. } = self else { return };
        let number = contestant.number;
        contestant.hears(now_us, |player, notice| {
            let next = matches!(notice, Notice::Hit { turn, .. } if player.game().active(turn.stroke) == Some(number));
            notices.push((notice, next));
        });
    }
}

/// Counts what is said.
fn counted<'a>(bytes: &'a mut u64, out: &'a mut Out<'_, usize, Crossing>) -> impl FnMut(usize, &Crossing) {
    move |to, message| {
        *bytes += sealed_len(&message.0) as u64;
        out(to, message);
    }
}

impl Actor<usize> for SimulatedPeer {
    type Packet = Crossing;

    fn hear(&mut self, now_ns: u64, from: usize, Crossing(message): &mut Crossing, out: &mut Out<'_, usize, Crossing>) {
        let Some((_, message)) = Message::read(message) else { return };
        let mut out = counted(&mut self.bytes, out);
        self.participant.receive(now_ns / 1_000, PeerId(from as u8), &message, &mut said(0, &mut out));
        drop(out);
        self.take_notices(now_ns / 1_000);
    }

    fn speak(&mut self, now_ns: u64, out: &mut Out<'_, usize, Crossing>) {
        let now_us = now_ns / 1_000;
        let mut out = counted(&mut self.bytes, out);
        match &mut self.participant {
            Participant::Server(server) => server.poll(now_us, &mut said(0, &mut out)),
            Participant::Player(contestant) => {
                self.strike = contestant.tick(now_us, self.damped, &mut said(0, &mut out))
            }
        }
        drop(out);
        self.take_notices(now_us);
    }
}

/// The players with their numbers, of all seats.
fn players(seats: &[Seat<SimulatedPeer>]) -> impl Iterator<Item = (usize, &Seat<SimulatedPeer>, &Contestant)> {
    seats.iter().enumerate().filter_map(|(at, seat)| match &seat.actor.participant {
        Participant::Player(contestant) => Some((at, seat, contestant.as_ref())),
        Participant::Server(_) => None,
    })
}

/// The referee watches a turn.
fn watch(referee: &mut Referee, rallies: &mut u16, seen: EngineView<'_, SimulatedPeer>) {
    let (now_s, by) = (seen.now_ns as f64 * 1e-9, seen.seat as u8);
    let clock = seen.seats[seen.seat].clock;
    let SimulatedPeer { participant, strike, notices, .. } = &mut seen.seats[seen.seat].actor;
    let contestant = match participant {
        Participant::Server(server) => {
            let last = server.game().last;
            if last.rally > *rallies {
                *rallies = last.rally;
                referee.decided(last);
            }
            return;
        }
        Participant::Player(contestant) => contestant,
    };
    if let Some(strike) = strike.take() {
        let ball = contestant.player.ball(clock.at(seen.now_ns) / 1_000).unwrap_or_default();
        let [x, y] = strike.impact.pulse_n(TICK_S as f32).map(f64::from);
        let pulse_n = &mut referee.report.largest_pulse_n;
        *pulse_n = pulse_n.max(SCALE * x.hypot(y));
        if ball.velocity[0] > 0.0 {
            referee.hit(now_s, by, strike.turn, ball, strike.bounded);
        }
    }
    for (notice, next) in notices.drain(..) {
        match notice {
            Notice::Begins(_) => {}
            Notice::Hit { turn, corrected_m: [x, y] } => {
                let corrected_m = &mut referee.report.largest_correction_m;
                *corrected_m = corrected_m.max(f64::from(x).hypot(f64::from(y)));
                if next {
                    referee.next_knows(now_s, turn);
                }
            }
            Notice::Ends { verdict, score, seen } => referee.reported(by, verdict, score, seen),
        }
    }
}

/// How far every hand went in a round trip of so many ticks, and from where the others think that it is.
fn measure(referee: &mut Referee, seats: &mut [Seat<SimulatedPeer>], round_trip: usize) {
    for at in 1..seats.len() {
        let Seat {
            actor: SimulatedPeer { participant: Participant::Player(contestant), trail, .. }, off: false, ..
        } = &mut seats[at]
        else {
            continue;
        };
        let [x, y] = contestant.bot.position;
        trail.push_back([x, y]);
        if trail.len() > round_trip {
            trail.pop_front();
        }
        let away = |[a, b]: [f64; 2]| (a - x).hypot(b - y);
        let travelled = trail.front().copied().map_or(0.0, away);
        let others = players(seats).filter(|(other, seat, _)| *other != at && !seat.off);
        let heard = others.filter_map(|(_, _, other)| other.player.racket_of(PeerId(at as u8)));
        let error = heard.map(|heard| away(heard.position.map(f64::from))).fold(0.0, f64::max);
        let report = &mut referee.report;
        report.hand_travel_m = report.hand_travel_m.max(travelled);
        report.hand_error_m = report.hand_error_m.max(error);
    }
}

fn moment(seats: &[Seat<SimulatedPeer>], now_ns: u64) -> Moment {
    let turn = players(seats).map(|(.., contestant)| contestant.player.turn()).max().unwrap_or_default();
    let ball = |(_, seat, contestant): (usize, &Seat<SimulatedPeer>, &Contestant)| {
        contestant.player.ball(seat.clock.at(now_ns) / 1_000)
    };
    let mut on = players(seats).filter(|(_, seat, _)| !seat.off);
    Moment {
        time_s: now_ns as f64 * 1e-9,
        balls: players(seats).map(ball).collect(),
        hands: players(seats).map(|(.., contestant)| contestant.bot.position).collect(),
        active: on.find(|(.., contestant)| contestant.player.is_active()).map(|(at, ..)| at - 1),
        turn: (turn.rally, turn.stroke),
    }
}

/// Plays one game of bots to its end.
pub fn play(options: &Options) -> Game {
    let mut rng = Rng::new(options.seed);
    let (count, damped) = (usize::from(options.players) + 1, options.motion_bounder);
    let mut clock = |_| {
        // Quartz: 100 ppm.
        let (start_us, ppm) = (rng.below(1 << 40), rng.below(201) as f64 - 100.0);
        Clock { start_ns: 1_000 * start_us, rate: 1.0 + ppm * 1e-6 }
    };
    let clocks: Vec<Clock> = (0..count).map(&mut clock).collect();
    let delay_s = options.network.extra_delay_s + options.round_trip_s / 2.0;
    let route = |_| {
        let network = Network { extra_delay_s: delay_s, seed: rng.below(1 << 32) as u32, ..options.network };
        Route::new(0).with_rule(SeededRule::new(network, Direction::OneToTwo, PLACE_EVERY_US as f64 / 1e6))
    };
    let mut routes: Vec<Route> = (0..count * count).map(route).collect();
    let config = ServerConfig { players: options.players, rallies: options.rallies, bounder: options.bounder };
    let seats = clocks.into_iter().enumerate().map(|(at, clock)| {
        let server = || SimulatedPeer::new(Participant::Server(Box::new(Server::new(config))), damped);
        let actor = if at == 0 { server() } else { SimulatedPeer::player(at, damped, &mut rng) };
        Seat { clock, ..Seat::new(actor) }
    });
    let (seats, period_ns) = (seats.collect(), (1e9 * TICK_S) as u64);
    let mut engine = Engine::new(period_ns, seats, |from, to| std::mem::take(&mut routes[from * count + to]));
    let mut referee = Referee::new(Court::SINGLES, options.players);
    let ticks = (options.seconds / TICK_S).round() as u64;
    let round_trip = (options.round_trip_s / TICK_S).round().max(1.0) as usize;
    let (mut moments, mut present, mut rallies) = (Vec::new(), vec![true; count - 1], 0);
    // The game is over, and everybody who is there knows.
    let is_over = |seats: &[Seat<SimulatedPeer>]| {
        seats.iter().filter(|seat| !seat.off).all(|seat| seat.actor.participant.game().phase == Phase::Over)
    };
    while engine.tick() < ticks && !is_over(&engine.seats) {
        let tick = engine.tick();
        for &(at_s, number, change) in &options.changes {
            if (at_s / TICK_S).round() as u64 == tick {
                let (at, seat) = (usize::from(number), &mut engine.seats[usize::from(number)]);
                match (change, &mut seat.actor.participant) {
                    (Change::Leaves, Participant::Player(contestant)) => contestant.player.leave(),
                    (Change::Leaves, Participant::Server(_)) => {}
                    (Change::Vanishes, _) => seat.off = true,
                    (Change::Comes, _) => {
                        seat.actor = SimulatedPeer::player(at, damped, &mut rng);
                        seat.off = false;
                        referee.came_back(number);
                    }
                }
                present[at - 1] = change == Change::Comes;
            }
        }
        engine.step(&mut |seen| watch(&mut referee, &mut rallies, seen));
        measure(&mut referee, &mut engine.seats, round_trip);
        if options.record_every > 0 && tick % options.record_every == 0 {
            moments.push(moment(&engine.seats, tick * period_ns));
        }
    }
    let over = is_over(&engine.seats);
    // The next rally begins when all know the last: only one result can be on its way.
    referee.ends(&present, usize::from(!over));
    let mut report = referee.report;
    report.over = over;
    report.round_trip_ms = f64::from(engine.seats[0].actor.participant.game().round_trip_us) * 1e-3;
    report.score.truncate(usize::from(options.players));
    let bytes: u64 = engine.seats[1..].iter().map(|seat| seat.actor.bytes).sum();
    report.bytes_per_s = bytes as f64 / (engine.tick() as f64 * TICK_S) / f64::from(options.players);
    report.state_hash = hash(players(&engine.seats).map(|(.., contestant)| &contestant.player));
    Game { report, moments }
}

/// FNV-1a of what the players know: equal seeds, equal games.
fn hash<'a>(players: impl Iterator<Item = &'a Player>) -> String {
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    for byte in players.flat_map(|player| format!("{player:?}").into_bytes()) {
        hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    }
    format!("{hash:016x}")
}

const _: () = assert!(PLAYERS == 8 && SERVER.0 == 0);
