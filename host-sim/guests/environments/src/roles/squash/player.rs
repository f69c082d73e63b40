//! A player: hits when it is active, knows where the ball is when it is not.

use cohold_protocol::{clock::Clock, notices::Notices, wire::PeerId};

use super::ball::{Ball, BallBounds, Court, Impact, Racket, RoundTrips};
use super::rules::{
    Ending, Game, Message, PING_EVERY_US, PLACE_EVERY_US, PLAYERS, Phase, SAY_AGAIN_US, SERVER, Turn, Verdict, place_of,
};
use crate::roles::{Out, Role};

/// Settings of a player.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlayerConfig {
    /// Its number, 1 to [`PLAYERS`].
    pub number: PeerId,
    /// Dimensions of the court, m.
    pub court: Court,
    /// Mass of the ball, kg.
    pub ball_kg: f32,
    /// Another number at each start: a random one.
    pub life: u16,
}

/// What a player has to tell its user.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Notice {
    /// The rally with this number begins.
    Begins(u16),
    /// Somebody has hit the ball.
    Hit {
        /// Which hit.
        turn: Turn,
        /// How far the ball is from where it was thought to be, m, in x and y.
        corrected_m: [f32; 2],
    },
    /// A rally has ended.
    Ends {
        /// What it came to.
        verdict: Verdict,
        /// The score now.
        score: [u8; PLAYERS],
        /// Hits of it that this player knew of.
        seen: u16,
    },
}

/// A hit that was made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strike {
    /// The hit's place in its rally.
    pub turn: Turn,
    /// What the device renders.
    pub impact: Impact,
    /// The ball is as fast as the network allows, and not as fast as the racket would have it.
    pub bounded: bool,
}

/// The newest hit: when it was, and how the ball flew after it.
#[derive(Clone, Copy, Debug, Default)]
struct Flight {
    turn: Turn,
    at_us: u64,
    ball: Ball,
    /// The ball had left before this player knew.
    unseen: bool,
}

#[derive(Clone, Copy, Debug, Default)]
struct OpponentState {
    /// The newest hit that it knows.
    turn: Turn,
    life: u16,
    /// Its newest place.
    number: u32,
    racket: Ball,
    ping: u32,
    pinged_us: u64,
    answered: bool,
    next_us: u64,
}

/// A player of the game, on this client.
#[derive(Clone, Debug)]
pub struct Player {
    config: PlayerConfig,
    game: Game,
    flight: Flight,
    lost: Option<Ending>,
    clock: Clock,
    trips: RoundTrips,
    racket: Ball,
    /// The server at 0, players at their numbers.
    others: [OpponentState; PLAYERS + 1],
    number: u32,
    next_place_us: u64,
    next_again_us: u64,
    leaving: bool,
    notices: Notices<Notice, 8>,
}

impl Player {
    /// A player that would like to play.
    pub fn new(config: PlayerConfig) -> Self {
        Self {
            config,
            game: Game::default(),
            flight: Flight::default(),
            lost: None,
            clock: Clock::default(),
            trips: RoundTrips::default(),
            racket: Ball::default(),
            others: [OpponentState::default(); PLAYERS + 1],
            number: 0,
            next_place_us: 0,
            next_again_us: 0,
            leaving: false,
            notices: Notices::default(),
        }
    }

    /// The game, as far as it is known here.
    pub fn game(&self) -> &Game {
        &self.game
    }

    /// The newest hit that is known here.
    pub fn turn(&self) -> Turn {
        self.flight.turn
    }

    /// Bounds on the ball.
    pub fn bounds(&self) -> BallBounds {
        BallBounds::new(self.config.court.length_m, self.game.round_trip_us)
    }

    /// The longest round trip that was measured here, µs.
    pub fn round_trip_us(&self) -> u32 {
        self.trips.longest_us()
    }

    /// The time on the server's clock, once that is known, µs.
    fn game_us(&self, now: u64) -> Option<u64> {
        now.checked_add_signed(self.clock.offset_us(now)?)
    }

    /// The ball now; `None` outside of rallies and before the serve.
    pub fn ball(&self, now: u64) -> Option<Ball> {
        let on = self.game.phase == Phase::Rally && self.flight.turn.rally == self.game.rally;
        (on && self.flight.turn.stroke > 0).then_some(())?;
        Some(self.config.court.flight(&self.flight.ball, self.since_hit_s(now)?))
    }

    /// Where another player's racket was last said to be.
    pub fn racket_of(&self, player: PeerId) -> Option<Ball> {
        self.others.get(usize::from(player.0)).filter(|other| other.number > 0).map(|other| other.racket)
    }

