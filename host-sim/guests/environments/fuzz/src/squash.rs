//! A game of squash with three players on a network that the script commands. At most one player may hit the ball in a rally;
//! all hear the same of every rally; the ball is always in the court; and what a racket is to feel is always a number.

use std::collections::HashMap;

use cohold_environments::roles::squash::{
    Ball, Court, Message, Notice, PLAYERS, Phase, Player, PlayerConfig, Racket, Server, ServerConfig, Verdict,
};
use cohold_environments::roles::{Outbox, Role};
use cohold_protocol::wire::PeerId;

use super::net::Net;
use super::script::Script;

const MEMBERS: usize = 3;

struct World {
    now_us: u64,
    net: Net<Message>,
    out: Outbox<Message, 64>,
    server: Server,
    players: [Player; MEMBERS],
    /// What the server said of each rally.
    verdicts: HashMap<u16, (Verdict, [u8; PLAYERS])>,
}

impl World {
    fn new(bounder: bool) -> Self {
        let player = |number| {
            Player::new(PlayerConfig {
                number: PeerId(number),
                court: Court::SINGLES,
                ball_kg: 0.024,
                life: number.into(),
            })
        };
        Self {
            now_us: 0,
            net: Net::new(),
            out: Outbox::new(),
            server: Server::new(ServerConfig { players: MEMBERS as u8, rallies: 1_000, bounder }),
            players: [player(1), player(2), player(3)],
            verdicts: HashMap::new(),
        }
    }

    /// What the clock of `peer` shows: they are far apart.
    fn now(&self, peer: usize) -> u64 {
        self.now_us + (1 << (10 * peer))
    }

    fn poll(&mut self, peer: usize) {
        let now = self.now(peer);
        match peer.checked_sub(1) {
            None => self.server.poll(now, &mut self.out),
            Some(at) => self.players[at].poll(now, &mut self.out),
        }
        self.net.post(peer, &mut self.out);
    }

    fn receive(&mut self, (from, to, message): (usize, usize, Message)) {
        let (now, from) = (self.now(to), PeerId(from as u8));
        match to.checked_sub(1) {
            None => self.server.receive(now, from, &message, &mut self.out),
            Some(at) => self.players[at].receive(now, from, &message, &mut self.out),
        }
        self.net.post(to, &mut self.out);
        self.look();
    }

    fn hit(&mut self, at: usize, racket: &Racket) {
        let now = self.now(at + 1);
        if let Some(strike) = self.players[at].hit(now, racket, &mut self.out) {
            let felt = strike.impact.velocity.iter().chain(&strike.impact.recoil_n_s);
            assert!(felt.clone().all(|part| part.is_finite()), "{strike:?}");
        }
        self.net.post(at + 1, &mut self.out);
    }

    /// What must always be true.
    fn look(&mut self) {
        let game = self.server.game();
        if game.phase != Phase::Rally && game.rally > 0 {
            let said = (game.last, game.score);
            assert_eq!(*self.verdicts.entry(game.rally).or_insert(said), said, "the server has changed its mind");
        }
        let mut active = Vec::new();
        for (at, player) in self.players.iter_mut().enumerate() {
            while let Some(notice) = player.take_notice() {
                if let Notice::Ends { verdict, score, .. } = notice {
                    assert_eq!(self.verdicts.get(&verdict.rally), Some(&(verdict, score)), "player {}", at + 1);
                }
            }
            if player.is_active() {
                active.push(player.turn().rally);
            }
            if let Some(ball) = player.ball(self.now_us + (1 << (10 * (at + 1)))) {
                let [x, y] = ball.position;
                assert!((0.0..=9.75).contains(&x) && (0.0..=6.4).contains(&y), "{ball:?}");
            }
        }
        active.sort_unstable();
        assert!(active.is_sorted_by(|one, two| one < two), "two players may hit in one rally: {active:?}");
    }
}

/// A few m/s, or any number at all.
fn speed(script: &mut Script) -> f32 {
    match script.byte() {
        255 => f32::from_bits(u32::from(script.half()) << 16),
        byte => f32::from(byte) - 127.0,
    }
}

/// Runs one fuzz input through a game of three players.
pub(super) fn run(bytes: &[u8]) {
    let mut script = Script(bytes);
    let mut world = World::new(script.byte() & 1 == 0);
    // The game begins in peace; a script that had to find out how would seldom come further.
    for _ in 0..400 {
        world.now_us += 1_000;
        for message in world.net.take_all() {
            world.receive(message);
        }
        (0..=MEMBERS).for_each(|peer| world.poll(peer));
    }
    assert_eq!(world.server.game().phase, Phase::Rally);
    while script.goes_on() {
        let (call, peer) = (script.byte(), script.below(MEMBERS + 1));
        let at = peer.saturating_sub(1);
        match call % 16 {
            0..=3 => world.now_us += script.time_us(),
            4..=6 => world.poll(peer),
            7..=10 => {
                if let Some(message) = world.net.deliver(&mut script) {
                    world.receive(message);
                }
            }
            11 => world.net.lose(&mut script),
            12 | 13 => {
                let velocity = [speed(&mut script), speed(&mut script)];
                world.hit(at, &Racket { mass_kg: 0.2, velocity, normal: [1.0, speed(&mut script)] });
            }
            14 => {
                let position = [speed(&mut script), speed(&mut script)];
                world.players[at].place(Ball { position, velocity: [0.0; 2] });
            }
            // Everybody hears everything.
            _ => {
                for message in world.net.take_all() {
                    world.receive(message);
                }
            }
        }
        world.look();
    }
}
