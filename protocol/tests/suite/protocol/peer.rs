//! Packets of haptic-core on the wire, and what two peers must have been told alike.

use haptic_core::law::Packet;
use haptic_core::num::Motion;
use haptic_core::schema::Schema;
use haptic_core::settings::{Allowed, Settings, Value};
use haptic_protocol::peer::{flow_of, packets_of, parameters_of};
use haptic_protocol::wire::{Flow, Flow3, Message};

#[test]
fn packets_survive_the_way() {
    let packet = |position| Packet::<f32> {
        motion: Motion { position, velocity: -1.5 },
        wave: 2.0,
        energy_j: 1.0 / 3.0,
        wave_integral: -1.0 / 7.0,
        live_ticks: u32::MAX,
    };
    let one: Flow = flow_of([packet(0.25)], true, 9);
    assert_eq!((packets_of(&one), one.engaged, one.tick), ([packet(0.25)], true, 9));
    let sent = [0.25, -1.0, 3.0].map(packet);
    let three: Flow3 = flow_of(sent, false, 7);
    let mut bytes = [0; Flow3::LEN];
    assert_eq!(Message::from(three).emit(&mut bytes), Ok(Flow3::LEN));
    let Ok(Message::Flow3(came)) = Message::parse(&bytes) else { panic!("{bytes:?}") };
    assert_eq!((packets_of(&came), came.engaged, came.tick), (sent, false, 7));
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
        let shared = own || key.name == "axis.shared" || tables.iter().any(|table| key.name.starts_with(table));
        assert_eq!(parameters_of(&changed) != parameters_of(&settings), shared, "{}", key.name);
    }
}
