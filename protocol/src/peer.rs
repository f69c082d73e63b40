//! Between the coordination and the wire (feature `peer`): packets of haptic-core and flow, the settings that two peers must share,
//! and what waits for the next exchange. The same for a board and a PC.

use haptic_core::law::{Packet, event::LONGEST};
use haptic_core::num::{Motion, Scalar};
use haptic_core::settings::{Settings, Value};

use crate::link::{Config, ConfigError, Link};
use crate::{ends::Ends, key::Key, parameters::Parameters, playout::Playout, wire::Along, wire::Flows, wire::Message};

/// The settings that both peers must share, as a greeting carries them.
pub fn parameters_of(settings: &Settings) -> Parameters {
    Parameters::of(settings.shared(), |table, key, value| match value {
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
    let link = Link::new(config)?.apart_after(us(safety.disengage_s)).within(us(safety.max_delay_s));
    Ok(link.keeping_silent(us(settings.own(&LONGEST))))
}

/// What an exchange gave at tick `tick`, a packet for each shared axis, as it goes out; `engaged` while the motors are on.
pub fn flow_of<S: Scalar, const AXES: usize>(packets: [Packet<S>; AXES], engaged: bool, tick: u32) -> Flows<AXES> {
    // From f32 and back to it nothing is lost.
    let wire = |value: S| value.to_f64() as f32;
    let axes = packets.map(|packet| Along {
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
        motion: Motion { position: core(along.position), velocity: core(along.velocity) },
        wave: core(along.wave),
        energy_j: S::Counter::from_f64(along.energy_sent),
        wave_integral: S::Counter::from_f64(along.wave_integral),
        live_ticks: along.live_ticks,
    })
}

/// The flow in a message, if it is of so many shared axes.
pub fn flow_in<const AXES: usize>(message: &Message) -> Option<Flows<AXES>> {
    fn of<const CAME: usize, const AXES: usize>(flow: &Flows<CAME>) -> Option<Flows<AXES>> {
        let Flows { engaged, fading, tick, axes } = flow;
        axes.as_slice().try_into().ok().map(|axes| Flows { engaged: *engaged, fading: *fading, tick: *tick, axes })
    }
    match message {
        Message::Flow(flow) => of(flow),
        Message::Flow2(flow) => of(flow),
        Message::Flow3(flow) => of(flow),
        _ => None,
    }
}

/// Flow of the other end that no exchange has taken yet: the newest, or, with play-out, what is due.
#[derive(Clone, Debug)]
pub struct Inbox<const AXES: usize = 1> {
    newest: Option<Flows<AXES>>,
    /// The other end's motors have gone off since its last flow that counted.
    apart: bool,
    playout: Option<Playout<Flows<AXES>>>,
}

impl<const AXES: usize> Inbox<AXES> {
    /// Nothing there; flow waits for `playout_packets` packet periods of so many control periods each, 0: for nothing.
    pub fn new(playout_packets: u32, ticks_per_packet: u32) -> Self {
        let playout = (playout_packets > 0).then(|| Playout::new(playout_packets, ticks_per_packet));
        Self { newest: None, apart: false, playout }
    }

    /// Takes a flow that came in this control period.
    pub fn put(&mut self, tick: u32, flow: Flows<AXES>) {
        match &mut self.playout {
            Some(playout) => {
                playout.put(tick, flow.tick, flow);
            }
            None => self.newest = Some(flow),
        }
    }

    /// Forgets what was there: the other end has gone.
    pub fn clear(&mut self) {
        self.newest = None;
        if let Some(playout) = &mut self.playout {
            playout.clear();
        }
    }

    /// Brings out what the next exchange takes, in its control period.
    pub fn play(&mut self, tick: u32) {
        if let Some(playout) = &mut self.playout {
            self.newest = playout.take(tick);
        }
    }

    /// What the next exchange takes.
    pub fn newest(&self) -> Option<&Flows<AXES>> {
        self.newest.as_ref()
    }

    /// What an exchange takes in, and whether the other end has armed anew since the last that counted: then it counts from
    /// zero, from another place, and nothing that came before goes with it.
    pub fn take(&mut self) -> (Option<Flows<AXES>>, bool) {
        let newest = self.newest.take();
        let anew = self.apart && newest.is_some_and(|flow| flow.engaged);
        self.apart = newest.map_or(self.apart, |flow| !flow.engaged);
        (newest.filter(|flow| flow.engaged), anew)
    }
}
