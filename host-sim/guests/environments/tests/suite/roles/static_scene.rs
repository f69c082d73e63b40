//! A static world: downloads over a network that loses, repeats and reorders, broken sessions, new versions, broken
//! records, neighbourhoods, and clients that roam. No link here: parts and questions themselves are carried.

use std::collections::BTreeSet;

use cohold_environments::records::{Body, Bounds, Database, Manifest, Object, Region, Scope, Shape};
use cohold_environments::roles::static_scene::{BURST, Board, Download, Roam, Server, Taken};
use cohold_protocol::wire::{Ask, Page, Part, Payload, Presence, Sighting, Topic};

use crate::random::Rng;

type World = Database<300>;

fn body(id: u32, version: u32, x: f32) -> Object {
    Object { id, version, shape: Shape::Body(Body { x_m: x, radius_m: 0.5, ..Body::default() }) }
}

/// Bodies in a row, one a metre, and two regions that meet at x = 100.
fn world(objects: u32) -> World {
    let mut world = World::default();
    (world.version, world.margin_m) = (1, 5.0);
    for id in 0..objects {
        world.put(body(3 * id, 1, id as f32)).unwrap();
    }
    for (id, from, to) in [(0, -10.0, 100.0), (1, 100.0, 310.0)] {
        let bounds = Bounds { min: [from, -10.0], max: [to, 10.0] };
        world.put_region(Region { id, server: id + 1, bounds }).unwrap();
    }
    world
}

/// Carries questions and answers, and counts the objects that crossed.
struct Wire {
    rng: Rng,
    loss: f64,
    now: u64,
    due: Vec<(u64, Part)>,
    objects_sent: u32,
    up: bool,
    /// Breaks a part on its way, as a server with bad memory would.
    spoil: fn(&mut Rng, &mut Part),
}

impl Wire {
    fn new(seed: u64, loss: f64) -> Self {
        Self { rng: Rng(seed), loss, now: 0, due: vec![], objects_sent: 0, up: true, spoil: |_, _| {} }
    }

    /// One packet period of 8 ms; parts take up to 40 ms and overtake each other.
    fn period<const M: usize, const N: usize>(&mut self, server: &Server<M>, client: &mut Download<N>) -> Vec<Taken> {
        self.now += 8_000;
        if let Some(ask) = client.poll(self.now, 100_000)
            && self.up
            && !self.rng.chance(self.loss)
        {
            let parts: Vec<Part> = server.answer(&ask).collect();
            assert!(parts.len() <= BURST);
            for mut part in parts {
                self.objects_sent += u32::from(part.payload.topic() == Topic::Object);
                (self.spoil)(&mut self.rng, &mut part);
                for _ in 0..1 + u64::from(self.rng.chance(0.1)) {
                    if !self.rng.chance(self.loss) {
                        self.due.push((self.now + self.rng.below(40_000), part));
                    }
                }
            }
        }
        let now = self.now;
        let mut due: Vec<_> = self.due.extract_if(.., |(due, _)| *due <= now).collect();
        due.sort_by_key(|(due, _)| *due);
        due.iter().map(|(_, part)| client.take(part)).collect()
    }

    /// Periods until everything in scope is there.
    fn finish<const M: usize, const N: usize>(&mut self, server: &Server<M>, client: &mut Download<N>) -> u64 {
        for periods in 0..5_000 {
            self.period(server, client);
            if client.is_complete() {
                return periods;
            }
        }
        panic!("not complete after 40 s: {:?}", client.progress());
    }
}

fn held<const N: usize>(client: &Download<N>) -> Vec<Object> {
    client.objects().copied().collect()
}

#[test]
fn a_whole_world_comes_over_a_bad_network_once_each() {
    for (seed, loss) in [(1, 0.0), (2, 0.3), (3, 0.6)] {
        let server = Server::new(world(300), None).unwrap();
        let (mut client, mut wire) = (Download::<300>::default(), Wire::new(seed, loss));
        let periods = wire.finish(&server, &mut client);
        assert_eq!(held(&client), server.database().objects());
        assert!(client.regions().eq(server.database().regions()));
        assert_eq!((client.objects_taken(), client.corrupt(), client.left_out()), (300, 0, 0));
        // Without losses 300/8 = 38 pages and 300 objects are 22 questions, and there are at most a few waits.
        assert!(loss > 0.0 || (wire.objects_sent == 300 && periods < 60), "{periods} periods, {}", wire.objects_sent);
        println!("loss {loss}: {periods} periods, {} objects sent", wire.objects_sent);
    }
}

