//! Four hands on one object through a hub: two of people, and two that nobody can take.

use cohold_core::safety::Mode;
use cohold_live::hand::{Hand, end_of_travel};
use cohold_live::playable::{Column, Held, PERIOD_S, Play};
use cohold_sim::network::link::Route;
use cohold_sim::scene::Scene;

use crate::Error;
use crate::cooperative::waves::Waves;

/// Number of hands on the object.
const HANDS: usize = 4;

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
    held: [Held; HANDS],
    pulls: [f64; HANDS],
    tick: u64,
}

impl Hub {
    pub(super) fn open(scene: &Scene) -> Result<Self, Error> {
        scene.check_one_axis("a hub in the page")?;
        let waves = Waves::new(scene, HANDS)?;
        let (hands, held) = (Default::default(), [Held::ByNobody; HANDS]);
        Ok(Self { waves, hands, held, pulls: [0.0; HANDS], tick: 0 })
    }
}

impl Play for Hub {
    fn hold(&mut self, hand: usize, held: Held) {
        self.held[hand] = held;
    }

    fn device(&self, hand: usize) -> Option<f64> {
        self.waves.sides().nth(hand).map(|side| side.plant.motions()[0].position)
    }

    fn step(&mut self) {
        let Self { waves, hands, held, pulls, tick } = self;
        for (at, side) in waves.sides_mut().enumerate() {
            let [motion, ..] = side.plant.motions();
            let wanted = if let Held::At([along, _]) = held[at] { Some([along]) } else { None };
            hands[at].point(*tick, wanted, [motion.position]);
            [pulls[at]] = hands[at].pull(*tick, [motion], PERIOD_S);
            side.plant.pull([pulls[at] - end_of_travel(motion), 0.0]);
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

    fn modes(&self) -> [Mode; 2] {
        let mut modes = self.waves.sides().map(|side| side.peer.mode());
        let first = modes.next().unwrap_or(Mode::Armed);
        [first, modes.find(|mode| *mode != Mode::Armed).unwrap_or(Mode::Armed)]
    }
}
