//! Every parser against anything: no panic, one encoding only, and nothing changed by what is refused.

use cohold_protocol::link::Link;
use cohold_protocol::wire::{
    Ack, Ask, AxisFlow, Bits, Event, Flow, Flow2, Flow3, Goodbye, Greeting, GreetingKind, Header, MAX_DATAGRAM,
    MAX_MESSAGE, Message, Moved, Page, Part, Payload, PeerId, Presence, Probe, Push, Reply, Sample, Sighting, TABLES,
    Telemetry, Topic, VERSION,
};
use cohold_protocol::wire::{Manifest, Scope};
use proptest::prelude::*;

use crate::protocol::world::{World, config, state};

fn f32s() -> impl Strategy<Value = f32> {
    any::<f32>().prop_filter("finite", |number| number.is_finite())
}

fn f64s() -> impl Strategy<Value = f64> {
    any::<f64>().prop_filter("finite", |number| number.is_finite())
}

fn messages() -> impl Strategy<Value = Message> {
    let along = (any::<u32>(), f32s(), f32s(), f32s(), f64s(), f64s()).prop_map(
        |(live_ticks, position, velocity, wave, wave_integral, energy_sent)| AxisFlow {
            position,
            velocity,
            wave,
            wave_integral,
            energy_sent,
            live_ticks,
        },
    );
    let flow = (any::<(bool, bool, u32)>(), 1..=3, prop::array::uniform3(along)).prop_map(
        |((engaged, fading, tick), count, [x, y, z])| match count {
            1 => Flow { engaged, fading, tick, axes: [x] }.into(),
            2 => Flow2 { engaged, fading, tick, axes: [x, y] }.into(),
            _ => Message::from(Flow3 { engaged, fading, tick, axes: [x, y, z] }),
        },
    );
    let telemetry = (any::<([u8; 3], [u32; 8], i64)>(), prop::array::uniform6(f32s()), f64s(), f64s()).prop_map(
        |((bytes, words, clock_offset_us), numbers, energy_received, energy_sent)| {
            Message::Telemetry(Telemetry {
                mode: bytes[0] % 3,
                fault: bytes[1],
                stage: bytes[2] % 6,
                tick: words[0],
                device_position: numbers[0],
                object_position: numbers[1],
                desired_position: numbers[2],
                contact_force: numbers[3],
                coordination_force: numbers[4],
                energy_received,
                energy_sent,
                round_trip_us: words[1],
                jitter_us: words[2],
                clock_offset_us,
                clock_drift_ppm: numbers[5],
                packets_taken: words[3],
                packets_missing: words[4],
                flow_late: words[5],
                refused: words[6],
                overruns: words[7],
                longest_tick_ns: words[0],
            })
        },
    );
    let event = (any::<(u16, u32)>(), prop::collection::vec(any::<u8>(), 0..=Event::MAX_PAYLOAD))
        .prop_map(|((code, number), payload)| Message::Event(Event::new(code, &payload).unwrap().numbered(number)));
    let sample = (any::<u16>(), prop::collection::vec(any::<u8>(), 0..=Sample::MAX_PAYLOAD))
        .prop_map(|(code, payload)| Message::Sample(Sample::new(code, &payload).unwrap()));
    let scope = prop_oneof![
        Just(Scope::All),
        any::<u8>().prop_map(Scope::Region),
        (f32s(), f32s(), f32s()).prop_map(|(x, y, radius)| Scope::Around { x, y, radius: radius.abs() }),
    ];
    let topic = prop::sample::select(vec![Topic::Manifest, Topic::Region, Topic::Page, Topic::Object]);
    let ask = (topic, any::<(u16, u8, [u8; 32])>(), scope).prop_map(|(topic, (first, tag, wanted), scope)| {
        Message::Ask(Ask { topic, first, scope, tag, wanted: Bits(wanted) })
    });
    let payload = prop_oneof![
        (any::<u32>(), 0..=4096u16, 0..=32u8, f32s()).prop_map(|(version, objects, regions, margin)| {
            Payload::Manifest(Manifest { version, objects, regions, margin_m: margin.abs() })
        }),
        any::<[u8; 32]>().prop_map(Payload::Region),
        (any::<u8>(), any::<[u64; 8]>()).prop_map(|(mask, all)| {
            let checksums = std::array::from_fn(|at| if mask >> at & 1 == 1 { all[at] } else { 0 });
            Payload::Page(Page { mask, checksums })
        }),
        any::<[[u8; 32]; 2]>().prop_map(|halves| Payload::Object(std::array::from_fn(|at| halves[at / 32][at % 32]))),
    ];
    let part = (payload, any::<(u16, u8, u64)>()).prop_map(|(payload, (number, tag, world))| {
        let number = if payload.topic() == Topic::Manifest { 0 } else { number };
        Message::Part(Part { number, tag, world, payload })
    });
    let sighting = (any::<u32>(), prop::array::uniform4(f32s())).prop_map(|(who, [x, y, u, v])| Sighting {
        who,
        position: [x, y],
        velocity: [u, v],
    });
    let presence = (any::<u32>(), prop::collection::vec(sighting, 0..=4))
        .prop_map(|(tick, seen)| Message::Presence(Presence::new(tick, seen)));
    let push =
        (any::<(u32, u64)>(), prop::array::uniform4(f32s())).prop_map(|((round_trip_us, sent_us), [f, g, x, y])| {
            Message::Push(Push { round_trip_us, sent_us, force: [f, g], hand: [x, y] })
        });
    let moved = (any::<(u32, [u64; 3])>(), prop::array::uniform4(f32s())).prop_map(
        |((version, [echo_us, came_us, sent_us]), [x, u, y, v])| {
            Message::Moved(Moved { version, axes: [[x, u], [y, v]], echo_us, came_us, sent_us })
        },
    );
    prop_oneof![
        flow,
        telemetry,
        event,
        sample,
        ask,
        part,
        presence,
        push,
        moved,
        Just(Message::Goodbye(Goodbye {})),
        any::<(u32, u32)>().prop_map(|(next, ahead)| Message::Ack(Ack { next, ahead })),
        any::<u64>().prop_map(|sent_us| Message::Probe(Probe { sent_us })),
        any::<[u64; 3]>().prop_map(|[probe_sent_us, probe_received_us, sent_us]| {
            Message::Reply(Reply { probe_sent_us, probe_received_us, sent_us })
        }),
    ]
}