#[test]
fn a_broken_session_goes_on_where_it_was() {
    let server = Server::new(world(300), None).unwrap();
    let (mut client, mut wire) = (Download::<300>::default(), Wire::new(5, 0.0));
    while client.objects_taken() < 150 {
        wire.period(&server, &mut client);
    }
    wire.up = false;
    for _ in 0..1_000 {
        wire.period(&server, &mut client);
    }
    let (before, sent) = (client.objects_taken(), wire.objects_sent);
    assert!((150..300).contains(&before) && !client.is_complete());
    // Another process of the same server: it knows nothing of the first, and need not.
    let (server, mut wire) = (Server::new(world(300), None).unwrap(), Wire { up: true, ..wire });
    wire.finish(&server, &mut client);
    assert_eq!(client.objects_taken(), 300);
    assert!(wire.objects_sent - sent <= 300 - before, "only what was missing: {}", wire.objects_sent - sent);
}

#[test]
fn a_new_version_is_noticed_and_only_what_changed_is_fetched() {
    let mut server = Server::new(world(200), None).unwrap();
    let (mut client, mut wire) = (Download::<300>::default(), Wire::new(6, 0.2));
    wire.finish(&server, &mut client);
    let mut next = world(200);
    next.version = 2;
    next.put(body(30, 2, 10.25)).unwrap(); // changed
    next.put(body(31, 1, 10.75)).unwrap(); // new: every number after it moves
    next.retain(|object| object.id != 60); // gone
    server.publish(next).unwrap();
    let taken = client.objects_taken();
    let seen: BTreeSet<String> =
        (0..400).flat_map(|_| wire.period(&server, &mut client)).map(|taken| format!("{taken:?}")).collect();
    assert!(seen.contains("World") && seen.contains("Complete"), "{seen:?}");
    assert_eq!(held(&client), server.database().objects());
    assert_eq!(client.world().map(|(sum, manifest)| (sum, manifest.version)), Some((server.world(), 2)));
    assert_eq!(client.objects_taken() - taken, 2);
}

#[test]
fn a_version_that_changes_in_the_middle_of_a_download() {
    let mut server = Server::new(world(300), None).unwrap();
    let (mut client, mut wire) = (Download::<300>::default(), Wire::new(7, 0.3));
    for round in 0..40 {
        for _ in 0..4 {
            wire.period(&server, &mut client);
            // Whatever it is in the middle of, every object that is held is one that some version had.
            assert!(client.objects().all(|object| object.version <= round + 1));
        }
        let mut next = server.database().clone();
        next.version += 1;
        next.put(body(3 * (round * 7 % 300), round + 2, round as f32)).unwrap();
        server.publish(next).unwrap();
    }
    wire.finish(&server, &mut client);
    assert_eq!(held(&client), server.database().objects());
}

#[test]
fn broken_records_are_noticed_and_fetched_again() {
    let server = Server::new(world(200), None).unwrap();
    let (mut client, mut wire) = (Download::<300>::default(), Wire::new(8, 0.0));
    wire.spoil = |rng, part| {
        if let Payload::Object(record) = &mut part.payload
            && rng.chance(0.3)
        {
            record[rng.below(64) as usize] ^= 1 << rng.below(8);
        }
    };
    wire.finish(&server, &mut client);
    assert_eq!(held(&client), server.database().objects());
    assert!(client.corrupt() > 50, "{}", client.corrupt());
}

#[test]
fn a_right_record_in_the_wrong_place_is_noticed() {
    let server = Server::new(world(200), None).unwrap();
    let (mut client, mut wire) = (Download::<300>::default(), Wire::new(9, 0.0));
    // The record of another object, its own checksum right.
    wire.spoil = |rng, part| {
        if let Payload::Object(record) = &mut part.payload
            && rng.chance(0.3)
        {
            *record = body(1, 1, 1.0).emit().unwrap();
        }
    };
    wire.finish(&server, &mut client);
    assert_eq!(held(&client), server.database().objects());
    assert!(client.corrupt() > 30);
    // A page that lies about everything: then only the checksum of the whole can tell, and does.
    let (mut client, mut wire) = (Download::<300>::default(), Wire::new(9, 0.0));
    wire.spoil = |_, part| match &mut part.payload {
        Payload::Object(record) if part.number == 4 => *record = body(12, 1, 99.0).emit().unwrap(),
        Payload::Page(page) if part.number == 0 => {
            let record = body(12, 1, 99.0).emit().unwrap();
            page.checksums[4] = u64::from_le_bytes(*record.last_chunk().unwrap());
        }
        _ => {}
    };
    let seen: Vec<Taken> = (0..300).flat_map(|_| wire.period(&server, &mut client)).collect();
    assert!(seen.contains(&Taken::Corrupt) && !seen.contains(&Taken::Complete));
    wire.spoil = |_, _| {};
    wire.finish(&server, &mut client);
    assert_eq!(held(&client), server.database().objects());
}

