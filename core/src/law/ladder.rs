//! What silence does: hold, fade, disengage; and what the end of silence does: the same steps back.
//!
//! Counted in packet periods without a packet: up to `safety.fade_packets` the last packet stands; then the coordination
//! fades, one step a period, until at `safety.disengage_packets` it is gone and the peer renders alone. The first packet
//! after that starts the law anew where the object is, from no force, and every packet takes one step back. A faded
//! packet is a wave made smaller (which takes energy out of the line, never in) and a remote motion moved toward the
//! local one.
//!
//! Silence is all this ladder knows. Who does know that the other peer is gone, or another one (a link whose session
//! ended), takes the last step at once ([`crate::peer::State::part`]): what comes next is counted from zero by a peer that
//! started anew, and must not be measured by the old one's counters.

use super::Packet;
use crate::num::{Motion, Scalar};
use crate::settings::{Allowed, Refused, Settings, Value};

/// How long each rung is.
#[derive(Clone, Copy, Debug)]
pub struct Ladder<S> {
    /// Periods of silence that change nothing.
    hold: u32,
    /// Steps from engaged to disengaged.
    steps: u32,
    /// One step.
    step: S,
}

/// Where a peer stands on the ladder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Engagement {
    /// Steps above disengaged.
    level: u32,
    /// Packet periods without a packet, since the last one.
    silent: u32,
    /// A packet has come since the peer was armed: before that there is no silence.
    heard: bool,
}

impl<S: Scalar> Ladder<S> {
    /// The scene's ladder.
    pub fn build(settings: &Settings) -> Self {
        let safety = &settings.safety;
        let steps = safety.disengage_packets - safety.fade_packets;
        Self { hold: safety.fade_packets, steps, step: S::from_f64(1.0 / f64::from(steps)) }
    }

    /// Refuses a ladder whose rungs are out of order.
    pub fn check(settings: &Settings) -> Result<(), Refused<'static>> {
        let safety = &settings.safety;
        if safety.disengage_packets > safety.fade_packets {
            return Ok(());
        }
        Err(Refused {
            key: "safety.disengage_packets",
            value: Value::Number(f64::from(safety.disengage_packets)),
            allowed: Allowed::Whole { min: safety.fade_packets.saturating_add(1), max: 100_000 },
            unit: "packets",
        })
    }

    /// Fully engaged, nothing heard yet.
    pub fn engaged(&self) -> Engagement {
        Engagement { level: self.steps, silent: 0, heard: false }
    }

    /// One packet period with or without a packet; true if the law has to start anew.
    pub fn step(&self, at: &mut Engagement, arrived: bool) -> bool {
        if arrived {
            let anew = at.level == 0;
            *at = Engagement { level: at.level.saturating_add(1).min(self.steps), silent: 0, heard: true };
            return anew;
        }
        if at.heard {
            at.silent = at.silent.saturating_add(1);
            if at.silent > self.hold {
                at.level = at.level.saturating_sub(1);
            }
        }
        false
    }

    /// How far the coordination may act, from 0, disengaged, to exactly 1, engaged.
    pub fn share(&self, at: &Engagement) -> S {
        if at.level >= self.steps { S::ONE } else { S::from_f64(f64::from(at.level)) * self.step }
    }

    /// The packet as far as the peer is engaged.
    pub fn faded(&self, at: &Engagement, packet: Packet<S>, local: Motion<S>) -> Packet<S> {
        if at.level >= self.steps {
            return packet;
        }
        let share = self.share(at);
        let toward = |local: S, remote: S| local + share * (remote - local);
        Packet {
            motion: Motion {
                position: toward(local.position, packet.motion.position),
                velocity: toward(local.velocity, packet.motion.velocity),
            },
            wave: share * packet.wave,
            ..packet
        }
    }
}

impl Engagement {
    /// Disengages at once. Silence goes on being counted.
    pub fn part(&mut self) {
        self.level = 0;
    }

    /// The coordination acts at all.
    #[inline]
    pub fn is_engaged(&self) -> bool {
        self.level > 0
    }

    /// Silence has begun to change what stands.
    pub fn is_fading(&self) -> bool {
        self.silent > 0 && self.level > 0
    }

    /// Packet periods of silence.
    pub fn silent(&self) -> u32 {
        self.silent
    }
}
