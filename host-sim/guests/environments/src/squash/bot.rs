//! A bot: sees a hit, reacts as late and as roughly as a person, runs to where the ball will be, and swings; and a contestant: a
//! player's role and the bot that plays it, simulated or live.
//!
//! In the court's own metres; a device's workspace is [`SCALE`] times as large. The hand is a mass that its arm pulls with a
//! limited force and that the user-motion bounder damps; it is advanced by semi-implicit Euler at the control rate.

use cohold_protocol::wire::PeerId;
use cohold_sim::rng::Rng;

use crate::roles::squash::{
    Ball, Court, Game, Message, MotionBounder, Notice, Player, PlayerConfig, Racket, Server, Strike,
};
use crate::roles::{Out, Role as _};

/// Control period of a bot, s.
pub(crate) const TICK_S: f64 = 0.001;
/// A device's workspace over the court: 15 cm for 9.75 m.
pub const SCALE: f64 = 0.15 / 9.75;
/// Mass of a squash ball, kg.
const BALL_KG: f32 = 0.024;
/// Mass of a racket that takes part in an impact, kg.
const RACKET_KG: f32 = 0.15;
/// Mass of the hand with what it carries, kg.
const HAND_KG: f64 = 1.0;
/// Most force of the arm, and how far the user-motion bounder lets it move in a round trip.
pub const MOTION: MotionBounder = MotionBounder { force_n: 150.0, reach_m: 2.0 };
/// Natural frequency of the arm, rad/s; it is critically damped.
const ARM_RAD_PER_S: f64 = 15.0;
/// How far from the hand the racket meets a ball, m.
const RACKET_REACH_M: f64 = 0.7;
/// Reaction: mean and deviation, s.
const REACTION_S: (f64, f64) = (0.2, 0.03);
/// Deviation of where the ball is expected, m, and of when the swing comes, s.
const ROUGH: (f64, f64) = (0.1, 0.008);
/// How long a server bounces the ball before it serves, s.
const SERVES_AFTER_S: f64 = 0.6;
/// Speeds that bots hit at, m/s: rally strokes and smashes.
const STROKES: (f64, f64) = (8.0, 22.0);
const SMASHES: (f64, f64) = (55.0, 75.0);
/// How often a ball is smashed, near the front wall and elsewhere; and what is near, as a share of the court's length.
const SMASH: (f64, f64) = (0.5, 0.05);
const FRONT: f64 = 0.55;
/// How near a hand must come to where it means to meet the ball for the bot to try it, m.
const NEAR_M: f64 = 0.4;
/// How fast a person's hand moves forward that serves, m/s.
const SERVE_M_PER_S: f64 = 0.5;
/// Moments of a flight that a bot looks at, s apart.
const MOMENT_S: f64 = 0.04;

/// What a bot intends for the next hit.
#[derive(Clone, Copy)]
struct Plan {
    /// On its own clock, s.
    at_s: f64,
    /// Speed of the ball, m/s, and its direction, rad from straight ahead.
    speed: f64,
    angle: f64,
}

/// One bot, in the court's metres.
pub(super) struct Bot {
    court: Court,
    home: [f64; 2],
    pub(super) position: [f64; 2],
    velocity: [f64; 2],
    target: [f64; 2],
    /// When it begins to do something about what it has seen, s.
    reacts_s: Option<f64>,
    plan: Option<Plan>,
    /// A person has its hand, and wants it here.
    person: Option<[f64; 2]>,
    /// It may hit, and has not.
    turn: bool,
    rng: Rng,
}

impl Bot {
    /// A bot that stands somewhere in the middle.
    fn new(court: Court, seed: u64) -> Self {
        let mut rng = Rng::new(seed);
        let [length, width] = [court.length_m, court.width_m].map(f64::from);
        let home = [length * 0.35, width * (0.25 + 0.5 * unit(&mut rng))];
        Self {
            court,
            home,
            position: home,
            velocity: [0.0; 2],
            target: home,
            reacts_s: None,
            plan: None,
            person: None,
            turn: false,
            rng,
        }
    }

    /// Where the hand is and how it moves.
    fn racket(&self) -> Ball {
        Ball { position: self.position.map(|m| m as f32), velocity: self.velocity.map(|v| v as f32) }
    }

    /// It has seen that it is its turn.
    fn sees_its_turn(&mut self, now_s: f64) {
        let reaction = REACTION_S.0 + REACTION_S.1 * normal(&mut self.rng);
        self.reacts_s = Some(now_s + reaction.max(0.1));
        self.plan = None;
        self.turn = true;
    }

    /// It is not its turn any more.
    fn rests(&mut self) {
        self.reacts_s = None;
        self.plan = None;
        self.turn = false;
        self.target = self.home;
    }

