//! Energy tank: the energy that a law may still spend, of its start value and what the other peer has sent.
//!
//! A law with a tank pays for whatever it gives to the copy, to the tick: the work of its force at the copy's mean velocity and
//! what its spring gains. Energy goes to the other peer as the `energy_j` of the packets, a sum since arming, so that a packet that
//! is lost, late, repeated or overtaken costs nothing and brings nothing twice: what came out of both tanks is never more than
//! what was in them when they began and what was put in since, whatever the network does. No clock is needed.
//!
//! That is exact only for a force that is solved for with the copy's motion: `object.integrator = "midpoint"`.

use cohold_core::law::Packet;
use cohold_core::law::credit::CAP_J;
use cohold_core::num::Scalar;
use cohold_core::settings::{Key, PLENTY_J, Refused, Settings};

/// Energy in a tank when its law begins, J; two peers can give out at most twice this beyond what was put in.
pub const START: Key = Key::number("coordination.tank_j", 0.02, [0.0, PLENTY_J], "J")
    .means("Laws with an energy tank: what is in it when they begin.");

/// Energy in the tank of a law that sends waves when it begins, J: by this much the energy that it emits may exceed the
/// energy of the waves that it has received.
pub const WAVE_START: Key = Key::number("coordination.wave_tank_j", 0.0, [0.0, PLENTY_J], "J")
    .means("Wave laws with an energy tank: energy that may be emitted beyond what was heard.");

/// Gains of laws that solve for their force with the copy's motion.
pub(super) const MIDPOINT: &[&str] = &[
    "coordination.stiffness_n_per_m=1590",
    "coordination.decode=implicit",
    "object.integrator=midpoint",
    "object.force_delay_ticks=0",
];

/// What a tank begins with and may hold.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tanks<C> {
    start_j: C,
    most_j: C,
    /// Control period T_c, s.
    pub(super) period_s: C,
    pub(super) half: C,
}

configured!([C: Scalar] Tanks<C> { start_j, most_j, period_s, half });

/// The energy that a law may spend.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Tank<C> {
    /// Energy in the tank, J; never negative.
    pub(super) level_j: C,
    /// The other peer's sum in the newest packet, J.
    heard_j: Option<C>,
    /// What came since the tick before, J.
    fresh_j: C,
}

/// Refuses every order but those in which a force works with the way of the same tick.
pub(super) fn needs_midpoint(settings: &Settings) -> Result<(), Refused<'static>> {
    cohold_core::law::needs_midpoint(
        settings,
        "\"midpoint\" or \"backward-euler\" where coordination.comm is a law that pays for its energy",
    )
}

impl<C: Scalar> Tanks<C> {
    /// `start` says what is in a tank at first.
    pub(super) fn build(settings: &Settings, start: &Key) -> Result<Self, Refused<'static>> {
        needs_midpoint(settings)?;
        let start_j = settings.own(start);
        Ok(Self {
            start_j: C::from_f64(start_j),
            most_j: C::from_f64(start_j.max(CAP_J)),
            period_s: C::from_f64(settings.timing.control_period_s),
            half: C::from_f64(0.5),
        })
    }

    pub(super) fn start(&self) -> Tank<C> {
        Tank { level_j: self.start_j, ..Tank::default() }
    }

    /// After a silence: what is there is there, and what the other peer sent meanwhile is forgotten.
    pub(super) fn restart(&self, tank: &Tank<C>) -> Tank<C> {
        Tank { level_j: tank.level_j, ..Tank::default() }
    }

    /// Puts in what has come since the tick before, and gives the power that it was, W. What does not fit is lost.
    #[inline]
    pub(super) fn fill(&self, tank: &mut Tank<C>) -> C {
        let fresh = core::mem::take(&mut tank.fresh_j);
        tank.put(fresh, self.most_j);
        fresh.over(self.period_s)
    }

    /// No less is in it than at the start.
    #[inline]
    pub(super) fn is_full(&self, tank: &Tank<C>) -> bool {
        tank.level_j >= self.start_j
    }

    /// Puts in what is known a tick later, or takes it out, J.
    #[inline]
    pub(super) fn settle(&self, tank: &mut Tank<C>, energy_j: C) {
        tank.put(energy_j, self.most_j);
    }

    /// The stretch nearest to `wanted` that a spring (N/m) which is stretched by `before` (m) can be brought to with what is in the tank;
    /// pays for it, or takes in what the spring lets go of. Also gives what it cost, J.
    #[inline]
    pub(super) fn stretch(&self, tank: &mut Tank<C>, stiffness: C, before: C, wanted: C) -> (C, C) {
        // Without stiffness there is no energy, and no most.
        let after = if stiffness > C::ZERO {
            let twice = tank.level_j + tank.level_j;
            wanted.limit((before * before + twice.over(stiffness)).sqrt())
        } else {
            wanted
        };
        let cost = self.half * stiffness * (after - before) * (after + before);
        tank.level_j = (tank.level_j - cost).max(C::ZERO);
        (after, cost)
    }

    /// The wave nearest to `wanted` (√W) whose tick, ½·T_c·u², can be paid for; pays for it.
    #[inline]
    pub(super) fn emit<S: Scalar<Counter = C>>(&self, tank: &mut Tank<C>, wanted: S) -> S {
        let price = self.half * self.period_s;
        let most = tank.level_j.over(price).sqrt();
        let emitted = S::of_counter(wanted.to_counter().limit(most));
        let wave = emitted.to_counter();
        tank.level_j = (tank.level_j - price * wave * wave).max(C::ZERO);
        emitted
    }
}

impl<C: Scalar> Tank<C> {
    /// Takes in the sum of a packet; the first brings no past.
    pub(super) fn receive<S: Scalar<Counter = C>>(&mut self, packet: &Packet<S>) {
        let sum = packet.energy_j;
        let before = *self.heard_j.get_or_insert(sum);
        if sum > before {
            self.heard_j = Some(sum);
            self.fresh_j = self.fresh_j + (sum - before);
        }
    }

    #[inline]
    fn put(&mut self, energy_j: C, most_j: C) {
        // Below nothing is rounding.
        self.level_j = (self.level_j + energy_j).min(most_j).max(C::ZERO);
    }
}