    /// Whether this player may hit the ball, or serve.
    pub fn is_active(&self) -> bool {
        let Turn { rally, stroke } = self.flight.turn;
        let on = self.game.phase == Phase::Rally && rally == self.game.rally && self.lost.is_none();
        on && self.game.active(stroke) == Some(self.config.number)
    }

    /// Points of this player.
    pub fn points(&self) -> u8 {
        self.game.score.get(place_of(self.config.number)).copied().unwrap_or(0)
    }

    /// Where the user's racket is, for the others to see.
    pub fn place(&mut self, racket: Ball) {
        self.racket = racket;
    }

    /// The user leaves the game.
    pub fn leave(&mut self) {
        self.leaving = true;
    }

    /// The racket meets the ball, or serves one that lies still at its place. `None` if this player may not hit it, it is
    /// out of the court, or the two move apart. Whether racket and ball are at one place is for the caller to find out.
    pub fn hit(&mut self, now: u64, racket: &Racket, out: &mut dyn Out<Message>) -> Option<Strike> {
        let at_us = self.game_us(now)?;
        if !self.is_active() || self.flight.unseen {
            return None;
        }
        let before = match self.ball(now) {
            Some(ball) if self.since_hit_s(now)? < self.config.court.leaves_s(&self.flight.ball) => ball,
            Some(_) => return None,
            None => Ball { position: self.config.court.inside(self.racket.position), velocity: [0.0; 2] },
        };
        let wish = racket.hit(self.config.ball_kg, before.velocity)?;
        let velocity = self.bounds().limit(before.velocity, wish);
        let Turn { rally, stroke } = self.flight.turn;
        let impact = Impact::between(self.config.ball_kg, before.velocity, velocity);
        if velocity[0] > 0.0 {
            let turn = Turn { rally, stroke: stroke.checked_add(1)? };
            self.flight = Flight { turn, at_us, ball: Ball { velocity, ..before }, unseen: false };
        } else {
            self.lost = Some(Ending::Fault);
        }
        self.next_again_us = now;
        self.poll(now, out);
        Some(Strike { turn: self.flight.turn, impact, bounded: velocity != wish })
    }

    /// Everybody else in the game, and the server.
    fn peers(&self) -> impl Iterator<Item = PeerId> + use<> {
        let own = self.config.number;
        let game = self.game;
        core::iter::once(SERVER).chain(game.players.into_iter().filter(move |peer| *peer != own && *peer != SERVER))
    }

    fn own_place(&self) -> Message {
        Message::Place {
            turn: self.flight.turn,
            revision: self.game.revision,
            life: self.config.life,
            number: self.number.saturating_add(1),
            round_trip_us: self.trips.longest_us(),
            racket: self.racket,
        }
    }

    fn since_hit_s(&self, now: u64) -> Option<f32> {
        let since = i128::from(self.game_us(now)?) - i128::from(self.flight.at_us);
        Some(since as f32 * 1e-6)
    }

    fn learn(&mut self, game: Game) {
        let newer = game.revision > self.game.revision;
        if newer {
            if game.last.rally > self.game.last.rally {
                let seen = if self.flight.turn.rally == game.last.rally { self.flight.turn.stroke } else { 0 };
                self.notices.put(Notice::Ends { verdict: game.last, score: game.score, seen });
            }
            if game.phase == Phase::Rally && game.rally > self.game.rally {
                let turn = Turn { rally: game.rally, stroke: 0 };
                // A hit may have come before its rally was announced.
                if self.flight.turn < turn {
                    self.flight = Flight { turn, ..Flight::default() };
                }
                self.lost = None;
                self.notices.put(Notice::Begins(game.rally));
            }
        }
        if newer || game.revision == self.game.revision {
            self.game = game;
        }
    }

    fn take_hit(&mut self, now: u64, turn: Turn, at_us: u64, ball: Ball) {
        if turn <= self.flight.turn {
            return;
        }
        let thought = self.ball(now);
        let before = self.flight.turn;
        self.flight = Flight { turn, at_us, ball, unseen: false };
        self.lost = None;
        let since_s = self.since_hit_s(now).unwrap_or(0.0);
        self.flight.unseen = since_s >= self.config.court.leaves_s(&ball);
        let is = self.config.court.flight(&ball, since_s).position;
        // After the serve, or a hit that was never heard of, there is nothing to correct.
        let corrected_m = match thought {
            Some(thought) if before.rally == turn.rally && before.stroke.saturating_add(1) == turn.stroke => {
                let [x, y] = thought.position;
                [is[0] - x, is[1] - y]
            }
            _ => [0.0; 2],
        };
        self.notices.put(Notice::Hit { turn, corrected_m });
    }

