//! Four hands on one object through a hub: two of people, two of partners who play always.

use cohold_environments::cooperative::waves::Waves;
use cohold_sim::network::link::Route;
use cohold_sim::scene::Scene;

use super::environment::{ARMED, Column, number_of};
use super::partner::{Model, Partner};
use super::session::{PERIOD_S, first, on_device};
use super::shared_environment::{Held, Play};
use cohold_cli::Failure;
use cohold_live::hand::Hand;

/// Number of hands on the object.
const HANDS: usize = 4;
/// What those who are always there do: neither can have its way alone.
const THERE: [Model; 2] = [Model::CarriesOn, Model::Resists];

pub(super) const COLUMNS: [Column; 17] = [
    ("device_1", "m", "device 1"),
    ("device_2", "m", "device 2"),
    ("device_3", "m", "device 3"),
    ("device_4", "m", "device 4"),
    ("object_1", "m", "copy of the object at peer 1"),
    ("object_2", "m", "copy of the object at peer 2"),
    ("object_3", "m", "copy of the object at peer 3"),
    ("object_4", "m", "copy of the object at peer 4"),
    ("hand_1", "N", "force of hand 1 on its device"),
    ("hand_2", "N", "force of hand 2 on its device"),
    ("hand_3", "N", "force of hand 3 on its device"),
    ("hand_4", "N", "force of hand 4 on its device"),
    ("wanted_1", "m", "hand of person 1, no number while it holds nothing"),
    ("wanted_2", "m", "hand of person 2"),
    ("wanted_3", "m", "hand 3"),
    ("wanted_4", "m", "hand 4"),
    ("apart", "m", "largest distance between two copies"),
];

/// Peers around a hub, and their hands.
pub(super) struct Hub {
    waves: Waves,
    hands: [Hand; HANDS],
    partners: [Partner; HANDS],
    held: [Held; 2],
    pulls: [f64; HANDS],
    tick: u64,
}

impl Play for Hub {
    fn open(scene: &Scene) -> Result<Self, Failure> {
        scene.check_one_axis("a hub in the page")?;
        let waves = Waves::new(scene, HANDS)?;
        let [three, four] = THERE.map(Partner::new);
        let partners = [Partner::new(Model::default()), Partner::new(Model::default()), three, four];
        let (hands, held) = (Default::default(), [Held::ByNobody; 2]);
        Ok(Self { waves, hands, partners, held, pulls: [0.0; HANDS], tick: 0 })
    }

    fn hold(&mut self, hand: usize, held: Held) {
        self.held[hand] = held;
    }

    fn partner(&mut self, model: Model) {
        self.partners[..2].fill(Partner::new(model));
    }

    fn step(&mut self) {
        let Self { waves, hands, partners, held, pulls, tick } = self;
        for (at, side) in waves.sides_mut().enumerate() {
            let motions = side.plant.motions();
            let position = [motions[0].position];
            let wanted = match held.get(at) {
                None | Some(Held::ByNobody) => partners[at].wants(position, PERIOD_S),
                Some(Held::Free) => None,
                Some(Held::At([along, ..])) => Some([*along]),
            };
            if matches!(held.get(at), Some(Held::Free | Held::At(_))) {
                partners[at].rest();
            }
            hands[at].point(*tick, wanted, position);
            let pull = hands[at].pull(*tick, first(motions), PERIOD_S);
            side.plant.pull(on_device(pull, motions));
            [pulls[at]] = pull;
        }
        waves.step();
        *tick += 1;
    }

    fn numbers(&self, number: &mut dyn FnMut(f64)) {
        self.waves.sides().for_each(|side| number(side.plant.motions()[0].position));
        self.waves.copies().for_each(|copy| number(copy.position));
        self.pulls.iter().for_each(|pull| number(*pull));
        self.hands.iter().for_each(|hand| number(hand.holds().map_or(f64::NAN, |[at]| at)));
        let places = || self.waves.copies().map(|copy| copy.position);
        number(places().fold(f64::NEG_INFINITY, f64::max) - places().fold(f64::INFINITY, f64::min));
    }

    fn seats(&self) -> usize {
        HANDS + 1
    }

    fn route(&mut self, from: usize, to: usize) -> &mut Route {
        self.waves.route(from, to)
    }

    fn modes(&self) -> [u8; 2] {
        let mut modes = self.waves.sides().map(|side| number_of(side.peer.mode()));
        let first = modes.next().unwrap_or(ARMED);
        [first, modes.find(|mode| *mode != ARMED).unwrap_or(ARMED)]
    }
}
