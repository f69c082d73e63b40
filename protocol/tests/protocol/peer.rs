//! Packets of haptic-core on the wire, and what two peers must have been told alike.

use haptic_core::law::Packet;
use haptic_core::num::Motion;
use haptic_core::schema::Schema;
use haptic_core::settings::{Allowed, Settings, Value};
use haptic_protocol::peer::{flow_of, packet_of, parameters_of};

#[test]
fn a_packet_survives_the_way() {
    let sent = Packet::<f32> {
        motion: Motion { position: 0.25, velocity: -1.5 },
        wave: 2.0,
        energy_j: 1.0 / 3.0,
        wave_integral: -1.0 / 7.0,
        live_ticks: u32::MAX,
    };
    let flow = flow_of(sent, true, 9);
    assert_eq!((packet_of(&flow), flow.engaged, flow.tick), (sent, true, 9));
}

#[test]
fn what_is_each_devices_own_may_differ_and_nothing_else() {
    let settings = Settings::default();
    for key in Settings::keys() {
        let now = settings.get(key.name).expect("a listed key has a value");
        let other = |values: &[Value<'static>]| values.iter().copied().find(|value| *value != now);
        let other = match key.allowed {
            Allowed::Number { min, max } => other(&[min, max].map(Value::Number)),
            Allowed::Whole { min, max } => other(&[min, max].map(|whole| Value::Number(whole.into()))),
            Allowed::Flag => other(&[false, true].map(Value::Flag)),
            Allowed::Names(names) => names.iter().map(|name| Value::Text(name)).find(|value| *value != now),
            Allowed::Kinds(kinds) => kinds.iter().map(|kind| Value::Text(kind.name)).find(|value| *value != now),
            Allowed::Only(_) => None,
        };
        let other = other.expect("another value");
        let mut changed = settings;
        changed.set(key.name, other).expect("an allowed value");
        let own = Schema::BUILT_IN.kinds().iter().any(|law| law.keys.iter().any(|own| own.name == key.name));
        let tables = ["timing.", "object.", "coordination."];
        let shared = own || tables.iter().any(|table| key.name.starts_with(table));
        assert_eq!(parameters_of(&changed) != parameters_of(&settings), shared, "{}", key.name);
    }
}