    /// What nobody has answered: a hit to each who does not know it, a miss to a server that has not said so.
    fn say_again(&mut self, out: &mut dyn Out<Message>) {
        let Flight { turn, at_us, ball, .. } = self.flight;
        if self.game.phase != Phase::Rally || turn.rally != self.game.rally {
            return;
        }
        if let Some(ending) = self.lost {
            out.send(SERVER, Message::Miss { turn, ending });
        }
        let own = turn.stroke.checked_sub(1).is_some_and(|before| self.game.active(before) == Some(self.config.number));
        if own {
            for peer in self.peers().filter(|peer| *peer != SERVER) {
                if self.others.get(usize::from(peer.0)).is_some_and(|other| other.turn < turn) {
                    out.send(peer, Message::Hit { turn, at_us, ball });
                }
            }
        }
    }

    /// Measures how far everybody is, counted from the first sending.
    fn ping(&mut self, now: u64, out: &mut dyn Out<Message>) {
        for peer in self.peers() {
            let Some(other) = self.others.get_mut(usize::from(peer.0)).filter(|other| now >= other.next_us) else {
                continue;
            };
            if other.answered || other.ping == 0 {
                other.ping = other.ping.saturating_add(1);
                other.pinged_us = now;
                other.answered = false;
            }
            other.next_us = now.saturating_add(SAY_AGAIN_US);
            // The time of this sending tells the clocks, the first one the round trip.
            out.send(peer, Message::Ping { number: other.ping, sent_us: now });
        }
    }

    fn ponged(&mut self, now: u64, from: PeerId, number: u32, [sent_us, received_us, answered_us]: [u64; 3]) {
        if from == SERVER {
            // Times that no clocks could give say nothing.
            let _ = self.clock.sample(sent_us, received_us, answered_us, now);
        }
        let Some(other) = self.others.get_mut(usize::from(from.0)) else { return };
        if number == other.ping && !other.answered {
            other.answered = true;
            other.next_us = other.pinged_us.saturating_add(PING_EVERY_US).max(now);
            let round_trip = u32::try_from(now.saturating_sub(other.pinged_us)).unwrap_or(u32::MAX);
            self.trips.add(now, round_trip.max(1));
        }
    }
}

impl Role for Player {
    type Message = Message;
    type Notice = Notice;

    fn receive(&mut self, now: u64, from: PeerId, message: &Message, out: &mut dyn Out<Message>) {
        match *message {
            Message::Game { game } if from == SERVER => self.learn(game),
            Message::Place { turn, life, number, racket, .. } => {
                let Some(other) = self.others.get_mut(usize::from(from.0)) else { return };
                if life != other.life {
                    // It has started anew, and counts from the beginning.
                    *other = OpponentState { life, ..OpponentState::default() };
                }
                if number > other.number {
                    *other = OpponentState { number, racket, turn: turn.max(other.turn), ..*other };
                }
            }
            Message::Hit { turn, at_us, ball } => {
                let by = turn.stroke.checked_sub(1).and_then(|before| self.game.active(before));
                if turn.rally != self.game.rally || by == Some(from) {
                    self.take_hit(now, turn, at_us, ball);
                }
                // So that it need not be said again.
                out.send(from, self.own_place());
            }
            Message::Ping { number, sent_us } => {
                out.send(from, Message::Pong { number, sent_us, received_us: now, answered_us: now });
            }
            Message::Pong { number, sent_us, received_us, answered_us } => {
                self.ponged(now, from, number, [sent_us, received_us, answered_us]);
            }
            _ => {}
        }
        self.poll(now, out);
    }

    fn poll(&mut self, now: u64, out: &mut dyn Out<Message>) {
        let gone =
            self.since_hit_s(now).is_some_and(|since_s| since_s >= self.config.court.leaves_s(&self.flight.ball));
        if self.is_active() && self.flight.turn.stroke > 0 && gone {
            self.lost = Some(if self.flight.unseen { Ending::Unseen } else { Ending::Missed });
            self.next_again_us = now;
        }
        if now >= self.next_again_us {
            self.next_again_us = now.saturating_add(SAY_AGAIN_US);
            self.say_again(out);
        }
        if now >= self.next_place_us {
            self.next_place_us = now.saturating_add(PLACE_EVERY_US);
            out.send(SERVER, if self.leaving { Message::Leave } else { Message::Join });
            for peer in self.peers() {
                out.send(peer, self.own_place());
            }
            self.number = self.number.saturating_add(1);
        }
        self.ping(now, out);
    }

    fn take_notice(&mut self) -> Option<Notice> {
        self.notices.take()
    }
}