    /// One tick: where it thinks that the ball is (`None` before the serve), and the damping on its hand. Gives the racket if it
    /// swings and does not miss.
    fn tick(&mut self, now_s: f64, tick_s: f64, ball: Option<Ball>, damping: f64) -> Option<Racket> {
        if let Some(wanted) = self.person {
            self.target = wanted;
            self.moves(tick_s, damping);
            return self.swings(ball, damping);
        }
        self.moves(tick_s, damping);
        if self.reacts_s.is_some_and(|at_s| now_s >= at_s) {
            self.reacts_s = None;
            self.plan = Some(self.plans(now_s, ball));
        }
        let plan = self.plan.filter(|plan| now_s >= plan.at_s)?;
        self.plan = None;
        self.target = self.home;
        let before = match ball {
            None => [0.0; 2],
            Some(ball) => {
                let [x, y] = [0, 1].map(|axis| f64::from(ball.position[axis]) - self.position[axis]);
                if x.hypot(y) > RACKET_REACH_M {
                    return None;
                }
                ball.velocity.map(f64::from)
            }
        };
        self.meets_it(before, plan.speed, plan.angle, damping)
    }

    /// A person's racket hits what it meets on its turn: as hard and as far aside as the hand moves, within what a bot's strokes
    /// have; a serve needs a hand that moves forward.
    fn swings(&mut self, ball: Option<Ball>, damping: f64) -> Option<Racket> {
        let [vx, vy] = self.velocity;
        let before = match ball {
            None => (vx > SERVE_M_PER_S).then_some([0.0; 2])?,
            Some(ball) => {
                let [x, y] = [0, 1].map(|axis| f64::from(ball.position[axis]) - self.position[axis]);
                let before = ball.velocity.map(f64::from);
                (before[0] < 0.0 && x.hypot(y) < RACKET_REACH_M).then_some(before)?
            }
        };
        if !std::mem::take(&mut self.turn) {
            return None;
        }
        let speed = (STROKES.0 + vx.hypot(vy)).min(STROKES.1);
        self.meets_it(before, speed, libm::atan2(vy, vx.abs().max(1.0)).clamp(-0.6, 0.6), damping)
    }

    /// The racket that gives a ball of velocity `before` (m/s) this speed, m/s, and angle, rad from straight ahead.
    fn meets_it(&self, before: [f64; 2], speed: f64, angle: f64, damping: f64) -> Option<Racket> {
        let wish = [speed * angle.cos(), speed * angle.sin()];
        let change = [wish[0] - before[0], wish[1] - before[1]];
        let size = change[0].hypot(change[1]);
        let normal = change.map(|part| part / size);
        // What an elastic impact needs, as far as the damped arm can move it.
        let masses = f64::from((RACKET_KG + BALL_KG) / (2.0 * RACKET_KG));
        let along = before[0] * normal[0] + before[1] * normal[1] + size * masses;
        let along = if damping > 0.0 { along.min(f64::from(MOTION.force_n) / damping) } else { along };
        Some(Racket {
            mass_kg: RACKET_KG,
            velocity: normal.map(|part| (part * along) as f32),
            normal: normal.map(|part| part as f32),
        })
    }

    fn moves(&mut self, tick_s: f64, damping: f64) {
        let pull = [0, 1].map(|axis| {
            HAND_KG
                * ARM_RAD_PER_S
                * (ARM_RAD_PER_S * (self.target[axis] - self.position[axis]) - 2.0 * self.velocity[axis])
        });
        let size = pull[0].hypot(pull[1]);
        let share = (f64::from(MOTION.force_n) / size.max(1e-9)).min(1.0);
        for (axis, pull) in pull.into_iter().enumerate() {
            // The damper implicitly: it can be stiff, and a damper never turns anything round.
            let pushed = self.velocity[axis] + tick_s / HAND_KG * share * pull;
            self.velocity[axis] = pushed / (1.0 + tick_s * damping / HAND_KG);
            self.position[axis] += tick_s * self.velocity[axis];
        }
    }

    /// Where and when to meet the ball, and how to hit it.
    fn plans(&mut self, now_s: f64, ball: Option<Ball>) -> Plan {
        let (in_s, there) = ball.map_or((SERVES_AFTER_S, self.home), |ball| self.meets(&ball));
        let front = there[0] > FRONT * f64::from(self.court.length_m);
        let smash = self.rng.chance(if front { SMASH.0 } else { SMASH.1 });
        let (least, most) = if smash { SMASHES } else { STROKES };
        let (speed, angle) = (between(&mut self.rng, least, most), between(&mut self.rng, -0.6, 0.6));
        self.target = there.map(|m| m + ROUGH.0 * normal(&mut self.rng));
        Plan { at_s: now_s + in_s + ROUGH.1 * normal(&mut self.rng), speed, angle }
    }

