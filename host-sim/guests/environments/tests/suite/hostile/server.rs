//! A hostile client with a line's key at a server of a static world, beside an honest one.

use cohold_core::num::Motion;
use cohold_environments::records::Scope;
use cohold_environments::world::host::Host;
use cohold_environments::world::visitor::{Correspondent, Setup, Visitor};
use cohold_environments::world::{CLIENT, open_link, parse};
use cohold_protocol::key::Key;
use cohold_protocol::wire::{Message, Presence, Sighting};
use cohold_sim::rng::Rng;

use super::asked;

/// Whatever it asks for and wherever it says that it is, the server goes on, and the honest one has its world and feels what it felt.
#[test]
fn a_server_and_its_clients_bear_whatever_a_client_says() {
    let mut rng = Rng::new(asked("HOSTILE_SEED", 1));
    let key = Key::new([7; 32]);
    let world = *parse("version = 1\n[[wall]]\nid = 1\n", "w.toml").expect("a good world");
    let mut drawn = 0_u8;
    let entropy = move || {
        drawn = drawn.wrapping_add(1).max(1);
        [drawn; Key::LEN]
    };
    let mut host = Host::new(key.clone(), 1, 8, world, None, entropy).expect("a good world");
    let setup = Setup { key: key.line(3), line: 3, home: 1, reachable: vec![1], radius_m: None };
    let mut visitor = Visitor::new(setup, || [99; Key::LEN]);
    let mut hostile = open_link(key.line(4), [CLIENT, 1], [98; Key::LEN]).expect("a link").on_line(4);
    let numbers = [0.0, -1.0, 1e-40, 1e9, -1e30, f32::MAX, f32::MIN, f32::MIN_POSITIVE];
    let (mut told, mut seen) = (0_u64, 0_u64);
    let periods = asked("HOSTILE_PROGRAMS", 10_000);
    for period in 0..periods {
        let now = 8_000 * period;
        let any = |rng: &mut Rng| match rng.below(3) {
            0 => f32::from_bits(rng.below(1 << 32) as u32),
            _ => numbers[rng.below(numbers.len() as u64) as usize],
        };
        let mut said = vec![];
        hostile.say_due(now, |bytes| said.push(bytes.to_vec()));
        let sightings = (0..1 + rng.below(4)).map(|_| Sighting {
            who: rng.below(1 << 32) as u32,
            position: [any(&mut rng), any(&mut rng)],
            velocity: [any(&mut rng), any(&mut rng)],
        });
        let sightings: Vec<Sighting> = sightings.collect();
        let presence = Presence::new(rng.below(1 << 32) as u32, sightings);
        told += u64::from(hostile.say(now, presence, |bytes| said.push(bytes.to_vec())));
        let mut download = Box::<cohold_environments::roles::static_scene::Download<32>>::default();
        download.look(Scope::Around { x: any(&mut rng), y: any(&mut rng), radius: any(&mut rng) });
        if let Some(ask) = download.poll(now, 1) {
            hostile.say(now, ask, |bytes| said.push(bytes.to_vec()));
        }
        let mut back = vec![];
        for mut bytes in said {
            host.receive(now, 4, &mut bytes, |to, bytes| back.push((to, bytes.to_vec())));
        }
        let felt_n = visitor.step([Motion::at(0.0); 2]);
        assert!(felt_n.iter().all(|force| force.is_finite()), "{felt_n:?}");
        let mut from_visitor = vec![];
        visitor.exchange(now, |_, bytes| from_visitor.push(bytes.to_vec()));
        for mut bytes in from_visitor {
            host.receive(now, 3, &mut bytes, |to, bytes| back.push((to, bytes.to_vec())));
        }
        host.tick(now, |to, bytes| back.push((to, bytes.to_vec())));
        for (to, mut bytes) in back {
            match to {
                3 => visitor.receive(now, Correspondent::Server(1), &mut bytes, |_, _| {}),
                _ => {
                    if let Ok(Some(Message::Presence(presence))) = hostile.receive(now, &mut bytes) {
                        seen += presence.seen().len() as u64;
                    }
                }
            }
        }
    }
    let finite = |seen: &Sighting| seen.position.iter().chain(&seen.velocity).all(|number| number.is_finite());
    assert!(visitor.others().all(finite));
    assert!(told > periods / 4, "{told} said, {seen} seen");
    assert!(visitor.is_complete() && host.clients() == 2);
}