#[test]
fn a_neighbourhood_follows_the_client_in_little_memory() {
    let server = Server::new(world(300), None).unwrap();
    // Room for 16 of 300 objects.
    let (mut client, mut wire) = (Download::<16>::default(), Wire::new(10, 0.3));
    for step in 0..20 {
        let x = 15.0 * step as f32;
        client.look(Scope::Around { x, y: 0.0, radius: 5.0 });
        wire.finish(&server, &mut client);
        let around = |object: &&Object| match object.shape {
            Shape::Body(body) => (body.x_m - x).abs() <= 5.5,
            _ => false,
        };
        let wanted: Vec<Object> = server.database().objects().iter().filter(around).copied().collect();
        assert_eq!(held(&client), wanted, "at {x}");
        assert!(wanted.len() <= 11 && client.left_out() == 0);
    }
    // More in scope than there is room for: what fits is held, and the rest is counted.
    client.look(Scope::All);
    wire.finish(&server, &mut client);
    assert_eq!((client.objects().count(), client.left_out()), (16, 284));
}

#[test]
fn a_question_about_anything_is_answered_within_bounds() {
    let server = Server::new(world(300), Some(0)).unwrap();
    let mut rng = Rng(11);
    let (mut client, mut parts) = (Download::<300>::default(), 0);
    for _ in 0..2_000 {
        let mut ask = Ask { first: rng.next() as u16, tag: 0, ..Ask::default() };
        ask.topic = [Topic::Manifest, Topic::Region, Topic::Page, Topic::Object][rng.below(4) as usize];
        if rng.chance(0.5) {
            ask.first %= 320;
        }
        ask.wanted.0 = rng.bytes();
        let answer: Vec<Part> = server.answer(&ask).collect();
        assert!(answer.len() <= BURST);
        parts += answer.len();
        for part in &answer {
            client.take(part);
            client.poll(rng.next(), rng.next());
        }
    }
    assert!(parts > 1_000);
    // Region 0 ends at 100 and its margin at 105: nothing beyond is given away.
    wireless_finish(&server, &mut client);
    assert!(client.objects().all(|object| object.id <= 3 * 105) && client.objects().count() == 106);
}

/// A server that says anything at all, in any order: no panic, bounded memory, and nothing is held but what has a right record.
#[test]
fn any_parts_in_any_order() {
    let mut rng = Rng(15);
    for _ in 0..300 {
        let mut client = Download::<4>::default();
        let mut now = 0;
        for _ in 0..200 {
            now += rng.below(200_000);
            let object = body(rng.below(6) as u32, rng.below(3) as u32, rng.below(9) as f32);
            let mut record = object.emit().unwrap();
            let checksum = u64::from_le_bytes(*record.last_chunk().unwrap());
            let payload = match rng.below(4) {
                0 => Payload::Manifest(Manifest {
                    version: rng.below(2) as u32,
                    objects: rng.below(12) as u16,
                    regions: rng.below(3) as u8,
                    margin_m: 0.0,
                }),
                1 => Payload::Region(rng.bytes()),
                2 => {
                    let (mask, mut checksums) = (rng.next() as u8, rng.bytes::<8>().map(u64::from));
                    checksums[rng.below(8) as usize] = checksum;
                    Payload::Page(Page { mask, checksums })
                }
                _ => {
                    if rng.chance(0.2) {
                        record[rng.below(64) as usize] ^= 1;
                    }
                    Payload::Object(record)
                }
            };
            let part = Part { number: rng.below(3) as u16, tag: rng.below(2) as u8, world: rng.below(2), payload };
            client.take(&part);
            if rng.chance(0.1) {
                client.look(Scope::Region(rng.below(3) as u8));
            }
            if let Some(ask) = client.poll(now, rng.below(100_000)) {
                assert!(ask.wanted.iter().count() <= BURST && ask.wanted.iter().count() > 0);
            }
            assert!(client.objects().count() <= 4);
            let ids: Vec<u32> = client.objects().map(|object| object.id).collect();
            assert!(ids.is_sorted_by(|a, b| a < b), "{ids:?}");
        }
    }
}