    /// Somewhere on the ball's way back from the front wall where the hand can be in time: rather sooner, far in front,
    /// than later; where there is no such place, the last one.
    fn meets(&mut self, ball: &Ball) -> (f64, [f64; 2]) {
        let leaves_s = f64::from(self.court.leaves_s(ball));
        let moments = (1..).map(|n| f64::from(n) * MOMENT_S).take_while(|in_s| *in_s < leaves_s.min(4.0));
        let coming =
            moments.map(|in_s| (in_s, self.court.flight(ball, in_s as f32))).filter(|(_, ball)| ball.velocity[0] < 0.0);
        let places: Vec<_> = coming.map(|(in_s, ball)| (in_s, ball.position.map(f64::from))).collect();
        let can = |(in_s, place): &(f64, [f64; 2])| {
            let far = (place[0] - self.position[0]).hypot(place[1] - self.position[1]);
            // What is left of the way to a critically damped arm.
            let turned = ARM_RAD_PER_S * in_s;
            far * (1.0 + turned) * libm::exp(-turned) < NEAR_M
        };
        let can: Vec<_> = places.iter().copied().filter(can).collect();
        let last = places.last().copied().unwrap_or((0.0, self.position));
        let pick = unit(&mut self.rng) * unit(&mut self.rng);
        can.get((pick * can.len() as f64) as usize).copied().unwrap_or(last)
    }
}

/// Who takes part in a game.
pub enum Participant {
    /// The server's role, which keeps the score.
    Server(Box<Server>),
    /// A player's role and the bot that plays it.
    Player(Box<Contestant>),
}

impl Participant {
    /// The game as this part knows it.
    pub fn game(&self) -> &Game {
        match self {
            Self::Server(server) => server.game(),
            Self::Player(contestant) => contestant.player.game(),
        }
    }

    /// Gives its role a message of `from` that came at `now`, µs on its own clock; what it says to that goes to `out`.
    pub fn receive(&mut self, now: u64, from: PeerId, message: &Message, out: &mut dyn Out<Message>) {
        match self {
            Self::Server(server) => server.receive(now, from, message, out),
            Self::Player(contestant) => contestant.player.receive(now, from, message, out),
        }
    }
}

/// One contestant. Times are its own clock's, µs.
pub struct Contestant {
    /// Number of the player, 1 or more.
    pub(super) number: PeerId,
    /// Its role as a player in the game.
    pub player: Player,
    pub(super) bot: Bot,
    was_active: bool,
}

impl Contestant {
    /// `life` is another one at each start, `seed` is the bot's.
    pub fn new(number: PeerId, life: u16, seed: u64) -> Self {
        let court = Court::SINGLES;
        let player = Player::new(PlayerConfig { number, court, ball_kg: BALL_KG, life });
        Self { number, player, bot: Bot::new(court, seed), was_active: false }
    }

    /// A person has its hand from now on and wants it there, in the court; or nobody has, and the bot plays.
    pub fn held(&mut self, person: Option<[f64; 2]>) {
        self.bot.person = person;
    }

    /// Where its hand is, in the court.
    pub fn hand(&self) -> [f64; 2] {
        self.bot.position
    }

    /// Hands the bot, and `each`, what has happened.
    pub fn hears(&mut self, now: u64, mut each: impl FnMut(&Player, Notice)) {
        while let Some(notice) = self.player.take_notice() {
            self.was_active &= match notice {
                Notice::Begins(_) => false,
                Notice::Hit { turn, .. } => self.player.game().active(turn.stroke) != Some(self.number),
                Notice::Ends { .. } => true,
            };
            each(&self.player, notice);
        }
        match (self.player.is_active(), self.was_active) {
            (true, false) => self.bot.sees_its_turn(now as f64 * 1e-6),
            (false, true) => self.bot.rests(),
            _ => {}
        }
        self.was_active = self.player.is_active();
    }

    /// One tick of hand and role, the hand `damped` by the round trip or not; the hit, if it makes one.
    pub fn tick(&mut self, now: u64, damped: bool, out: &mut dyn Out<Message>) -> Option<Strike> {
        let damping = if damped { MOTION.damping_n_s_per_m(self.player.round_trip_us()) } else { 0.0 };
        let racket = self.bot.tick(now as f64 * 1e-6, TICK_S, self.player.ball(now), f64::from(damping));
        self.player.place(self.bot.racket());
        let strike = racket.and_then(|racket| self.player.hit(now, &racket, out));
        self.player.poll(now, out);
        strike
    }
}

fn unit(rng: &mut Rng) -> f64 {
    rng.below(1 << 53) as f64 * (-53.0_f64).exp2()
}

fn between(rng: &mut Rng, least: f64, most: f64) -> f64 {
    least + (most - least) * unit(rng)
}

/// Standard normal, by Box and Muller.
fn normal(rng: &mut Rng) -> f64 {
    let radius = (-2.0 * libm::log(1.0 - unit(rng))).sqrt();
    radius * libm::cos(core::f64::consts::TAU * unit(rng))
}
