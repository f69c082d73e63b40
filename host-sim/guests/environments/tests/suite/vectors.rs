//! Known answers of a world: its checksum, made by a second implementation (`protocol/tests/inside/vectors.py`), and its parts as
//! the messages that carry them. cohold-protocol's own tests seal the same messages to what that implementation sealed.

use cohold_environments::records::{Bounds, Database, Object, Region, Scope, Shape, Wall};
use cohold_environments::roles::static_scene::Server;
use cohold_protocol::wire::{Ask, Bits, MAX_DATAGRAM, Message, Topic};

const WORLD: u64 = u64::from_be_bytes([0x98, 0xbb, 0x64, 0xcc, 0xfb, 0x8d, 0x33, 0x13]).swap_bytes();
const PARTS: &str = include_str!("../../../../../protocol/tests/data/world-parts.txt");

#[test]
fn a_world_and_the_parts_that_it_answers_with() {
    let mut database = Database::<4>::default();
    (database.version, database.margin_m) = (9, 0.125);
    let (min, max) = ([-1.0, -1.0], [1.0, 1.0]);
    database.put_region(Region { id: 3, server: 1, bounds: Bounds { min, max } }).unwrap();
    let wall = Wall { from_x_m: 0.0, from_y_m: 0.5, to_x_m: 2.0, to_y_m: 0.5, thickness_m: 0.25, ..Wall::default() };
    database.put(Object { id: 5, version: 6, shape: Shape::Wall(wall) }).unwrap();
    let server = Server::new(database, None).unwrap();
    assert_eq!(server.world(), WORLD);

    let mut wanted = Bits::default();
    wanted.set(0);
    let scope = Scope::Around { x: 1.0, y: -2.0, radius: 3.0 };
    // The wall's rectangle reaches down to y = 0.25, within 3 m of the point.
    let topics = [Topic::Manifest, Topic::Region, Topic::Page, Topic::Object];
    let said = topics.map(|topic| {
        let answer: Vec<_> = server.answer(&Ask { topic, scope, tag: 8, wanted, first: 0 }).collect();
        assert_eq!(answer.len(), 1);
        let mut bytes = [0; MAX_DATAGRAM];
        let len = Message::Part(answer[0]).emit(&mut bytes).expect("a part that can be said");
        bytes[..len].iter().map(|byte| format!("{byte:02x}")).collect::<String>()
    });
    assert_eq!(said, PARTS.lines().collect::<Vec<_>>()[..], "{}", said.join("\n"));
}
