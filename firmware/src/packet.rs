//! Between the coordination and the wire: packets and flow, and what two peers must have been told alike.

use haptic_core::law::Packet;
use haptic_core::num::Motion;
use haptic_core::settings::{Settings, Value};
use haptic_protocol::parameters::Parameters;
use haptic_protocol::wire::Flow;

/// What both peers must have been told alike, as a greeting names it.
pub fn parameters(settings: &Settings) -> Parameters {
    Parameters::of(settings.shared(), |table, key, value| match value {
        Value::Number(number) => table.number(key, number),
        Value::Flag(flag) => table.flag(key, flag),
        Value::Text(text) => table.text(key, text),
    })
    // There is room for all of it; tests see to that.
    .unwrap_or_default()
}

/// A packet of tick `tick` as it goes out; `engaged` while the motors are on.
pub fn flow(packet: Packet<f32>, engaged: bool, tick: u32) -> Flow {
    Flow {
        engaged,
        tick,
        position: packet.motion.position,
        velocity: packet.motion.velocity,
        wave: packet.wave,
        wave_integral: packet.wave_integral,
        energy_sent: packet.energy_j,
        ..Flow::default()
    }
}

/// The packet in a flow.
pub fn packet(flow: &Flow) -> Packet<f32> {
    Packet {
        motion: Motion { position: flow.position, velocity: flow.velocity },
        wave: flow.wave,
        energy_j: flow.energy_sent,
        wave_integral: flow.wave_integral,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use haptic_core::settings::Allowed;

    #[test]
    fn a_packet_survives_the_way() {
        let sent = Packet {
            motion: Motion { position: 0.25, velocity: -1.5 },
            wave: 2.0,
            energy_j: 1.0 / 3.0,
            wave_integral: -1.0 / 7.0,
        };
        let flow = flow(sent, true, 9);
        assert_eq!((packet(&flow), flow.engaged, flow.tick), (sent, true, 9));
    }

    #[test]
    fn what_is_each_devices_own_may_differ_and_nothing_else() {
        let settings = Settings::default();
        for key in Settings::KEYS {
            let now = settings.get(key.name).expect("a listed key has a value");
            let other = |values: &[Value<'static>]| values.iter().copied().find(|value| *value != now);
            let other = match key.allowed {
                Allowed::Number { min, max } => other(&[min, max].map(Value::Number)),
                Allowed::Whole { min, max } => other(&[min, max].map(|whole| Value::Number(whole.into()))),
                Allowed::Flag => other(&[false, true].map(Value::Flag)),
                Allowed::Names(names) => names.iter().map(|name| Value::Text(name)).find(|value| *value != now),
                Allowed::Only(_) => None,
            };
            let other = other.expect("another value");
            let mut changed = settings;
            changed.set(key.name, other).expect("an allowed value");
            let shared = ["timing.", "object.", "coordination."].iter().any(|table| key.name.starts_with(table));
            assert_eq!(parameters(&changed) != parameters(&settings), shared, "{}", key.name);
        }
    }
}