/// A message's bytes, or any.
fn bytes() -> impl Strategy<Value = Vec<u8>> {
    let altered =
        (messages(), any::<(usize, u8)>(), 0..2usize, -3..3isize).prop_map(|(message, (at, with), count, more)| {
            let mut out = [0; MAX_MESSAGE];
            let len = message.emit(&mut out).unwrap();
            let mut bytes = out[..len].to_vec();
            if count > 0 {
                bytes[at % len] = with;
            }
            bytes.resize(len.saturating_add_signed(more), with);
            bytes
        });
    let any_kind =
        (prop_oneof![1..8u8, 16..19u8], prop::collection::vec(any::<u8>(), 0..130)).prop_map(|(kind, mut bytes)| {
            if let Some(first) = bytes.first_mut() {
                *first = kind;
            }
            bytes
        });
    prop_oneof![altered, any_kind, prop::collection::vec(any::<u8>(), 0..300)]
}

proptest! {
    #[test]
    fn what_is_written_is_read(message in messages()) {
        let mut out = [0xee; MAX_MESSAGE];
        let len = message.emit(&mut out).unwrap();
        prop_assert_eq!(Message::parse(&out[..len]), Ok(message));
        prop_assert!(out[len..].iter().all(|byte| *byte == 0xee));
        // Too little room is an error and no panic.
        prop_assert!(message.emit(&mut out[..len - 1]).is_err());
    }

    #[test]
    fn what_is_read_has_one_encoding_only(bytes in bytes()) {
        if let Ok(message) = Message::parse(&bytes) {
            let mut out = [0; MAX_MESSAGE];
            let len = message.emit(&mut out).unwrap();
            prop_assert_eq!(&out[..len], &bytes[..]);
        }
    }

    #[test]
    fn greetings_likewise(mut bytes in prop::collection::vec(any::<u8>(), Greeting::TAGGED), kind in 0..4u8, count in 0..20u8, clean: bool) {
        bytes[..2].copy_from_slice(&[VERSION, kind]);
        if clean {
            bytes[4..8].fill(0);
            bytes[80] = count;
            bytes[81..88].fill(0);
            let used = 88 + 6 * usize::from(count.min(TABLES as u8));
            bytes[used..184].fill(0);
        }
        match Greeting::parse(&bytes) {
            Ok((greeting, body, tag)) => {
                let mut out = [0; Greeting::LEN];
                prop_assert_eq!(greeting.emit(&mut out), Ok(Greeting::LEN));
                prop_assert_eq!(&out[..], &bytes[..Greeting::LEN]);
                prop_assert_eq!((body, &tag[..]), bytes.split_at(Greeting::LEN));
                prop_assert!(greeting.kind == GreetingKind::Hello || greeting.kind == GreetingKind::Welcome);
            }
            Err(_) => prop_assert!(!clean || kind == 0 || kind == 3 || usize::from(count) > TABLES),
        }
        for len in 0..Greeting::TAGGED {
            prop_assert!(Greeting::parse(&bytes[..len]).is_err());
        }
    }

    #[test]
    fn headers_likewise(mut bytes in prop::collection::vec(any::<u8>(), 0..250), right: bool) {
        if right && bytes.len() > 2 {
            bytes[..2].copy_from_slice(&[VERSION, 3]);
        }
        let copy = bytes.clone();
        if let Ok((header, head, sealed)) = Header::parse(&mut bytes) {
            let mut out = [0; Header::LEN];
            prop_assert_eq!(header.emit(&mut out), Ok(Header::LEN));
            prop_assert_eq!(&out, head);
            prop_assert_eq!([&head[..], sealed].concat(), copy);
        }
    }

    #[test]
    fn a_link_refuses_anything_and_stays_as_it_was(datagrams in prop::collection::vec((bytes(), 0..3usize), 1..40)) {
        let mut world = World::engaged(1);
        let now = world.clock(0);
        let _ = world.links[0].receive(now, &mut []);
        let before = state(&world.links[0]);
        for (mut datagram, dress) in datagrams {
            // Bare, or with the beginning of a datagram that could come from the other end.
            match (dress, datagram.get_mut(..4)) {
                (1, Some(head)) => head.copy_from_slice(&[VERSION, 3, 2, 1]),
                (2, Some(head)) => {
                    head.copy_from_slice(&[VERSION, 1, 2, 1]);
                    datagram.resize(Greeting::TAGGED, 0);
                }
                _ => {}
            }
            prop_assert!(world.links[0].receive(now, &mut datagram).is_err());
            prop_assert_eq!(state(&world.links[0]), before.clone());
        }
    }

    /// Calls in any order at any time, datagrams delivered, dropped, repeated or altered: no panic, levels within bounds.
    #[test]
    fn any_sequence_of_calls(script in prop::collection::vec((0..10u8, any::<u64>()), 1..400)) {
        let mut links = [Link::new(config(1, 2, [1; 32])).unwrap(), Link::new(config(2, 1, [2; 32])).unwrap()];
        let (mut wire, mut out, mut now) = (Vec::<(usize, Vec<u8>)>::new(), [0; MAX_DATAGRAM], 0u64);
        for (call, value) in script {
            let peer = (value % 2) as usize;
            let link = &mut links[peer];
            let said = match call {
                0 => { now = now.wrapping_add(value % 300_000); None }
                1 => { if value % 50 == 0 { now = value } None }
                2 | 3 => link.poll(now, &mut out),
                4 => link.send(now, Flow { tick: value as u32, ..Flow::default() }, &mut out),
                5 => link.send(now, Telemetry::default(), &mut out),
                6 => { let _ = link.push_event(Event::new(1, &value.to_le_bytes()).unwrap()); None }
                7 => { let _ = (link.take_event(), link.take_notice()); None }
                _ => {
                    if !wire.is_empty() {
                        let at = value as usize / 7 % wire.len();
                        let (to, mut bytes) = if value % 5 == 0 { wire[at].clone() } else { wire.remove(at) };
                        if value % 11 == 0 {
                            let bit = value as usize / 3 % (8 * bytes.len());
                            bytes[bit / 8] ^= 1 << (bit % 8);
                        }
                        let _ = links[to].receive(now, &mut bytes);
                    }
                    None
                }
            };
            if let Some(len) = said {
                wire.push((1 - peer, out[..len].to_vec()));
            }
            for link in &links {
                let mut telemetry = Telemetry::default();
                link.describe(now, &mut telemetry);
                prop_assert!(telemetry.emit(&mut out).is_ok());
            }
        }
    }
}

#[test]
fn peers_of_any_number() {
    for (a, b) in [(0, 255), (255, 0), (3, 4)] {
        let mut links = [Link::new(config(a, b, [1; 32])).unwrap(), Link::new(config(b, a, [2; 32])).unwrap()];
        let mut out = [0; MAX_DATAGRAM];
        for round in 0..10 {
            for from in [0, 1] {
                while let Some(len) = links[from].poll(round * 1_000, &mut out) {
                    links[1 - from].receive(round * 1_000, &mut out[..len].to_vec()).unwrap();
                }
            }
        }
        assert!(links.iter().all(|link| link.counts().taken > 0), "{:?}", PeerId(a));
    }
}
