//! What is promised of one end, checked from what is seen of it and of the end that it talks to.

use cohold_live::node::Line;
use cohold_live::recording::common_clock::Watched;
use cohold_sim::scene::Scene;

use super::Planted;

/// A clock that began anywhere and runs a little fast or slow.
#[derive(Clone, Copy, Debug)]
pub(super) struct Clock {
    pub(super) from_us: u64,
    pub(super) fast_ppm: i64,
}

impl Clock {
    /// What it shows at a true time, µs.
    pub(super) fn us(&self, true_ms: u64) -> u64 {
        self.from_us + true_ms * 1_000_000_u64.strict_add_signed(self.fast_ppm) / 1_000
    }
}

/// How old what is heeded may be, and how long silence is borne, ms.
pub(super) struct Limits {
    /// Flow that is taken: twice the longest delay one way.
    pub(super) age_ms: u64,
    /// From the last flow that was taken until nothing of it acts.
    pub(super) silence_ms: u64,
}

/// Delay one way beyond which flow is not taken, s: `safety.max_delay_s` as it is by default, whatever a planted scene says.
const MAX_DELAY_S: f64 = 0.25;

impl Limits {
    pub(super) fn of(scene: &Scene) -> Self {
        let ms = |seconds: f64| (1e3 * seconds).ceil() as u64;
        let packet_s = scene.peer.timing.packet_period_s();
        // Steps are of whole packet periods, and so are looks at what came. A link bears silence for 96 ms at the least.
        let silence_s = scene.peer.safety.disengage_s.max(0.096) + 2.0 * packet_s;
        Self { age_ms: ms(2.0 * MAX_DELAY_S), silence_ms: ms(silence_s) + 2 }
    }
}

/// What an end is and does in this millisecond.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    /// Its coordination acts.
    pub(super) engaged: bool,
    /// And it does so in full.
    pub(super) whole: bool,
    /// Its flow says that its motors are on.
    pub(super) says: bool,
    /// Its hand moves, or has moved.
    pub(super) moves: bool,
}

/// When an end was last what others rely on, ms.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Said {
    engaged_ms: Option<u64>,
    pub(super) live_ms: Option<u64>,
    pub(super) halted_ms: Option<u64>,
}

pub(super) struct End {
    /// Which clock is its own, and which end it talks to.
    pub(super) clock: usize,
    pub(super) partner: usize,
    pub(super) said: Said,
    was_engaged: bool,
    was_moving: bool,
    /// Its coordination was complete and has acted ever since.
    live: bool,
    /// The other end's clock, as a live program watches it.
    watched: Watched,
    lives: u64,
    /// The oldest yes that it engaged by, and for how long it was engaged after the other end's motors went off, ms.
    pub(super) oldest_ms: u64,
    pub(super) engaged_after_ms: u64,
    /// The largest share of a stated error that was used up, and the largest stated error, s.
    pub(super) share: f64,
    pub(super) stated_s: f64,
}

impl End {
    pub(super) fn new(clock: usize, partner: usize) -> Self {
        Self {
            clock,
            partner,
            said: Said::default(),
            was_engaged: false,
            was_moving: false,
            live: false,
            watched: Watched::default(),
            lives: 0,
            oldest_ms: 0,
            engaged_after_ms: 0,
            share: 0.0,
            stated_s: 0.0,
        }
    }

    /// Whether its coordination acts.
    pub(super) fn is_engaged(&self) -> bool {
        self.was_engaged
    }

    /// Notes what others may rely on.
    pub(super) fn see(&mut self, now_ms: u64, seen: Seen) {
        self.live = seen.engaged && (self.live || seen.whole);
        self.said.live_ms = if self.live { Some(now_ms) } else { self.said.live_ms };
        self.said.engaged_ms = if seen.says { Some(now_ms) } else { self.said.engaged_ms };
    }

    /// It engages only by what the other end said not long ago, and lets go in time of one whose motors are off.
    pub(super) fn consents(&mut self, now_ms: u64, seen: Seen, other: Said, limits: &Limits) -> Result<(), String> {
        let was_engaged = std::mem::replace(&mut self.was_engaged, seen.engaged);
        if seen.engaged && !was_engaged {
            let age_ms = now_ms - other.engaged_ms.ok_or("engaged, and the other end never said so")?;
            self.oldest_ms = self.oldest_ms.max(age_ms);
            if age_ms > limits.age_ms {
                return Err(format!("engages {age_ms} ms after the other end said that it is engaged"));
            }
        }
        if let Some(halted_ms) = other.halted_ms.filter(|_| seen.engaged) {
            self.engaged_after_ms = now_ms - halted_ms;
            if self.engaged_after_ms > limits.age_ms + limits.silence_ms {
                return Err(format!("engaged {} ms after the other end's motors went off", self.engaged_after_ms));
            }
        }
        Ok(())
    }

    /// Its hand begins only when it is live, the other end was as far as it can know, and all ends have been.
    pub(super) fn begins(
        &mut self,
        now_ms: u64,
        seen: Seen,
        other: Said,
        others: bool,
        limits: &Limits,
    ) -> Result<(), String> {
        let was_moving = std::mem::replace(&mut self.was_moving, seen.moves);
        if was_moving || !seen.moves {
            return Ok(());
        }
        let age_ms = other.live_ms.map(|live_ms| now_ms - live_ms);
        match age_ms {
            _ if !self.live => Err("moves, and is not live".to_owned()),
            None => Err("moves, and the other end was never live".to_owned()),
            Some(age_ms) if age_ms > limits.age_ms + limits.silence_ms => {
                Err(format!("moves {age_ms} ms after the other end was live"))
            }
            Some(_) if !others => Err("moves, and not all ends were live".to_owned()),
            Some(_) => Ok(()),
        }
    }

    /// Its own and the other end's clock show this, µs: what it says of them is true.
    pub(super) fn knows_the_clock(
        &mut self,
        line: &Line,
        [own, other]: [u64; 2],
        planted: Planted,
    ) -> Result<(), String> {
        if std::mem::replace(&mut self.lives, line.lives) != line.lives {
            self.watched.forget();
        }
        if self.watched.see(line.link.clock().newest()).is_some() {
            self.watched.look();
            if self.watched.relation.is_none() {
                return Err("two quartzes are taken for no clocks".to_owned());
            }
        }
        let Some(relation) = &self.watched.relation else { return Ok(()) };
        let own_s = 1e-6 * own as f64;
        let stated_s = match planted {
            // And what two clocks that show whole microseconds leave.
            Planted::HalfTheRoundTrip => 0.5 * relation.round_trip_s + 10e-6,
            _ => relation.error_s(own_s),
        };
        let wrong_s = (relation.offset_s(own_s) - 1e-6 * (other as f64 - own as f64)).abs();
        self.share = self.share.max(wrong_s / stated_s);
        self.stated_s = self.stated_s.max(stated_s);
        if wrong_s <= stated_s { Ok(()) } else { Err(format!("offset wrong by {wrong_s} s, {stated_s} s stated")) }
    }
}
