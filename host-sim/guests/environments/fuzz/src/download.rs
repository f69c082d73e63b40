//! A client that downloads a world which changes, over a network that the script commands and breaks objects on the way. What is
//! held is always part of a world that was published; a download that says it is complete has exactly what is in scope; and
//! in the end it is.

use cohold_environments::records::{Body, Bounds, Database, Object, Region, Scope, Shape};
use cohold_environments::roles::static_scene::{BURST, Download, Server};
use cohold_protocol::wire::{Ask, Part, Payload};

use super::net::Net;
use super::script::Script;

const OBJECTS: usize = 40;
/// Half of a body, m.
const RADIUS_M: f32 = 0.5;
const MARGIN_M: f32 = 2.0;

/// A question, or a part of the answer.
#[derive(Clone)]
enum QueryMessage {
    Ask(Ask),
    Part(Part),
}

type World = Database<OBJECTS>;

/// A body at a whole metre of a line, and so is every border: nothing here needs rounding.
fn body(id: u32, version: u32, x: u8) -> Object {
    Object { id, version, shape: Shape::Body(Body { x_m: f32::from(x), radius_m: RADIUS_M, ..Body::default() }) }
}

fn first() -> World {
    let mut world = World::default();
    (world.version, world.margin_m) = (1, MARGIN_M);
    for id in 0..20 {
        world.put(body(id, 1, id as u8)).expect("there is room");
    }
    for (id, from, to) in [(0, -1.0, 10.0), (1, 10.0, 300.0)] {
        let bounds = Bounds { min: [from, -1.0], max: [to, 1.0] };
        world.put_region(Region { id, server: id, bounds }).expect("there is room");
    }
    world
}

/// What of a world is in scope, found another way than the server does: on a line.
fn in_scope(world: &World, scope: Scope) -> Vec<Object> {
    let (from, to) = match scope {
        Scope::All => (f32::NEG_INFINITY, f32::INFINITY),
        Scope::Around { x, radius, .. } => (x - radius, x + radius),
        Scope::Region(0) => (-1.0 - MARGIN_M, 10.0 + MARGIN_M),
        Scope::Region(1) => (10.0 - MARGIN_M, 300.0 + MARGIN_M),
        Scope::Region(_) => (f32::INFINITY, f32::NEG_INFINITY),
    };
    let holds = |object: &&Object| match object.shape {
        Shape::Body(Body { x_m, .. }) => x_m + RADIUS_M >= from && x_m - RADIUS_M <= to,
        _ => false,
    };
    world.objects().iter().filter(holds).copied().collect()
}

struct Pair {
    server: Server<OBJECTS>,
    client: Download<OBJECTS>,
    /// Every world there was.
    worlds: Vec<Server<OBJECTS>>,
}

impl Pair {
    /// What a message comes to.
    fn receive(&mut self, said: QueryMessage, net: &mut Net<QueryMessage>) {
        match said {
            QueryMessage::Ask(ask) => {
                let parts: Vec<Part> = self.server.answer(&ask).collect();
                assert!(parts.len() <= BURST);
                parts.into_iter().for_each(|part| net.send(0, 1, QueryMessage::Part(part)));
            }
            QueryMessage::Part(part) => {
                self.client.take(&part);
                self.look();
            }
        }
    }

    /// What must always be true.
    fn look(&self) {
        let held: Vec<Object> = self.client.objects().copied().collect();
        assert!(held.is_sorted_by(|one, two| one.id < two.id));
        let known = |object: &Object| self.worlds.iter().any(|world| world.database().get(object.id) == Some(object));
        assert!(held.iter().all(known), "an object that was in no world");
        if self.client.is_complete() {
            let (sum, manifest) = self.client.world().expect("complete without a world");
            let world = self.worlds.iter().find(|world| world.world() == sum).expect("a world that was published");
            assert_eq!(manifest, world.database().manifest());
            assert!(self.client.regions().eq(world.database().regions()));
            assert_eq!(held, in_scope(world.database(), self.client.scope()));
        }
    }

    /// The world as it is from now on.
    fn publish(&mut self, world: World) {
        self.server.publish(world).expect("every number is finite");
        self.worlds.push(self.server.clone());
    }
}

/// Runs one fuzz input through a server and a client that downloads.
pub(super) fn run(bytes: &[u8]) {
    let server = Server::new(first(), None).expect("every number is finite");
    let mut pair = Pair { worlds: vec![server.clone()], server, client: Download::default() };
    let (mut net, mut script, mut now) = (Net::new(), Script(bytes), 0);
    // As many scopes as have different tags: what is older than that does not come through a link.
    let mut looks = 0;
    while script.goes_on() {
        let call = script.byte();
        match call % 16 {
            0 | 1 => now += script.time_us(),
            2..=4 => {
                if let Some(ask) = pair.client.poll(now, 50_000) {
                    assert!((1..=BURST).contains(&ask.wanted.iter().count()));
                    net.send(1, 0, QueryMessage::Ask(ask));
                }
            }
            5..=10 => {
                if let Some((_, _, mut said)) = net.deliver(&mut script) {
                    if let (QueryMessage::Part(Part { payload: Payload::Object(record), .. }), true) =
                        (&mut said, call >= 192)
                    {
                        record[usize::from(call) % 64] ^= script.byte();
                    }
                    pair.receive(said, &mut net);
                }
            }
            11 => net.lose(&mut script),
            12 => net.take_all().into_iter().for_each(|(_, _, said)| pair.receive(said, &mut net)),
            13 | 14 => {
                let mut world = pair.server.database().clone();
                world.version = script.byte().into();
                let id = u32::from(script.byte() % OBJECTS as u8);
                match world.get(id).map(|object| object.version) {
                    Some(_) if call >= 192 => world.retain(|object| object.id != id),
                    version => world.put(body(id, version.unwrap_or(0) + 1, script.byte())).expect("there is room"),
                }
                pair.publish(world);
            }
            _ if looks < 255 => {
                looks += 1;
                let (x, radius) = (f32::from(script.byte() % 32), f32::from(script.byte() % 8));
                let scopes = [Scope::All, Scope::Around { x, y: 0.0, radius }, Scope::Region(script.byte() % 3)];
                pair.client.look(scopes[usize::from(call / 16) % 3]);
            }
            _ => {}
        }
        pair.look();
    }
    // Peace: everything arrives at once. A second until the client asks whether the world is still the same, 5 pages and 40
    // objects in 16s, and as much again for what it asked for in the middle of all that.
    for _ in 0..400 {
        now += 10_000;
        if let Some(ask) = pair.client.poll(now, 50_000) {
            net.send(1, 0, QueryMessage::Ask(ask));
        }
        while let [first, rest @ ..] = &net.take_all()[..] {
            for (_, _, said) in std::iter::once(first).chain(rest) {
                pair.receive(said.clone(), &mut net);
            }
        }
    }
    assert!(pair.client.is_complete(), "{:?}", pair.client.progress());
    assert_eq!(pair.client.world().map(|(sum, _)| sum), Some(pair.server.world()));
}