fn wireless_finish(server: &Server<300>, client: &mut Download<300>) {
    let mut wire = Wire::new(12, 0.0);
    wire.now = 1 << 62;
    client.look(Scope::Region(0));
    wire.finish(server, client);
}

#[test]
fn a_client_that_roams_holds_its_neighbourhood_all_the_way() {
    let servers = [Server::new(world(300), Some(0)).unwrap(), Server::new(world(300), Some(1)).unwrap()];
    let regions = world(0).regions().to_vec();
    let mut downloads = [Download::<300>::default(), Download::default()];
    let mut wires = [Wire::new(13, 0.3), Wire::new(14, 0.3)];
    let mut roam = Roam::new(1);
    downloads[0].look(Scope::Around { x: 80.0, y: 0.0, radius: 2.0 });
    wires[0].finish(&servers[0], &mut downloads[0]);
    let mut both = 0;
    // From x = 80 to 120 and back at 1 m/s, with a packet period of 8 ms.
    for step in 0..10_000 {
        let x = 80.0 + 40.0 * (1.0 - (f64::from(step) / 5_000.0 - 1.0).abs()) as f32;
        let needed = roam.needs(&regions, 5.0, [x, 0.0]);
        assert!(needed.contains(&roam.home()));
        both += u32::from(needed.len() == 2);
        for server in 1..=2_u8 {
            let at = usize::from(server) - 1;
            if needed.contains(&server) {
                // Looked for anew every half metre.
                let centre = (2.0 * x).round() / 2.0;
                downloads[at].look(Scope::Around { x: centre, y: 0.0, radius: 2.0 });
                wires[at].period(&servers[at], &mut downloads[at]);
            }
        }
        roam.update(&regions, [x, 0.0], |server| downloads[usize::from(server) - 1].is_complete());
        // Whatever touches the client is held by the server it is at home at.
        let home = &downloads[usize::from(roam.home()) - 1];
        for object in world(300).objects() {
            let Shape::Body(body) = object.shape else { continue };
            if (body.x_m - x).abs() < 0.5 {
                assert!(home.objects().any(|held| held == object), "at {x}: {object:?} is not held");
            }
        }
    }
    assert_eq!((roam.home(), roam.moves()), (1, 2));
    assert!((1_500..4_000).contains(&both), "{both} periods at two servers");
}

#[test]
fn everybody_hears_of_everybody_in_turns() {
    for clients in [2_u32, 5, 6, 40] {
        let mut board = Board::<64>::new(100_000);
        let mut seats = vec![None; clients as usize];
        let mut heard = vec![BTreeSet::new(); clients as usize];
        let turns = (clients - 1).div_ceil(4) + 1;
        for period in 0..turns + 1 {
            for who in 0..clients {
                let own = Sighting { who: 777, position: [who as f32, 0.0], velocity: [0.0; 2] };
                let said = Presence::new(period, [own]);
                let (presence, seat) = board.hear(u64::from(period) * 8_000, who, &said, seats[who as usize]).unwrap();
                seats[who as usize] = Some(seat);
                assert_eq!(presence.tick, period);
                // Who somebody is, the server knows by the line and not by what is said.
                assert!(presence.seen().iter().all(|other| other.who != who && other.position[0] == other.who as f32));
                heard[who as usize].extend(presence.seen().iter().map(|other| other.who));
            }
        }
        assert!(heard.iter().all(|heard| heard.len() == clients as usize - 1), "{clients}: {heard:?}");
    }
}

#[test]
fn the_silent_are_not_told_and_give_up_their_seat() {
    let mut board = Board::<2>::new(100_000);
    let said = Presence::new(0, [Sighting::default()]);
    let (_, seat) = board.hear(0, 1, &said, None).unwrap();
    board.hear(0, 2, &said, None).unwrap();
    assert_eq!(board.hear(50_000, 3, &said, None), None);
    let (presence, _) = board.hear(99_000, 1, &said, Some(seat)).unwrap();
    assert_eq!(presence.seen().len(), 1);
    // Client 2 has been silent for 100 ms.
    let (presence, _) = board.hear(100_000, 1, &said, Some(seat)).unwrap();
    assert_eq!((presence.seen().len(), board.present(100_000)), (0, 1));
    let (presence, other) = board.hear(100_000, 3, &said, Some(seat)).unwrap();
    assert!(other != seat && presence.seen().len() == 1);
    assert_eq!(board.hear(0, 4, &Presence::default(), None), None);
}
