//! Between the coordination and the wire: packets and flow, and what two peers must have been told alike.

use haptic_core::couple::Packet;
use haptic_core::motion::Motion;
use haptic_core::settings::{Settings, Value};
use haptic_protocol::parameters::{Parameters, Table};
use haptic_protocol::wire::Flow;

/// Tables that both peers must have been told alike; the rest is each device's own.
const SHARED: [&str; 3] = ["timing", "object", "coordination"];

/// Those tables, as a greeting names them. host-sim's peers make the same of the same settings (tests/board holds both to it).
pub fn parameters(settings: &Settings) -> Parameters {
    let mut parameters = Parameters::new();
    for name in SHARED {
        let mut table = Table::new(name);
        for key in Settings::KEYS {
            let Some((_, short)) = key.name.split_once('.').filter(|(table, _)| *table == name) else { continue };
            table = match settings.get(key.name) {
                Some(Value::Number(number)) => table.number(short, number),
                Some(Value::Flag(flag)) => table.flag(short, flag),
                Some(Value::Text(text)) => table.text(short, text),
                None => table,
            };
        }
        // There is room for 16.
        let _ = parameters.add(table);
    }
    parameters
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
        let mut other = settings;
        other.motor.full_scale_a = 1.0;
        other.safety.max_force_n = 1.0;
        assert_eq!(parameters(&other), parameters(&settings));
        other.coordination.stiffness_n_per_m += 1.0;
        assert_ne!(parameters(&other), parameters(&settings));
    }
}
