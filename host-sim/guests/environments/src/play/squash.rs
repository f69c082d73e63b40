//! Squash: four players and a server over the scene's network, of whom one or two are people.
//!
//! A person's pointer is where the hand is wanted, in a device's workspace, which is the court on a scale; the arm pulls the hand there
//! with a limited force, damped by the round trip, and the racket hits what it meets when it is its turn. Who has let go stands.

use cohold_live::playable::{Column, Held, Play};
use cohold_protocol::wire::PeerId;
use cohold_sim::engine::{Actor, Engine, Out, Seat};
use cohold_sim::{network::link::Route, rng::Rng, scene::Scene};

use super::engine;
use crate::roles::squash::{Court, Message, PLAYERS, Phase, RALLIES, Server, ServerConfig};
use crate::roles::{Carried as _, Role as _};
use crate::squash::bot::{Contestant, Participant, SCALE};
use crate::{Crossing, said};

/// Number of players in the game.
const COUNT: usize = 4;
const _: () = assert!(COUNT <= PLAYERS);

pub(super) const COLUMNS: [Column; 18] = [
    ("hand_1_x", "m", "hand 1, from the back of the court"),
    ("hand_1_y", "m", "hand 1, from its side"),
    ("hand_2_x", "m", "hand 2"),
    ("hand_2_y", "m", "hand 2"),
    ("hand_3_x", "m", "hand 3"),
    ("hand_3_y", "m", "hand 3"),
    ("hand_4_x", "m", "hand 4"),
    ("hand_4_y", "m", "hand 4"),
    ("ball_x", "m", "ball, where who is to hit it believes it to be; no number before the serve"),
    ("ball_y", "m", "ball"),
    ("next", "", "who is to hit it, 1 to 4; 0 nobody"),
    ("rally", "", "rallies so far"),
    ("stroke", "", "hits in this rally"),
    ("score_1", "", "points of player 1"),
    ("score_2", "", "points of player 2"),
    ("score_3", "", "points of player 3"),
    ("score_4", "", "points of player 4"),
    ("round_trip", "s", "longest round trip that the game knows of, which bounds the ball"),
];

/// Size of the court, m, and a pointer's metre in it.
pub(super) fn size() -> [f64; 2] {
    let Court { length_m, width_m } = Court::SINGLES;
    [length_m, width_m].map(f64::from)
}

/// A pointer's metres for a metre of the court.
pub(super) const POINTER: f64 = SCALE;

/// The server or one player.
struct GameSeat(Participant);

impl Actor<usize> for GameSeat {
    type Packet = Crossing;

    fn hear(&mut self, now_ns: u64, from: usize, Crossing(message): &mut Crossing, out: &mut Out<'_, usize, Crossing>) {
        let Some((_, message)) = Message::read(message) else { return };
        self.0.receive(now_ns / 1_000, PeerId(from as u8), &message, &mut said(0, out));
        if let Participant::Player(contestant) = &mut self.0 {
            contestant.hears(now_ns / 1_000, |_, _| ());
        }
    }

    fn speak(&mut self, now_ns: u64, out: &mut Out<'_, usize, Crossing>) {
        let now_us = now_ns / 1_000;
        match &mut self.0 {
            Participant::Server(server) => server.poll(now_us, &mut said(0, out)),
            Participant::Player(contestant) => {
                contestant.tick(now_us, true, &mut said(0, out));
                contestant.hears(now_us, |_, _| ());
            }
        }
    }
}

/// A game of squash in the page.
pub(super) struct Squash {
    engine: Engine<GameSeat>,
}

impl Squash {
    fn players(&self) -> impl Iterator<Item = &Contestant> {
        self.engine.seats.iter().filter_map(|seat| match &seat.actor.0 {
            Participant::Player(contestant) => Some(contestant.as_ref()),
            Participant::Server(_) => None,
        })
    }

    pub(super) fn open(scene: &Scene) -> Self {
        let config = ServerConfig { players: COUNT as u8, rallies: RALLIES, bounder: true };
        // The noise of the hands is the scene's, as its losses are: who has the scene has the game.
        let mut seeds = Rng::new(scene.world.network.seed.into());
        let player = |number: usize| {
            let seed = seeds.below(u64::MAX);
            Participant::Player(Box::new(Contestant::new(PeerId(number as u8), seed as u16, seed)))
        };
        let server = std::iter::once(Participant::Server(Box::new(Server::new(config))));
        let seats = server.chain((1..=COUNT).map(player)).map(|part| Seat::new(GameSeat(part))).collect();
        Self { engine: engine(scene, seats) }
    }
}

impl Play for Squash {
    fn hold(&mut self, hand: usize, held: Held) {
        let Some(Participant::Player(contestant)) = self.engine.seats.get_mut(hand + 1).map(|seat| &mut seat.actor.0)
        else {
            return;
        };
        let [length, width] = size();
        contestant.held(match held {
            Held::ByNobody => None,
            Held::Free => Some(contestant.hand()),
            Held::At([x, y]) => Some([(x / POINTER).clamp(0.0, length), (y / POINTER).clamp(0.0, width)]),
        });
    }

    fn step(&mut self) {
        self.engine.step(&mut |_| ());
    }

    fn numbers(&self, number: &mut dyn FnMut(f64)) {
        let now_us = self.engine.now_ns() / 1_000;
        self.players().flat_map(Contestant::hand).for_each(&mut *number);
        let next = self.players().position(|contestant| contestant.player.is_active());
        let ball = self.players().nth(next.unwrap_or(0)).and_then(|contestant| contestant.player.ball(now_us));
        ball.map_or([f64::NAN; 2], |ball| ball.position.map(f64::from)).into_iter().for_each(&mut *number);
        number(next.map_or(0, |next| next + 1) as f64);
        let turn = self.players().map(|contestant| contestant.player.turn()).max().unwrap_or_default();
        [turn.rally, turn.stroke].into_iter().for_each(|count| number(count.into()));
        let game = self.engine.seats[0].actor.0.game();
        game.score.iter().take(COUNT).for_each(|score| number((*score).into()));
        number(1e-6 * f64::from(game.round_trip_us));
    }

    fn seats(&self) -> usize {
        COUNT + 1
    }

    fn route(&mut self, from: usize, to: usize) -> &mut Route {
        self.engine.route(from, to)
    }

    fn is_over(&self) -> bool {
        self.engine.seats[0].actor.0.game().phase == Phase::Over
    }
}
