//! A contestant: a player's role and the bot that plays it, simulated or live.

use haptic_protocol::roles::squash::{Court, Message, Notice, Player, PlayerConfig, Strike};
use haptic_protocol::roles::{Out, Role as _};
use haptic_protocol::wire::PeerId;

use super::bot::{Action, BALL_KG, Bot, MOTION};

/// Control period, s.
pub const TICK_S: f64 = 0.001;

/// One contestant. Times are its own clock's, µs.
#[derive(Clone, Debug)]
pub struct Contestant {
    number: PeerId,
    /// The role.
    pub player: Player,
    /// Who plays it.
    pub bot: Bot,
    was_active: bool,
}

impl Contestant {
    /// Number `number`, 1 or more; `life` is another one at each start, `seed` is the bot's.
    pub fn new(number: PeerId, life: u16, seed: u64) -> Self {
        let court = Court::SINGLES;
        let player = Player::new(PlayerConfig { number, court, ball_kg: BALL_KG, life });
        Self { number, player, bot: Bot::new(court, seed), was_active: false }
    }

    /// Which player.
    pub fn number(&self) -> PeerId {
        self.number
    }

    /// The bot is told what has happened, and so is `each`.
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
        let action = self.bot.tick(now as f64 * 1e-6, TICK_S, self.player.ball(now), f64::from(damping));
        self.player.place(self.bot.racket());
        let strike = match action {
            Action::Swings(racket) => self.player.hit(now, &racket, out),
            Action::Waits | Action::Misses => None,
        };
        self.player.poll(now, out);
        strike
    }
}
