//! Between the coordination and the wire (feature `peer`): packets of cohold-core and flow, the settings that two peers must share,
//! and what waits for the next exchange. The same for a board and a PC.

use cohold_core::law::bounds::{Bounds, Sums};
use cohold_core::law::{Packet, event::LONGEST};
use cohold_core::num::{Motion, Scalar};
use cohold_core::playout::Playout;
use cohold_core::settings::{Settings, Value};

use crate::link::{Config, ConfigError, Link};
use crate::{ends::Ends, error::Refusal, key::Key, parameters::Parameters, wire::AxisFlow, wire::Flows, wire::Message};

/// The settings that both peers must share, as a greeting carries them.
pub fn parameters_of(settings: &Settings) -> Parameters {
    Parameters::of(settings.common(), |table, key, value| match value {
        Value::Number(number) => table.number(key, number),
        Value::Flag(flag) => table.flag(key, flag),
        Value::Text(text) => table.text(key, text),
    })
    // There is room for all of it; tests see to that.
    .unwrap_or_default()
}

/// A link to the other peer that begins to call, as these settings want it: how often flow is sent, which settings both must share,
/// and for how long silence and delay are borne.
///
/// # Errors
/// [`Link::new`]'s.
pub fn open(settings: &Settings, key: Key, ends: Ends, entropy: [u8; Key::LEN]) -> Result<Link, ConfigError> {
    let (timing, safety) = (&settings.timing, &settings.safety);
    let packet_period_us = u32::try_from(timing.packet_period_ns() / 1_000).unwrap_or(u32::MAX);
    let config = Config { key, ends, packet_period_us, parameters: parameters_of(settings), entropy };
    // Casts saturate.
    let us = |seconds: f64| (1e6 * seconds) as u32;
    let link = Link::new(config)?.disengage_after(us(safety.disengage_s)).within(safety.max_delay_us());
    Ok(link.keeping_silent(us(settings.own(&LONGEST))))
}

/// The nearest f32. From f32 nothing is lost, and nothing is done.
#[inline(always)]
pub(crate) fn wire<S: Scalar>(value: S) -> f32 {
    value.to_f64() as f32
}

/// What an exchange gave at tick `tick`, a packet for each shared axis, as it goes out; `engaged` while the motors are on.
pub fn flow_of<S: Scalar, const AXES: usize>(packets: [Packet<S>; AXES], engaged: bool, tick: u32) -> Flows<AXES> {
    let axes = packets.map(|packet| AxisFlow {
        position: wire(packet.motion.position),
        velocity: wire(packet.motion.velocity),
        wave: wire(packet.wave),
        wave_integral: packet.wave_integral.to_f64(),
        live_ticks: packet.live_ticks,
        energy_sent: packet.energy_j.to_f64(),
    });
    Flows { engaged, fading: false, tick, axes }
}

/// The packets in a flow.
pub fn packets_of<S: Scalar, const AXES: usize>(flow: &Flows<AXES>) -> [Packet<S>; AXES] {
    let core = |value: f32| S::from_f64(value.into());
    flow.axes.map(|along| Packet {
        motion: Motion::new(core(along.position), core(along.velocity)),
        wave: core(along.wave),
        energy_j: S::Counter::from_f64(along.energy_sent),
        wave_integral: S::Counter::from_f64(along.wave_integral),
        live_ticks: along.live_ticks,
    })
}

/// The flow in a message, if it is of so many shared axes.
pub fn flow_in<const AXES: usize>(message: &Message) -> Option<Flows<AXES>> {
    match message {
        Message::Flow(flow) if AXES == 1 => Some(flow.along()),
        Message::Flow2(flow) if AXES == 2 => Some(flow.along()),
        Message::Flow3(flow) if AXES == 3 => Some(flow.along()),
        _ => None,
    }
}

/// Decides, when a flow comes, whether it can be, and which life of the other end it is of. A life is over when the link lets go of
/// the other end ([`crate::link::Notice::Disengaged`]), when motors that were off are on again, for then the other end counts from zero,
/// from another place, and with whatever cannot be ([`Bounds`]). Nothing of one life goes with anything of the next.
#[derive(Clone, Copy, Debug)]
pub struct Lives<const AXES: usize = 1> {
    bounds: Bounds,
    /// Of the newest flow of this life.
    sums: [Option<Sums>; AXES],
    /// Lives that are over; wraps.
    life: u32,
    /// The other end's motors have gone off since its last flow that counted.
    off: bool,
}

