//! Squash in real time: one process for the server and one for each player, a sealed link between any two ([`super::post`]).
//! The bots are those of the simulated game ([`crate::shared::squash`]).

use haptic_sim::key_file::entropy;
use std::net::SocketAddr;
use std::time::{Duration, Instant};

use haptic_protocol::key::Key;
use haptic_protocol::roles::squash::{
    Ending, Message, Notice, PLAYERS, RALLIES, SERVER, Server, ServerConfig, Verdict,
};
use haptic_protocol::roles::{Outbox, Role};
use haptic_protocol::wire::PeerId;
use serde::Serialize;

use super::pace::{Pace, Punctuality};
use super::post::{Met, Post};
use crate::shared::squash::contestant::{Contestant, TICK_S};

/// Who this is, and where the others are.
#[derive(Clone, Debug)]
pub struct Options {
    /// 0 is the server, 1 … the players.
    pub number: u8,
    /// Where each of them listens, in order.
    pub addresses: Vec<SocketAddr>,
    /// The server bounds the ball.
    pub bounder: bool,
    /// The player's hand is damped.
    pub motion_bounder: bool,
    /// How long, s.
    pub seconds: f64,
}

/// A rally as this process was told.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Rally {
    /// Its number.
    pub rally: u16,
    /// Hits.
    pub strokes: u16,
    /// How it ended.
    pub ending: String,
    /// Who was active then.
    pub loser: u8,
}

impl From<Verdict> for Rally {
    fn from(verdict: Verdict) -> Self {
        let Verdict { rally, strokes, ending, loser } = verdict;
        Self { rally, strokes, ending: format!("{ending:?}").to_lowercase(), loser: loser.0 }
    }
}

/// What one process saw.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// 0 is the server, 1 … the players.
    pub number: u8,
    /// Rallies that ended while it was there.
    pub rallies: Vec<Rally>,
    /// Points of player 1, 2, ….
    pub score: Vec<u8>,
    /// Hits that it made.
    pub strokes: u32,
    /// Balls that had left the court before it knew of the hit.
    pub unseen: u32,
    /// Longest round trip that the game knows of, ms; 0 without the bounder.
    pub round_trip_ms: f64,
    /// The others, and when each was there.
    pub others: Vec<Met>,
    /// Links to others that are up in the end.
    pub links: usize,
    /// Datagrams that were refused.
    pub refused: u32,
    /// How well the 1 kHz beat was kept.
    pub punctuality: Punctuality,
}

/// What this process plays.
enum Part {
    Server(Box<Server>),
    Player(Box<Contestant>),
}

/// Plays until the time is over.
///
/// # Errors
/// A number without an address, a socket that cannot be opened, nobody there: in one line.
pub fn run(key: &Key, options: &Options) -> Result<Report, String> {
    let count = options.addresses.len();
    if !(3..=PLAYERS + 1).contains(&count) {
        return Err(format!(
            "--addresses has {count} addresses: it must have 3 to 9, the server's and 2 to 8 players'"
        ));
    }
    if usize::from(options.number) >= count {
        let most = count - 1;
        return Err(format!(
            "--number {} is not allowed: with {count} addresses it must be 0 to {most}",
            options.number
        ));
    }
    let mut post = Post::new(key, options.number, &options.addresses)?;
    let seed = entropy()?.iter().take(8).fold(0, |seed, byte| seed << 8 | u64::from(*byte));
    let mut part = if options.number == SERVER.0 {
        let players = (count - 1) as u8;
        Part::Server(Box::new(Server::new(ServerConfig { players, rallies: RALLIES, bounder: options.bounder })))
    } else {
        Part::Player(Box::new(Contestant::new(PeerId(options.number), seed as u16, seed)))
    };
    let mut out = Outbox::<Message, 64>::new();
    let (mut rallies, mut strokes, mut unseen): (Vec<Rally>, _, _) = (Vec::new(), 0, 0);
    let tick = Duration::from_secs_f64(TICK_S);
    let mut pace = Pace::new(tick);
    let ticks = (options.seconds / TICK_S).round() as u64;
    for _ in 0..ticks {
        pace.wait();
        let now = pace.now_us();
        for (from, message) in post.take(now, Instant::now() + tick) {
            match &mut part {
                Part::Server(server) => server.receive(now, from, &message, &mut out),
                Part::Player(contestant) => contestant.player.receive(now, from, &message, &mut out),
            }
        }
        match &mut part {
            Part::Server(server) => {
                server.poll(now, &mut out);
                let last = server.game().last;
                if rallies.last().map_or(0, |rally| rally.rally) < last.rally {
                    unseen += u32::from(last.ending == Ending::Unseen);
                    rallies.push(last.into());
                }
            }
            Part::Player(contestant) => {
                contestant.hears(now, |_, notice| {
                    if let Notice::Ends { verdict, .. } = notice {
                        let own = verdict.loser.0 == options.number;
                        unseen += u32::from(verdict.ending == Ending::Unseen && own);
                        rallies.push(verdict.into());
                    }
                });
                strokes += u32::from(contestant.tick(now, options.motion_bounder, &mut out).is_some());
            }
        }
        post.say(now, &mut out);
    }
    if !post.met().iter().any(Met::is_met) {
        return Err(post.nobody(options.seconds));
    }
    let game = match &part {
        Part::Server(server) => server.game(),
        Part::Player(contestant) => contestant.player.game(),
    };
    Ok(Report {
        number: options.number,
        rallies,
        score: game.score.into_iter().take(count - 1).collect(),
        strokes,
        unseen,
        round_trip_ms: f64::from(game.round_trip_us) * 1e-3,
        others: post.met(),
        links: post.links(),
        refused: post.refused(),
        punctuality: pace.punctuality(),
    })
}
