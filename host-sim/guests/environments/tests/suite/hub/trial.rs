//! Peers around a hub in virtual time, over a network in memory, every byte of it sealed.

use cohold_core::device::AXES;
use cohold_core::settings::Value;
use cohold_environments::cooperative::hub::{Hub, number_on};
use cohold_live::node::Node;
use cohold_protocol::key::Key;
use cohold_sim::engine::{Actor, Engine, Out, Seat};
use cohold_sim::network::link::Route;
use cohold_sim::network::rule::Direction;
use cohold_sim::peers::Builds;
use cohold_sim::plant::Plant;
use cohold_sim::scene::Scene;
use cohold_sim::scenes;

pub(super) fn built_in(name: &str, keys: &[String]) -> Scene {
    let mut scene = scenes::load(cohold_sim::Laws::built_in(), name).expect("a built-in scene");
    keys.iter().for_each(|key| scene.apply_override(key).expect("a good override"));
    scene.check("the test").expect("a good scene");
    scene
}

pub(super) fn key() -> Key {
    Key::new([0x5a; Key::LEN])
}

/// Who sits at the engine: the peers, and last the hub.
pub(super) enum Participant<const SHARED: usize = 1, const N: usize = AXES> {
    Hub(Box<Hub<usize, SHARED>>),
    Peer(Box<Node<SHARED, N>>, usize),
}

impl<const SHARED: usize, const N: usize> Actor<usize> for Participant<SHARED, N> {
    type Packet = [u8];

    fn hear(&mut self, now_ns: u64, from: usize, datagram: &mut [u8], out: &mut Out<'_, usize, [u8]>) {
        match self {
            Self::Hub(hub) => hub.receive(now_ns / 1_000, from, datagram, out),
            Self::Peer(node, _) => drop(node.receive(now_ns / 1_000, datagram)),
        }
    }

    fn speak(&mut self, now_ns: u64, out: &mut Out<'_, usize, [u8]>) {
        if let Self::Peer(node, hub) = self {
            let _ = node.tick(now_ns / 1_000, |bytes| out(*hub, bytes));
        }
    }

    fn act(&mut self, now_ns: u64, out: &mut Out<'_, usize, [u8]>) {
        if let Self::Hub(hub) = self {
            hub.tick(now_ns / 1_000, out);
        }
    }
}

/// A hub, its peers and their lines; a peer may be gone.
pub(super) struct HubTrial<const SHARED: usize = 1, const N: usize = AXES> {
    pub(super) scene: Scene,
    pub(super) engine: Engine<Participant<SHARED, N>>,
    lives: u8,
}

impl<const SHARED: usize, const N: usize> HubTrial<SHARED, N>
where
    f32: Builds<SHARED, N>,
{
    pub(super) fn new(scene: Scene, users: usize) -> Self {
        let mut drawn = 0;
        let entropy = || {
            drawn += 1;
            Ok([drawn; Key::LEN])
        };
        let hub = Participant::Hub(Box::new(Hub::new(&scene, users, &key(), entropy).expect("a hub")));
        let peers =
            (0..users).map(|index| life(&scene, index, users, 101 + index as u8, Plant::build(&scene, index % 2)));
        let seats = peers.chain([hub]).map(Seat::new).collect();
        let route = |from: usize, to: usize| match from == users {
            true => Route::of_scene(&scene, Direction::TwoToOne, to as u32),
            false => Route::of_scene(&scene, Direction::OneToTwo, from as u32),
        };
        Self { engine: Engine::new(1_000_000, seats, route), lives: 100 + users as u8, scene }
    }

    /// Another life of the peer on line `index` + 1.
    pub(super) fn restart(&mut self, index: usize, device: Plant<N>) {
        self.lives += 1;
        let hub = self.engine.seats.len() - 1;
        let seat = &mut self.engine.seats[index];
        (seat.actor, seat.off) = (life(&self.scene, index, hub, self.lives, device), false);
    }

    /// One control period, after which along no axis more went back into the lines than the peers had put in, and what lines that carry on
    /// begin with at both ends.
    pub(super) fn step(&mut self) {
        self.engine.step(&mut |_| ());
        for (axis, energy) in self.hub().junction.energies().iter().enumerate() {
            let capital_j = match self.scene.get("coordination.carry_energy_j") {
                Some(Value::Number(capital_j)) => capital_j * self.hub().junction.ports.len() as f64,
                _ => 0.0,
            };
            let most_j = energy.put_in_j * (1.0 + 1e-9) + 1e-15 + capital_j;
            assert!(energy.sent_j <= most_j, "tick {}, axis {axis}: {energy:?}", self.engine.tick());
        }
    }

    pub(super) fn hub(&self) -> &Hub<usize, SHARED> {
        match &self.engine.seats.last().expect("a hub").actor {
            Participant::Hub(hub) => hub,
            Participant::Peer(..) => panic!("the hub sits last"),
        }
    }

    /// Those who are there.
    pub(super) fn peers(&self) -> impl Iterator<Item = &Node<SHARED, N>> {
        self.engine.seats.iter().filter(|seat| !seat.off).filter_map(|seat| match &seat.actor {
            Participant::Peer(node, _) => Some(node.as_ref()),
            Participant::Hub(_) => None,
        })
    }

    pub(super) fn lives_on(&self, index: usize) -> u64 {
        let (end, _) = self.hub().lines().nth(index).expect("a line");
        end.line.lives
    }
}

/// A life of the peer on line `index` + 1 of a hub at seat `hub`.
fn life<const SHARED: usize, const N: usize>(
    scene: &Scene,
    index: usize,
    hub: usize,
    entropy: u8,
    device: Plant<N>,
) -> Participant<SHARED, N>
where
    f32: Builds<SHARED, N>,
{
    let line = index as u32 + 1;
    let node = Node::with_device(scene, number_on(line), key().line(line), [entropy; Key::LEN], Box::new(device));
    Participant::Peer(Box::new(node.expect("a peer")), hub)
}