impl<const AXES: usize> Lives<AXES> {
    /// Of an end that may say so much.
    pub fn new(bounds: Bounds) -> Self {
        Self { bounds, sums: [None; AXES], life: 0, off: false }
    }

    /// Number of the life that a flow is of which has just come; 0 is the first. None if the flow does not count, because its
    /// sender's motors are off.
    ///
    /// # Errors
    /// [`Refusal::Impossible`]: a number in it that cannot be. The life is over with it.
    #[inline]
    pub fn of(&mut self, flow: &Flows<AXES>) -> Result<Option<u32>, Refusal> {
        let was_off = core::mem::replace(&mut self.off, !flow.engaged);
        if !flow.engaged {
            return Ok(None);
        }
        if was_off {
            self.end();
        }
        for (sums, packet) in self.sums.iter_mut().zip(&packets_of::<f64, AXES>(flow)) {
            if let Err(what) = self.bounds.take(sums, packet) {
                self.end();
                return Err(Refusal::Impossible(what));
            }
        }
        Ok(Some(self.life))
    }

    /// The other end has gone: what comes next is of another life. Gives that one's number.
    #[inline]
    pub fn end(&mut self) -> u32 {
        self.sums = [None; AXES];
        self.life = self.life.wrapping_add(1);
        self.life
    }

    /// From now on the other end may say so much.
    pub fn bound(&mut self, bounds: Bounds) {
        self.bounds = bounds;
    }
}

/// Flow of the other end that no exchange has taken yet: the newest, or, with play-out, what is due.
#[derive(Clone, Debug)]
pub struct Inbox<const AXES: usize = 1> {
    lives: Lives<AXES>,
    /// What the next exchange takes, and the life that it is of, if it counts.
    newest: Option<(Flows<AXES>, Option<u32>)>,
    /// The life that the next exchange is in.
    life: u32,
    /// The life that the last one was in.
    taken: u32,
    playout: Option<Playout<(Flows<AXES>, Option<u32>)>>,
}

impl<const AXES: usize> Inbox<AXES> {
    /// Nothing there; flow of an end that may say so much waits for `playout_packets` packet periods of so many control periods each, 0:
    /// for nothing.
    pub fn new(bounds: Bounds, playout_packets: u32, ticks_per_packet: u32) -> Self {
        let playout = (playout_packets > 0).then(|| Playout::new(playout_packets, ticks_per_packet));
        Self { lives: Lives::new(bounds), newest: None, life: 0, taken: 0, playout }
    }

    /// From now on the other end may say so much.
    pub fn bound(&mut self, bounds: Bounds) {
        self.lives.bound(bounds);
    }

    /// Takes a flow that came in this control period.
    ///
    /// # Errors
    /// [`Refusal::Impossible`]: a number in it that cannot be. The other end is then let go of, as if it had gone.
    pub fn put(&mut self, tick: u32, flow: Flows<AXES>) -> Result<(), Refusal> {
        let life = self.lives.of(&flow).inspect_err(|_| self.clear())?;
        let came = (flow, life);
        match &mut self.playout {
            Some(playout) => {
                playout.put(tick, flow.tick, came);
            }
            None => self.show(Some(came)),
        }
        Ok(())
    }

    /// Forgets what was there: the other end has gone.
    pub fn clear(&mut self) {
        self.newest = None;
        self.life = self.lives.end();
        self.playout.iter_mut().for_each(Playout::clear);
    }

    /// Brings out what the next exchange takes, in its control period.
    pub fn play(&mut self, tick: u32) {
        if let Some(due) = self.playout.as_mut().map(|playout| playout.take(tick)) {
            self.show(due);
        }
    }

    /// This is what the next exchange takes; the life of a flow that counts is the one that it is in.
    fn show(&mut self, newest: Option<(Flows<AXES>, Option<u32>)>) {
        self.newest = newest;
        self.life = newest.and_then(|(_, life)| life).unwrap_or(self.life);
    }

    /// What the next exchange takes.
    pub fn newest(&self) -> Option<&Flows<AXES>> {
        self.newest.as_ref().map(|(flow, _)| flow)
    }

    /// What an exchange takes in, and whether it has to let go of the other end first, whose life is another than at the last
    /// exchange: nothing that came before goes with what comes now.
    pub fn take(&mut self) -> (Option<Flows<AXES>>, bool) {
        let parted = core::mem::replace(&mut self.taken, self.life) != self.life;
        let flow = self.newest.take().and_then(|(flow, life)| life.map(|_| flow));
        (flow, parted)
    }
}
