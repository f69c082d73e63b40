//! The server of a game: who plays, what a rally came to, how fast the ball may be.

use core::convert::Infallible;

use cohold_protocol::wire::PeerId;

use super::ball::RoundTrips;
use super::rules::{
    Ending, Game, HEARTBEAT_LIMIT_US, Message, PLACE_EVERY_US, PLAYERS, Phase, RALLIES, SERVER, Turn, Verdict, place_of,
};
use crate::roles::{Out, Role};

/// Settings of the server.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ServerConfig {
    /// Players that the game begins with; later ones come in between two rallies. 2 to [`PLAYERS`].
    pub players: u8,
    /// Rallies after which the game is over; [`RALLIES`] at the most.
    pub rallies: u16,
    /// Whether the ball is bounded by the longest round trip.
    pub bounder: bool,
}

#[derive(Clone, Copy, Debug, Default)]
struct Seat {
    wants: bool,
    heard_us: u64,
    life: u16,
    /// Number of its newest place.
    number: u32,
    revision: u16,
    measured: bool,
}

/// The server of a game.
#[derive(Clone, Debug, Default)]
pub struct Server {
    config: ServerConfig,
    game: Game,
    seats: [Seat; PLAYERS],
    /// The newest hit that is known.
    turn: Turn,
    trips: RoundTrips,
    next_us: u64,
}

impl Server {
    /// A server that waits for players.
    pub fn new(config: ServerConfig) -> Self {
        Self { config, ..Self::default() }
    }

    /// The state of the game.
    pub fn game(&self) -> &Game {
        &self.game
    }

    fn wants(&self, player: PeerId) -> bool {
        self.seats.get(place_of(player)).is_some_and(|seat| seat.wants)
    }

    fn is_on(&self, turn: Turn) -> bool {
        self.game.phase == Phase::Rally && turn.rally == self.game.rally
    }

    fn hear(&mut self, turn: Turn) {
        if self.is_on(turn) && turn > self.turn {
            self.turn = turn;
        }
    }

    fn end(&mut self, ending: Ending, active: PeerId) {
        let strokes = self.turn.stroke;
        self.game.last = Verdict { rally: self.game.rally, strokes, ending, loser: active };
        if let Some(before) = strokes.checked_sub(1)
            && ending.scores()
            && let Some(winner) = self.game.active(before)
            && let Some(points) = self.game.score.get_mut(place_of(winner))
        {
            *points = points.saturating_add(1);
        }
        let over = self.game.rally >= self.config.rallies.min(RALLIES);
        self.game.phase = if over { Phase::Over } else { Phase::Waiting };
        self.game.revision = self.game.revision.saturating_add(1);
    }

    /// The next rally, once everybody is there, knows how the last one ended and has measured how far the others are.
    fn begin(&mut self) {
        let here = || (1..).map(PeerId).zip(&self.seats).filter(|(_, seat)| seat.wants);
        let count = here().count();
        let ready =
            here().all(|(_, seat)| seat.measured && (self.game.rally == 0 || seat.revision == self.game.revision));
        let least = if self.game.rally == 0 { usize::from(self.config.players) } else { 2 };
        if !ready || count < least.max(2) {
            return;
        }
        let Some(rally) = self.game.rally.checked_add(1) else { return };
        // Each rally another one serves; the others follow in turn.
        let mut players = [SERVER; PLAYERS];
        let first = usize::from(rally - 1).checked_rem(count).unwrap_or(0);
        let order = here().map(|(player, _)| player).cycle().skip(first).take(count);
        players.iter_mut().zip(order).for_each(|(place, player)| *place = player);
        self.game.players = players;
        self.game.rally = rally;
        self.game.phase = Phase::Rally;
        self.game.revision = self.game.revision.saturating_add(1);
        self.turn = Turn { rally, stroke: 0 };
    }

    fn say(&mut self, now: u64, out: &mut dyn Out<Message>) {
        self.next_us = now.saturating_add(PLACE_EVERY_US);
        for (player, seat) in (1..).map(PeerId).zip(&self.seats) {
            // Who has just gone hears it, too.
            if seat.wants || self.game.order().any(|other| other == player) {
                out.send(player, Message::Game { game: self.game });
            }
        }
    }
}

impl Role for Server {
    type Message = Message;
    type Notice = Infallible;

    fn receive(&mut self, now: u64, from: PeerId, message: &Message, out: &mut dyn Out<Message>) {
        let Some(seat) = self.seats.get_mut(place_of(from)) else { return };
        match *message {
            Message::Join => {
                if !seat.wants {
                    // Its places may be numbered from the beginning again.
                    *seat = Seat { wants: true, ..Seat::default() };
                }
                seat.heard_us = now;
            }
            Message::Leave => seat.wants = false,
            Message::Place { turn, revision, life, number, round_trip_us, .. } => {
                seat.heard_us = now;
                if seat.number > 0 && life != seat.life {
                    // It has started anew and knows nothing of the rally: out, and in again when it asks.
                    seat.wants = false;
                }
                if !seat.wants {
                    self.poll(now, out);
                    return;
                }
                seat.life = life;
                if number > seat.number {
                    seat.number = number;
                    seat.revision = revision;
                    if round_trip_us > 0 {
                        seat.measured = true;
                        self.trips.add(now, round_trip_us);
                    }
                    self.hear(turn);
                }
            }
            Message::Hit { turn, .. } => self.hear(turn),
            Message::Miss { turn, ending } => {
                let active = self.game.active(turn.stroke) == Some(from);
                if self.is_on(turn) && active && turn >= self.turn && ending != Ending::None {
                    self.turn = turn;
                    self.end(ending, from);
                    self.say(now, out);
                }
            }
            Message::Ping { number, sent_us } => {
                out.send(from, Message::Pong { number, sent_us, received_us: now, answered_us: now });
            }
            Message::Game { .. } | Message::Pong { .. } => {}
        }
        self.poll(now, out);
    }

    fn poll(&mut self, now: u64, out: &mut dyn Out<Message>) {
        for seat in &mut self.seats {
            seat.wants &= now.saturating_sub(seat.heard_us) < HEARTBEAT_LIMIT_US;
        }
        let revision = self.game.revision;
        match self.game.phase {
            Phase::Rally => {
                if let Some(gone) = self.game.order().find(|player| !self.wants(*player)) {
                    self.end(Ending::Broken, gone);
                }
            }
            Phase::Waiting => self.begin(),
            Phase::Over => {}
        }
        self.game.round_trip_us = if self.config.bounder { self.trips.longest_us() } else { 0 };
        if now >= self.next_us || self.game.revision != revision {
            self.say(now, out);
        }
    }
}
