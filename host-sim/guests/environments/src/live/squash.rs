//! Squash in real time: one process for the server and one for each player, a sealed link between any two.
//! The bots are those of the simulated game ([`crate::squash`]).

use std::{net::SocketAddr, time::Duration};

use cohold_live::endpoint::{Endpoint, Live, Punctuality, Stop, Ticker};
use cohold_live::key_file::entropy;
use cohold_protocol::{key::Key, wire::PeerId};
use cohold_sim::engine::{Actor, Out};
use serde::Serialize;

use super::links::{Links, PeerContact};
use crate::Error;
use crate::roles::squash::{Ending, Message, Notice, PLAYERS, RALLIES, SERVER, Server, ServerConfig, Verdict};
use crate::roles::{Outbox, Role};
use crate::squash::bot::{Contestant, Participant, TICK_S};

/// Who this is, and where the others are.
#[derive(Clone, Debug)]
pub struct Options {
    /// 0 is the server, 1 … the players.
    pub number: u8,
    /// Where the server listens, and then each player, in the order of their numbers.
    pub addresses: Vec<SocketAddr>,
    /// The server bounds the ball.
    pub bounder: bool,
    /// The player's hand is damped.
    pub motion_bounder: bool,
    /// How long to play if it is not stopped, s.
    pub seconds: f64,
}

/// A rally as this process heard of it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Rally {
    /// Number of the rally, counted from 1.
    pub rally: u16,
    /// Hits in the rally, the serve among them.
    pub strokes: u16,
    /// How it ended: `missed`, `fault`, `unseen` or `broken`.
    pub ending: String,
    /// Number of the player who was active when it ended; of a broken rally, of the one who had gone.
    pub loser: u8,
}

impl From<Verdict> for Rally {
    fn from(verdict: Verdict) -> Self {
        let Verdict { rally, strokes, ending, loser } = verdict;
        Self { rally, strokes, ending: format!("{ending:?}").to_lowercase(), loser: loser.0 }
    }
}

/// What one process saw.
#[derive(Default, Serialize)]
pub struct Report {
    /// 0 is the server, 1 … the players.
    pub number: u8,
    /// Rallies whose end this process heard of, in order.
    pub rallies: Vec<Rally>,
    /// Points of player 1, 2, ….
    pub score: Vec<u8>,
    /// Hits that this process's own player made; 0 of the server.
    pub strokes: u32,
    /// Balls that had left the court before it knew of the hit.
    pub unseen: u32,
    /// Longest round trip that the game knows of, ms; 0 without the bounder.
    pub round_trip_ms: f64,
    /// The others, and when each was there.
    pub others: Vec<PeerContact>,
    /// Links to others that are up in the end.
    pub links: usize,
    /// Datagrams of the others that their links refused.
    pub refused: u32,
    /// How well the process kept its ticks.
    pub punctuality: Punctuality,
}

struct Process<'a> {
    options: &'a Options,
    own: SocketAddr,
    links: Links,
    part: Participant,
    out: Outbox<Message, 64>,
    ticks: u64,
    seen: Report,
}

impl Actor<SocketAddr> for Process<'_> {
    type Packet = [u8];

    fn hear(&mut self, now_ns: u64, from: SocketAddr, datagram: &mut [u8], _: &mut Out<'_, SocketAddr, [u8]>) {
        let (now, Self { links, part, out, .. }) = (now_ns / 1_000, self);
        links.hear(now, from, datagram, |from, message| part.receive(now, from, message, out));
    }

    fn act(&mut self, now_ns: u64, net: &mut Out<'_, SocketAddr, [u8]>) {
        let now = now_ns / 1_000;
        let Self { options, links, part, out, seen, .. } = self;
        match part {
            Participant::Server(server) => {
                server.poll(now, out);
                let last = server.game().last;
                if seen.rallies.last().map_or(0, |rally| rally.rally) < last.rally {
                    seen.unseen += u32::from(last.ending == Ending::Unseen);
                    seen.rallies.push(last.into());
                }
            }
            Participant::Player(contestant) => {
                contestant.hears(now, |_, notice| {
                    if let Notice::Ends { verdict, .. } = notice {
                        let own = verdict.loser.0 == options.number;
                        seen.unseen += u32::from(verdict.ending == Ending::Unseen && own);
                        seen.rallies.push(verdict.into());
                    }
                });
                seen.strokes += u32::from(contestant.tick(now, options.motion_bounder, out).is_some());
            }
        }
        links.say(now, out, net);
        self.ticks += 1;
    }
}

impl Live for Process<'_> {
    fn missing(&self) -> Option<String> {
        self.links.nobody(self.options.seconds, self.own)
    }

    fn goodbye(&mut self, now_ns: u64, net: &mut Out<'_, SocketAddr, [u8]>) {
        let now_us = now_ns / 1_000;
        self.seen.links = self.links.up();
        let early = (self.ticks as f64 * TICK_S) < self.options.seconds;
        // In the middle of the game: the server need not wait for a heartbeat that stays away.
        if let (true, Participant::Player(contestant)) = (early, &mut self.part) {
            contestant.player.leave();
            contestant.player.poll(now_us, &mut self.out);
            self.links.say(now_us, &mut self.out, net);
        }
        self.links.goodbye(now_us, net);
    }
}

/// Plays until the time is over, or it is stopped.
pub fn run(key: &Key, options: &Options, stop: &Stop) -> Result<Report, Error> {
    let count = options.addresses.len();
    if !(3..=PLAYERS + 1).contains(&count) {
        return Err(Error::Refused(format!(
            "{count} addresses are not allowed: there must be 3 to 9, the server's and 2 to 8 players'"
        )));
    }
    let number = options.number;
    let own = *(options.addresses.get(usize::from(number))).ok_or_else(|| {
        let allowed = format!("with {count} addresses it must be 0 to {}", count - 1);
        cohold_sim::Error::not_allowed(format!("number {number}"), allowed)
    })?;
    let seed = entropy()?.iter().take(8).fold(0, |seed, byte| seed << 8 | u64::from(*byte));
    let part = if number == SERVER.0 {
        let players = (count - 1) as u8;
        Participant::Server(Box::new(Server::new(ServerConfig { players, rallies: RALLIES, bounder: options.bounder })))
    } else {
        Participant::Player(Box::new(Contestant::new(PeerId(number), seed as u16, seed)))
    };
    let links = Links::new(key, number, &options.addresses)?;
    let endpoint = Endpoint::polled(own)?;
    let mut others = (0..).zip(&options.addresses).filter(|(other, _)| *other != number);
    others.try_for_each(|(_, address)| endpoint.reaches(*address))?;
    let (own, seen) = (endpoint.address, Report { number, ..Report::default() });
    let mut process = Process { options, own, links, part, out: Outbox::new(), ticks: 0, seen };
    let ticker = Ticker::realtime(Duration::from_secs_f64(TICK_S)).lasting(options.seconds);
    let punctuality = endpoint.run(ticker, f64::MAX, stop, &mut process)?;
    let game = process.part.game();
    Ok(Report {
        score: game.score.into_iter().take(count - 1).collect(),
        round_trip_ms: f64::from(game.round_trip_us) * 1e-3,
        others: process.links.met().cloned().collect(),
        refused: process.links.refused(),
        punctuality,
        ..process.seen
    })
}
